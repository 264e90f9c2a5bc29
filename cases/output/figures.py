"""What all pictures share."""

from __future__ import annotations

import numpy as np

LIGHT = np.array([-0.3, -0.7, 0.65])  # direction the light comes from


class NoPicture(ValueError):
    """A run folder without anything to draw."""
