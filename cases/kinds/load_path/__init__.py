"""The structure alone: static load paths with large rotations.

Read `config.py` (the scene's tables), `build.py` (shell, supports, load), `run.py` (the path step
by step), `published.py` (what it is compared with), `forecast.py`, `picture.py`.
"""

from ..kind import StepFolder
from .config import SECTIONS, LoadPathScene, impossible

KIND = StepFolder(LoadPathScene, SECTIONS, impossible, __name__)
