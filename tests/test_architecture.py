"""The house rules that no linter knows: import arrows, silence below cases, numba in its place."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("shells", "hbem", "coupling", "cases")
BELOW = PACKAGES[:3]
NUMBA_OPTIONS = {"cache": True, "error_model": "numpy"}
HEAVY = ("numba", "skfem", "matplotlib", "meshio", "pyvista")


def _modules(*packages: str) -> list[Path]:
    return [path for package in packages for path in sorted((ROOT / package).rglob("*.py"))]


def _name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _imports(tree: ast.Module) -> Iterator[str]:
    """Top-level names of all absolute imports, wherever they stand."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module.split(".")[0]


def _is_numba(node: ast.expr) -> bool:
    name = node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")
    return name in ("njit", "jit", "vectorize", "guvectorize", "cfunc", "stencil")


@pytest.mark.parametrize("path", _modules(*BELOW), ids=_name)
def test_arrows_and_silence_below_cases(path: Path) -> None:
    tree = _tree(path)
    package = _name(path).split("/")[0]
    imported = set(_imports(tree))
    assert not imported & (set(PACKAGES) - {package}), "the packages meet in cases only"
    assert not imported & {"argparse", "matplotlib", "rich", "pyvista"}
    called = {n.func.id for n in ast.walk(tree) if isinstance(n, ast.Call) and _named(n.func)}
    assert not called & {"print", "open", "input"}, "arrays in, arrays out"


def _named(node: ast.expr) -> bool:
    return isinstance(node, ast.Name)


@pytest.mark.parametrize("path", _modules(*PACKAGES), ids=_name)
def test_numba_only_in_kernel_files(path: Path) -> None:
    tree = _tree(path)
    if not (path.name.startswith("_") and path.name.endswith("kernels.py")):
        assert "numba" not in set(_imports(tree))
        return
    calls = [n for n in ast.walk(tree) if isinstance(n, ast.Call) and _is_numba(n.func)]
    for call in calls:
        assert getattr(call.func, "attr", getattr(call.func, "id", "")) == "njit"
        options = {k.arg: getattr(k.value, "value", None) for k in call.keywords}
        assert NUMBA_OPTIONS.items() <= options.items(), f"line {call.lineno}"
        assert "fastmath" not in options, f"line {call.lineno}"
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)]
    bare = [f.name for f in functions if any(_is_numba(d) for d in f.decorator_list)]
    assert not bare, f"njit without options: {bare}"


@pytest.mark.parametrize("package", PACKAGES)
def test_importing_a_package_is_light(package: str) -> None:
    code = f"import sys, {package}; print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


@pytest.mark.parametrize("package", PACKAGES)
def test_lazy_names_exist(package: str) -> None:
    module = __import__(package)
    for name in getattr(module, "__all__", ()):
        assert getattr(module, name) is not None
