"""Rigid motions: the near-null space of an unstressed shell, and which of them supports leave free.

A motion is free if its coefficients lie in the range of the extraction E; static equilibrium of
an unstressed shell is then undetermined, and the tangent singular. Pieces that a restriction cuts
off from each other move on their own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu
from skfem import BilinearForm, LinearForm

from ..surfaces.curve import CurveBasis
from ..surfaces.element_basis import ElementBasis


def rigid_modes(points: np.ndarray) -> np.ndarray:
    """Translations and rotations of points ``(n, 3)`` about their centre: ``(3 n, 6)``."""
    eye, arms = np.eye(3), points - points.mean(axis=0)
    shifts = np.tile(eye, (points.shape[0], 1))
    return np.column_stack([shifts, *(np.cross(axis, arms).ravel() for axis in eye)])


@dataclass(frozen=True)
class Mechanism:
    """Free rigid motions.

    Attributes
    ----------
    motions : (n, 6 n_pieces) array
        Orthonormal combinations of three translations and three rotations about its centre (arms
        in units of the structure's length) for each piece.
    modes : (n_dofs, 6 n_pieces) array
        Those translations and rotations of all vector dofs.
    elements : tuple of int arrays
        Element numbers of each piece of the surface; one piece where it is connected.
    """

    motions: np.ndarray
    modes: np.ndarray
    elements: tuple[np.ndarray, ...] = ()

    def under(self, grounding: csr_matrix | None) -> Mechanism:
        """The motions that a stiffness leaves free besides.

        Parameters
        ----------
        grounding : (n, n) sparse matrix or None
            Positive on the rigid motions that it holds; of the first n dofs.
        """
        if grounding is None or not self.motions.size:
            return self
        modes = self.modes[: grounding.shape[0]] @ self.motions.T
        values, vectors = np.linalg.eigh(modes.T @ (grounding @ modes))
        free = values < 1e-9 * abs(grounding).max() * np.square(modes).sum(axis=0).max()
        return Mechanism(_simplest(vectors[:, free].T @ self.motions), self.modes, self.elements)

    def refuse(self, dead: bool = True) -> None:
        """Raise if any motion is free.

        Parameters
        ----------
        dead : bool
            The loads are dead, so that `minimise` takes them.

        Raises
        ------
        ValueError
            Naming the motions, the piece that moves, and the remedy.
        """
        if self.motions.shape[0] == 0:
            return
        other = ", or use shells.minimise, which needs no supports" if dead else ""
        raise ValueError(
            f"the supports leave {self.motions.shape[0]} rigid motion(s) free: {self.names}; "
            f"support them (shells.pin or another edge){other}"
        )

    def refuse_resultant(self, force: np.ndarray) -> None:
        """Raise if a dead load does work on a free translation: nothing will ever balance it.

        Raises
        ------
        ValueError
            Naming the translation and the resultant.
        """
        if self.motions.shape[0] == 0:
            return
        turns = self.motions.reshape(self.motions.shape[0], -1, 6)[..., 3:]
        pure = Mechanism(
            self.motions[np.abs(turns).max(axis=(1, 2), initial=0.0) < 1e-9],
            self.modes,
            self.elements,
        )
        work = pure.motions @ (self.modes.T @ force.ravel())
        if (bad := np.abs(work) > 1e-9 * np.abs(force).sum()).any():
            first = Mechanism(pure.motions[bad][:1], self.modes, self.elements)
            raise ValueError(
                f"the load has a resultant of {work[bad][0]:.3g} along a free {first.names}: "
                "no deformation balances it; support that motion or balance the load"
            )

    @property
    def names(self) -> str:
        """The motions in words, dominant parts first, and the pieces that move."""
        words = [
            f"{kind} {axis}" for kind in ("translation along", "rotation about") for axis in "xyz"
        ]
        strong = np.abs(self.motions.reshape(self.motions.shape[0], -1, 6)) > 0.3
        named: dict[tuple[int, ...], list[str]] = {}
        for motion in strong:
            moving = tuple(np.flatnonzero(motion.any(axis=1)).tolist())
            parts = " with ".join(w for w, s in zip(words, motion.any(axis=0), strict=True) if s)
            named.setdefault(moving, []).append(parts)
        if len(self.elements) < 2:
            return ", ".join(part for parts in named.values() for part in parts)
        return "; ".join(f"{', '.join(p)} of {self._pieces(k)}" for k, p in named.items())

    def _pieces(self, moving: tuple[int, ...]) -> str:
        """Pieces in words."""
        parts = [
            f"{part.size} element(s) from number {part.min()} to {part.max()}"
            for part in (self.elements[k] for k in moving)
        ]
        return (
            f"the unsupported piece of {' and that of '.join(parts)} (the restriction cuts the "
            f"surface into {len(self.elements)} pieces without a common edge)"
        )


def mechanism(extraction: csr_matrix, basis: ElementBasis | CurveBasis) -> Mechanism:
    """Free rigid motions of the reference of a vector basis under an extraction ``E``."""
    n = basis.N // basis.dimension
    if isinstance(basis, CurveBasis):
        points, piece, axes = basis.coefficients, np.zeros(n, dtype=int), np.array([0, 1, 5])
        elements: tuple[np.ndarray, ...] = ()
    else:
        surface, axes = basis.surface, np.arange(6)
        points, piece = coefficients_of(basis), surface.coefficient_pieces
        numbers = surface.element_numbers
        elements = tuple(numbers[surface.pieces == k] for k in np.unique(surface.pieces))
    length, count = float(np.ptp(points, axis=0).max()), int(piece.max()) + 1
    made = plane_modes if isinstance(basis, CurveBasis) else rigid_modes
    modes = np.zeros((extraction.shape[0], count, 6))
    own = modes[: basis.N].reshape(n, basis.dimension, count, 6)
    for k in range(count):
        part = piece == k
        own[part, :, k] = made(points[part] / length).reshape(part.sum(), basis.dimension, 6)
    modes = modes.reshape(extraction.shape[0], 6 * count)
    axes = (6 * np.arange(count)[:, None] + axes).ravel()  # those that stay in the plane
    E = extraction.tocsc()
    outside = modes - E @ splu((E.T @ E).tocsc()).solve(E.T @ modes)
    _, values, reduced = np.linalg.svd(outside[:, axes], full_matrices=False)
    rows = np.zeros((values.size, 6 * count))
    rows[:, axes] = reduced
    # 1e-7 of a coefficient's motion: a support moves whole coefficients, rounding none
    free = values < 1e-7 * np.sqrt(n)
    return Mechanism(_simplest(rows[free]), modes, elements)


def _simplest(motions: np.ndarray) -> np.ndarray:
    """Another basis of the same span with as many pure motions as possible (pivoted)."""
    if motions.shape[0] < 2:
        return motions
    reduced = motions.copy()
    for i in range(reduced.shape[0]):
        rest = np.abs(reduced[i:])
        row, column = np.unravel_index(rest.argmax(), rest.shape)
        reduced[[i, i + row]] = reduced[[i + row, i]]
        reduced[i] /= reduced[i, column]
        others = np.arange(reduced.shape[0]) != i
        reduced[others] -= np.outer(reduced[others, column], reduced[i])
    return reduced / np.linalg.norm(reduced, axis=1, keepdims=True)


def plane_modes(coefficients: np.ndarray) -> np.ndarray:
    """The three motions in the plane of Hermite coefficients ``(n, 2)``, others zero: ``(2 n, 6)``.

    Every second coefficient is a derivative: it turns but does not translate.
    """
    modes = np.zeros((*coefficients.shape, 6))
    modes[::2, 0, 0] = modes[::2, 1, 1] = 1.0
    modes[:, 0, 5], modes[:, 1, 5] = -coefficients[:, 1], coefficients[:, 0]
    return modes.reshape(-1, 6)


def coefficients_of(basis: ElementBasis) -> np.ndarray:
    """Coefficients ``(n, 3)`` of the reference: its L2 projection (exact for spline references)."""
    scalar = basis.scalar
    mass = BilinearForm(lambda u, v, w: u * v).assemble(scalar)
    load = [LinearForm(lambda v, w, i=i: w.x[i] * v).assemble(scalar) for i in range(3)]
    return splu(mass.tocsc()).solve(np.stack(load, axis=1))
