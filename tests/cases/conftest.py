"""The toy build in place of the real one."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

import cases

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
    """Put a toy build with the given scheme in the place of `cases.kinds.inflation.build`."""

    def put(scheme=None):
        fake = toy.build(scheme)
        monkeypatch.setitem(sys.modules, "cases.kinds.inflation.build", fake)
        monkeypatch.setattr(cases, "build", fake, raising=False)

    return put
