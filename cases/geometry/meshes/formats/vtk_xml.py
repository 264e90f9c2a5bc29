"""VTK's XML files, unstructured (.vtu) and polygons (.vtp): all pieces, text, base64 or appended.

Entities are refused unread; compressed blocks are unpacked to the size that they declare at most.
"""

from __future__ import annotations

import base64
import binascii
import lzma
import re
import zlib
from dataclasses import dataclass
from typing import Literal
from xml.etree import ElementTree

import numpy as np

from cases.geometry.meshes.facet_mesh import MeshError
from cases.geometry.meshes.formats.cells import CellMesh
from cases.geometry.meshes.formats.text import clean_name
from cases.geometry.meshes.formats.vtk_cells import POLYGON, STRIP, vtk_mesh

MOST_BYTES = 1 << 30
_TYPES = {
    f"{name}{8 * n}": f"{name[0].lower()}{n}" for name in ("Int", "UInt") for n in (1, 2, 4, 8)
}
_TYPES |= {"Float32": "f4", "Float64": "f8"}
_POLYGONAL = {"Verts": 2, "Lines": 4, "Polys": POLYGON, "Strips": STRIP}


@dataclass(frozen=True)
class _Coding:
    """How arrays are written: byte order, type of the sizes, compressor, appended bytes."""

    order: Literal["<", ">"]
    size: np.dtype
    compressor: str
    appended: bytes
    base64: bool


def read(data: bytes) -> CellMesh:
    """Points and cells of all pieces; integer cell data are groups."""
    if re.search(rb"<!\s*(DOCTYPE|ENTITY)", data, re.IGNORECASE):
        raise MeshError("it declares entities (<!DOCTYPE or <!ENTITY), which no VTK file needs")
    root, appended, encoding = _parsed(data)
    kind = root.get("type", "")
    if root.tag != "VTKFile" or kind not in ("UnstructuredGrid", "PolyData"):
        raise MeshError(f"a <{root.tag[:24]} {kind[:24]}>, not an unstructured grid or polygons")
    coding = _Coding(
        ">" if root.get("byte_order") == "BigEndian" else "<",
        np.dtype(_TYPES.get(root.get("header_type", "UInt32"), "u4")),
        root.get("compressor", ""),
        appended,
        encoding == "base64",
    )
    pieces = [_piece(piece, coding, kind) for piece in root.findall(f"{kind}/Piece")]
    if not pieces:
        raise MeshError("no <Piece> in it: cut short, or a parallel file that names others")
    points = np.concatenate([piece[0] for piece in pieces])
    types = np.concatenate([piece[1] for piece in pieces])
    shift = np.cumsum([0, *(len(piece[3]) for piece in pieces)])
    ends = np.concatenate([piece[2] + n for piece, n in zip(pieces, shift, strict=False)])
    first = np.cumsum([0, *(len(piece[0]) for piece in pieces)])
    nodes = np.concatenate([piece[3] + n for piece, n in zip(pieces, first, strict=False)])
    names = [name for name in pieces[0][4] if all(name in piece[4] for piece in pieces)]
    values = {name: np.concatenate([piece[4][name] for piece in pieces]) for name in names}
    left = [tag.get("Name", "?") for tag in root.iterfind(".//PointData/DataArray")]
    notes = (
        [f"point data left out: {', '.join(map(clean_name, dict.fromkeys(left)))}"] if left else []
    )
    return vtk_mesh(points, types, ends, nodes, values, notes)


def _parsed(data: bytes) -> tuple[ElementTree.Element, bytes, str]:
    """The tree, the bytes of its appended data and their encoding."""
    appended, encoding = b"", ""
    if head := re.search(rb"<AppendedData[^<>]*>", data):
        stop = data.rfind(b"</AppendedData>")
        start = data.find(b"_", head.end()) + 1
        if stop < 0 or not 0 < start <= stop:
            raise MeshError("<AppendedData> is not closed: cut short; export or copy it again")
        match = re.search(rb'encoding="(\w+)"', head[0])
        encoding = match[1].decode() if match else "raw"
        appended, data = data[start:stop], data[: head.end()] + data[stop:]
    try:
        return ElementTree.fromstring(data), appended, encoding
    except ElementTree.ParseError as error:
        raise MeshError(f"its XML ends or breaks: {error}; export or copy it again") from None


def _piece(piece: ElementTree.Element, coding: _Coding, kind: str):  # type: ignore[no-untyped-def]
    """Points, types, ends, nodes and cell data of a piece."""
    n_points = _number(piece, "NumberOfPoints", -1)
    tag = piece.find("Points/DataArray")
    if tag is None:
        raise MeshError("a <Piece> without points")
    points = _array(tag, coding, "points").astype(float).ravel()
    if n_points < 0 or len(points) != 3 * n_points:
        raise MeshError(f"{len(points)} coordinates for {n_points} points: damaged")
    types, ends, nodes = [np.empty(0, int)], [np.empty(0, int)], [np.empty(0, int)]
    for name in ("Cells",) if kind == "UnstructuredGrid" else _POLYGONAL:
        if (cells := piece.find(name)) is None:
            continue
        found = {a.get("Name", ""): a for a in cells.iterfind("DataArray")}
        if not {"connectivity", "offsets"} <= found.keys():
            raise MeshError(f"<{name}> without connectivity or offsets")
        own = _array(found["offsets"], coding, "offsets").astype(np.int64)
        ends.append(own + sum(map(len, nodes)))
        nodes.append(_array(found["connectivity"], coding, "connectivity").astype(np.int64))
        if name == "Cells":
            if "types" not in found:
                raise MeshError("<Cells> without types")
            types.append(_array(found["types"], coding, "types").astype(np.int64))
        else:
            types.append(np.full(len(own), _POLYGONAL[name]))
    total = len(np.concatenate(ends))
    counted = sum(_number(piece, f"NumberOf{n}", 0) for n in ("Cells", *_POLYGONAL))
    if counted != total:
        raise MeshError(f"a <Piece> of {counted} cells holds {total}: damaged")
    data = {}
    for tag in piece.iterfind("CellData/DataArray"):
        values = _array(tag, coding, "cell data")
        width = _number(tag, "NumberOfComponents", 1)
        name = clean_name(tag.get("Name", "cell data"))
        data[name] = values if width == 1 else values.reshape(-1, width)
    return points.reshape(-1, 3), *map(np.concatenate, (types, ends, nodes)), data


