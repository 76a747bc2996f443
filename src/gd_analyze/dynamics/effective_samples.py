"""How many independent readings a series is worth whose neighbours resemble each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gd_analyze.arrays import Array, FloatArray

# Readings of one block: neighbours resemble each other over far fewer than half of it.
_BLOCK = 2**14
# Correlations are summed over so many times what they sum to: beyond, noise alone would be added.
# A. Sokal (1997), Monte Carlo methods in statistical mechanics, section 3.
_WINDOW = 5.0


def correlation_time(
    residual: Callable[[slice], FloatArray], used: Array, stretches: Sequence[slice]
) -> float:
    """Readings per independent one, 1 or more: 1 + 2 sum_k rho_k, rho_k the correlation of those k apart.

    A mean over N of them is as uncertain as one over N divided by this. For the coefficients of a fit the
    same holds as long as what they belong to changes more slowly than the residuals are alike, and errs to
    the safe side otherwise.

    Parameters
    ----------
    residual
        Gives what a fit leaves at the set points of a slice.
    used
        Which set points took part, shape (N,).
    stretches
        Slices of set points without a gap.
    """
    products, pairs = np.zeros(_BLOCK // 2), np.zeros(_BLOCK // 2)
    for stretch in stretches:
        for start in range(stretch.start, stretch.stop, _BLOCK):
            block = slice(start, min(start + _BLOCK, stretch.stop))
            there = used[block].astype(float)
            if there.any():
                products += _at_distance(np.where(used[block], residual(block), 0.0))
                pairs += _at_distance(there)
    # Few pairs say little.
    enough = pairs >= max(0.1 * pairs[0], 1.0)
    known = len(enough) if enough.all() else int(np.argmin(enough))
    covariance = products[:known] / pairs[:known]
    if known < 2 or not covariance[0] > 0:
        return 1.0
    times = 2.0 * np.cumsum(covariance / covariance[0]) - 1.0
    wide = np.flatnonzero(np.arange(known) >= _WINDOW * times)
    return max(1.0, float(times[wide[0] if len(wide) else -1]))


def _at_distance(values: FloatArray) -> FloatArray:
    """Sums of products of values 0, 1, 2, ... readings apart, for half a block."""
    spectrum = np.fft.rfft(values, 2 * _BLOCK)
    return np.fft.irfft(np.abs(spectrum) ** 2, 2 * _BLOCK)[: _BLOCK // 2]
