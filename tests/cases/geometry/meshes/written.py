"""Bags and files of them, written by the tests (and by meshio, an independent hand)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from cases.geometry.meshes.facet_mesh import FacetMesh


def sphere(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of an icosahedron split `levels` times, outwards."""
    g = (1 + 5**0.5) / 2
    points = np.array(
        [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g],
         [0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    )  # fmt: skip
    triangles = np.array(
        [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
         [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
         [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]
    )  # fmt: skip
    points = points / np.linalg.norm(points, axis=1)[:, None]
    for _ in range(levels):
        ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], 2), 2).reshape(-1, 2)
        edges, of = np.unique(ends, axis=0, return_inverse=True)
        x, y, z = of.reshape(-1, 3).T + len(points)
        new = points[edges].mean(axis=1)
        points = np.concatenate([points, new / np.linalg.norm(new, axis=1)[:, None]])
        a, b, c = triangles.T
        parts = ((a, x, z), (x, b, y), (z, y, c), (x, y, z))
        triangles = np.concatenate([np.stack(part, axis=1) for part in parts])
    return points, triangles


def bag(levels: int = 1) -> FacetMesh:
    """A flattened sphere with the groups "film" and "inlet"; numbers that any format keeps."""
    points, triangles = sphere(levels)
    points = np.round(points * [32, 32, 16]) / 32
    low = points[triangles].mean(axis=1)[:, 2] < -0.3
    groups = {"film": np.flatnonzero(~low), "inlet": np.flatnonzero(low)}
    return FacetMesh(points, triangles, groups)


def soup(facets: FacetMesh) -> FacetMesh:
    """The same with three points of its own for each triangle."""
    points = facets.points[facets.triangles].reshape(-1, 3)
    return FacetMesh(points, np.arange(len(points)).reshape(-1, 3), facets.groups)


