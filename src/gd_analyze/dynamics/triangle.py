"""Least squares of long columns from a small triangle: what their QR decomposition leaves, block by block."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from gd_analyze.arrays import FloatArray

# A column of whose length no more than this part is independent of those before it tells nothing of its own:
# rates and torques have not as many good digits.
_DEPENDENT = 1e-6

# A column that varies less than this part of its length is constant: round-off of sums of a million terms.
_CONSTANT = 1e-12


def triangle(blocks: Iterable[FloatArray], columns: int) -> FloatArray:
    """R of the QR decomposition of some columns, given as blocks of rows, shape (columns, columns).

    Whatever least squares or sums of squares of the columns are wanted, R gives them in place of the columns,
    and without the squaring that would cost half the digits.
    """
    left = np.zeros((columns, columns))
    for block in blocks:
        left = reduced(np.vstack([left, block]))
    return left


def reduced(columns: FloatArray) -> FloatArray:
    """R of the QR decomposition of columns at hand."""
    return np.asarray(np.linalg.qr(columns, mode="r"))


def independent(r: FloatArray, columns: Sequence[int]) -> list[int]:
    """Those of some columns that are not made up of the ones before them."""
    kept: list[int] = []
    for column in columns:
        whole = float(np.linalg.norm(r[:, column]))
        own = abs(reduced(r[:, [*kept, column]])[-1, -1])
        if own > _DEPENDENT * whole:
            kept.append(column)
    return kept


def spread(columns: FloatArray) -> FloatArray:
    """Norm of columns of R less their means, where the first is of an offset; nan of what is constant."""
    varied = np.linalg.norm(columns[1:], axis=0)
    return np.where(varied > _CONSTANT * np.linalg.norm(columns, axis=0), varied, np.nan)
