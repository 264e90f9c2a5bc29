"""Facets with the Bezier triangles over them, split as often as asked, and what that changed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from shells.surfaces.local_elements import functions, lattice, rule
from shells.surfaces.triangles.edge_graph import edge_graph

from ..facet_mesh import FacetMesh, MeshError
from .smooth import CORNERS, SECOND_CORNERS, control_points

CHILDREN = np.array(  # corners of the four triangles in local xi, eta of the one that is split
    [
        [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]],
        [[0.5, 0.0], [1.0, 0.0], [0.5, 0.5]],
        [[0.0, 0.5], [0.5, 0.5], [0.0, 1.0]],
        [[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]],
    ]
)
FLAT = 1e-9  # volume over the cube of the size, below which sheets lie on each other
MOST = 5  # splits: 1024 triangles of each


@dataclass(frozen=True)
class CurvedMesh:
    """A triangulation and its Bezier triangles.

    Attributes
    ----------
    facets : FacetMesh
    control : (m, n_functions, 3) array
        Bezier control points, equal where neighbours meet.
    degree : int
    moved : float
        Largest distance between points of the surface and of the facets that it came from, at
        equal local coordinates.
    facet_volume : float
        Inside the facets; NaN of an open surface.
    flat : (m, n_functions, 3) array, optional
        The same triangles in the unfolded reference.
    """

    facets: FacetMesh
    control: np.ndarray
    degree: int
    moved: float
    facet_volume: float
    flat: np.ndarray | None = None

    @cached_property
    def closed(self) -> bool:
        """Whether every edge has two triangles."""
        return not edge_graph(self.facets.triangles).rim.size

    @cached_property
    def area(self) -> float:
        return float(triangle_areas(self.control, self.degree).sum())

    @cached_property
    def volume(self) -> float:
        """Inside the smooth surface; NaN of an open one."""
        return enclosed_volume(self.control, self.degree) if self.closed else np.nan


def curved_mesh(
    facets: FacetMesh,
    *,
    degree: int = 3,
    smooth: bool = True,
    crease: float = 30.0,
    surface: Callable[[np.ndarray], np.ndarray] | None = None,
    split: int = 0,
) -> CurvedMesh:
    """Bezier triangles on oriented facets, see `control_points`.

    Parameters
    ----------
    facets : FacetMesh
    degree, smooth, crease, surface :
        As of `control_points`; an unfolded reference is smoothed by its own normals.
    split : int
        How often each triangle of the smooth surface is divided into four.

    Returns
    -------
    CurvedMesh

    Raises
    ------
    MeshError
        See `control_points`; a split that is no whole number from 0 to 5.
    """
    if isinstance(split, bool) or not isinstance(split, int | np.integer) or not 0 <= split <= MOST:
        raise MeshError(f"mesh.split = {split!r}: expected a whole number from 0 to {MOST}")
    curve = partial(control_points, degree=degree, smooth=smooth, crease=crease)
    control = curve(facets.points, facets.triangles, middles=facets.middles, surface=surface)
    flat = None
    if facets.reference is not None:
        flat = curve(facets.reference, facets.triangles)
    mesh = CurvedMesh(facets, control, degree, _moved(facets, control, degree), np.nan, flat)
    if mesh.closed:
        flat_volume = enclosed_volume(facets.points[facets.triangles], 1)
        mesh = replace(mesh, facet_volume=flat_volume)
    mesh = replace(mesh, facets=replace(facets, notes=(*facets.notes, _note(mesh))))
    for _ in range(split):
        mesh = divided(mesh)
    return mesh


def _note(mesh: CurvedMesh) -> str:
    """What smoothing did."""
    size = np.linalg.norm(np.ptp(mesh.facets.points, axis=0))
    if mesh.moved <= 1e-12 * size:
        return "the surface is the facets of the file, not smoothed"
    kind = "smooth surface" if mesh.facets.middles is None else "second-order surface"
    note = f"{kind}: at most {mesh.moved:.3g} ({mesh.moved / size:.2g} of the size) off the facets"
    if not mesh.closed or abs(mesh.facet_volume) < FLAT * size**3:
        return note
    change = mesh.volume / mesh.facet_volume - 1.0
    return f"{note}; volume {mesh.facet_volume:.5g} before, {mesh.volume:.5g} after ({change:+.2g})"


def divided(mesh: CurvedMesh) -> CurvedMesh:
    """Each triangle in four on the same surface; triangle t becomes 4 t .. 4 t + 3."""
    graph, t = edge_graph(mesh.facets.triangles), mesh.facets.triangles
    n = len(mesh.facets.points)
    middle = n + graph.of_triangle
    ab, bc, ca = middle.T
    a, b, c = t.T
    four = np.array([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
    triangles = four.transpose(2, 0, 1).reshape(-1, 3)
    control = _children(mesh.control, mesh.degree)
    flat = None if mesh.flat is None else _children(mesh.flat, mesh.degree)
    count = n + len(graph.vertices)
    facets = FacetMesh(
        points=_vertices(control, triangles, count, mesh.degree),
        triangles=triangles,
        groups={name: split_members(members, 1) for name, members in mesh.facets.groups.items()},
        reference=None if flat is None else _vertices(flat, triangles, count, mesh.degree),
        notes=mesh.facets.notes,
    )
    return replace(mesh, facets=facets, control=control, flat=flat)


def split_members(members: np.ndarray, split: int) -> np.ndarray:
    """Triangles that come of some, each divided into four this often."""
    for _ in range(split):
        members = (4 * members[:, None] + np.arange(4)).ravel()
    return members


def _children(control: np.ndarray, degree: int) -> np.ndarray:
    """Control points of four triangles each, ``(4 m, n_functions, 3)``: exact interpolation."""
    xi, eta, _ = lattice("triangle", degree)
    inverse = np.linalg.inv(functions("triangle", degree, xi, eta))
    corners = np.stack([1.0 - xi - eta, xi, eta], axis=1) @ CHILDREN
    tables = np.array([inverse @ functions("triangle", degree, *at.T) for at in corners])
    return np.einsum("kab,mbc->mkac", tables, control).reshape(-1, *control.shape[1:])


def _vertices(control: np.ndarray, triangles: np.ndarray, count: int, degree: int) -> np.ndarray:
    points = np.zeros((count, 3))
    points[triangles] = control[:, CORNERS if degree == 3 else SECOND_CORNERS]
    return points


def _moved(facets: FacetMesh, control: np.ndarray, degree: int, cells: int = 4) -> float:
    xi, eta, _ = lattice("triangle", cells)
    flat = np.stack([1.0 - xi - eta, xi, eta], axis=1) @ facets.points[facets.triangles]
    off = functions("triangle", degree, xi, eta) @ control - flat
    return float(np.sqrt(np.sum(off**2, axis=2).max()))


def _normals(control: np.ndarray, degree: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, normals ``x_xi x x_eta`` ``(m, q, 3)`` and weights, exact for volumes."""
    xi, eta, weights = rule("triangle", (3 * degree + 1) // 2)
    x, s, t = (
        functions("triangle", degree, xi, eta, order) @ control
        for order in ((0, 0), (1, 0), (0, 1))
    )
    return x, np.cross(s, t), weights


def triangle_areas(control: np.ndarray, degree: int) -> np.ndarray:
    """Areas ``(m,)`` of Bezier triangles, by quadrature."""
    _, normals, weights = _normals(control, degree)
    return np.linalg.norm(normals, axis=2) @ weights


def enclosed_volume(control: np.ndarray, degree: int) -> float:
    """Volume inside closed Bezier triangles ``(m, n_functions, 3)``, exact."""
    x, normals, weights = _normals(control - control.mean(axis=(0, 1)), degree)
    return float(np.einsum("mqc,mqc,q->", x, normals, weights) / 3.0)
