"""From the accuracy wanted of the traction to the tolerances of quadrature, compression, Krylov.

Lubrication amplifies operator errors: in a gap of thinness ``eps = gap / (2 extent)`` a relative
error p of the matrix becomes up to ``0.1 eps^-2.6 p`` of the traction. The tables below are
measured on disc bags (`airfold bench integrals` repeats them), interpolated in the logarithms of
eps and tolerance; the formula serves only beyond them. All other modules receive numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .surfaces.quadrature import QuadratureOrders
from .traction_error import TractionError

# Shares of the budget; the rest is what the estimates themselves may be off by.
QUADRATURE, COMPRESSION, KRYLOV = 0.5, 0.3, 0.1
AMPLIFICATION = 2.6  # exponent beyond the tables
# Error that a film's traction may have before it is corrected, see `solvers.refinement`, from this
# thinness up; below less, with the power. Other flows have up to 55 times more, and corrections
# still divide it by ten or more on 5000 elements.
CORRECTED, CORRECTED_AT, CORRECTED_POWER, LOOSEST = 7e-3, 0.05, 1.2, 1e-3
THIN = 0.2  # below, two-level Schwarz; above, the mass matrix is enough
SMALLEST_KRYLOV, LARGEST_KRYLOV = 1e-9, 1e-5

# Traction error of each rule against thinness, cheapest first: the worse of flat bags and, from
# 0.05 up, ellipsoids (at 0.02 not below 0.05). Sharp rims in thinner gaps are beyond it: ellipsoids
# (rim radius eps^2) have 1.3e-3 at 0.02, 4.6e-3 at 0.01 with the last rule, 6.0e-3, 3.9e-2 with
# the first.
THINNESS = np.array([0.01, 0.02, 0.05, 0.1, 0.3])
RULES: tuple[tuple[QuadratureOrders, tuple[float, ...]], ...] = (
    (QuadratureOrders(), (1.4e-2, 1.2e-3, 4.5e-4, 3.9e-4, 2.8e-5)),
    (QuadratureOrders.fine(), (1.4e-2, 1.2e-3, 3e-4, 3.8e-4, 2.8e-5)),
    (QuadratureOrders(far=4), (9.8e-4, 4.3e-4, 3.7e-4, 2.5e-5, 2.4e-6)),
    (replace(QuadratureOrders.fine(), far=4), (5.3e-4, 3.5e-4, 1.4e-4, 5.2e-6, 7.6e-7)),
)
# Traction error of each compression tolerance, thinness 0.01 and 0.05: the largest measured on
# disc bags of 968 to 5000 elements. At 1e-3 and 0.05, H2 costs 5.4e-4 on 968 elements, 2.1e-3 on
# 2048 and 6.7e-3 on 5000; at 1e-4, or at 0.01, the first two agree within a factor of 1.4.
COMPRESSED_AT = np.array([0.01, 0.05])
COMPRESSED: Mapping[str, tuple[np.ndarray, np.ndarray]] = {
    "aca": (
        np.array([1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8]),
        np.array(
            [
                [1.1e-1, 3.1e-2, 5.2e-3, 8.4e-4, 7e-5, 1.1e-5],
                [1.2e-2, 2.2e-3, 1.3e-4, 3.4e-5, 1.5e-6, 1.8e-7],
            ]
        ),
    ),
    "h2": (
        np.array([1e-3, 1e-4, 1e-5, 1e-6, 1e-7]),
        np.array([[7.3e-3, 7e-4, 1.1e-4, 8e-6, 2e-7], [6.7e-3, 9e-5, 2.9e-6, 5.7e-7, 1.4e-8]]),
    ),
}
# Traction error of the mesh against element size over film length: equal spheres that approach
# each other, density of degree 2, meshes of 6 x 6 and 8 x 8 elements.
FILM = np.array([0.56, 0.74, 1.0, 1.35, 1.8, 2.3, 3.2, 4.3, 5.5])
FILM_ERROR = np.array([2.3e-3, 5.3e-3, 2.2e-2, 4.5e-2, 6.0e-2, 7.8e-2, 0.27, 0.5, 0.74])
# Traction error over true residual, two-level Schwarz.
RESIDUAL_AT, RESIDUAL = np.array([0.01, 0.05]), np.array([64.0, 9.0])


@dataclass(frozen=True)
class Budget:
    """Tolerances that a traction error allows in the narrowest gap.

    Parameters
    ----------
    traction : float
        Relative traction error asked for.
    thinness : float
        ``eps = gap / (2 extent)``.
    orders : QuadratureOrders
    compression : mapping
        Relative matrix tolerance by method, ``"aca"`` and ``"h2"``.
    krylov : float
        True relative residual.
    preconditioner : str
        ``"schwarz"`` or ``"mass"``.
    predicted : mapping
        Traction error expected from ``quadrature``, ``compression`` and ``krylov``.
    mesh : float
        Traction error expected of the mesh in the film of the narrowest gap; NaN where only a
        solve can tell.
    warnings : tuple of str
        What cannot be met, with numbers and remedy; empty if everything can.
    """

    traction: float
    thinness: float
    orders: QuadratureOrders
    compression: Mapping[str, float]
    krylov: float
    preconditioner: str
    predicted: Mapping[str, float]
    mesh: float
    warnings: tuple[str, ...]

    @property
    def corrected(self) -> Mapping[str, float]:
        """Matrix tolerances by method where every solve is corrected by exact sums."""
        film = CORRECTED * min(1.0, self.thinness / CORRECTED_AT) ** CORRECTED_POWER
        loose = {m: min(matrix_tolerance(m, film, self.thinness), LOOSEST) for m in COMPRESSED}
        return {m: max(t, loose[m]) for m, t in self.compression.items()}

    @property
    def met(self) -> bool:
        """Whether everything can be met."""
        return not self.warnings

    @property
    def expected(self) -> TractionError:
        """The traction error expected, share by share, and its verdict before any solve."""
        p = self.predicted
        return TractionError(
            self.traction, self.mesh, p["quadrature"], p["compression"], p["krylov"]
        )

    @property
    def total(self) -> float:
        """Sum of the traction errors expected of everything but the mesh."""
        return sum(self.predicted.values())

    def krylov_error(self, residual: float) -> float:
        """Traction error expected of a true relative residual of the linear system."""
        return residual * _at(self.thinness, RESIDUAL_AT, RESIDUAL)

    def describe(self) -> dict[str, float | str | None]:
        """Plain numbers for records.

        Returns
        -------
        dict of str to float, str or None
        """
        o = self.orders
        return {
            "traction": self.traction,
            "thinness": self.thinness,
            "near_rule": f"{o.near_offset:g} + {o.near_slope:g} ln(1/b)",
            "polar_rule": f"{o.radial} x {o.angular}",
            "outer_points": o.outer,
            "far_points": o.source,
            "compression_aca": self.compression["aca"],
            "compression_h2": self.compression["h2"],
            "krylov": self.krylov,
            **{f"predicted_{name}": value for name, value in self.predicted.items()},
            "predicted_mesh": self.expected.describe()["mesh"],
            "verdict": self.expected.verdict.value,
        }


def thinness(gap: float, extent: float) -> float:
    """``eps = gap / (2 extent)`` of a gap between two sheets.

    Raises
    ------
    ValueError
        A gap or extent that is not positive.
    """
    if not (gap > 0.0 and extent > 0.0):
        raise ValueError(f"gap and extent must be positive, got {gap:g} and {extent:g}")
    return gap / (2.0 * extent)


def budget(traction: float, gap: float, extent: float, film: float = 0.0) -> Budget:
    """Tolerances for a relative traction error.

    Parameters
    ----------
    traction : float
        In (0, 1).
    gap, extent : float
        Sheet distance and lateral extent of the narrowest gap; infinite gaps are fat bodies.
    film : float
        Element size over ``sqrt(gap R)``, the length over which a curved gap changes; 0 where
        that is not known.

    Returns
    -------
    Budget

    Raises
    ------
    ValueError
        A traction error outside (0, 1), or a gap or extent that is not positive.
    """
    if not 0.0 < traction < 1.0:
        raise ValueError(f"the traction error must lie in (0, 1), got {traction:g}")
    eps = thinness(gap, extent)
    errors = [_at(eps, THINNESS, np.array(row)) for _, row in RULES]
    enough = [i for i, error in enumerate(errors) if error <= QUADRATURE * traction]
    chosen = enough[0] if enough else int(np.argmin(errors))
    amplification = _at(eps, RESIDUAL_AT, RESIDUAL)
    krylov = KRYLOV * traction / amplification
    krylov = min(max(krylov, SMALLEST_KRYLOV), LARGEST_KRYLOV)
    predicted = {
        "quadrature": errors[chosen],
        "compression": COMPRESSION * traction,
        "krylov": krylov * amplification,
    }
    return Budget(
        traction,
        eps,
        RULES[chosen][0],
        {method: matrix_tolerance(method, COMPRESSION * traction, eps) for method in COMPRESSED},
        krylov,
        "schwarz" if eps < THIN else "mass",
        predicted,
        film_error(film) if film > 0.0 else math.nan,
        _warnings(traction, eps, errors[chosen], krylov * amplification),
    )


def matrix_tolerance(method: str, traction: float, eps: float) -> float:
    """Compression tolerance that costs the given traction error at thinness eps.

    Above the table's thinness its last row serves, which is safe.
    """
    tolerances, rows = COMPRESSED[method]
    logs = [np.interp(np.log(traction), np.log(r[::-1]), np.log(tolerances[::-1])) for r in rows]
    # beyond the ends of a row errors are proportional to tolerances
    for i, row in enumerate(rows):
        logs[i] += min(0.0, math.log(traction / row[-1])) + max(0.0, math.log(traction / row[0]))
    x = np.clip(np.log(eps), *np.log(COMPRESSED_AT))
    tolerance = math.exp(np.interp(x, np.log(COMPRESSED_AT), logs))
    return min(tolerance * min(1.0, eps / COMPRESSED_AT[0]) ** AMPLIFICATION, 1e-2)


def compression_error(method: str, tolerance: float, eps: float) -> float:
    """Traction error expected of a compression tolerance at thinness eps."""
    low, high = 1e-14, 1.0
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (
            (middle, high) if matrix_tolerance(method, middle, eps) < tolerance else (low, middle)
        )
    return math.sqrt(low * high)


def larger_unknowns(n_elements: int, degree: int, shape: str = "quadrilateral") -> int:
    """Unknowns of the density space that measures the mesh's share, see `flows.mesh_share`."""
    columns = degree + 1 if shape == "quadrilateral" else 0.5 * degree + 1.0
    return int(3 * n_elements * (degree + 1) * columns)


