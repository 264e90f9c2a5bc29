"""What a repaired mesh is like: holes, sheets, edges and angles, with places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .facet_mesh import place
from .flat_triangles import facet_areas, smallest_angles
from .mending.topology import boundary_loops, edges_of

SLIVER = 5.0  # degrees; below, the fluid's error grows


@dataclass(frozen=True)
class Hole:
    """A closed rim: its vertices in the order of the triangles' sides, length and centre."""

    loop: np.ndarray
    length: float
    centre: np.ndarray


@dataclass(frozen=True)
class SheetFigures:
    """One connected surface: triangles, area, volume (holes closed) and box."""

    triangles: int
    area: float
    volume: float
    low: np.ndarray
    high: np.ndarray

    def told(self) -> str:
        """In words."""
        return (
            f"{self.triangles} triangles, area {self.area:.4g}, volume {self.volume:.4g}, "
            f"box {place(self.low)} to {place(self.high)}"
        )


@dataclass(frozen=True)
class MeshQuality:
    """Edges and angles of triangles, lengths in the mesh's unit, angles in degrees.

    Attributes
    ----------
    shortest, median, longest : float
        Lengths of edges.
    smallest_angle : float
    sharpest : (3,) array
        Centre of the triangle with the smallest angle.
    slivers : int
        Triangles with an angle below 5 degrees.
    """

    shortest: float
    median: float
    longest: float
    smallest_angle: float
    sharpest: np.ndarray
    slivers: int

    def warnings(self) -> list[str]:
        """Lines on what hurts."""
        lines = []
        if self.slivers:
            lines.append(
                f"{self.slivers} triangles with an angle below {SLIVER:g} degrees, the sharpest "
                f"{self.smallest_angle:.2g} at {place(self.sharpest)}: remesh there"
            )
        if self.shortest < 1e-3 * self.median:
            lines.append(
                f"shortest edge {self.shortest:.3g}, median {self.median:.3g}: raise "
                "geometry.weld or remesh"
            )
        return lines


def holes(points: np.ndarray, triangles: np.ndarray) -> list[Hole]:
    """Rims of an oriented mesh, the longest first."""
    found = []
    for loop in boundary_loops(triangles):
        rim = points[loop]
        sides = np.roll(rim, -1, axis=0) - rim
        lengths = np.linalg.norm(sides, axis=1)
        centre = lengths @ (rim + sides / 2) / max(lengths.sum(), 1e-300)
        found.append(Hole(loop, float(lengths.sum()), centre))
    return sorted(found, key=lambda hole: -hole.length)


def mesh_quality(points: np.ndarray, triangles: np.ndarray) -> MeshQuality:
    """Figures of a mesh's edges and angles."""
    ends = edges_of(triangles).ends
    lengths = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    angles = smallest_angles(points, triangles)
    worst = int(np.argmin(angles))
    return MeshQuality(
        float(lengths.min()),
        float(np.median(lengths)),
        float(lengths.max()),
        float(angles[worst]),
        points[triangles[worst]].mean(axis=0),
        int(np.sum(angles < SLIVER)),
    )


def sheet_table(
    points: np.ndarray, triangles: np.ndarray, parts: np.ndarray, volumes: np.ndarray
) -> list[SheetFigures]:
    """Figures of each part."""
    areas = np.bincount(parts, facet_areas(points, triangles))
    counts = np.bincount(parts)
    low, high = np.full((len(areas), 3), np.inf), np.full((len(areas), 3), -np.inf)
    np.minimum.at(low, np.repeat(parts, 3), points[triangles.ravel()])
    np.maximum.at(high, np.repeat(parts, 3), points[triangles.ravel()])
    return [
        SheetFigures(int(counts[i]), float(areas[i]), float(volumes[i]), low[i], high[i])
        for i in range(len(areas))
    ]
