"""Pieces of elements on which one closest point and one near rule suffice.

A piece is a box of an element's local coordinates. Elements whose normal turns by more than
`TURN` along s or t are bisected, across the direction that turns more, until every piece is nearly
flat: then a point nearer than the piece's size has a single closest point on it. `convexity`
proves it: along a line from a stationary point at distance d, ``|y - x|^2 / 2`` grows at least by
``tau^2 / 2 (mu - c (d + L / 3))`` with bounds ``mu <= |y'|^2``, ``|y''| <= c``, ``|y'| <= L``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .bernstein import bernstein, bernstein_derivative

TURN = np.pi / 4.0  # largest angle between normals along a coordinate line
DEEPEST = 4  # bisections of one element at most
GRID = 0.5 - 0.5 * np.cos(np.pi * (np.arange(5) + 0.5) / 5)  # interior: normals exist at poles too


@dataclass(frozen=True)
class ElementPieces:
    """The pieces of all elements, element by element.

    Attributes
    ----------
    indptr : (n_elements + 1,) int array
    elements : (n_pieces,) int array
    boxes : (n_pieces, 4) array
        ``s`` from and to, ``t`` from and to.
    centres : (n_pieces, 3) array
    radii : (n_pieces,) array
        Balls around the pieces. Centres are means of the piece's own points, so that they rotate
        with it: an axis-aligned box would break the symmetry of a scene.
    convexity : (n_pieces, 2) array
        ``mu / c`` and ``L``: a stationary point at distance d is nearer than all points whose
        coordinates are within ``3 (mu / c - d) / L`` of it, measured with `speeds`.
    flat : (n_pieces,) array
        Four fifths of the smallest radius of curvature, normal or of a coordinate line, at sample
        points.
    speeds : (n_pieces, 2) array
        Bounds of ``|x_s|`` and ``|x_t|``.
    nets : (n_pieces, (g + 1)**2, 3) array
        Bezier control points of the pieces themselves.
    """

    indptr: np.ndarray
    elements: np.ndarray
    boxes: np.ndarray
    centres: np.ndarray
    radii: np.ndarray
    convexity: np.ndarray
    flat: np.ndarray
    speeds: np.ndarray
    nets: np.ndarray

    @property
    def n(self) -> int:
        return self.elements.size


def divide(control: np.ndarray) -> ElementPieces:
    """Pieces of Bezier patches ``control (n_elements, g + 1, g + 1, 3)``."""
    elements = np.arange(control.shape[0])
    boxes = np.tile([0.0, 1.0, 0.0, 1.0], (elements.size, 1))
    for _ in range(DEEPEST):
        along_s, along_t = _turning(control[elements], boxes)
        split = np.maximum(along_s, along_t) > TURN
        if not split.any():
            break
        across_s = along_s >= along_t
        elements, boxes = _bisect(elements, boxes, split, across_s)
    ordered = np.lexsort((boxes[:, 2], boxes[:, 0], elements))
    elements, boxes = elements[ordered], boxes[ordered]
    centres, radii = balls(control[elements], boxes)
    indptr = np.searchsorted(elements, np.arange(control.shape[0] + 1))
    convexity, speeds, nets = bounds(control[elements], boxes)
    flat = _flatness(control[elements], boxes)
    return ElementPieces(indptr, elements, boxes, centres, radii, convexity, flat, speeds, nets)


def balls(control: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres ``(n, 3)`` and radii ``(n,)`` of balls around boxes of patches, edges included."""
    y = _grid(control, boxes, np.linspace(0.0, 1.0, 5))[0]
    # the mean over a symmetric grid does not depend on how the patch is turned
    inner = _grid(control, boxes, GRID)[0]
    centres = inner.mean(axis=1)
    return centres, np.linalg.norm(y - centres[:, None], axis=2).max(axis=1)