def signed_volume(facets: FacetMesh) -> float:
    a, b, c = (facets.points[facets.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def corners(facets: FacetMesh, name: str | None = None) -> np.ndarray:
    """Corners (m, 9) of triangles, each from its smallest corner on, sorted: what a mesh is."""
    own = slice(None) if name is None else facets.groups[name]
    found = facets.points[facets.triangles[own]]
    rows = []
    for triangle in found.tolist():
        k = triangle.index(min(triangle))
        rows.append(np.ravel(triangle[k:] + triangle[:k]).tolist())
    return np.array(sorted(rows))


def _grouped(facets: FacetMesh):
    return [(name, facets.triangles[own]) for name, own in facets.groups.items()]


def stl_text(facets: FacetMesh) -> str:
    lines = []
    for name, triangles in _grouped(facets):
        lines.append(f"solid {name}")
        for triangle in facets.points[triangles]:
            lines += ["facet normal 0 0 0", " outer loop"]
            lines += [f"  vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
            lines += [" endloop", "endfacet"]
        lines.append(f"endsolid {name}")
    return "\n".join(lines) + "\n"


def stl_binary(
    points: np.ndarray, triangles: np.ndarray, header: bytes = b"solid scrambled"
) -> bytes:
    record = np.dtype([("n", "<f4", 3), ("x", "<f4", (3, 3)), ("a", "<u2")])
    records = np.zeros(len(triangles), record)
    records["x"] = points[triangles]
    return header.ljust(80) + len(triangles).to_bytes(4, "little") + records.tobytes()


def obj_text(facets: FacetMesh) -> str:
    lines = ["mtllib bag.mtl", "o bag"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in facets.points.tolist()]
    lines += ["vt 0 0", "vn 0 0 1", "s off"]
    for name, triangles in _grouped(facets):
        lines.append(f"g {name}")
        lines += [f"f {a}/1/1 {b}/1/1 {c}//1" for a, b, c in (triangles + 1).tolist()]
    return "\n".join(lines) + "\n"


def ply_text(facets: FacetMesh) -> str:
    label = np.zeros(len(facets.triangles), int)
    label[facets.groups["inlet"]] = 1
    lines = ["ply", "format ascii 1.0", "comment a bag", f"element vertex {len(facets.points)}"]
    lines += [f"property double {k}" for k in "xyz"]
    lines += [f"element face {len(label)}", "property list uchar int vertex_index"]
    lines += ["property int part", "end_header"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in facets.points.tolist()]
    lines += [
        f"3 {a} {b} {c} {k}" for (a, b, c), k in zip(facets.triangles.tolist(), label, strict=True)
    ]
    return "\n".join(lines) + "\n"


def off_text(facets: FacetMesh) -> str:
    lines = ["OFF", "# a bag", f"{len(facets.points)} {len(facets.triangles)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in facets.points.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in facets.triangles.tolist()]
    return "\n".join(lines) + "\n"


def abaqus_text(facets: FacetMesh, name: str = "M3D3") -> str:
    lines = ["*HEADING", "a bag", "** nodes", "*Node, nset=all"]
    lines += [f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(facets.points.tolist(), 1)]
    number = 0
    for group, triangles in _grouped(facets):
        lines.append(f"*Element, type={name}, elset={group}")
        for a, b, c in (triangles + 1).tolist():
            number += 1
            lines.append(f"{number}, {a}, {b}, {c}")
    return "\n".join([*lines, "*MEMBRANE SECTION, ELSET=film, MATERIAL=fabric", "0.1"]) + "\n"


def nastran_text(facets: FacetMesh, commas: bool = False) -> str:
    lines = ["SOL 101", "CEND", "BEGIN BULK"]
    for i, name in enumerate(facets.groups):
        lines.append(f"$ Femap Property {7 + i} : {name}")
    for i, (x, y, z) in enumerate(facets.points.tolist(), 1):
        if commas:
            lines.append(f"GRID,{i},,{x!r},{y!r},{z!r}")
        else:
            lines.append(f"GRID*   {i:16d}{'':16s}{x:16.9f}{y:16.9f}")
            lines.append(f"*       {z:16.9f}")
    number = 0
    for i, (_, triangles) in enumerate(_grouped(facets)):
        for a, b, c in (triangles + 1).tolist():
            number += 1
            words = [number, 7 + i, a, b, c]
            wide = "CTRIA3  " + "".join(f"{word:8d}" for word in words)
            lines.append("CTRIA3," + ",".join(map(str, words)) if commas else wide)
    return "\n".join([*lines, "ENDDATA"]) + "\n"


def lsdyna_text(facets: FacetMesh, reference: np.ndarray | None = None) -> str:
    lines = ["*KEYWORD", "$ a bag", "*PART"]
    for i, name in enumerate(facets.groups):
        lines += ["$#  title", name, f"{3 + i:10d}{1:10d}{1:10d}"]
    lines.append("*NODE")
    lines += [f"{i:8d}{x:16.9f}{y:16.9f}{z:16.9f}" for i, (x, y, z) in enumerate(facets.points, 11)]
    if reference is not None:
        lines.append("*AIRBAG_REFERENCE_GEOMETRY")
        lines += [f"{i:8d}{x:16.9f}{y:16.9f}{z:16.9f}" for i, (x, y, z) in enumerate(reference, 11)]
    lines.append("*ELEMENT_SHELL")
    number = 0
    for i, (_, triangles) in enumerate(_grouped(facets)):
        for a, b, c in (triangles + 11).tolist():
            number += 1
            lines.append("".join(f"{n:8d}" for n in (number, 3 + i, a, b, c, c)))
    return "\n".join([*lines, "*END"]) + "\n"


def by_meshio(facets: FacetMesh, path: Path, form: str, **options) -> None:
    """A file by meshio: groups as blocks with Gmsh's physical numbers or as cell data."""
    import meshio

    blocks = [("triangle", triangles) for _, triangles in _grouped(facets)]
    sizes = [len(triangles) for _, triangles in _grouped(facets)]
    labels = [np.full(n, i + 1) for i, n in enumerate(sizes)]
    if form.startswith("gmsh"):
        names = {name: np.array([i + 1, 2]) for i, name in enumerate(facets.groups)}
        data = {"gmsh:physical": labels, "gmsh:geometrical": labels}
        # meshio writes the entities, and with them physical numbers, that points belong to
        entity = np.column_stack(
            [np.full(len(facets.points), 2), np.arange(len(facets.points)) % 2 + 1]
        )
        tags = {"gmsh:dim_tags": entity} if form == "gmsh" else {}
        mesh = meshio.Mesh(facets.points, blocks, tags, cell_data=data, field_data=names)
    elif form == "abaqus":
        sets = {
            name: [np.arange(n) if i == j else np.array([], int) for j, n in enumerate(sizes)]
            for i, name in enumerate(facets.groups)
        }
        mesh = meshio.Mesh(facets.points, blocks, cell_sets=sets)
    else:
        key = "nastran:ref" if form == "nastran" else "part"
        mesh = meshio.Mesh(facets.points, blocks, cell_data={key: labels})
    mesh.write(path, file_format=form, **options)


def text(make: Callable[[FacetMesh], str]) -> Callable[[FacetMesh, Path], None]:
    """A writer of files from a writer of text."""
    return lambda facets, path: path.write_text(make(facets))


def meshio_form(form: str, **options) -> Callable[[FacetMesh, Path], None]:
    return lambda facets, path: by_meshio(facets, path, form, **options)


def stl_file(facets: FacetMesh, path: Path) -> None:
    path.write_bytes(stl_binary(facets.points, facets.triangles))


# name: ending, writer, name of the group "inlet" in the file
WRITERS: dict[str, tuple[str, Callable[[FacetMesh, Path], None], str | None]] = {
    "stl": (".stl", text(stl_text), "inlet"),
    "stl binary": (".stl", stl_file, None),
    "obj": (".obj", text(obj_text), "inlet"),
    "ply": (".ply", text(ply_text), "part 1"),
    "ply binary": (".ply", meshio_form("ply"), None),
    "off": (".off", text(off_text), None),
    "gmsh 2.2": (".msh", meshio_form("gmsh22", binary=False), "inlet"),
    "gmsh 2.2 binary": (".msh", meshio_form("gmsh22", binary=True), "inlet"),
    "gmsh 4.1": (".msh", meshio_form("gmsh", binary=False), "inlet"),
    "gmsh 4.1 binary": (".msh", meshio_form("gmsh", binary=True), "inlet"),
    "vtk 4.2": (".vtk", meshio_form("vtk42", binary=False), "part 2"),
    "vtk 4.2 binary": (".vtk", meshio_form("vtk42", binary=True), "part 2"),
    "vtk 5.1": (".vtk", meshio_form("vtk", binary=False), "part 2"),
    "vtk 5.1 binary": (".vtk", meshio_form("vtk", binary=True), "part 2"),
    "vtu": (".vtu", meshio_form("vtu", binary=False), "part 2"),
    "vtu zlib": (".vtu", meshio_form("vtu", compression="zlib"), "part 2"),
    "vtu lzma": (".vtu", meshio_form("vtu", compression="lzma"), "part 2"),
    "vtu base64": (".vtu", meshio_form("vtu", compression=None), "part 2"),
    "abaqus membranes": (".inp", text(abaqus_text), "inlet"),
    "abaqus shells": (".inp", meshio_form("abaqus"), "inlet"),
    "nastran": (".bdf", text(nastran_text), "inlet"),
    "nastran commas": (".nas", text(lambda facets: nastran_text(facets, True)), "inlet"),
    "nastran narrow": (
        ".dat",
        meshio_form("nastran", point_format="fixed-small", cell_format="fixed-small"),
        "property 2",
    ),
    "lsdyna": (".k", text(lsdyna_text), "inlet"),
}
