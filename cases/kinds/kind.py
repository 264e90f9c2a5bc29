"""What a kind of scene is: its tables, its forecast, its run and its picture.

A kind is a folder with ``config.py`` (dataclasses of its sections, `impossible`), ``forecast.py``
(``sizes(scene)``, ``forecast(scene)``), ``build.py`` or ``run.py`` and ``picture.py``
(``overview(folder, scene)``), and an object ``KIND`` in its ``__init__``. Only configs are imported
with it: the rest loads when it is needed, so that listing and checking scenes stays light.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from ..output.figures import NoPicture
from ..output.forecast import Forecast
from ..scene_file import last_resort
from ..sections import AnyScene, Sections, without_effect
from .sizes import Sizes

if TYPE_CHECKING:
    from ..output.step_records import StepOutcome, StepRecords
    from .simulated import Simulated


class Kind(Protocol):
    """What the console and the runners know of a kind; scenes passed in are of this kind."""

    @property
    def name(self) -> str:
        """The word of scenes, ``kind = ...``."""

    @property
    def sections(self) -> Sections:
        """Tables of a scene by name."""

    @property
    def scene(self) -> Callable[..., AnyScene]:
        """Makes a scene of its name, description and sections."""

    def impossible(self, scene: Any) -> list[str]:
        """Combinations of single good values that cannot work together."""

    def sizes(self, scene: Any) -> Sizes:
        """Counts and memory, estimated without building anything."""

    def forecast(self, scene: Any) -> Forecast:
        """What `airfold check` prints."""

    def draw(self, folder: Path, scene: Any) -> Path:
        """Draw overview.png of a run folder."""

    def animate(self, folder: Path) -> Path:
        """Draw animation.gif of a run folder; raises `NoPicture` where a kind has none."""


@runtime_checkable
class TimeKind(Kind, Protocol):
    """A kind that the time loop of `coupling` runs."""

    def simulated(self, scene: Any) -> Simulated:
        """The scene as objects, worked out once."""


@runtime_checkable
class StepKind(Kind, Protocol):
    """A kind without time, which takes its steps by itself."""

    def run(self, scene: Any, records: StepRecords) -> StepOutcome:
        """Take the steps that are left and write them to the records."""


@dataclass(frozen=True)
class _FolderKind:
    """A kind whose parts are modules of one folder.

    Attributes
    ----------
    scene : type
        Dataclass of its scenes.
    sections, impossible
        As in `Kind`.
    folder : str
        The package with the modules.
    pictures : str
        Module of the picture, where it is not the folder's own.
    """

    scene: type[AnyScene]
    sections: Sections
    impossible: Callable[[Any], list[str]]
    folder: str
    pictures: str = ""

    @property
    def name(self) -> str:
        """The word of scenes."""
        return self.scene.kind

    def sizes(self, scene: Any) -> Sizes:
        """By the folder's ``forecast.py``."""
        return import_module(f"{self.folder}.forecast").sizes(scene)

    def forecast(self, scene: Any) -> Forecast:
        """By the folder's ``forecast.py``, and what the scene says without effect.

        Raises
        ------
        SceneError
            A scene whose numbers overflow or fill the memory.
        """
        with last_resort(scene.name, scene):
            found = import_module(f"{self.folder}.forecast").forecast(scene)
        return replace(found, warnings=(*found.warnings, *without_effect(scene)))

    def draw(self, folder: Path, scene: Any) -> Path:
        """By ``picture.py``."""
        module = import_module(self.pictures or f"{self.folder}.picture")
        return module.overview(folder, scene)

    def animate(self, folder: Path) -> Path:
        """By ``animation.py``, where the folder of the pictures has one."""
        module = (self.pictures or f"{self.folder}.picture").replace(".picture", ".animation")
        if find_spec(module) is None:
            raise NoPicture(f"scenes of kind {self.name!r} have no animation")
        return import_module(module).animation(folder)


@dataclass(frozen=True)
class TimeFolder(_FolderKind):
    """A `TimeKind` whose parts are modules of one folder."""

    def simulated(self, scene: Any) -> Simulated:
        """By the folder's ``build.py``; what has no effect counts as left out.

        Raises
        ------
        SceneError
            A scene whose numbers overflow or fill the memory.
        """
        with last_resort(scene.name, scene):
            found = import_module(f"{self.folder}.build").simulated(scene)
        return replace(found, skips=(*found.skips, *without_effect(scene)))


@dataclass(frozen=True)
class StepFolder(_FolderKind):
    """A `StepKind` whose parts are modules of one folder."""

    def run(self, scene: Any, records: StepRecords) -> StepOutcome:
        """By the folder's ``run.py``."""
        for what in without_effect(scene):
            records.skip(what)
        return import_module(f"{self.folder}.run").run(scene, records)
