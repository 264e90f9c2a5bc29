"""Reach and stiffness of contact, from the gap of a bag and a forecast of its pressure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .potential.facing_search import FacingSearch
from .sampled_mesh import SampledMesh

REACH = 0.15  # of the gap: rounded corners of fitted bags face each other at this distance
SHORTEST = 0.1  # of the gap: below it chords of folds come closer than the sheets
STIFFNESS = 4.0  # times the largest pressure: sheets then stay above a third of the reach


@dataclass(frozen=True)
class ContactNumbers:
    """Numbers of the contact potential and what they come from.

    Attributes
    ----------
    reach, stiffness : float
        Of `BarrierContact`.
    gap : float
        Expected gap of facing sheets.
    facing : float
        Smallest distance of facing sheets at rest; infinity if none face each other within the
        gap.
    acting : int
        Samples that contact pushes at rest already.
    """

    reach: float
    stiffness: float
    gap: float
    facing: float
    acting: int

    @property
    def remark(self) -> str:
        """What may be wrong with them; empty if nothing."""
        if not self.acting:
            return ""
        return (
            f"contact: sheets face each other at {self.facing:.3g} = {self.facing / self.gap:.2g} "
            f"of the gap in the initial bag, within the reach {self.reach:.3g} of contact, which "
            f"pushes {self.acting} samples at rest; refine the mesh where it pinches the bag, or "
            "set a shorter reach"
        )


def choose_contact(
    mesh: SampledMesh, rest: np.ndarray, gap: float, pressure: float
) -> ContactNumbers:
    """Choose reach and stiffness so that nothing acts at rest and contact carries the pressure.

    Parameters
    ----------
    mesh : SampledMesh
    rest : (n_full, 3) array
        Initial configuration.
    gap : float
        Of facing sheets.
    pressure : float
        Largest one that is expected.

    Returns
    -------
    ContactNumbers

    Raises
    ------
    ValueError
        A gap or a pressure that is not positive and finite.
    """
    for name, value in (("gap", gap), ("pressure", pressure)):
        if not 0.0 < value < np.inf:
            raise ValueError(f"contact needs a positive finite {name}, got {value:g}")
    found = FacingSearch(mesh.triangles, gap, slack=0.0).facing(mesh.sample @ rest)
    facing = float(found.distance.min(initial=np.inf))
    reach = float(np.clip(facing, SHORTEST * gap, REACH * gap))
    acting = len(np.unique(found.vertices[found.distance < reach, 0]))
    return ContactNumbers(reach, STIFFNESS * pressure, gap, facing, acting)
