"""What a run or a benchmark ran on: processor, threads, memory, versions; where numba may write."""

from __future__ import annotations

import os
import platform
import stat
from pathlib import Path

PACKAGES = ("airfold", "numpy", "scipy", "numba", "scikit-fem", "meshio")
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def versions() -> dict[str, str]:
    """Versions of Python and of the packages that enter the numbers."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def machine() -> dict[str, str | int | float]:
    """Processor, usable cores, memory in GB and thread settings."""
    threads = {name: os.environ[name] for name in THREADS if name in os.environ}
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": usable_cores(),
        "memory_GB": round(memory_bytes() / 1e9, 1),
        **threads,
    }


def usable_cores() -> int:
    """Cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def memory_bytes() -> int:
    """Physical memory; 0 where the system does not tell."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return 0


def keep_compiled_code() -> None:
    """Let numba keep its machine code among temporary files where it may write nowhere else.

    It writes beside the modules or below the home, and without a place refuses to load them: a
    read-only installation. Must be called before numba is imported.
    """
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # nobody's home
        home = Path(os.sep)
    places = (Path(__file__).parents[1] / "hbem" / "__pycache__", home / "numba")
    if "NUMBA_CACHE_DIR" not in os.environ and not any(map(_writable, places)):
        os.environ["NUMBA_CACHE_DIR"] = _private_folder("airfold-numba")


def _writable(folder: Path) -> bool:
    """Whether a folder can be written to, or made."""
    nearest = next(path for path in (folder, *folder.parents) if path.exists())
    return nearest.is_dir() and os.access(nearest, os.W_OK)


def _private_folder(name: str) -> str:
    """A temporary folder that outlives the process and that nobody else can write to."""
    import tempfile

    user = getattr(os, "getuid", lambda: "user")()
    folder = Path(tempfile.gettempdir()) / f"{name}-{user}"
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    foreign = user != "user" and (found.st_uid != user or found.st_mode & 0o077)
    if foreign or not stat.S_ISDIR(found.st_mode):  # what is loaded from there is executed
        return tempfile.mkdtemp(prefix=name)
    return str(folder)


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or "unknown"
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"
