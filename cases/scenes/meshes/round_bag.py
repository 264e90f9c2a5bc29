"""The pancake's own shape as a soup of triangles: jittered rings of points, joined ring by ring.

In millimetres, one unit of the pancake's scene being 50 mm; corners unwelded, in single
precision, and every third triangle the wrong way round, as scanned and exported files come.
"""

from __future__ import annotations

import struct

import numpy as np

from ...geometry.pancake import Pancake
from .triangulation import flipped

BODY = Pancake(radius=1.0, half_width=10.0, neck_radius=1.0, fillet=1.0)
UNIT = 50.0  # mm
JITTER, JITTER_BENT = 0.2, 0.05  # of a ring's spacing, less where the bag turns
FLIPPED = 3  # every so many triangles
# Places along the meridian, in pieces from joint to joint, and points of each ring.
UPPER = ((0.3, 6), (0.62, 11), (0.86, 16))
RIM_ROWS, RIM_POINTS = 4, 18
LOWER = ((0.17, 17), (0.5, 13), (0.83, 10))
FILLET_ROWS, NECK_POINTS = 3, 12
DISC = ((0.5, 6),)


def rings() -> list[tuple[float, float, int]]:
    """Radius, height and number of points of each ring, from pole to the middle of the disc."""
    joints, lengths = BODY.joints, BODY.lengths
    places = [(0.0, 1)]
    places += [(lengths[0] * share, n) for share, n in UPPER]
    rim = np.linspace(joints[1], joints[2], RIM_ROWS + 1)
    places += [(float(s), RIM_POINTS) for s in rim]
    places += [(joints[2] + lengths[2] * share, n) for share, n in LOWER]
    fillet = np.linspace(joints[3], joints[4], FILLET_ROWS + 1)
    places += [(float(s), NECK_POINTS) for s in fillet]
    surface = BODY.meridian(np.array([s for s, _ in places]))
    found = [(r, z, n) for (r, z), (_, n) in zip(surface.tolist(), places, strict=True)]
    found += [(BODY.neck_radius * (1.0 - share), 0.0, n) for share, n in DISC]
    return [*found, (0.0, 0.0, 1)]


def round_bag() -> tuple[np.ndarray, np.ndarray]:
    """Points ``(n, 3)`` in units of the scene and triangles ``(m, 3)``, outward."""
    points: list[np.ndarray] = []
    strips: list[np.ndarray] = []
    curves: list[np.ndarray] = []
    last = np.empty(0, dtype=np.int64)
    for k, (r, z, n) in enumerate(rings()):
        first = sum(p.shape[0] for p in points)
        angle = _angles(k, first, n, JITTER_BENT if _bent(r, z) else JITTER)
        points.append(np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(n, z)]))
        ring = first + np.arange(n)
        curves.append(np.full(n, k if _bent(r, z) else -1))
        if last.size:
            strips.append(_strip(np.concatenate(points), last, ring))
        last = ring
    p, t = np.concatenate(points), np.concatenate(strips)
    return p, flipped(p, t, np.concatenate(curves))


def _bent(r: float, z: float) -> bool:
    """Whether the bag turns at a ring, so that edges along it must stay."""
    outer = BODY.half_width - BODY.radius
    inner = BODY.neck_radius + BODY.fillet
    height = BODY.fillet + 2.0 * BODY.radius
    on_neck = BODY.neck_radius - 1e-9 < r < inner + 1e-9 and z < height - 1e-9
    return r > outer - 1e-9 or on_neck


def _angles(k: int, first: int, n: int, jitter: float) -> np.ndarray:
    """Increasing angles of ring k: even, turned by half a spacing, jittered by the golden ratio."""
    shift = (first + np.arange(n)) * 0.6180339887 % 1.0 - 0.5
    return np.asarray(2.0 * np.pi / n * (np.arange(n) + 0.5 * (k % 2) + 2.0 * jitter * shift))


def _strip(points: np.ndarray, outer: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """Triangles between two rings, or a ring and a point: the next point by angle."""
    n, m = outer.size, inner.size
    angles = [np.unwrap(np.arctan2(points[ring, 1], points[ring, 0])) for ring in (outer, inner)]
    i = j = 0
    found = []
    while i < n or j < m:
        ahead = [a[(k + 1) % a.size] + 2.0 * np.pi * ((k + 1) // a.size)
                 for a, k in zip(angles, (i, j), strict=True)]  # fmt: skip
        a, b = outer[i % n], inner[j % m]
        if n > 1 and i < n and (m == 1 or j == m or ahead[0] <= ahead[1]):
            found.append((a, b, outer[(i + 1) % n]))
            i += 1
        elif m > 1 and j < m:
            found.append((a, b, inner[(j + 1) % m]))
            j += 1
        else:
            break
    return np.array(found)


def bag_stl() -> bytes:
    """The file: binary STL."""
    points, triangles = round_bag()
    corners = np.round(UNIT * points, 3)[triangles]
    corners[::FLIPPED] = corners[::FLIPPED][:, [0, 2, 1]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.round(normals / np.linalg.norm(normals, axis=1)[:, None], 3)
    facets = np.concatenate([normals[:, None], corners], axis=1).astype("<f4")
    head = b"round bag in mm, with the disc of its inlet at z = 0".ljust(80)
    body = b"".join(f.tobytes() + b"\0\0" for f in facets)
    return head + struct.pack("<I", len(facets)) + body
