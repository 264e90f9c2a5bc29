"""The narrowest gap between facing elements: the true closest distance, not that of samples.

Candidates are pairs of elements whose samples face each other, or lie on different bodies; Newton
on both points at once finds the closest points of each pair. Between bodies the smallest distance
counts. Walls of one body meet at their common rim: only points count whose normals lie along the
segment between them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._threads_kernels import over
from ..surfaces.surface_points import SampledSurface
from . import _facing_kernels as kernels
from .facing_candidates import body_labels, facing_candidates, neighbouring_pairs

TILT = 0.02  # largest sine between normals and segment where walls of one body face each other
TOUCHING = 1e-9  # distances below this fraction of an element are its neighbours' edges
POLE = 1e-7  # local coordinates this far from an edge have a normal even if it is collapsed
REFINED = 8  # pairs of elements around which their neighbours are tried too


@dataclass(frozen=True)
class FacingGap:
    """Two points, each the closest of its wall to the other.

    Parameters
    ----------
    distance : float
    elements : (2,) int array
    local : (2, 2) array
        Local coordinates s, t on each element.
    points, normals : (2, 3) array
        Positions and outward unit normals there.
    curvature_radius : float
        Of the gap: it grows by ``xi^2 / (2 R)`` at the lateral distance xi. Half the radius of two
        equal spheres; infinite between parallel walls. The gap changes over
        ``sqrt(distance R)``, the length of a lubrication film.
    element_size : (2,) array
        Length of the longer coordinate line through the point of each element.
    """

    distance: float
    elements: np.ndarray
    local: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    curvature_radius: float
    element_size: np.ndarray

    @property
    def film_length(self) -> float:
        """Lateral distance over which the gap changes, ``sqrt(distance R)``."""
        return float(np.sqrt(self.distance * self.curvature_radius))


def closest_facing(surface: SampledSurface) -> FacingGap | None:
    """The closest points of facing walls, of one body or of several.

    Parameters
    ----------
    surface : SampledSurface

    Returns
    -------
    FacingGap or None
        None where no wall faces another.
    """
    body = body_labels(surface)
    first, second, start = facing_candidates(surface, body)
    if first.size == 0:
        return None
    found = _Pairs.closest(surface, body, first, second, start)
    best = found.order()[:REFINED]
    if best.size == 0:
        return None
    near = neighbouring_pairs(surface, found.elements[best], found.local[best])
    found = found.joined(_Pairs.closest(surface, body, *near))
    return found.gap(surface, int(found.order()[0]))


@dataclass(frozen=True)
class _Pairs:
    """Closest points of pairs of elements, where normals lie along the segment or bodies differ."""

    elements: np.ndarray
    local: np.ndarray
    distance: np.ndarray
    sine: np.ndarray  # between segment and normals, 0 of different bodies

    @classmethod
    def closest(
        cls,
        surface: SampledSurface,
        body: np.ndarray,
        first: np.ndarray,
        second: np.ndarray,
        start: np.ndarray,
    ) -> _Pairs:
        """Move the starts ``(n, 4)`` to closest points; the starts themselves count too."""
        local, distance = start.copy(), np.empty(first.size)
        patches = surface.shapes.powers, surface.control
        over(first.size, kernels.approach_all, *patches, first, second, local, distance)
        elements = np.tile(np.stack([first, second], axis=1), (2, 1))
        local = np.concatenate([local, start]).reshape(-1, 2, 2)
        segment = np.subtract(*(_jets(surface, elements[:, i], local[:, i])[:, 0] for i in (1, 0)))
        inside = np.clip(local, POLE, 1.0 - POLE)
        jets = [_jets(surface, elements[:, i], inside[:, i]) for i in range(2)]
        distance = np.linalg.norm(segment, axis=1)
        direction = segment / np.maximum(distance, 1e-300)[:, None]
        a, b = (np.sum(direction * _normals(jet), axis=1) for jet in jets)
        cosine = np.where(a * b < 0.0, np.minimum(np.abs(a), np.abs(b)), 0.0)
        sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
        apart = body[elements[:, 0]] != body[elements[:, 1]]
        # where elements of one body touch there is no segment that normals could lie along
        touching = distance < TOUCHING * surface.radii[elements].max(axis=1)
        sine = np.where(touching, 1.0, sine)
        return cls(elements, local, distance, np.where(apart, 0.0, sine))

    def joined(self, other: _Pairs) -> _Pairs:
        names = ("elements", "local", "distance", "sine")
        return _Pairs(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in names))

    def order(self) -> np.ndarray:
        """Facing pairs, closest first."""
        kept = np.flatnonzero(self.sine <= TILT)
        return kept[np.argsort(self.distance[kept], kind="stable")]

    def gap(self, surface: SampledSurface, k: int) -> FacingGap:
        elements, local = self.elements[k], self.local[k]
        jets = _jets(surface, elements, local)
        # at a collapsed point curvature has no coordinates: a little inside it has
        inside = _jets(surface, elements, np.clip(local, 0.02, 0.98))
        return FacingGap(
            float(self.distance[k]),
            elements,
            local,
            jets[:, 0] + surface.origin,
            _normals(inside),
            _curvature_radius(inside, jets[1, 0] - jets[0, 0]),
            np.linalg.norm(jets[:, 1:3], axis=2).max(axis=1),
        )


def _jets(surface: SampledSurface, elements: np.ndarray, local: np.ndarray) -> np.ndarray:
    out = np.empty((elements.size, 6, 3))
    arrays = np.ascontiguousarray(elements), np.ascontiguousarray(local)
    over(out.shape[0], kernels.jets, surface.shapes.powers, surface.control, *arrays, out)
    return out


def _normals(jets: np.ndarray) -> np.ndarray:
    normal = np.cross(jets[:, 1], jets[:, 2])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)


def _curvature_radius(jets: np.ndarray, segment: np.ndarray) -> float:
    """Radius of the gap's largest relative principal curvature."""
    normals = _normals(jets)
    axis = segment if np.any(segment) else normals[0]
    axis = axis / np.abs(axis).max()  # squares of tiny gaps would vanish
    axis = axis / np.linalg.norm(axis)
    _, _, plane = np.linalg.svd(axis[None])
    curvature = []
    for jet, normal in zip(jets, normals, strict=True):
        slopes = plane[1:] @ jet[1:3].T
        bend = jet[3:] @ normal * np.sign(normal @ axis)
        inverse = np.linalg.pinv(slopes)
        curvature.append(inverse.T @ np.array([bend[:2], bend[1:]]) @ inverse)
    largest = np.abs(np.linalg.eigvalsh(curvature[1] - curvature[0])).max()
    return float(1.0 / largest) if largest > 0.0 else np.inf
