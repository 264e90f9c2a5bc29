"""Planar bags: pieces of constant curvature, counterclockwise from the inlet's right end.

``theta' = kappa``; pancake [T fig. 4.2], arc [T 5.3.2] and fold: both sheets of a zigzag of
radius rho and panels 10 rho, folded inwards over a central chamber, wall gap 0.4 rho.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .config import ArcCurve, FlatCurve, FoldCurve, PlanarMesh, PlanarShape


@dataclass(frozen=True)
class CurvePieces:
    """A curve of pieces ``(m,)`` with constant curvature, from ``start`` in direction ``angle``."""

    lengths: np.ndarray
    curvatures: np.ndarray
    start: tuple[float, float]
    angle: float

    @property
    def length(self) -> float:
        return float(self.lengths.sum())

    def at(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and unit tangents ``(n, 2)`` at arc lengths s."""
        ends = np.concatenate([[0.0], np.cumsum(self.lengths)])
        angles = self.angle + np.concatenate([[0.0], np.cumsum(self.lengths * self.curvatures)])
        corners = np.array(self.start) + np.zeros((ends.size, 2))
        for k, (length, curvature) in enumerate(zip(self.lengths, self.curvatures, strict=True)):
            corners[k + 1] = corners[k] + _arc(np.array(length), curvature, angles[k])
        piece = np.clip(np.searchsorted(ends, s, side="right") - 1, 0, self.lengths.size - 1)
        d = s - ends[piece]
        points = corners[piece] + _arc(d, self.curvatures[piece], angles[piece])
        angle = angles[piece] + self.curvatures[piece] * d
        return points, np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def nodes(self, mesh: PlanarMesh) -> np.ndarray:
        """Arc lengths of the nodes: every joint, or equal elements of the whole; halved."""
        coarse = self._coarse(mesh)
        fine = np.linspace(0.0, coarse.size - 1.0, (coarse.size - 1) * 2**mesh.halvings + 1)
        return np.interp(fine, np.arange(coarse.size), coarse)

    def count(self, mesh: PlanarMesh) -> int:
        """Elements, without making them."""
        coarse = mesh.uniform or int(self._elements(mesh).sum())
        return coarse * 2**mesh.halvings

    def _elements(self, mesh: PlanarMesh) -> np.ndarray:
        """Elements of each piece before they are halved."""
        largest = np.where(self.curvatures != 0.0, mesh.curved, mesh.straight)
        return np.maximum(1, np.ceil(self.lengths / largest - 1e-9)).astype(int)

    def _coarse(self, mesh: PlanarMesh) -> np.ndarray:
        if mesh.uniform:
            return np.linspace(0.0, self.length, mesh.uniform + 1)
        parts, start = [np.zeros(1)], 0.0
        for length, n in zip(self.lengths, self._elements(mesh), strict=True):
            parts.append(start + length * np.arange(1, n + 1) / n)
            start += length
        return np.concatenate(parts)


