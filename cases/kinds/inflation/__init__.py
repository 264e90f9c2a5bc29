"""Inflation of a bag in space by Stokes flow or a uniform pressure [T ch. 6].

Read `config.py` (the scene's tables), `plan.py` (what a scene comes to), `build.py` and
`membrane.py` (objects), `forecast.py` with `cloth.py` and `difficulty.py` (`airfold check`); a bag
from a file is `mesh_config.py`, `users_mesh.py`, `mesh_forecast.py`; `views` draws.
"""

from ..kind import TimeFolder
from .combinations import impossible
from .config import SECTIONS, InflationScene

KIND = TimeFolder(
    InflationScene, SECTIONS, impossible, __name__, pictures=f"{__name__}.views.picture"
)
