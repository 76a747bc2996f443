"""Climbing to a local maximum within a box of positions, from several places at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box

# Of the box's width: the first step, and how often it is halved.
_FIRST_STEP, _HALVINGS = 1 / 32, 9
# Moves at most, lest a long ridge be followed for ever.
_MOST_MOVES = 40


def local_maximum(
    value: Callable[[FloatArray], FloatArray], box: Box, starts: FloatArray
) -> tuple[FloatArray, float]:
    """Climb from every start, and return the highest place reached and its value.

    Every joint is tried one step to either side; the best of these is taken, and the step halved where none
    is better.

    Parameters
    ----------
    value
        Of positions (n, K), shape (K,).
    box
        Its limits are kept.
    starts
        Positions, shape (n, S).
    """
    lower, upper = box.lower[:, None], box.upper[:, None]
    width = box.upper - box.lower
    moves = np.vstack([np.diag(width), -np.diag(width)])[np.tile(width > 0.0, 2)].T
    q = np.clip(starts, lower, upper)
    reached = value(q)
    step = np.full(q.shape[1], _FIRST_STEP)
    for _ in range(_MOST_MOVES if moves.size else 0):
        places = np.flatnonzero(step > _FIRST_STEP / 2**_HALVINGS)
        if not places.size:
            break
        tried = q[:, places, None] + step[places, None] * moves[:, None]
        tried = np.clip(tried, lower[..., None], upper[..., None])
        values = value(tried.reshape(len(q), -1)).reshape(tried.shape[1:])
        best = values.argmax(axis=1)
        rows = np.arange(len(best))
        better = values[rows, best] > reached[places]
        q[:, places[better]] = tried[:, rows[better], best[better]]
        reached[places[better]] = values[rows[better], best[better]]
        step[places[~better]] /= 2
    top = int(reached.argmax())
    return q[:, top], float(reached[top])
