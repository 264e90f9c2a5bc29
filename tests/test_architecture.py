"""The house rules that no linter knows: floors, arrows, names, sizes, silence below cases."""

from __future__ import annotations

import ast
import importlib
import re
import statistics
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("shells", "hbem", "coupling", "cases")
BELOW = PACKAGES[:3]
# Folders and modules of each package; one may import those of its own floor and of floors before.
FLOORS = {
    "shells": ("_threads_kernels", "surfaces", "energy", "conditions", "equilibrium"),
    "hbem": (
        "_stokes_kernels _threads_kernels", "surfaces", "near", "compression", "layers",
        "solvers traction_error", "accuracy traction", "flows planar",
    ),
    "coupling": (
        "exchange", "protocols", "records", "schemes contact", "stepping",
        "navier_stokes", "model_adaptivity", "partitions",
    ),
    "cases": (
        "machine input_file", "limits", "sections", "scene_file scene_text", "values", "output",
        "geometry", "kinds", "loader", "runs", "benchmarks scenes", "cli",
    ),
}  # fmt: skip
NUMBA_OPTIONS = {"cache": True, "error_model": "numpy"}
HEAVY = ("numba", "skfem", "matplotlib", "meshio", "pyvista")
LIMITS = {"lines of a file": 300, "median lines of a file": 130, "files of a folder": 15}


@cache
def _modules() -> dict[str, tuple[Path, ast.Module]]:
    """Dotted name of every module of the packages to its file and tree."""
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = path, ast.parse(path.read_text(encoding="utf-8"))
    return found


def _base(module: str, path: Path, node: ast.ImportFrom) -> str:
    """Absolute name of what an import names; dots count from the module's package."""
    if not node.level:
        return node.module or ""
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    parts = package[: len(package) - node.level + 1]
    return ".".join([*parts, *([node.module] if node.module else [])])


@cache
def _arrows() -> dict[str, set[str]]:
    """Imports among the modules, wherever they stand: in functions and for types too."""
    modules, arrows = _modules(), defaultdict(set)
    for name, (path, tree) in modules.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                arrows[name].update(a.name for a in node.names if a.name in modules)
            elif isinstance(node, ast.ImportFrom):
                base = _base(name, path, node)
                for alias in node.names:
                    inner = f"{base}.{alias.name}"
                    target = inner if inner in modules else base
                    if target in modules and target != name:
                        arrows[name].add(target)
    return arrows


def _circles(arrows: dict[str, set[str]]) -> list[list[str]]:
    """Circles found by walking depth first, one for each arrow that closes one."""
    state: dict[str, int] = {}
    found: list[list[str]] = []

    def visit(name: str, trail: list[str]) -> None:
        state[name] = 1
        for target in sorted(arrows.get(name, ())):
            if state.get(target) == 1:
                found.append([*trail[trail.index(target) :], target])
            elif target not in state:
                visit(target, [*trail, target])
        state[name] = 2

    for name in sorted(arrows):
        if name not in state:
            visit(name, [name])
    return found


def test_no_circles() -> None:
    assert _circles({"a": {"b"}, "b": {"c"}, "c": {"a"}}) == [["a", "b", "c", "a"]]
    assert _circles(_arrows()) == []


def test_arrows_go_down() -> None:
    """Packages meet in cases only; inside a package floors are ordered."""
    up = []
    for name, targets in _arrows().items():
        package, *inner = name.split(".")
        for target in targets:
            other, *there = target.split(".")
            if package != other:
                if package != "cases":
                    up.append(f"{name} -> {target}")
            elif inner and there and _floor(package, inner[0]) < _floor(package, there[0]):
                up.append(f"{name} -> {target}")
    assert up == []


def _floor(package: str, room: str) -> int:
    (floor,) = [i for i, rooms in enumerate(FLOORS[package]) if room in rooms.split()]
    return floor


def test_every_room_has_a_floor() -> None:
    for package in PACKAGES:
        rooms = {name.split(".")[1] for name in _modules() if name.startswith(f"{package}.")}
        assert rooms == {room for floor in FLOORS[package] for room in floor.split()}


def test_sizes() -> None:
    lines = {p: len(p.read_text(encoding="utf-8").splitlines()) for p, _ in _modules().values()}
    names = {p.relative_to(ROOT).as_posix(): n for p, n in lines.items()}
    assert {n: k for n, k in names.items() if k > LIMITS["lines of a file"]} == {}
    real = [n for p, n in lines.items() if p.name != "__init__.py"]
    assert statistics.median(real) <= LIMITS["median lines of a file"]
    folders: dict[Path, int] = defaultdict(int)
    for path in lines:
        folders[path.parent] += 1
    assert {str(f): n for f, n in folders.items() if n > LIMITS["files of a folder"]} == {}


