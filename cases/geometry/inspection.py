"""What a folded bag is like before it is run: stretches, resolution, gaps, what its patch faces.

Measured on the fitted surface, not on the exact one: a mesh too coarse for its folds shows here.
Needs neither scikit-fem nor numba; crossings need the optional extra ``contact``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .crumple import sampled
from .folded import FoldedBag

ELEMENTS_PER_RADIUS = 1.0  # below: folds are not resolved; 2 give strains to 3 %
QUANTILES = (0.0, 0.01, 0.99, 1.0)
AT_REST = 1e-10  # strains below which their signs are rounding


@dataclass(frozen=True)
class Inspection:
    """Figures of a folded bag.

    Attributes
    ----------
    stretches : (4,) array
        Principal stretches against the flat bag: smallest, 1 % and 99 % quantile by area, largest.
    per_radius : float
        Elements per fold radius along the folds' direction, at the coarsest place of a fold.
    curvature : float
        Largest ``|gap kappa / 2|``, 1 where a sheet turns inside out.
    faced : float
        Distance from the inlet outward to the nearest sheet; infinite if there is none.
    crosses : bool
        Whether the bag crosses itself.
    """

    stretches: np.ndarray
    per_radius: float
    curvature: float
    faced: float
    crosses: bool

    def warnings(self) -> list[str]:
        """Rules that are broken, with the remedy."""
        found = []
        if self.crosses:
            found.append(
                "the folded bag crosses itself: refine the mesh (mesh.around) or lower geometry.gap"
            )
        if self.per_radius < 0.75 * ELEMENTS_PER_RADIUS:
            found.append(
                f"{self.per_radius:.2g} elements a fold radius: below 1 the fold is a polygon, "
                f"and strains need 2 (3 % error); raise mesh.around by "
                f"{2.0 / self.per_radius:.2g}"
            )
        if self.faced < np.inf:
            found.append(
                f"the inlet faces a sheet {self.faced:.3g} away and would suck it in; "
                "use a fold whose end panel is outermost"
            )
        return found


def inspect(bag: FoldedBag) -> Inspection:
    """Measure a folded bag."""
    return Inspection(
        stretches(bag),
        _elements_per_radius(bag),
        bag.folding.bending,
        faced(bag),
        _crosses(bag),
    )


def _tangents(bag: FoldedBag, c: np.ndarray, points: int = 2) -> tuple[np.ndarray, np.ndarray]:
    x = np.polynomial.legendre.leggauss(points)[0]
    xi, eta = (0.5 * (g.ravel() + 1.0) for g in np.meshgrid(x, x, indexing="ij"))
    s, t = (bag.membrane.sample(xi, eta, k) @ c[: bag.n_membrane] for k in (0, 1))
    return s, t


def metric(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """First fundamental form ``(n, 2, 2)`` of tangents ``(n, 3)``."""
    st = np.sum(s * t, axis=1)
    return np.array([[np.sum(s * s, axis=1), st], [st, np.sum(t * t, axis=1)]]).transpose(2, 0, 1)


def stretches(bag: FoldedBag) -> np.ndarray:
    """Quantiles of the principal stretches of the folded against the flat bag, by flat area."""
    flat, folded = (metric(*_tangents(bag, c)) for c in (bag.flat, bag.coefficients))
    squares = np.linalg.eigvals(np.linalg.solve(flat, folded)).real
    order = np.argsort(squares, axis=None)
    area = np.repeat(np.sqrt(np.linalg.det(flat)), 2)[order]
    share = np.cumsum(area) / area.sum()
    at = np.minimum(np.searchsorted(share, QUANTILES), order.size - 1)
    return np.sqrt(squares.ravel()[order][at])


def principal_strains(natural: np.ndarray, now: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal Green strains e1 >= e2 between metrics ``(n, 2, 2)`` of the same parameters."""
    strain = 0.5 * (np.linalg.solve(natural, now) - np.eye(2))
    mean = 0.5 * np.trace(strain, axis1=1, axis2=2)
    radius = np.sqrt(np.maximum(mean**2 - np.linalg.det(strain), 0.0))
    return mean + radius, mean - radius