def _arc(d: np.ndarray, curvature: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Chord of an arc of length d that starts in direction ``angle``; stable for flat ones."""
    half = 0.5 * curvature * d
    chord = d * np.sinc(half / np.pi)
    return np.stack([chord * np.cos(angle + half), chord * np.sin(angle + half)], axis=-1)


def pieces(g: PlanarShape) -> CurvePieces:
    """The membrane of a planar geometry."""
    if isinstance(g, FlatCurve):
        return _pancake(g)
    return _circle(g) if isinstance(g, ArcCurve) else _fold(g)


def _pancake(g: FlatCurve) -> CurvePieces:
    r, inlet = g.radius, g.inlet or g.radius
    lower = 0.5 * (g.width - inlet) - 2.0 * r
    half = [(0.5 * np.pi * r, -1.0 / r), (lower, 0.0), (np.pi * r, 1.0 / r)]
    return _joined([*half, (g.width - 2.0 * r, 0.0), *half[::-1]], (0.5 * inlet, -2.0 * r))


def _circle(g: ArcCurve) -> CurvePieces:
    r, half = g.radius, 0.5 * (g.inlet or g.radius)
    opening = np.arcsin(half / r)
    start = (half, -np.sqrt(r * r - half * half))
    return CurvePieces(
        np.array([2.0 * r * (np.pi - opening)]), np.array([1.0 / r]), start, float(opening)
    )


def _fold(g: FoldCurve) -> CurvePieces:
    r, rho, panel, chamber = g.sizes
    inlet = g.inlet or g.radius
    out, back = [], []
    for sign in (1.0, -1.0):  # turn inwards, then outwards again
        out += [(np.pi * (rho + sign * r), sign / (rho + sign * r)), (panel, 0.0)]
        back += [(np.pi * (rho - sign * r), -sign / (rho - sign * r)), (panel, 0.0)]
    tip = [(np.pi * r, 1.0 / r)]
    arm = [*out, *tip, *back[::-1]]
    neck = [(0.5 * np.pi * r, -1.0 / r), (chamber - 0.5 * inlet - r, 0.0)]
    half = [*neck, *arm]
    return _joined([*half, (2.0 * chamber, 0.0), *half[::-1]], (0.5 * inlet, -2.0 * r))


def _joined(parts: list[tuple[float, float]], start: tuple[float, float]) -> CurvePieces:
    lengths, curvatures = (np.array(column) for column in zip(*parts, strict=True))
    return CurvePieces(lengths, curvatures, start, 0.5 * np.pi)


@dataclass(frozen=True)
class PlanarBag:
    """Initial geometry of a planar scene.

    Attributes
    ----------
    nodes : (n,) array
        Arc lengths.
    coefficients : (2 n, 2) array
        Hermite coefficients: positions and unit tangents.
    inlet : (m, 2) array
        Inner nodes of the inlet, from its left end to its right.
    profile : (m,) array
        Parabolic inflow profile there [T 4.30b].
    gap, extent : float
        Height H and length l of the narrowest region, closed at one end.
    """

    nodes: np.ndarray
    coefficients: np.ndarray
    inlet: np.ndarray
    profile: np.ndarray
    gap: float
    extent: float

    @property
    def perimeter(self) -> float:
        """Length of the whole boundary, Lambda."""
        chord = np.linalg.norm(self.coefficients[0] - self.coefficients[-2])
        return float(self.nodes[-1] + chord)


def planar_bag(g: PlanarShape, mesh: PlanarMesh) -> PlanarBag:
    """The bag of a planar scene."""
    curve = pieces(g)
    s = curve.nodes(mesh)
    points, tangents = curve.at(s)
    if g.asymmetry:
        # sideways, zero at the ends, without net volume to first order for a symmetric bag
        wave = 2.0 * np.pi / curve.length
        normal = np.stack([tangents[:, 1], -tangents[:, 0]], axis=1)
        points = points + g.asymmetry * np.sin(wave * s)[:, None] * normal
        tangents = tangents + g.asymmetry * wave * np.cos(wave * s)[:, None] * normal
    coefficients = np.stack([points, tangents], axis=1).reshape(-1, 2)
    x = np.linspace(-1.0, 1.0, mesh.inlet + 1)[1:-1]
    left, right = points[-1], points[0]
    inlet = 0.5 * (left + right) + 0.5 * x[:, None] * (right - left)
    return PlanarBag(s, coefficients, inlet, 1.0 - x**2, *_narrowest(g))


def _narrowest(g: PlanarShape) -> tuple[float, float]:
    if isinstance(g, ArcCurve):
        return 2.0 * g.radius, g.radius
    if isinstance(g, FlatCurve):
        return 2.0 * g.radius, 0.5 * g.width - g.radius
    r, rho, panel, chamber = g.sizes
    return 2.0 * r, chamber + 2.0 * (panel + np.pi * rho)
