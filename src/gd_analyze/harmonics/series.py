"""Sparse sums of basis functions, exactly differentiable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.harmonics.basis import Basis, Ids
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True, eq=False)
class Series:
    """sum_k coefficients[k] * function ids[k]; ids ascending and distinct."""

    basis: Basis
    ids: Ids
    coefficients: FloatArray

    @classmethod
    def gathered(cls, basis: Basis, ids: Ids, coefficients: FloatArray, floor: float = 0.0) -> Series:
        """Sum up equal functions and leave out what is at most `floor`."""
        distinct, place = np.unique(ids.astype(np.int64), return_inverse=True)
        # bincount of nothing counts, in integers.
        sums = np.bincount(place, weights=coefficients, minlength=len(distinct)).astype(np.float64)
        kept = np.abs(sums) > floor
        return cls(basis, distinct[kept], sums[kept])

    def __len__(self) -> int:
        return len(self.ids)

    def __add__(self, other: Series) -> Series:
        return Series.gathered(
            self.basis,
            np.concatenate([self.ids, other.ids]),
            np.concatenate([self.coefficients, other.coefficients]),
        )

    def __mul__(self, factor: float) -> Series:
        return Series(self.basis, self.ids, factor * self.coefficients)

    __rmul__ = __mul__

    def on(self, ids: Ids) -> FloatArray:
        """Coefficients of the given functions, 0 where there is none; `ids` ascending, all of ours in it."""
        out = np.zeros(len(ids))
        out[np.searchsorted(ids, self.ids)] = self.coefficients
        return out

    def cut(self, floor: float) -> Series:
        """Leave out coefficients of at most `floor`."""
        kept = np.abs(self.coefficients) > floor
        return Series(self.basis, self.ids[kept], self.coefficients[kept])

    def derivative(self, joint: int) -> Series:
        """Derivative by q_joint (from 0); exact."""
        ids, factors = self.basis.derivative(self.ids, joint)
        there = factors != 0.0
        return Series.gathered(self.basis, ids[there], (self.coefficients * factors)[there])

    def __call__(self, q: FloatArray) -> FloatArray:
        """Evaluate at q of shape (n, N): shape (N,)."""
        return self.coefficients @ self.basis.evaluate(self.ids, q)

    @property
    def size(self) -> float:
        """Bound on the magnitude for revolute joints: sum of the coefficients' magnitudes."""
        return float(np.abs(self.coefficients).sum())