def zones(e1: np.ndarray, e2: np.ndarray, poisson_ratio: float) -> np.ndarray:
    """State of a tension field: 0 taut (or at rest), 1 wrinkled, 2 slack."""
    state = np.where(e2 + poisson_ratio * e1 > 0.0, 0, np.where(e1 > 0.0, 1, 2))
    return np.where(np.maximum(np.abs(e1), np.abs(e2)) > AT_REST, state, 0)


def strain_energy(bag: FoldedBag, poisson_ratio: float = 0.0, share: float = 1.0) -> float:
    """Membrane energy of the folded against the flat bag, of unit stiffness [T 2.17].

    With a share below 1, of a tension field that keeps it against compression.
    """
    flat, folded = (metric(*_tangents(bag, c, 3)) for c in (bag.flat, bag.coefficients))
    e1, e2 = principal_strains(flat, folded)
    density = e1**2 + e2**2 + 2.0 * poisson_ratio * e1 * e2
    state = zones(e1, e2, poisson_ratio)
    relaxed = np.where(state == 1, (1.0 - poisson_ratio**2) * e1**2, 0.0)
    density = np.where(state == 0, density, share * density + (1.0 - share) * relaxed)
    w = np.polynomial.legendre.leggauss(3)[1]
    weights = np.tile(0.25 * np.outer(w, w).ravel(), bag.membrane.n_elements)
    return float(0.5 * (weights * np.sqrt(np.linalg.det(flat))) @ density)


def _elements_per_radius(bag: FoldedBag) -> float:
    """Fold radius over the longest element side along x of the flat bag, on folds."""
    if not np.isfinite(bag.folding.radius):
        return np.inf
    middle = np.array([0.5])
    c = bag.flat[: bag.n_membrane]
    x = (bag.membrane.sample(middle, middle) @ c)[:, 0]
    inside = np.zeros(x.size, dtype=bool)
    for a, b in bag.folding.panels:
        inside |= (x > a) & (x < b)
    folds = ~inside if not inside.all() else inside  # a roll is fold everywhere
    s, t = (np.abs((bag.membrane.sample(middle, middle, k) @ c)[:, 0]) for k in (0, 1))
    return float(bag.folding.radius / np.maximum(s, t)[folds].max())


def faced(bag: FoldedBag) -> float:
    """Shortest distance from the patch along its outward normal to another sheet."""
    middle = np.array([0.5])
    c = bag.coefficients[bag.n_membrane :]
    origin = bag.inlet.sample(middle, middle) @ c
    normal = np.cross(*(bag.inlet.sample(middle, middle, k) @ c for k in (0, 1)))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    corners = np.array([0.0, 1.0])
    xi, eta = (g.ravel() for g in np.meshgrid(corners, corners, indexing="ij"))
    quads = bag.membrane.sample(xi, eta) @ bag.coefficients[: bag.n_membrane]
    quads = quads.reshape(-1, 4, 3)
    triangles = np.concatenate([quads[:, [0, 2, 3]], quads[:, [0, 3, 1]]])
    hits = [_first_hit(o, n, triangles) for o, n in zip(origin, normal, strict=True)]
    return float(min(hits))


def _first_hit(origin: np.ndarray, direction: np.ndarray, triangles: np.ndarray) -> float:
    """Distance along a ray to the nearest triangle (Moeller and Trumbore), infinite if none."""
    a, b, c = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(direction, c)
    det = np.einsum("ij,ij->i", b, p)
    det[det == 0.0] = np.nan  # parallel to the ray or collapsed: no hit
    to = origin - a
    q = np.cross(to, b)
    u = np.einsum("ij,ij->i", to, p) / det
    v = (q @ direction) / det
    t = np.einsum("ij,ij->i", c, q) / det
    hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 1e-9)
    return float(t[hit].min()) if hit.any() else np.inf


def _crosses(bag: FoldedBag) -> bool:
    whole = bag.membrane.restrict(np.arange(bag.membrane.n_s * bag.membrane.n_t))
    c = np.empty((whole.n_coefficients, 3))
    c[bag.inlet.kept] = bag.coefficients[bag.n_membrane :]
    c[bag.membrane.kept] = bag.coefficients[: bag.n_membrane]
    return sampled(whole, c, 4).intersects(c)