def bounds(control: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Convexity, speeds and nets of boxes, rigorous: see `ElementPieces`."""
    degree, n = control.shape[1] - 1, boxes.shape[0]
    net = _coefficients(_grid(control, boxes, _chebyshev(degree))[0].reshape(n, -1, 3))
    first = [degree * np.diff(net, axis=k) for k in (1, 2)]
    second = [
        degree * (degree - 1) * np.diff(net, 2, axis=1),
        degree * degree * np.diff(np.diff(net, axis=1), axis=2),
        degree * (degree - 1) * np.diff(net, 2, axis=2),
    ]
    widths = np.stack([boxes[:, 1] - boxes[:, 0], boxes[:, 3] - boxes[:, 2]], axis=1)
    lengths = np.stack([_largest(f) for f in first], axis=1)  # of coordinate lines, bounds
    _, along_s, along_t = _grid(control, boxes, _chebyshev(2 * degree))
    a, b = (lengths / widths).T
    products = np.stack(
        [
            np.sum(along_s**2, axis=2) / (a * a)[:, None],
            np.sum(along_s * along_t, axis=2) / (a * b)[:, None],
            np.sum(along_t**2, axis=2) / (b * b)[:, None],
        ],
        axis=2,
    )
    metric = _coefficients(products)
    mixed = np.abs(metric[..., 1]).max(axis=(1, 2))
    mu = np.minimum(metric[..., 0].min(axis=(1, 2)), metric[..., 2].min(axis=(1, 2))) - mixed
    ss, st, tt = (_largest(f) for f in second)
    s, t = np.maximum(lengths, 1e-300).T
    bend = np.maximum(ss / (s * s), tt / (t * t)) + st / (s * t)
    convexity = np.stack([mu / np.maximum(bend, 1e-300), np.sqrt(1.0 + mixed)], axis=1)
    return convexity, lengths / widths, np.ascontiguousarray(net.reshape(n, -1, 3))


def _flatness(control: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """`ElementPieces.flat` of boxes."""
    _, s, t = _grid(control, boxes, GRID)
    k = GRID.size
    widths = np.stack([boxes[:, 1] - boxes[:, 0], boxes[:, 3] - boxes[:, 2]], axis=1)
    table = bernstein_derivative(k - 1, GRID) @ np.linalg.inv(bernstein(k - 1, GRID))

    def slopes(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        grid = f.reshape(-1, k, k, 3)
        along_s = np.einsum("ai,nijc->najc", table, grid).reshape(f.shape)
        along_t = np.einsum("bj,nijc->nibc", table, grid).reshape(f.shape)
        return along_s / widths[:, :1, None], along_t / widths[:, 1:, None]

    (ss, st), (_, tt) = slopes(s), slopes(t)
    normal = np.cross(s, t)
    area = np.maximum(np.linalg.norm(normal, axis=2), 1e-300)
    mixed = np.abs(np.sum(normal * st, axis=2)) / area**2
    a, b = (np.maximum(np.linalg.norm(v, axis=2), 1e-300) for v in (s, t))
    lines = [np.linalg.norm(np.cross(v, w), axis=2) / c**3 for v, w, c in ((s, ss, a), (t, tt, b))]
    curvature = np.maximum(*lines) * (a * b / area) ** 2 + mixed
    return 0.8 / np.maximum(curvature.max(axis=1), 1e-300)


def grid_points(control: np.ndarray, boxes: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Points of boxes of patches on the tensor grid of ``x (k,)``, ``(n, k * k, 3)``."""
    return np.ascontiguousarray(_grid(control, boxes, x)[0])


def _bisect(
    elements: np.ndarray, boxes: np.ndarray, split: np.ndarray, across_s: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Halve the marked boxes, across s or t."""
    first, second = boxes.copy(), boxes[split].copy()
    at = np.where(across_s, 0, 2)
    rows = np.flatnonzero(split)
    middle = 0.5 * (boxes[rows, at[rows]] + boxes[rows, at[rows] + 1])
    first[rows, at[rows] + 1] = middle
    second[np.arange(rows.size), at[rows]] = middle
    return np.concatenate([elements, elements[rows]]), np.concatenate([first, second])


def _grid(
    control: np.ndarray, boxes: np.ndarray, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions and both slopes on a tensor grid of every box, ``(n, k * k, 3)`` each."""
    degree = control.shape[1] - 1
    n = boxes.shape[0]
    tables = []
    for low, high in ((boxes[:, 0], boxes[:, 1]), (boxes[:, 2], boxes[:, 3])):
        nodes = (low[:, None] + (high - low)[:, None] * x).ravel()
        for table in (bernstein(degree, nodes), bernstein_derivative(degree, nodes)):
            tables.append(table.reshape(n, x.size, degree + 1))
    s, ds, t, dt = tables

    def values(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("nki,nijc,nlj->nklc", a, control, b, optimize=True).reshape(n, -1, 3)

    return values(s, t), values(ds, t), values(s, dt)


def _chebyshev(degree: int) -> np.ndarray:
    """Interpolation points of a degree on [0, 1]."""
    return 0.5 - 0.5 * np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))


def _coefficients(values: np.ndarray) -> np.ndarray:
    """Bernstein coefficients ``(n, k, k, m)`` of values ``(n, k * k, m)`` at Chebyshev points."""
    n, square, m = values.shape
    k = round(np.sqrt(square))
    inverse = np.linalg.inv(bernstein(k - 1, _chebyshev(k - 1)))
    grid = values.reshape(n, k, k, m)
    return np.einsum("ai,nijm,bj->nabm", inverse, grid, inverse, optimize=True)


def _largest(net: np.ndarray) -> np.ndarray:
    """Largest length of the vectors of each net, 0 of an empty one."""
    return np.linalg.norm(net, axis=-1).max(axis=(1, 2), initial=0.0)


def _turning(control: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Largest angle between normals along s and along t on each box."""
    _, along_s, along_t = _grid(control, boxes, GRID)
    normal = np.cross(along_s, along_t)
    size = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = normal / np.maximum(size, 1e-300)
    k = GRID.size
    grid = normal.reshape(-1, k, k, 3)
    by_s = np.einsum("nklc,nmlc->nlkm", grid, grid, optimize=True).min(axis=(1, 2, 3))
    by_t = np.einsum("nklc,nkmc->nklm", grid, grid, optimize=True).min(axis=(1, 2, 3))
    return np.arccos(np.clip(by_s, -1.0, 1.0)), np.arccos(np.clip(by_t, -1.0, 1.0))
