"""Bags in the plane, Stokes or potential flow [T ch. 4, 5].

Read `config.py` (the scene's tables), `geometry.py` (initial curves), `build.py` (objects),
`forecast.py` (`airfold check`), `picture.py`; `exact.py` holds flows that benchmarks compare with.
"""

from ..kind import TimeFolder
from .config import SECTIONS, PlanarScene, impossible

KIND = TimeFolder(PlanarScene, SECTIONS, impossible, __name__)
