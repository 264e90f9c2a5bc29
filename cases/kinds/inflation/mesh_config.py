"""Keys of a bag from a user's mesh file: [geometry] and [mesh] of ``geometry.kind = "mesh"``."""

from __future__ import annotations

from dataclasses import dataclass

from ...geometry.meshes.placing import UNITS
from ...input_file import InputFile
from ...limits import rule

NO_FILE = InputFile()
PLACE = {"least": -1e9, "most": 1e9}


@dataclass(frozen=True)
class Region:
    """A place in a user's mesh, by one of these: triangles whose middle lies in it.

    ``sphere`` is a centre and a radius, ``box`` two opposite corners, ``plane`` a normal and its
    distance d from the origin (what lies beyond it, ``n . x >= d``), ``hole`` the point nearest to
    the open edge that is to be closed.
    """

    sphere: tuple[float, ...] = rule((), **PLACE)
    box: tuple[tuple[float, float, float], ...] = rule((), **PLACE)
    plane: tuple[float, ...] = rule((), **PLACE)
    hole: tuple[float, ...] = rule((), **PLACE)


@dataclass(frozen=True)
class Fold:
    """A half turn of a flat pattern, ``at`` a distance along it, towards one side.

    All three are needed: the defaults are none.
    """

    at: float = rule(0.0, above=0.0, most=1e4)
    side: str = rule("", choices=("up", "down"))
    radius: float = rule(0.0, above=0.0, most=1e4)


@dataclass(frozen=True)
class MeshGeometry:
    """A bag from a mesh file: any triangulation, with the triangles of its inlet.

    ``unit`` of the file's lengths needs [physical]; without it they are in units of L. ``inlet``
    is a group or part of the file, ``"hole"``, or a region in units of L; ``rest`` names the groups
    of the membrane if there are others besides. Points within ``weld`` of the size are one;
    ``component = "largest"`` drops smaller pieces. ``smooth`` surfaces follow the normals at
    vertices but for edges sharper than ``crease`` degrees. ``reference`` is a file with the same
    triangles, unfolded: the stress-free bag. ``opening`` is half the distance given to
    coincident sheets; ``folds`` across the direction ``along`` fold a flat pattern.
    """

    kind: str = rule("mesh", choices=("mesh",))
    file: InputFile = rule(NO_FILE)
    unit: str = rule("", choices=("", *UNITS))
    component: str = rule("all", choices=("all", "largest"))
    weld: float = rule(1e-5, least=1e-12, below=0.1)
    inlet: str | Region = rule("inlet")
    rest: tuple[str, ...] = rule(())
    smooth: bool = rule(True)
    crease: float = rule(30.0, least=0.0, most=180.0)
    reference: InputFile = rule(NO_FILE)
    opening: float = rule(0.0, least=0.0, most=1e3)
    folds: tuple[Fold, ...] = rule(())
    along: tuple[float, float, float] = rule((1.0, 0.0, 0.0), **PLACE)


@dataclass(frozen=True)
class TriangleMesh:
    """Degrees of the surface and of the traction; ``split`` halves all edges so many times.

    More than ``most`` triangles are refused.
    """

    degree: int = rule(3, choices=(2, 3))
    density: int = rule(1, choices=(1, 2))
    split: int = rule(0, least=0, most=5)
    most: int = rule(20000, least=4, most=10**7)
