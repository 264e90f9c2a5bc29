"""An elastic capsule in a linear flow: the coupling against small-deformation theory.

Read `config.py` (the scene's tables, with the exact answer), `build.py`, `forecast.py`; its
pictures are those of an inflation.
"""

from ..kind import TimeFolder
from .config import SECTIONS, CapsuleScene, impossible

KIND = TimeFolder(
    CapsuleScene, SECTIONS, impossible, __name__, pictures="cases.kinds.inflation.views.picture"
)
