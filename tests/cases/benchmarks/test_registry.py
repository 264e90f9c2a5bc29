"""Every benchmark is a folder of its name with a suite; its modules import."""

import pkgutil
from importlib import import_module

from cases import benchmarks
from cases.benchmarks import BENCHMARKS


def test_a_benchmark_is_the_folder_of_its_name():
    assert list(BENCHMARKS) == sorted(BENCHMARKS)
    for name, entry in BENCHMARKS.items():
        assert entry.module == f"cases.benchmarks.{name}.suite"
        assert callable(import_module(entry.module).run)


def test_all_modules_import():
    for module in pkgutil.walk_packages(benchmarks.__path__, "cases.benchmarks."):
        import_module(module.name)
