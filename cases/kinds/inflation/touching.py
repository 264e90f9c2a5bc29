"""What a bag touches, as objects: forces between sheets, tests of motions, loads in files.

One sampled mesh serves them all.
"""

from __future__ import annotations

from coupling import BarrierContact, CollisionTest
from coupling.contact.crossing import Crossing
from coupling.contact.on_demand import Carrying, OnDemand

from ...geometry.bag_fields import BagFields, ContactLoad
from ...geometry.bag_sampler import BagSampler, triangulated
from ...output.accuracy import Accuracy
from ..collision import certified, touched_elements
from .plan import InflationPlan


def contact(plan: InflationPlan, sampler: BagSampler) -> Carrying | None:
    """Forces between sheets, from the samples that tests use; None where nothing carries."""
    body, numbers = plan.bag, plan.carried
    if numbers is None:
        return None
    mesh = triangulated(body, plan.scene.contact.tessellate)
    carrying = BarrierContact(mesh, mesh.areas(body.cut), numbers.reach, numbers.stiffness)
    # in a folded bag sheets are never far: a bound on motions would be measured all the time
    return carrying if plan.folded else OnDemand(carrying, sampler.gap, numbers.reach)


def fields(sampler: BagSampler, touching: Carrying | None) -> BagFields:
    """Grids for files and pictures, with the pressure of contact where it carries load."""
    load = None if touching is None else ContactLoad(touching.mesh, touching.pressure)
    return BagFields(sampler, load)


def accuracy(plan: InflationPlan, touching: Carrying | None) -> Accuracy:
    """Budget of the boundary integrals; elements in contact count apart."""
    body, cells = plan.bag, plan.scene.contact.tessellate
    touched = None if touching is None else touched_elements(touching, cells)
    measured = plan.measures_mesh
    return Accuracy(plan.budget, body.gap, body.extent, measured, touched=touched)


def test(plan: InflationPlan, touching: Carrying | None) -> CollisionTest | None:
    """Test of motions: for touching sheets, or for crossing ones where contact carries load."""
    if plan.tested == "off":
        return None
    if touching is None:
        return certified(plan.bag, plan.scene.contact.tessellate)
    return Crossing(touching.mesh)
