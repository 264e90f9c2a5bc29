"""A solve that measures its own error: compression and quadrature, in the norm of the traction.

Compression: the residual with exact sums, or with an operator compressed thirty times more
sharply where those cost too much, see `hbem.solvers.refinement`. Quadrature: the residual with the
next finer rule, whose near field is assembled once for a geometry. Both corrections are added, and
repeated until the error left is below what was asked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..accuracy import COMPRESSION, QUADRATURE
from ..layers.choice import OWN, sharper
from ..layers.compressed_layer import CompressedSingleLayer, compressed_single_layer
from ..layers.direct_layer import DirectSingleLayer
from ..layers.layer import SingleLayer
from ..layers.single_layer import single_layer_on
from ..solvers.refinement import INNER, refine, remaining
from ..solvers.saddle_system import SaddleSolution
from ..traction_error import TractionError
from .formulation import JumpFormulation

RULES = 4  # finer rules tried after each other
STALLED = 0.9  # largest rate of their corrections that a series is summed for


@dataclass(frozen=True)
class Measured:
    """A solution and the sizes of its corrections, each relative in the L2 norm of the traction.

    Attributes
    ----------
    solved : SaddleSolution
    compression, quadrature : tuple of float
        Each the error before that correction; empty where nothing was measured.
    """

    solved: SaddleSolution
    compression: tuple[float, ...] = ()
    quadrature: tuple[float, ...] = ()


def left_by_rules(found: Sequence[float]) -> float:
    """Error left after corrections by ever finer rules.

    Their sizes go on as a geometric series, and what is left is no less than the last of them:
    unlike corrections by one operator, they need not shrink faster and faster. Beside collapsed
    corners they stop shrinking at 1e-4 of the traction in a gap of thinness .005.
    """
    if len(found) == 1:
        return found[0]
    rate = min(found[-1] / max(found[-2], 1e-300), STALLED)
    return found[-1] * max(1.0, rate / (1.0 - rate))


@dataclass
class MeasuredSolve:
    """Solves of one formulation on one geometry, measured against sharper ones.

    Parameters
    ----------
    formulation : JumpFormulation
        The one that is solved.
    tolerance : float
        Relative error asked of the traction; compression and quadrature have their shares in it.
    """

    formulation: JumpFormulation
    tolerance: float
    _sharp: SingleLayer | None = field(default=None, init=False, repr=False)
    _finer: list[JumpFormulation] = field(default_factory=list, init=False, repr=False)

    def solve(
        self,
        tested: np.ndarray,
        background: np.ndarray | float = 0.0,
        *,
        compression: bool = True,
        quadrature: bool = True,
    ) -> Measured:
        """Solve for a boundary velocity and correct what can be measured.

        Parameters
        ----------
        tested : (3 n_dofs,) array
            Tested velocity.
        background : (3 n_dofs,) array or float
            Tested undisturbed velocity.
        compression, quadrature : bool
            What to measure; the quadrature's near field costs as much as the formulation's own.

        Returns
        -------
        Measured
        """
        solved = self.formulation.system.solve(self.formulation.data(tested, background))
        found = Measured(solved)
        if compression:
            found = self.decompressed(solved, tested, background)
        return self.refined(found, tested, background) if quadrature else found

    def decompressed(
        self, solved: SaddleSolution, tested: np.ndarray, background: np.ndarray | float = 0.0
    ) -> Measured:
        """Correct a solution's error of compression; nothing to do where there is none."""
        made = self.formulation
        data = made.data(tested, background)
        scale = float(np.linalg.norm(data))
        if not isinstance(made.layer, CompressedSingleLayer):
            return Measured(solved)
        if scale == 0.0:
            return Measured(solved, (0.0,))
        wanted = COMPRESSION * self.tolerance
        against = self._residual(data, self.sharp)
        found = refine(made.system, against, solved, scale, self.size, wanted, self.own)
        return Measured(found.solved, found.estimates)

    def refined(
        self,
        measured: Measured,
        tested: np.ndarray,
        background: np.ndarray | float = 0.0,
        rules: int = RULES,
    ) -> Measured:
        """Correct a solution's error of quadrature by at most so many finer rules."""
        solved = measured.solved
        if not (np.any(tested) or np.any(background)):
            return replace(measured, quadrature=(0.0,))
        found: list[float] = []
        while len(found) < rules:
            fine = self.finer(len(found))
            data = fine.data(tested, background)
            scale = float(np.linalg.norm(data))
            against = self._residual(data, fine.layer)
            step = refine(self.formulation.system, against, solved, scale, self.size, np.inf)
            solved = step.solved
            found.append(step.estimates[0])
            exhausted = fine.orders == fine.orders.finer()
            if left_by_rules(found) <= QUADRATURE * self.tolerance or exhausted:
                break
        return replace(measured, solved=solved, quadrature=tuple(found))

    def error(self, measured: Measured, krylov: float, *, corrected: bool = True) -> TractionError:
        """What was measured, as the shares of a traction error; that of the mesh is not known.

        Parameters
        ----------
        measured : Measured
        krylov : float
            Of the first solve.
        corrected : bool
            Whether the corrections were taken; else the errors are those before them.

        Returns
        -------
        TractionError
        """
        m = measured

        compression = 0.0
        if isinstance(self.formulation.layer, CompressedSingleLayer):
            compression = np.nan
            if m.compression:
                compression = remaining(m.compression, self.own) if corrected else m.compression[0]
        quadrature = np.nan
        if m.quadrature:
            quadrature = left_by_rules(m.quadrature) if corrected else m.quadrature[0]
        last = (*m.compression, *m.quadrature)[-1:]
        if corrected and last and m.solved.iterations:
            krylov = INNER * last[0]
        return TractionError(self.tolerance, np.nan, quadrature, compression, krylov)

    def size(self, density: np.ndarray) -> float:
        """L2 norm on the surface of a density ``(3 n_dofs,)``."""
        d = density.reshape(-1, 3)
        return float(np.sqrt(max(np.sum(d * (self.formulation.surface.mass @ d)), 0.0)))

    @property
    def own(self) -> float:
        """Error of `sharp` over that of the operator; none of exact sums."""
        return 0.0 if isinstance(self.sharp, DirectSingleLayer) else OWN

    @property
    def sharp(self) -> SingleLayer:
        """The same rule with the plain part summed exactly, or compressed more sharply."""
        if self._sharp is None:
            layer = self.formulation.layer
            assert isinstance(layer, CompressedSingleLayer)
            self._sharp = self._exactly(layer, layer)
        return self._sharp

    @property
    def finest(self) -> JumpFormulation:
        """The formulation with the finest rule that was needed so far."""
        return self._finer[-1] if self._finer else self.formulation

    def finer(self, level: int) -> JumpFormulation:
        """The formulation with the rule ``2 (level + 1)`` times finer.

        A single step would not do: plain rules of even and of odd orders err apart in thin gaps,
        so that the next one may differ by four times less than the error.
        """
        while len(self._finer) <= level:
            before = self._finer[-1] if self._finer else self.formulation
            orders = before.orders.finer().finer()
            surface = before.surface.with_points(orders)
            layer: SingleLayer = single_layer_on(surface, orders, storage="direct")
            if isinstance(self.formulation.layer, CompressedSingleLayer):
                layer = self._exactly(self.formulation.layer, layer)
            self._finer.append(replace(before, layer=layer, orders=orders))
        return self._finer[level]

    def _exactly(self, compressed: CompressedSingleLayer, like: SingleLayer) -> SingleLayer:
        """The points and near field of a layer, summed more exactly than the compressed one."""
        surface, near = like.surface, like.near
        sharp = sharper(
            compressed.compression,
            n_dofs=surface.patches.n_dofs,
            n_outer=surface.outer.weights.size,
            n_source=surface.source.weights.size,
        )
        if sharp is None:
            return DirectSingleLayer(surface, near)
        return compressed_single_layer(surface, near, sharp)

    def _residual(
        self, data: np.ndarray, layer: SingleLayer
    ) -> Callable[[SaddleSolution], np.ndarray]:
        system = self.formulation.system.system
        return lambda x: data - layer @ x.solution - system.multiplied(x.zeta)
