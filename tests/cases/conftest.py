"""The toy kind in place of the inflation."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from cases.kinds import KINDS

TOY = Path(__file__).with_name("toy.py")


@pytest.fixture(scope="session")
def toy() -> ModuleType:
    spec = importlib.util.spec_from_file_location("toy", TOY)
    module = importlib.util.module_from_spec(spec)
    sys.modules["toy"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def use(monkeypatch, toy):
    """Run scenes of inflations by the toy, with the given scheme."""

    def put(scheme=None):
        monkeypatch.setitem(KINDS, "inflation", toy.ToyKind(scheme))

    return put
