"""Which triangles are the inlet: a group, or those with centroids in a sphere, box or plane."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..facet_mesh import FacetMesh, MeshError, place

HOLE = "hole"
WITHOUT = "choose the triangles by a sphere, box or plane"  # in a mesh without groups
LISTED = 12  # group names in a message
FORMS = (
    'a group\'s name, "hole", { sphere = [x, y, z, r] }, { box = [[x, y, z], [x, y, z]] }, '
    "{ plane = [nx, ny, nz, d] } or { hole = [x, y, z] }"
)


def inlet_triangles(facets: FacetMesh, inlet: Any) -> tuple[np.ndarray, tuple[str, ...]]:
    """Triangles of an inlet that is part of the mesh.

    Parameters
    ----------
    facets : FacetMesh
    inlet : str or mapping
        A group's name; or one of ``sphere`` (centre and radius), ``box`` (two corners) and
        ``plane`` (normal n and d: where ``n . x >= d``), met by centroids of triangles.

    Returns
    -------
    (k,) int array, tuple of str
        Triangles, increasing, and what is worth a note.

    Raises
    ------
    MeshError
        An unknown name or form, numbers that make no sense, or no triangle there.
    """
    if isinstance(inlet, str):
        members, notes = group_triangles(facets, inlet, "geometry.inlet", WITHOUT)
        if not members.size:
            raise MeshError(
                f"geometry.inlet: group {inlet!r} has no triangles; name another, or a region"
            )
        return members, notes
    kind, numbers = _form(inlet)
    chosen = np.flatnonzero(SHAPES[kind](_centroids(facets), numbers))
    if not chosen.size:
        raise MeshError(
            f"geometry.inlet: no triangle's centroid lies in the {kind} "
            f"{place(np.ravel(numbers))}; the mesh extends from {place(facets.points.min(axis=0))} "
            f"to {place(facets.points.max(axis=0))}: move the {kind}, enlarge it, or mend "
            "geometry.unit"
        )
    return chosen, ()


def group_triangles(
    facets: FacetMesh, name: str, key: str, without: str
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Triangles of a group, by its name or one that differs in case only.

    Errors name the ``key``, and what to do in a mesh ``without`` groups.

    Raises
    ------
    MeshError
        No or several groups of that name.
    """
    if name in facets.groups:
        return np.asarray(facets.groups[name]), ()
    alike = [g for g in facets.groups if g.strip().lower() == name.strip().lower()]
    if len(alike) == 1:
        found = np.asarray(facets.groups[alike[0]])
        return found, (f"{key}: the mesh has no group {name!r}, took {alike[0]!r}",)
    if alike:
        raise MeshError(f"{key}: {name!r} may mean {' or '.join(map(repr, alike))}; give one as is")
    if not facets.groups:
        raise MeshError(f"{key}: the mesh has no group {name!r}, nor any other; {without}")
    raise MeshError(f"{key}: the mesh has no group {name!r}{_nearest(facets.groups, name)}")


def _nearest(groups: Mapping[str, np.ndarray], name: str) -> str:
    close = difflib.get_close_matches(name, groups, n=1)
    hint = f" (did you mean {close[0]!r}?)" if close else ""
    more = f" and {len(groups) - LISTED} more" if len(groups) > LISTED else ""
    return f"{hint}; it has {', '.join(map(repr, list(groups)[:LISTED]))}{more}"


def is_hole(inlet: Any, facets: FacetMesh) -> bool:
    """Whether a hole is to be capped: a group of that name comes first."""
    if isinstance(inlet, str):
        return inlet.strip().lower() == HOLE and inlet not in facets.groups
    return isinstance(inlet, Mapping) and set(inlet) == {HOLE}


def numbers_of(value: Any, shape: tuple[int, ...], key: str) -> np.ndarray:
    """Finite numbers of a shape.

    Raises
    ------
    MeshError
        Anything else.
    """
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != shape or not np.isfinite(array).all():
        wanted = " x ".join(map(str, shape))
        raise MeshError(f"{key}: expected {wanted} finite numbers, got {value!r}")
    return array


def _form(inlet: Any) -> tuple[str, np.ndarray]:
    if not isinstance(inlet, Mapping) or len(inlet) != 1 or next(iter(inlet)) not in NUMBERS:
        raise MeshError(f"geometry.inlet: expected {FORMS}, got {inlet!r}")
    ((kind, value),) = inlet.items()
    numbers = numbers_of(value, NUMBERS[kind], f"geometry.inlet.{kind}")
    if kind == "sphere" and not numbers[3] > 0.0:
        raise MeshError(f"geometry.inlet.sphere: the radius must be positive, not {numbers[3]:g}")
    if kind == "plane" and not numbers[:3].any():
        raise MeshError(
            "geometry.inlet.plane: the normal must not be zero; [nx, ny, nz, d] takes n . x >= d"
        )
    return kind, numbers


def _centroids(facets: FacetMesh) -> np.ndarray:
    return facets.points[facets.triangles].mean(axis=1)


def _in_sphere(x: np.ndarray, sphere: np.ndarray) -> np.ndarray:
    return np.linalg.norm(x - sphere[:3], axis=1) <= sphere[3]


def _in_box(x: np.ndarray, box: np.ndarray) -> np.ndarray:
    return np.all((x >= box.min(axis=0)) & (x <= box.max(axis=0)), axis=1)


def _beyond_plane(x: np.ndarray, plane: np.ndarray) -> np.ndarray:
    return x @ plane[:3] >= plane[3]


Test = Callable[[np.ndarray, np.ndarray], np.ndarray]
SHAPES: dict[str, Test] = {"sphere": _in_sphere, "box": _in_box, "plane": _beyond_plane}
NUMBERS = {"sphere": (4,), "box": (2, 3), "plane": (4,)}
