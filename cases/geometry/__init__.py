"""Initial geometries of scenes, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..kinds.inflation.config import Geometry, Mesh, Scene
    from .bag import Bag
