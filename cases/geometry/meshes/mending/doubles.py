"""Triangles with the same three corners: copies, or sheets that lie on each other."""

from __future__ import annotations

import numpy as np

from ..facet_mesh import MeshError, place
from .state import Mending, memberships

# Thickness over size below which doubled triangles of one solid may be two sheets.
THIN = 1e-6


def drop_doubles(mesh: Mending, triangles: np.ndarray) -> None:
    """Keep one of the triangles with the same three vertices, unless they are two sheets."""
    corners = np.sort(triangles, axis=1)
    _, first, inverse = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    inverse = inverse.ravel()
    again = np.flatnonzero(first[inverse] != np.arange(len(triangles)))
    again = again[np.all(np.diff(corners[again], axis=1) > 0, axis=1)]
    if not len(again):
        return
    kept = first[inverse[again]]
    names = memberships(mesh)
    apart = [(i, j) for i, j in zip(again.tolist(), kept.tolist(), strict=True)
             if names[mesh.origin[i]] != names[mesh.origin[j]]]  # fmt: skip
    soup = mesh.mesh.triangles is not triangles
    where = place(mesh.mesh.points[triangles[again[0]]].mean(axis=0))
    if apart and soup and len(mesh.given.groups) > 1:
        return  # told apart by their groups, or refused as edges of four triangles
    if apart:
        i, j = apart[0]
        two = " and ".join(sorted({_said(names[mesh.origin[i]]), _said(names[mesh.origin[j]])}))
        raise MeshError(
            f"{len(apart)} triangles on the same three points in different groups ({two}), the "
            f"first at {where}: give each sheet points of its own, joined at the seam"
        )
    way = np.array(
        [_even(a) == _even(b) for a, b in zip(triangles[again], triangles[kept], strict=True)]
    )
    used = mesh.mesh.points[np.unique(mesh.mesh.triangles)]
    thin = np.linalg.svd(used - used.mean(axis=0), full_matrices=False, compute_uv=False)
    if 2 * len(again) == len(triangles) and not np.any(way) and thin[2] <= THIN * thin[0]:
        raise MeshError(
            f"two flat sheets of {len(again)} triangles lie on each other and nothing tells them "
            "apart: name each as a solid or group, or export one sheet and double it"
        )
    keep = np.ones(len(triangles), bool)
    keep[again] = False
    mesh.notes.append(f"{len(again)} doubled triangles dropped, the first at {where}")
    mesh.take(keep)


def _said(names: tuple[str, ...]) -> str:
    return " + ".join(f"'{name}'" for name in names) or "none"


def _even(triangle: np.ndarray) -> bool:
    a, b, c = triangle
    return bool((a < b) ^ (b < c) ^ (c < a))
