"""What an inflation comes to, worked out once: `check`, `run`, records and pictures read it.

The bag, the budget of the boundary integrals in its narrowest gap, their orders and compression,
and the contraction of subiterations that schemes are judged by. Needs the geometry only: scikit-fem
is not loaded, numba where sheets are folded, for contact's own distance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from coupling.contact.contact_numbers import REACH
from coupling.contact.watch import UNTIL
from coupling.schemes.contraction import contraction_forecast
from hbem.accuracy import Budget, budget, larger_unknowns
from hbem.layers.choice import STORED_LIMIT, Compression, bytes_of, choose
from hbem.surfaces.quadrature import QuadratureOrders
from shells.surfaces.surface import Surface

from ...geometry.bag import Bag
from ...geometry.bag_sampler import element_areas
from ...machine import memory_bytes
from ..sizes import NEAR_BYTES, SHARE, Sizes, dense_bytes, response_bytes, shell_bytes
from .carried import FLOOR, Carried, carried
from .config import InflationScene, PillowGeometry
from .initial_bag import counts, initial_bag, narrowest
from .mesh_config import MeshGeometry, TriangleMesh

COARSER = {
    "pancake": "lower mesh.around or raise mesh.flat_max",
    "pillow": "lower mesh.around",
    "mesh": "lower mesh.split, or decimate the file in a mesh tool",
}
LARGER_LIMIT = 30_000  # unknowns of the space that measures the mesh's share, some ten assemblies


@dataclass(frozen=True)
class InflationPlan:
    """What a scene comes to; each part is worked out when it is first asked for.

    Attributes
    ----------
    scene : InflationScene
    given : Bag, optional
        The bag at the start, in place of the one that the scene's geometry describes.
    """

    scene: InflationScene
    given: Bag | None = None

    @cached_property
    def bag(self) -> Bag:
        """The bag at the start."""
        return initial_bag(self.scene) if self.given is None else self.given

    @property
    def inlet(self) -> Surface:
        """The inlet of the bag."""
        inlet = self.bag.inlet
        assert inlet is not None  # only closed bodies of other kinds have none
        return inlet

    @property
    def _bag_counts(self) -> bool:
        """Whether numbers come from the bag: its scene does not tell them."""
        return self.given is not None or isinstance(self.scene.geometry, MeshGeometry)

    @cached_property
    def _counts(self) -> tuple[int, int]:
        if self._bag_counts:
            parts = self.bag.parts
            return sum(p.n_elements for p in parts), sum(p.n_dofs for p in parts)
        return counts(self.scene)

    @property
    def unknowns(self) -> int:
        """Traction components on membrane and inlet."""
        return 3 * self._counts[1]

    @property
    def components(self) -> int:
        """Displacement components; splines carry traction and displacements alike."""
        if isinstance(self.scene.mesh, TriangleMesh):
            return 3 * self.bag.n_membrane
        return self.unknowns

    @property
    def elements(self) -> int:
        """Elements of membrane and inlet."""
        return self._counts[0]

    @cached_property
    def budget(self) -> Budget:
        """Tolerances of the boundary integrals from the traction error and the narrowest gap.

        In a folded bag that is the distance which contact guarantees.
        """
        b = self.bag if self._bag_counts else None
        gap, extent = narrowest(self.scene) if b is None else (b.gap, b.extent)
        if self.folded and self.carries:
            gap *= FLOOR * (self.scene.contact.reach or REACH)
        return budget(self.scene.fluid.tolerance, gap, extent)

    @property
    def carries(self) -> bool:
        """Whether contact carries load: its forces enter backward Euler's steps only."""
        s = self.scene
        return s.contact.force == "barrier" and s.time.integrator == "backward-euler"

    @cached_property
    def carried(self) -> Carried | None:
        """Numbers of the contact potential; None where contact carries nothing."""
        return carried(self.scene, self.bag) if self.carries else None

    @cached_property
    def orders(self) -> QuadratureOrders:
        """Orders of the budget, or those that the scene insists on."""
        f, orders = self.scene.fluid, self.budget.orders
        radial, angular = f.polar if any(f.polar) else (orders.radial, orders.angular)
        far = max(3, f.outer_points, orders.far)
        return replace(
            orders,
            # cross approximation needs one set of points
            outer=far if f.compression == "aca" else f.outer_points,
            far=far,
            radial=radial,
            angular=angular,
            near_ball=f.near_ball,
        )

    @cached_property
    def compression(self) -> Compression | None:
        """How the single layer is compressed; None where it is stored or summed directly."""
        f = self.scene.fluid
        return choose(
            "dense" if f.compression == "auto" and f.solver == "lu" else f.compression,
            self.budget.compression,
            n_dofs=self.unknowns // 3,
            n_outer=self.elements * self.orders.outer**2,
            n_source=self.elements * self.orders.source**2,
            memory=SHARE * memory_bytes() or None,
            seed=self.scene.output.seed,
        )

    @cached_property
    def operator_bytes(self) -> float:
        """Memory of the single layer, near field included; with copy and factors where dense."""
        how, near = self.compression, NEAR_BYTES * self.unknowns
        if how is not None:
            o, n = self.orders, self.unknowns // 3
            points = self.elements * o.outer**2, self.elements * o.source**2
            return near + bytes_of(how.method, how.tolerance, n, *points)
        stored = self.unknowns <= STORED_LIMIT or self.scene.fluid.solver == "lu"
        return dense_bytes(self.unknowns) if stored else near

    @cached_property
    def sizes(self) -> Sizes:
        """Counts and memory from the numbers of the scene."""
        s = self.scene
        memory = {"shell": shell_bytes(self.elements, s.mesh.degree, self.components)}
        if self.has_flow:
            memory["single layer"] = self.operator_bytes
            memory["fluid response"] = response_bytes(s.coupling, self.components)
            if s.fluid.viscosity_ratio != 1.0:
                memory["double layer"] = self._double_layer_bytes
        keys = COARSER[s.geometry.kind]
        lu = s.fluid.solver == "lu" or s.fluid.compression == "dense"
        other = ", or set fluid.solver and fluid.compression to 'auto'" if lu else ""
        return Sizes(self.elements, self.unknowns, memory, keys + other)

    @property
    def _double_layer_bytes(self) -> float:
        stored = self.unknowns <= STORED_LIMIT or self.scene.fluid.solver == "lu"
        return dense_bytes(self.unknowns) if stored else NEAR_BYTES * self.unknowns

    @cached_property
    def contraction(self) -> float:
        """Contraction rho of plain subiterations at the scene's time step, before any work."""
        return contraction_forecast(
            self.scene.fluid.mass_ratio,
            self.scene.time.dt,
            element_size=_element_size(self.bag),
            gap=self.bag.gap,
            extent=self.bag.extent,
        )

    @property
    def larger_unknowns(self) -> int:
        """Unknowns of the larger density space that measures the mesh's share."""
        m = self.scene.mesh
        if isinstance(m, TriangleMesh):
            return larger_unknowns(self.elements, m.density, "triangle")
        return larger_unknowns(self.elements, m.degree)

    @property
    def measures_mesh(self) -> bool:
        """Whether a run measures the mesh's share of the traction error."""
        return self.larger_unknowns <= LARGER_LIMIT

    @property
    def has_flow(self) -> bool:
        """Whether there are boundary integrals at all."""
        return self.scene.fluid.model != "pressure"

    @property
    def folded(self) -> bool:
        """Whether sheets lie close to each other from the start."""
        g = self.scene.geometry
        if isinstance(g, MeshGeometry):
            return self.bag.flat is not None
        return isinstance(g, PillowGeometry) and (g.fold != "flat" or g.crumple > 0.0)

    @property
    def tested(self) -> str:
        """Whether configurations are tested for self-intersection: "on", "off", or when due."""
        test = self.scene.contact.test
        return "on" if test == "auto" and self.folded else test

    def skips(self) -> tuple[str, ...]:
        """What this scene does not need and a run therefore leaves out."""
        skips = []
        if not self.has_flow:
            skips.append("fluid: uniform pressure, no boundary integrals")
        else:
            if self.scene.fluid.viscosity_ratio == 1.0:
                skips.append("double layer: equal viscosities need the single layer only")
            if self.compression is None:
                best = f"dense or direct serves {self.unknowns} unknowns best"
                skips.append(f"compression: {best}")
            if not self.measures_mesh:
                skips.append(
                    f"mesh's share of the traction error: {self.larger_unknowns} unknowns in the "
                    f"space that measures it, {LARGER_LIMIT} allowed"
                )
        if self.tested != "on":
            why = UNTIL if self.tested == "auto" else "contact.test = 'off'"
            skips.append(f"test for self-intersection: {why}")
        if self.scene.contact.force == "none":
            skips.append("contact forces: contact.force = 'none'; sheets that meet end the run")
        elif not self.carries:
            skips.append("contact forces: need time.integrator = 'backward-euler'")
        elif not self.folded:
            skips.append(f"contact forces: {UNTIL}")
        if self.carries:
            skips.append("limit of time.closing on steps: contact carries what closes")
        return tuple(skips)


def _element_size(body: Bag) -> float:
    """Square root of the smallest membrane element's area, poles left out."""
    return float(np.sqrt(element_areas(body.membrane, body.coefficients[: body.n_membrane]).min()))
