"""Coefficients that may become equal: what a refit can save beside the terms it lets go.

Two coefficients a budget apart from being equal, opposite or a power of two apart may as well be that: what
they multiply can then be added first, or formed once. Pairs are tried, the closest first, each with a new fit
of all that is kept, and stay tied where the program takes fewer operations.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import Candidates
from gd_analyze.simplification.refit import Refit
from gd_analyze.simplification.work import Work

# Pairs tried in all, and how far apart the coefficients of a pair may be, as a factor.
_TRIALS, _APART = 60, 1.5


def share_coefficients(
    candidates: Candidates,
    kept: NDArray[np.bool_],
    scale: FloatArray,
    count: Callable[[NDArray[np.bool_], FloatArray], int],
    work: Work,
) -> tuple[Candidates, FloatArray]:
    """Tie coefficients to each other while the budget holds and operations go down.

    Parameters
    ----------
    candidates, kept, scale
        What may be kept, what is, and the factors of their coefficients, shape (K,) each.
    count
        Operations of a selection with given factors.
    work
        What may be done.

    Returns
    -------
    tuple
        The candidates with fewer free numbers, and the factors.
    """
    fewest, trials = count(kept, scale), _TRIALS
    refit = Refit(candidates, work)
    while True:
        for one, other in _pairs(candidates, kept, scale):
            if trials == 0 or not work.affords(0.0):
                return candidates, scale
            trials -= 1
            trial = _tied(candidates, scale, one, other)
            refit = Refit(trial, work, refit)
            fitted = refit.within(kept)
            if fitted is not None and (operations := count(kept, fitted)) < fewest:
                candidates, scale, fewest = trial, fitted, operations
                break
        else:
            return candidates, scale


def _pairs(candidates: Candidates, kept: NDArray[np.bool_], scale: FloatArray) -> list[tuple[int, int]]:
    """Pairs of candidates that stand for coefficients to tie, the closest first."""
    members = np.flatnonzero(kept & (scale != 0.0))
    _, first = np.unique(candidates.parameter[members], return_index=True)
    chosen = members[first]
    size = np.log2(np.abs(candidates.magnitude[chosen] * scale[chosen]))
    found = []
    for a in range(len(chosen)):
        for b in range(a):
            apart = abs(size[a] - size[b] - round(size[a] - size[b]))
            if apart <= np.log2(_APART):
                found.append((float(apart), int(chosen[a]), int(chosen[b])))
    return [(one, other) for _, one, other in sorted(found)]


def _tied(candidates: Candidates, scale: FloatArray, one: int, other: int) -> Candidates:
    """Let the coefficient of one follow that of the other, at the nearest power of two."""
    size = candidates.magnitude[[one, other]] * np.abs(scale[[one, other]])
    step = size[1] * 2.0 ** np.round(np.log2(size[0] / size[1])) / size[0]
    parameter, ratio = candidates.parameter.copy(), candidates.ratio.copy()
    moved = parameter == parameter[one]
    free = {k: scale[k] / ratio[k] for k in (one, other)}
    ratio[moved] *= free[one] * step / free[other]
    parameter[moved] = parameter[other]
    return dataclasses.replace(candidates, parameter=parameter, ratio=ratio)
