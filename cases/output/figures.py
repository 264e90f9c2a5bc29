"""What all pictures share."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    pass


LIGHT = np.array([-0.3, -0.7, 0.65])


class NoPicture(ValueError):
    """A run folder without anything to draw."""