def _number(tag: ElementTree.Element, name: str, default: int) -> int:
    """A whole number among the attributes of a tag."""
    word = tag.get(name) or str(default)
    try:
        return int(word)
    except ValueError:
        raise MeshError(f"<{tag.tag}>: {name} = '{clean_name(word)[:24]}'") from None


def _array(tag: ElementTree.Element, coding: _Coding, what: str) -> np.ndarray:
    code = _TYPES.get(tag.get("type", ""))
    if code is None:
        raise MeshError(f"{what}: numbers of type '{clean_name(tag.get('type', ''))[:24]}'")
    form, text = tag.get("format", "ascii"), tag.text or ""
    if form == "ascii":
        try:
            kind = np.float64 if code[0] == "f" else np.int64
            return (
                np.array(text.split(), dtype=bytes).astype(kind)
                if text.split()
                else np.empty(0, kind)
            )
        except ValueError as error:
            raise MeshError(f"{what}: {clean_name(str(error))}") from None
    if form == "appended":
        offset = _number(tag, "offset", -1)
        if not 0 <= offset <= len(coding.appended):
            raise MeshError(f"{what}: appended data at {offset} of {len(coding.appended)} bytes")
        raw, packed = coding.appended[offset:], coding.base64
    else:
        raw, packed = "".join(text.split()).encode("ascii", "replace"), True
    block = _unpacked(raw, packed, coding, what)
    dtype = np.dtype(coding.order + code)
    if len(block) % dtype.itemsize:
        raise MeshError(f"{what}: {len(block)} bytes are no whole numbers: damaged")
    return np.frombuffer(block, dtype).astype(dtype.newbyteorder("="))


def _unpacked(raw: bytes, packed: bool, coding: _Coding, what: str) -> bytes:
    """Bytes of an array behind its header of sizes."""
    size = coding.size.newbyteorder(coding.order)
    if not raw:
        return b""
    if not coding.compressor:
        (count,) = np.frombuffer(_take(raw, 0, size.itemsize, packed, what), size).tolist()
        if packed and raw[: 4 * -(-size.itemsize // 3)].endswith(b"="):
            # the header was encoded on its own, with its own padding
            return _take(raw[4 * -(-size.itemsize // 3) :], 0, count, packed, what)
        return _take(raw, size.itemsize, count, packed, what)
    blocks = int(np.frombuffer(_take(raw, 0, size.itemsize, packed, what), size)[0])
    length = (3 + blocks) * size.itemsize if blocks else size.itemsize
    head = np.frombuffer(_take(raw, 0, length, packed, what), size).tolist()
    if not blocks:
        return b""
    _, whole, last, *sizes = head
    total = whole * (blocks - 1) + (last or whole)
    if total > MOST_BYTES:
        raise MeshError(
            f"{what}: unpacks to {total} bytes, more than {MOST_BYTES}; save it smaller"
        )
    body, start = raw[4 * -(-length // 3) :] if packed else raw[length:], 0
    body, parts = _take(body, 0, sum(sizes), packed, what), []
    for i, n in enumerate(sizes):
        expected = (last or whole) if i == blocks - 1 else whole
        parts.append(_inflated(body[start : start + n], expected, coding.compressor, what))
        start += n
    return b"".join(parts)


def _take(raw: bytes, start: int, count: int, packed: bool, what: str) -> bytes:
    """Bytes of `raw`, decoded from base64 as far as they are needed."""
    stop = start + count
    try:
        part = base64.b64decode(raw[: 4 * -(-stop // 3)], validate=True) if packed else raw[:stop]
    except binascii.Error as error:
        raise MeshError(f"{what}: {error}: damaged") from None
    if len(part) < stop:
        raise MeshError(f"{what}: {len(part)} bytes where {stop} are declared: cut short")
    return part[start:stop]


def _inflated(block: bytes, expected: int, compressor: str, what: str) -> bytes:
    """One block, unpacked to no more than it declares."""
    try:
        if compressor == "vtkZLibDataCompressor":
            found = zlib.decompressobj().decompress(block, expected + 1)
        elif compressor == "vtkLZMADataCompressor":
            found = lzma.LZMADecompressor().decompress(block, expected + 1)
        else:
            raise MeshError(
                f"compressed by '{clean_name(compressor)[:32]}'; save it with zlib or none"
            )
    except (zlib.error, lzma.LZMAError, EOFError) as error:
        raise MeshError(f"{what}: {clean_name(str(error))}: damaged") from None
    if len(found) != expected:
        raise MeshError(
            f"{what}: a block unpacks to {len(found)} bytes, declares {expected}: damaged"
        )
    return found