def test_every_folder_says_what_it_holds() -> None:
    silent = []
    for path, tree in _modules().values():
        text = ast.get_docstring(tree) or ""
        if path.name == "__init__.py" and len(text) < 60:
            silent.append(str(path))
    assert silent == []


def test_a_class_name_means_one_thing() -> None:
    """Protocols may share the name of what fulfils them; names with underscores are private."""
    owners = defaultdict(list)
    for name, (_, tree) in _modules().items():
        for node in ast.walk(tree):
            protocol = any("Protocol" in ast.dump(base) for base in getattr(node, "bases", ()))
            if isinstance(node, ast.ClassDef) and not protocol and node.name[0] != "_":
                owners[node.name].append(name)
    assert {name: where for name, where in owners.items() if len(where) > 1} == {}


def _external(tree: ast.Module) -> Iterator[str]:
    """Top-level names of all absolute imports, wherever they stand."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield (node.module or "").split(".")[0]


def test_silence_below_cases() -> None:
    loud = []
    for name, (_, tree) in _modules().items():
        if name.split(".")[0] in BELOW:
            nodes = [n for n in ast.walk(tree) if isinstance(n, ast.Call)]
            called = {n.func.id for n in nodes if isinstance(n.func, ast.Name)}
            if {"argparse", "matplotlib", "rich", "pyvista"} & set(_external(tree)):
                loud.append(name)
            if called & {"print", "open", "input"}:
                loud.append(name)
    assert loud == []


def _is_numba(node: ast.expr) -> bool:
    name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")
    return name in ("njit", "jit", "vectorize", "guvectorize", "cfunc", "stencil")


def test_numba_only_in_kernel_files() -> None:
    wrong = []
    for name, (path, tree) in _modules().items():
        if not (path.name.startswith("_") and path.name.endswith("kernels.py")):
            wrong += [name] if "numba" in set(_external(tree)) else []
            continue
        for call in (n for n in ast.walk(tree) if isinstance(n, ast.Call) and _is_numba(n.func)):
            options = {k.arg: getattr(k.value, "value", None) for k in call.keywords}
            plain = getattr(call.func, "attr", getattr(call.func, "id", "")) == "njit"
            if not (plain and NUMBA_OPTIONS.items() <= options.items()) or "fastmath" in options:
                wrong.append(f"{name}:{call.lineno}")
        functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
        wrong += [f.name for f in functions if any(_is_numba(d) for d in f.decorator_list)]
    assert wrong == []


@pytest.mark.parametrize("package", PACKAGES)
def test_importing_a_package_is_light(package: str) -> None:
    code = f"import sys, {package}; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


def _exporting() -> list[str]:
    """Packages with public names, listed in their stub."""
    stubs = [path for package in PACKAGES for path in (ROOT / package).rglob("__init__.pyi")]
    return sorted(".".join(path.parent.relative_to(ROOT).parts) for path in stubs)


@pytest.mark.parametrize("package", _exporting())
def test_public_names_stay_what_they_are(package: str) -> None:
    """A name equal to a submodule's would turn into the module at its second use."""
    folder = ROOT / package.replace(".", "/")
    below = {p.stem for p in folder.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    module = importlib.import_module(package)
    assert not set(module.__all__) & below
    for name in module.__all__:
        first, second = getattr(module, name), getattr(module, name)
        assert first is second
        assert not isinstance(second, ModuleType), name


def test_the_defects_of_the_ways_in() -> None:
    import hbem
    import shells
    from coupling.model_adaptivity import adapt, estimate
    from coupling.navier_stokes import mixed_flow

    for name in (shells.minimise, hbem.single_layer, hbem.double_layer, hbem.hmatrix, adapt):
        assert callable(name)
    assert callable(estimate)
    assert callable(mixed_flow)


def test_types_are_published() -> None:
    for package in PACKAGES:
        assert (ROOT / package / "py.typed").exists()


def test_extras_and_lower_bounds() -> None:
    """What can be met together: matplotlib 3.9 is the first for numpy 2."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert '"ipctk>=' in text.split("[project.optional-dependencies]")[0]
    assert re.search(r'"matplotlib>=3\.(9|\d\d)"', text)
    assert "contact = []" in text
