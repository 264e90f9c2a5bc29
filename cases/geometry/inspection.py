"""What a folded bag is like before it is run: stretches, resolution, gaps, what its patch faces.

Measured on the fitted surface, not on the exact one: a mesh too coarse for its folds shows here.
Needs neither scikit-fem nor numba.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shells.surfaces.local_elements import lattice, middle, rule

from .bag import Bag
from .bag_sampler import corner_triangles, tangents, triangulated
from .rays import first_hits

ELEMENTS_PER_RADIUS = 1.0  # below: folds are not resolved; 2 give strains to 3 %
QUANTILES = (0.0, 0.01, 0.99, 1.0)
CELLS = 4  # per element side, of the test for crossings
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

    def warnings(self, finer: str) -> list[str]:
        """Rules that are broken, with the remedy; ``finer`` says how a mesh is refined."""
        found = []
        if self.crosses:
            found.append(
                f"the folded bag crosses itself: {finer}, or give its sheets less distance"
            )
        if self.per_radius < 0.75 * ELEMENTS_PER_RADIUS:
            found.append(
                f"{self.per_radius:.2g} elements a fold radius: below 1 the fold is a polygon, "
                f"and strains need 2 (3 % error): {finer} by {2.0 / self.per_radius:.2g}"
            )
        if self.faced < np.inf:
            found.append(
                f"the inlet faces a sheet {self.faced:.3g} away and would suck it in; "
                "use a fold whose end panel is outermost"
            )
        return found


def inspect(bag: Bag) -> Inspection:
    """Measure a folded bag."""
    return Inspection(
        stretches(bag),
        _elements_per_radius(bag),
        0.0 if bag.folding is None else bag.folding.bending,
        faced(bag),
        triangulated(bag, CELLS).intersects(bag.coefficients),
    )


def _metrics(bag: Bag, points: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Metrics of the flat and of the folded membrane at points of a rule, and its weights."""
    membrane, n = bag.membrane, bag.n_membrane
    xi, eta, weights = rule(membrane.shape, points)
    flat, folded = (
        metric(*tangents(membrane, c[:n], (xi, eta))) for c in (bag.cut, bag.coefficients)
    )
    return flat, folded, np.tile(weights, membrane.n_elements)


def metric(s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """First fundamental form ``(n, 2, 2)`` of tangents ``(n, 3)``."""
    st = np.sum(s * t, axis=1)
    return np.array([[np.sum(s * s, axis=1), st], [st, np.sum(t * t, axis=1)]]).transpose(2, 0, 1)


def stretches(bag: Bag) -> np.ndarray:
    """Quantiles of the principal stretches of the folded against the flat bag, by flat area."""
    flat, folded, weights = _metrics(bag, 2)
    squares = np.linalg.eigvals(np.linalg.solve(flat, folded)).real
    order = np.argsort(squares, axis=None)
    area = np.repeat(weights * np.sqrt(np.linalg.det(flat)), 2)[order]
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


def strain_energy(bag: Bag, poisson_ratio: float = 0.0, share: float = 1.0) -> float:
    """Membrane energy of the folded against the flat bag, of unit stiffness [T 2.17].

    With a share below 1, of a tension field that keeps it against compression.
    """
    flat, folded, weights = _metrics(bag, 3)
    e1, e2 = principal_strains(flat, folded)
    density = e1**2 + e2**2 + 2.0 * poisson_ratio * e1 * e2
    state = zones(e1, e2, poisson_ratio)
    relaxed = np.where(state == 1, (1.0 - poisson_ratio**2) * e1**2, 0.0)
    density = np.where(state == 0, density, share * density + (1.0 - share) * relaxed)
    return float(0.5 * (weights * np.sqrt(np.linalg.det(flat))) @ density)


def _elements_per_radius(bag: Bag) -> float:
    """Fold radius over the longest element along x of the flat bag, on folds."""
    fold = bag.folding
    if fold is None or not np.isfinite(fold.radius):
        return np.inf
    xi, eta, _ = lattice(bag.membrane.shape, 1)
    x = (bag.membrane.sample(xi, eta) @ bag.cut[: bag.n_membrane])[:, 0].reshape(-1, xi.size)
    centre, size = x.mean(axis=1), np.ptp(x, axis=1)
    inside = np.zeros(centre.size, dtype=bool)
    for a, b in fold.panels:
        inside |= (centre > a) & (centre < b)
    folds = ~inside if not inside.all() else inside  # a roll is fold everywhere
    return float(fold.radius / size[folds].max())


def faced(bag: Bag) -> float:
    """Shortest distance from the patch along its outward normal to another sheet."""
    assert bag.inlet is not None  # asked of bags with a patch only
    c = bag.coefficients[bag.n_membrane :]
    xi, eta, _ = middle(bag.inlet.shape)
    origin = bag.inlet.sample(xi, eta) @ c
    normal = np.cross(*tangents(bag.inlet, c, (xi, eta)))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    triangles = corner_triangles(bag.membrane, bag.coefficients[: bag.n_membrane])
    return float(first_hits(origin, normal, triangles).min())
