"""Vector-valued basis functions made on access: storage stays scalar."""

from __future__ import annotations

import numpy as np
from skfem.element import DiscreteField


class VectorFunctions:
    """A sequence of scikit-fem basis functions: scalar one a, component c at ``d a + c``.

    Parameters
    ----------
    values : (n_functions, n_elements, n_points) array
    grads : (2, n_functions, n_elements, n_points) array
        Derivatives along s and t.
    hess : (3, n_functions, n_elements, n_points) array
        Second derivatives ss, tt, st.
    components : int
        Their number d.
    """

    def __init__(self, values: np.ndarray, grads: np.ndarray, hess: np.ndarray, components: int):
        self._tables, self._components = (values, grads, hess), components

    def __len__(self) -> int:
        return self._tables[0].shape[0] * self._components

    def __getitem__(self, i: int) -> tuple[DiscreteField, ...]:
        a, c = divmod(range(len(self))[i], self._components)
        values, grads, second = self._tables
        hess = np.stack([second[0, a], second[2, a], second[2, a], second[1, a]])
        parts = (values[a], grads[:, a], hess.reshape(2, 2, *hess.shape[1:]))
        if self._components == 1:
            return (DiscreteField(value=parts[0], grad=parts[1], hess=parts[2]),)
        full = []
        for part in parts:
            array = np.zeros((self._components, *part.shape))
            array[c] = part
            full.append(array)
        return (DiscreteField(value=full[0], grad=full[1], hess=full[2]),)
