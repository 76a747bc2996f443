"""Attempts to break a model's budget: random states of a region, and ascents from the worst of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from gd_analyze.arrays import CHUNK, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.tube import Tube
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Batch
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel

# Random states per round, and at a time; most of them added per joint: those that exceed the budget or, for
# models that are always refitted, reach this share of it.
TRIED, AT_ONCE, _JOINING, _NEARLY = 200_000, 50_000, 30, 0.8
# Steps of an ascent, and its largest move within limits, as a share of every range.
_STEPS, _NEAR = 3, 0.03


def worst_found(
    model: SimplifiedModel,
    exact: ExactDynamics,
    region: Box | Tube,
    allowed: FloatArray,
    seed: int,
    count: int,
) -> tuple[FloatArray, FloatArray]:
    """Largest error of every joint at states drawn from a region, (n,), and the worst states, (3, M, n)."""
    rng, n = np.random.default_rng(seed), len(allowed)
    least = _NEARLY if model.level.always_refits else 1.0
    # Over a whole box an ascent finds errors so rare that a recursion without them takes 2 to 5 % more
    # operations, and twice the search time.
    climbs = isinstance(region, Tube) or not model.level.always_refits

    @cache
    def batches(count: int) -> tuple[Batch, Batch]:
        return Batch(model.program, count), Batch(exact.form.program, count)

    def share(states: FloatArray, counts: FloatArray) -> FloatArray:
        """Errors over allowed ones at states (3, N, n), shape (n, N); counts (M, n) repeat."""
        inputs = inputs_of(States(*states))
        found, torque = (batch.over(inputs) for batch in batches(min(states.shape[1], CHUNK)))
        off = found - torque
        each = np.abs(off) / allowed[:, None]
        return np.asarray((each.reshape(n, -1, len(counts)) * counts.T[:, None]).reshape(n, -1))

    largest, worst = np.zeros(n), [np.empty((3, 0, n))]
    for _ in range(count // AT_ONCE):
        if (largest > 1.0).any():
            break  # ascents from the first ones have found enough
        lower, upper, counts = region.pieces(AT_ONCE, rng)
        states = rng.uniform(lower, upper)
        for i, errors in enumerate(share(states, counts)):
            top = np.argpartition(-errors, _JOINING)[:_JOINING]
            reached = states[:, top]
            low, high = (np.broadcast_to(x, states.shape)[:, top] for x in (lower, upper))
            if isinstance(region, Box):  # slightly farther than states were drawn
                near = _NEAR * (high - low)
                low, high = np.maximum(low, reached - near), np.minimum(high, reached + near)
            here = partial(share, counts=counts[top])
            reached = _climbed(here, i, reached, low, high) if climbs else reached
            errors = here(reached)
            largest = np.maximum(largest, errors.max(axis=1))
            worst.append(reached[:, errors[i] > least])
    return largest * allowed, np.concatenate(worst, axis=1)


def _climbed(
    share: Callable[[FloatArray], FloatArray],
    joint: int,
    states: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> FloatArray:
    """Ascend within small boxes: each variable moves to the end with the larger error, if that is larger."""
    count, n = states.shape[1:]
    for _ in range(_STEPS):
        here = share(states)[joint]
        # By end, kind and number of the variable that moves.
        moved = np.broadcast_to(states, (2, 3, n, *states.shape)).copy()
        for end, kind, k in np.ndindex(2, 3, n):
            moved[end, kind, k, kind, :, k] = (lower, upper)[end][kind, :, k]
        every = np.moveaxis(moved, 3, 0).reshape(3, -1, n)
        there = share(every)[joint].reshape(2, 3, n, count).swapaxes(2, 3)
        ends = np.where(there[1] > there[0], upper, lower)
        trial = np.where(there.max(axis=0) > here[:, None], ends, states)
        better = share(trial)[joint] > here
        if not better.any():
            break
        states = np.where(better[:, None], trial, states)
    return states
