"""Steady channel flow whose model adapts to a goal: Navier-Stokes only where needed [T ch. 7].

Read `config.py` (the scene's tables), `geometry.py` (the channel with its cavity), `build.py`
(flow, goal, strategy), `run.py` (the loop step by step), `forecast.py`, `picture.py`.
"""

from ..kind import StepFolder
from .config import SECTIONS, AdaptiveFlowScene, impossible

KIND = StepFolder(AdaptiveFlowScene, SECTIONS, impossible, __name__)
