"""Sums of products, each of one monomial per run of joints, as arrays: an arm has up to 10^5 of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.terms import Monomial
from gd_analyze.harmonics.trigonometric_polynomial import numbers


@dataclass(frozen=True, eq=False)
class ProductTable:
    """K sums over the same T products.

    Parameters
    ----------
    names
        For every run of joints the monomials that occur, all distinct.
    codes
        Which of them goes into every product, shape (T, runs); no two rows are equal.
    weights
        Shape (T, K).
    """

    names: tuple[tuple[Monomial, ...], ...]
    codes: NDArray[np.int64]
    weights: FloatArray

    def __len__(self) -> int:
        return len(self.codes)

    def only(self, chosen: NDArray[np.bool_]) -> ProductTable:
        """Leave out the other products."""
        return ProductTable(self.names, self.codes[chosen], self.weights[chosen])

    def rewritten(
        self, r: int, names: Sequence[Monomial], codes: NDArray[np.int64], weights: FloatArray
    ) -> ProductTable:
        """Put other products in their place, whose codes of run r are of these names."""
        return ProductTable((*self.names[:r], tuple(names), *self.names[r + 1 :]), codes, weights)

    def groups(self, r: int) -> NDArray[np.int64]:
        """Number of every product's group, shape (T,): those alike in all runs but r, as they first occur."""
        if len(self.names) == 1:
            return np.zeros(len(self), dtype=np.int64)
        others = numbers(np.delete(self.codes, r, axis=1))
        _, first, group = np.unique(others, return_index=True, return_inverse=True)
        return np.argsort(np.argsort(first))[group]

    def monomials(self) -> list[Monomial]:
        """Every product as one monomial."""
        return [
            tuple(sorted(factor for name, k in zip(self.names, code, strict=True) for factor in name[k]))
            for code in self.codes.tolist()
        ]

    def largest(self, values: Sequence[Sequence[float]]) -> FloatArray:
        """Product of the largest values of every run's monomials, shape (T,)."""
        out = np.ones(len(self))
        for value, code in zip(values, self.codes.T, strict=True):
            out *= np.array(value)[code]
        return out
