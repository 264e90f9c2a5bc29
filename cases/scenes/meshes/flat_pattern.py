"""A flat pattern 1 x 0.5 of two sheets, 0.01 apart, on irregular triangles: smoothed Delaunay.

Sewn at a rim with round corners, where the distance falls to zero like an ellipse. The sheets
have meshes of their own; the inlet is a round patch of the lower one, at the first panel.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

LENGTH, WIDTH, GAP, CORNER = 1.0, 0.5, 0.01, 0.06
SIZE = 0.0335  # of triangles
ROW, SECOND = 0.009, 0.028  # distances of the first two rows from the rim
RIM = 0.022  # width of the ellipse
INLET = (0.16, 0.25, 0.05)  # x, y, radius
INLET_POINTS = 12
SMOOTHING = 12
GOLDEN, PLASTIC = 0.6180339887498949, 0.7548776662466927


def pattern_obj() -> bytes:
    """The file: OBJ with the groups "upper", "lower" and "inlet"."""
    points, triangles, groups = flat_pattern()
    lines = ["# flat pattern of two sheets, folded by its scene"]
    lines += ["v " + " ".join(f"{x:.5f}" for x in p) for p in points]
    for name, members in groups.items():
        lines.append(f"g {name}")
        lines += ["f " + " ".join(str(k + 1) for k in triangles[t]) for t in members]
    return "\n".join([*lines, ""]).encode()


def flat_pattern() -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Points ``(n, 3)``, triangles ``(m, 3)`` outward, and the groups."""
    rim = outline(0.0, round(perimeter(0.0) / (0.85 * SIZE)), 0.0)
    (above, up), (below, down) = _sheet(rim, 0.11, None), _sheet(rim, 0.57, INLET)
    k, n = len(rim), len(above)
    shifted = np.where(down < k, down, down + n - k)[:, [0, 2, 1]]
    flat = np.concatenate([above, below[k:]])
    side = np.concatenate([np.zeros(k), np.ones(n - k), -np.ones(len(below) - k)])
    far = np.clip(rim_distance(flat) / RIM, 0.0, 1.0)
    height = side * 0.5 * GAP * np.sqrt(1.0 - (1.0 - far) ** 2)
    x, y, radius = INLET
    blown = (np.hypot(*(below - [x, y]).T) < radius + 1e-4)[down].all(axis=1)
    m = len(up)
    groups = {
        "upper": np.arange(m),
        "lower": m + np.flatnonzero(~blown),
        "inlet": m + np.flatnonzero(blown),
    }
    points = np.column_stack([np.round(flat, 5), np.round(height, 5)])
    return points, np.concatenate([up, shifted]), groups


def perimeter(inset: float) -> float:
    """Length of the outline moved inward."""
    straight = 2.0 * (LENGTH + WIDTH - 4.0 * CORNER)
    return straight + 2.0 * np.pi * (CORNER - inset)


def outline(inset: float, n: int, shift: float) -> np.ndarray:
    """Points ``(n, 2)`` on the outline moved inward, evenly along it."""
    a, b, r = LENGTH - 2.0 * CORNER, WIDTH - 2.0 * CORNER, CORNER - inset
    lengths = np.tile([a, 0.5 * np.pi * r, b, 0.5 * np.pi * r], 2)[[0, 1, 2, 3, 4, 5, 6, 7]]
    ends = np.cumsum(lengths)
    s = (np.arange(n) + shift) / n * ends[-1]
    piece = np.minimum(np.searchsorted(ends, s, side="right"), 7)
    d = s - (ends - lengths)[piece]
    centres = np.array([[1, 0], [1, 0], [1, 1], [1, 1], [0, 1], [0, 1], [0, 0], [0, 0]])
    corner = CORNER + centres * [a, b]
    start = np.array([[-a, -r], [0, -r], [r, -b], [r, 0], [a, r], [0, r], [-r, b], [-r, 0]])
    along = np.array([[1, 0], [0, 0], [0, 1], [0, 0], [-1, 0], [0, 0], [0, -1], [0, 0]])
    points = corner[piece] + start[piece] + d[:, None] * along[piece]
    arcs = piece % 2 == 1
    angle = 0.5 * np.pi * (piece // 2 - 1) + d / max(r, 1e-12)
    points[arcs] = (corner[piece] + r * np.column_stack([np.cos(angle), np.sin(angle)]))[arcs]
    return points


def rim_distance(points: np.ndarray) -> np.ndarray:
    """Distance inward from the outline ``(n,)``; negative outside."""
    half = np.array([0.5 * LENGTH, 0.5 * WIDTH])
    q = np.abs(points - half) - half + CORNER
    return np.asarray(CORNER - np.hypot(*np.maximum(q, 0.0).T) - np.minimum(q.max(axis=1), 0.0))


def _sheet(
    rim: np.ndarray, seed: float, hole: tuple[float, float, float] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Points of a sheet, those of the rim first, and its triangles, counterclockwise."""
    held = [rim, outline(ROW, len(rim), 0.5)]
    if hole is not None:
        held += [_ring(hole, 1.0, INLET_POINTS), _ring(hole, 0.5, INLET_POINTS // 2)]
        held.append(np.array([hole[:2]]))
    fixed = np.concatenate(held)
    free = _scattered(seed)
    near = np.linalg.norm(free[:, None] - fixed, axis=2).min(axis=1) < 0.55 * SIZE
    points = np.concatenate([fixed, free[~near & (rim_distance(free) > 0.75 * SECOND)]])
    for _ in range(SMOOTHING):
        triangles = _triangulated(points)
        mean = _neighbours_mean(points, triangles)
        points[len(fixed) :] += 0.7 * (mean - points)[len(fixed) :]
    points = np.round(points, 5)
    return points, _triangulated(points)


def _ring(circle: tuple[float, float, float], share: float, n: int) -> np.ndarray:
    angle = 2.0 * np.pi * (np.arange(n) + 0.3) / n
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.asarray(circle[:2] + circle[2] * share * around)


def _scattered(seed: float) -> np.ndarray:
    """Points of a hexagonal lattice, shaken by half a spacing."""
    rows = int(WIDTH / (0.866 * SIZE)) + 2
    columns = int(LENGTH / SIZE) + 2
    i, j = (g.ravel() for g in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    k = np.arange(i.size) + 1
    shake = np.column_stack([(seed + k * GOLDEN) % 1.0, (seed + k * PLASTIC) % 1.0]) - 0.5
    grid = np.column_stack([(i + 0.5 * (j % 2)) * SIZE, j * 0.866 * SIZE])
    return np.asarray(grid + 0.9 * SIZE * shake)


def _triangulated(points: np.ndarray) -> np.ndarray:
    """Delaunay triangles inside the outline, counterclockwise."""
    triangles = Delaunay(points).simplices.astype(np.int64)
    inside = rim_distance(points[triangles].mean(axis=1)) > 0.0
    a, b, c = points[triangles].transpose(1, 0, 2)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0.0] = triangles[area < 0.0][:, [0, 2, 1]]
    return np.asarray(triangles[inside & (np.abs(area) > 1e-9)])


def _neighbours_mean(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Mean of each point's neighbours: of all edges' other ends."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    a, b = np.concatenate([ends, ends[:, ::-1]]).T
    count = np.bincount(a, minlength=len(points))
    sums = [np.bincount(a, points[b, k], minlength=len(points)) for k in (0, 1)]
    return np.stack(sums, axis=1) / np.maximum(count, 1)[:, None]