def film_error(film: float) -> float:
    """Traction error expected of elements ``film`` film lengths long, at most 1.

    Smaller elements than the table's: third order, that of degree 2.
    """
    inside = math.exp(np.interp(math.log(film), np.log(FILM), np.log(FILM_ERROR)))
    return min(1.0, inside * min(1.0, film / FILM[0]) ** 3 * max(1.0, film / FILM[-1]))


def at_gap(asked: Budget, gap: float, extent: float) -> Budget:
    """A budget as it stands once its gap has closed to another one."""
    return replace(asked, thinness=thinness(gap, extent))


def _at(eps: float, at: np.ndarray, values: np.ndarray) -> float:
    """Interpolate in logarithms; thinner than the table, grow by the amplification."""
    inside = math.exp(np.interp(math.log(eps), np.log(at), np.log(values)))
    return inside * max(1.0, at[0] / eps) ** AMPLIFICATION


def _warnings(traction: float, eps: float, quadrature: float, krylov: float) -> tuple[str, ...]:
    found = []
    if quadrature > QUADRATURE * traction:
        remedy = _round_up(quadrature / QUADRATURE)
        found.append(
            f"fluid.tolerance = {traction:g} cannot be met in a gap of thinness {eps:.2g}: even "
            f"the finest rule leaves a traction error of about {quadrature:.1e} (half of the "
            f"tolerance is allowed); set fluid.tolerance to {remedy:g}, or open the gap"
        )
    if krylov > KRYLOV * traction * 1.001:
        found.append(
            f"fluid.tolerance = {traction:g} asks for a residual below {SMALLEST_KRYLOV:g}, which "
            f"rounding hides at thinness {eps:.2g}; set fluid.tolerance to "
            f"{_round_up(krylov / KRYLOV):g}"
        )
    if eps < THINNESS[0]:
        found.append(
            f"the gap is thinner ({eps:.2g}) than the measured range ({THINNESS[0]:g}): errors are "
            "extrapolated as eps^-2.6"
        )
    return tuple(found)


def _round_up(value: float) -> float:
    """The next number with one digit."""
    scale = 10.0 ** math.floor(math.log10(value))
    return math.ceil(value / scale - 1e-9) * scale
