"""Run before the package, without the compiler: kernels whose indices and memory are checked.

Compiled code checks no index, and Python takes negative ones from the end. Here every index and
slice of an array that a kernel receives must lie within it, and fresh memory holds NaN, or integers
that are no index.
"""

import numba
import numpy as np

NO_INDEX = -(2**31) + 1
depth = 0
empty = np.empty


class CheckedArray(np.ndarray):
    """An array that takes no index from its end and no slice beyond it."""

    def _check(self, key):
        keys = key if isinstance(key, tuple) else (key,)
        for k, n in zip(keys, self.shape, strict=False):
            if isinstance(k, slice):
                start = 0 if k.start is None else k.start
                stop = n if k.stop is None else k.stop
                if not 0 <= start <= stop <= n:
                    raise IndexError(f"slice {start}:{stop} of an axis of {n}")
            elif isinstance(k, (int, np.integer)) and not 0 <= k < n:
                raise IndexError(f"index {k} of an axis of {n}")

    def __getitem__(self, key):
        self._check(key)
        return self.view(np.ndarray)[key]

    def __setitem__(self, key, value):
        self._check(key)
        super().__setitem__(key, value)


def _checked(value):
    if type(value) is np.ndarray:
        return value.view(CheckedArray)
    return tuple(_checked(v) for v in value) if type(value) is tuple else value


def _kernel(function):
    """Arrays are checked in kernels that Python calls; these pass rows on as plain ones."""

    def run(*arguments):
        global depth
        if depth:
            return function(*arguments)
        depth += 1
        try:
            return function(*[_checked(a) for a in arguments])
        finally:
            depth -= 1

    return run


def _poisoned(shape, dtype=float, *rest, **options):
    made = empty(shape, dtype, *rest, **options)
    if made.dtype.kind == "f":
        made.fill(np.nan)
    elif made.dtype.kind == "i":
        made.fill(NO_INDEX)
    return made


def install():
    """Take the place of the compiler and of `numpy.empty`; import kernels afterwards."""
    numba.njit = lambda **options: _kernel
    np.empty = _poisoned
