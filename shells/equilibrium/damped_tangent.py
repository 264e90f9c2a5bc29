"""Tangents with a linear damping known by its action only: Newton-Krylov on the bordered system.

``[K + D, q; q^T 0] [dx; dlam] = [-r; -g]`` with sparse K, solved by GMRES preconditioned from the
left by a bordered factor of K: one structure back-solve and one D (a frozen fluid solve) an
iteration. Iterations go like the number of eigenvalues of K^-1 D above 1.
While Newton's iteration goes on K and q change and D stays. So every pair (v, D v) is kept: the
next system is solved in their span first, and GMRES looks beyond it only [de Sturler 1996]. The
factor is kept, too, until iterations tell that K has left it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .newton import LinearSolver, Matrix, Solve

KNOWN = 12  # newest pairs kept from one system to the next: each costs a back-solve there
FEW, FEW_FREE = 8, 20  # iterations with an old factor, with D and without
SPANNED, RANK = 1e-13, 1e-9  # distance from a span that unit vectors lie in; what spans nothing
ACROSS = 1e-3  # flux of vectors against that of the stiffest, from which on they are a step
LOOSE, TIGHT = 1e-3, 1e-6  # tolerances of the first system and of those near Newton's solution


@dataclass
class FrozenDamping:
    """A damping D while it stays the same, and what has been found out about it.

    Parameters
    ----------
    apply : callable, optional
        D on free coordinates ``(n,)``; default none, so that iterations cost back-solves only.
    solve : callable, optional
        Solves with the K of some earlier iterate.
    size : float
        Norm of the last residual.
    """

    apply: Solve | None = None
    solve: Solve | None = None
    size: float = 0.0
    _pairs: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)

    def __call__(self, v: np.ndarray) -> np.ndarray:
        """D v, combined from what is known where that spans v."""
        if self.apply is None:
            return np.zeros_like(v)
        x, images = self.known(v.size)
        c = np.linalg.lstsq(x, v, rcond=None)[0]
        spanned = np.linalg.norm(v - x @ c) <= SPANNED * np.linalg.norm(v)
        return np.asarray(images @ c) if spanned else self.extend(v)

    def extend(self, v: np.ndarray) -> np.ndarray:
        """D v, kept for the unit vector."""
        image = np.zeros_like(v) if self.apply is None else self.apply(v)
        size = float(np.linalg.norm(v))
        if size > 0.0:
            self._pairs.append((v / size, image / size))
        return image

    def known(self, n: int) -> tuple[np.ndarray, np.ndarray]:
        """Vectors and their images, ``(n, k)`` each."""
        pairs = np.array(self._pairs).reshape(-1, 2, n)
        return pairs[:, 0].T, pairs[:, 1].T

    def forget(self) -> None:
        """Keep the newest pairs only."""
        del self._pairs[:-KNOWN]

    def tolerance(self, residual: np.ndarray) -> float:
        """Tolerance of Newton's next update: as close to its end it gains the square of the last.

        Parameters
        ----------
        residual : (n,) array
            Of Newton's iteration.
        """
        size = float(np.linalg.norm(residual))
        gain, self.size = size / self.size if self.size > 0.0 else 1.0, size
        return TIGHT if self.apply is None else float(np.clip(gain * gain, TIGHT, LOOSE))

    @property
    def few(self) -> int:
        """Iterations with an old factor, beyond which a new one is cheaper."""
        return FEW_FREE if self.apply is None else FEW


@dataclass(frozen=True)
class DampedFactor:
    """Solver for one Newton iteration.

    Parameters
    ----------
    tangent : (n, n) sparse matrix
        K.
    damping : FrozenDamping
    factorize : callable
        Solver for a K.
    accuracy : float, optional
        Preconditioned residual over the update; default what Newton's iteration can use.
    max_iterations : int
    """

    tangent: Matrix
    damping: FrozenDamping
    factorize: LinearSolver
    accuracy: float | None = None
    max_iterations: int = 200

    def bordered(
        self, residual: np.ndarray, q: np.ndarray | None, g: float
    ) -> tuple[np.ndarray, float]:
        """Updates of x and of the multiplier.

        Raises
        ------
        RuntimeError
            GMRES stalled; Newton's iteration then ends as singular.
        """
        d = self.damping
        d.forget()
        tolerance, found = self.accuracy or d.tolerance(residual), None
        if d.solve is not None:
            found = self._gmres(_Constraint(d.solve, q), residual, g, tolerance, d.few)
        if found is None:
            d.solve = self.factorize(self.tangent)
            constraint = _Constraint(d.solve, q)
            found = self._gmres(constraint, residual, g, tolerance, self.max_iterations)
        if found is None or not np.all(np.isfinite(found[0])):
            raise RuntimeError("GMRES on the damped tangent stalled")
        return found

    def _gmres(
        self, constraint: _Constraint, residual: np.ndarray, g: float, tolerance: float, most: int
    ) -> tuple[np.ndarray, float] | None:
        """Solution of the bordered system; None where ``most`` iterations do not find it.

        Beside a first step to the constraint all vectors keep it. Eigenvalues are not below 1, so
        that the residual bounds the error.
        """
        (x, damped), (known, images) = self._split(constraint, g)

        def applied(v: np.ndarray, image: np.ndarray) -> np.ndarray:
            return constraint.project(self.tangent @ v + image)

        base, fixed = -residual - self.tangent @ x - damped, x
        b = constraint.project(base)
        left, sigma, right = np.linalg.svd(applied(known, images), full_matrices=False)
        good = sigma > RANK
        left, back = left[:, good], right[good].T / sigma[good]
        inside = np.zeros((back.shape[1], 0))
        within, y = left.T @ b, np.zeros(0)
        r = b - left @ within
        beta = rest = float(np.linalg.norm(r))
        basis, basis_images, h = r[:, None] / (beta or 1.0), np.zeros((r.size, 0)), np.zeros((1, 0))
        for j in range(most + 1):
            c = back @ (within - inside @ y)
            x = fixed + known @ c + basis[:, :j] @ y
            if rest <= tolerance * np.linalg.norm(x):
                damped = damped + images @ c + basis_images @ y
                return x, constraint.multiplier(-residual - self.tangent @ x - damped)
            if j == most:
                break
            image = self.damping.extend(basis[:, j])
            w = applied(basis[:, j], image)
            inside, basis_images = _beside(inside, left.T @ w), _beside(basis_images, image)
            w, along = w - left @ inside[:, j], np.zeros(j + 1)
            for _ in range(2):  # twice is enough [Giraud et al. 2005]
                more = basis.T @ w
                w, along = w - basis @ more, along + more
            size = float(np.linalg.norm(w))
            h = _beside(np.vstack([h, np.zeros(j)]), np.append(along, size))
            target = np.append(beta, np.zeros(j + 1))
            y = np.linalg.lstsq(h, target, rcond=None)[0]
            rest = float(np.linalg.norm(h @ y - target))
            basis = _beside(basis, w / size)
        return None

    def _split(
        self, constraint: _Constraint, g: float
    ) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """A step to the constraint, and what is known along it: vectors and their images."""
        q, n = constraint.q, self.tangent.shape[0]
        known, images = self.damping.known(n)
        if q is None:
            return (np.zeros(n), np.zeros(n)), (known, images)
        flux = q @ known
        across = constraint.along / np.linalg.norm(constraint.along)
        if np.linalg.norm(flux) <= ACROSS * abs(float(q @ across)) * max(flux.size, 1):
            self.damping.extend(across)
            known, images = self.damping.known(n)
            flux = q @ known
        share = flux / (flux @ flux)
        step = known @ share, images @ share
        along = known - np.outer(step[0], flux), images - np.outer(step[1], flux)
        return (-g * step[0], -g * step[1]), along


class _Constraint:
    """A factor of K with the constraint's row and column q around it.

    Parameters
    ----------
    solve : callable
    q : (n,) array or None
    """

    def __init__(self, solve: Solve, q: np.ndarray | None) -> None:
        self.solve, self.q = solve, q
        self.along = np.zeros(0) if q is None else solve(q)
        self.slope = 0.0 if q is None else float(q @ self.along)

    def project(self, f: np.ndarray) -> np.ndarray:
        """Displacements ``(n,)`` or ``(n, k)`` under forces, on the constraint."""
        y = self.solve(f)
        return y if self.q is None else y - np.multiply.outer(self.along, self.q @ y / self.slope)

    def multiplier(self, f: np.ndarray) -> float:
        """What holds forces ``(n,)`` on the constraint."""
        return 0.0 if self.q is None else float(self.q @ self.solve(f)) / self.slope


def _beside(a: np.ndarray, column: np.ndarray) -> np.ndarray:
    return np.column_stack([a, column])
