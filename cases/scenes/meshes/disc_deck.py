"""A flat disc bag as an LS-DYNA deck: two sheets of no thickness that share the nodes of the rim.

In millimetres: a square lattice trimmed to a circle, so quads with triangles (n3 = n4) between,
narrow ones at the rim. Both sheets are numbered the same way round,
as nobody minds in a deck; the inlet is a part of its own, a square of the lower sheet.
"""

from __future__ import annotations

import numpy as np

RADIUS = 290.0
CELL = 25.0
OFF = (4.0, 7.0)  # of the lattice from the circle's middle, so that no two rims are trimmed alike
SNAP = 0.25  # of a cell: the circle is moved onto nodes that it passes within this
INFLATOR = 4  # cells along its side
PARTS = {1: "Airbag upper", 2: "Airbag lower", 3: "Inflator"}


def trimmed_lattice() -> tuple[np.ndarray, np.ndarray, list[tuple[int, ...]]]:
    """Nodes ``(n, 2)`` of one sheet, those on the rim ``(n,)``, and its quads and triangles."""
    half = int(np.ceil(RADIUS / CELL)) + 1
    steps = CELL * np.arange(-half, half + 1)
    nodes = {
        (i, j): (float(x) + OFF[0], float(y) + OFF[1])
        for i, x in enumerate(steps)
        for j, y in enumerate(steps)
    }
    radius = {key: float(np.hypot(*place)) for key, place in nodes.items()}
    rim = {key for key, r in radius.items() if abs(r - RADIUS) < SNAP * CELL}
    for key in rim:
        x, y = nodes[key]
        nodes[key] = (x * RADIUS / radius[key], y * RADIUS / radius[key])
    inside = {key for key, r in radius.items() if r < RADIUS} - rim
    names: dict[object, int] = {}
    places: list[tuple[float, float]] = []
    on_rim: list[bool] = []

    def number(name: object, place: tuple[float, float], outer: bool) -> int:
        if name not in names:
            names[name] = len(places)
            places.append(place)
            on_rim.append(outer)
        return names[name]

    cells: list[tuple[int, ...]] = []
    for i in range(steps.size - 1):
        for j in range(steps.size - 1):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            loop: list[int] = []
            for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
                if a in inside or a in rim:
                    loop.append(number(a, nodes[a], a in rim))
                if len({a, b} & inside) == 1 and not {a, b} & rim:
                    loop.append(number(frozenset((a, b)), _crossing(nodes[a], nodes[b]), True))
            if len(loop) > 2 and any(not on_rim[k] for k in loop):
                cells += _pieces(loop, on_rim)
    return np.array(places), np.array(on_rim), cells


def _crossing(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Where the circle crosses a lattice line between two nodes."""
    (x, y), (u, v) = a, b
    if x == u:
        return x, float(np.copysign(np.sqrt(RADIUS**2 - x**2), y + v))
    return float(np.copysign(np.sqrt(RADIUS**2 - y**2), x + u)), y


def _pieces(loop: list[int], on_rim: list[bool]) -> list[tuple[int, ...]]:
    """A trimmed cell as a quad, a triangle or both, cut off at a node inside where it can be."""
    if len(loop) < 5:
        return [tuple(loop)]
    start = next((k for k, node in enumerate(loop) if on_rim[node] and on_rim[loop[k - 1]]), 0)
    a, b, c, d, e = loop[start:] + loop[:start]
    return [(a, b, c), (a, c, d, e)]


def disc_deck() -> bytes:
    """The file: keywords, nodes, parts and shells in columns of 8 and 16."""
    places, rim, cells = trimmed_lattice()
    inner = np.flatnonzero(~rim)
    lower = np.arange(1, rim.size + 1)
    lower[inner] = rim.size + 1 + np.arange(inner.size)
    middles = np.array([places[list(cell)].mean(axis=0) for cell in cells])
    blown = np.abs(middles - OFF).max(axis=1) < 0.5 * INFLATOR * CELL
    lines = ["*KEYWORD", "*TITLE", "flat disc bag, two sheets without thickness, mm", "*NODE"]
    lines.append("$    nid               x               y               z")
    every = np.concatenate([places, places[inner]])
    lines += [f"{k:8d}{x:16.3f}{y:16.3f}{0.0:16.3f}" for k, (x, y) in enumerate(every, 1)]
    for part, title in PARTS.items():
        lines += ["*PART", title, f"{part:10d}{1:10d}{1:10d}"]
    lines += ["*ELEMENT_SHELL", "$    eid     pid      n1      n2      n3      n4"]
    shells = [(1, [node + 1 for node in cell]) for cell in cells]
    shells += [
        (3 if inflator else 2, [int(lower[node]) for node in cell])
        for cell, inflator in zip(cells, blown, strict=True)
    ]
    for number, (part, shell) in enumerate(shells, 1):
        corners = [*shell, shell[-1]][:4]
        lines.append("".join(f"{entry:8d}" for entry in (number, part, *corners)))
    return "\n".join([*lines, "*END", ""]).encode()
