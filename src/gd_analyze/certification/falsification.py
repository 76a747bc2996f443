"""Attempts to break a model's budget: random states of a region, and ascents from the worst of them.

In a box positions alone are random: velocities and accelerations are the worst at each.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.error_field import local_maxima
from gd_analyze.certification.motion import MotionFactors
from gd_analyze.certification.tube import Tube
from gd_analyze.harmonics.expansion import expansion_factors
from gd_analyze.motions.states import States
from gd_analyze.operations.program import program_inputs
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel

# Random states of a tube per round.
RANDOM_STATES = 200_000
# Random states at a time.
STATES_AT_ONCE = 50_000

_JOINING_PER_JOINT = 30  # most states added to the fit per joint: those that exceed the budget
_TUBE_ASCENT_STEPS = 3  # steps of an ascent in a small box of a tube
POSITIONS_AT_ONCE = 4_000  # random positions of a box at a time
# Positions, the worst per joint of those at a time, from which the error ascends. From 4 of 4000, errors
# of three arms of six joints end within 1.5 % of the largest known; the other positions are margin.
_ASCENTS = 4

# Random positions of a box per round.
RANDOM_POSITIONS = 20_000


def worst_found(
    model: SimplifiedModel,
    exact: ExactDynamics,
    region: Tube,
    allowed: FloatArray,
    seed: int,
    count: int,
) -> tuple[FloatArray, FloatArray]:
    """Largest error of every joint at states drawn from a region, (n,), and the worst states, (3, M, n)."""
    rng, n = np.random.default_rng(seed), len(allowed)

    @cache
    def runners(count: int) -> tuple[Callable[..., FloatArray], ...]:
        return model.program.runner(count), exact.form.program.runner(count)

    def share(states: FloatArray, counts: FloatArray) -> FloatArray:
        """Errors over allowed ones at states (3, N, n), shape (n, N); counts (M, n) repeat."""
        inputs = program_inputs(States(*states))
        torque, exact_torque = (run(inputs) for run in runners(min(states.shape[1], CHUNK)))
        error = torque - exact_torque
        shares = np.abs(error) / allowed[:, None]
        return np.asarray((shares.reshape(n, -1, len(counts)) * counts.T[:, None]).reshape(n, -1))

    largest, worst = np.zeros(n), [np.empty((3, 0, n))]
    for _ in range(count // STATES_AT_ONCE):
        if (largest > 1.0).any():
            break  # ascents from the first ones have found enough
        lower, upper, counts = region.pieces(STATES_AT_ONCE, rng)
        states = rng.uniform(lower, upper)
        errors = share(states, counts)
        worst_of_joints = np.argpartition(-errors, _JOINING_PER_JOINT)[:, :_JOINING_PER_JOINT]
        joints, top = np.repeat(np.arange(n), _JOINING_PER_JOINT), worst_of_joints.ravel()
        low, high = (np.broadcast_to(x, states.shape)[:, top] for x in (lower, upper))
        share_at = partial(share, counts=counts[top])
        reached = _climbed(share_at, joints, states[:, top], low, high)
        errors = share_at(reached)
        largest = np.maximum(largest, errors.max(axis=1))
        worst.append(reached[:, errors[joints, np.arange(len(top))] > 1.0])
    return largest * allowed, np.concatenate(worst, axis=1)


def _climbed(
    share: Callable[[FloatArray], FloatArray],
    joints: NDArray[np.intp],
    states: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> FloatArray:
    """Ascend within small boxes: each variable moves to the end with the larger error, if that is larger.

    The error is that of one of the `joints`, (N,), at every state.
    """
    count, n = states.shape[1:]
    places = np.arange(count)
    for _ in range(_TUBE_ASCENT_STEPS):
        present = share(states)[joints, places]
        # By end, kind and number of the variable that moves.
        moved = np.broadcast_to(states, (2, 3, n, *states.shape)).copy()
        for end, kind, k in np.ndindex(2, 3, n):
            moved[end, kind, k, kind, :, k] = (lower, upper)[end][kind, :, k]
        candidates = np.moveaxis(moved, 3, 0).reshape(3, -1, n)
        moved_errors = share(candidates).reshape(-1, 2, 3, n, count)[joints, :, :, :, places]
        moved_errors = np.moveaxis(moved_errors, 0, 2)
        ends = np.where(moved_errors[1] > moved_errors[0], upper, lower)
        trial = np.where(moved_errors.max(axis=0) > present[:, None], ends, states)
        better = share(trial)[joints, places] > present
        if not better.any():
            break
        states = np.where(better[:, None], trial, states)
    return states


class BoxErrors:
    """Errors of a model over allowed ones, by position in a box.

    The error is affine in accelerations and quadratic in velocities. So its values at a position determine
    the `MotionFactors` there: one value at rest, and one per factor with its velocities or its acceleration
    at their limits.
    """

    def __init__(self, model: SimplifiedModel, exact: ExactDynamics, box: Box, allowed: FloatArray) -> None:
        self.box, self.allowed, factors = box, allowed, expansion_factors(box.n_joints)
        self.motion = MotionFactors(box.n_joints, factors)
        # Velocities and accelerations of these states as shares of their limits, (2, states, n).
        shares = np.zeros((2, len(factors), box.n_joints))
        for state, (kind, joints) in enumerate(factors):
            shares[int(kind == "qdd"), state, list(joints)] = 1.0
        of_factors = [shares[int(kind == "qdd")][:, list(joints)].prod(axis=1) for kind, joints in factors]
        self._inverse = np.linalg.inv(np.transpose(of_factors))
        self._moving = shares * np.stack([box.velocity, box.acceleration])[:, None]

        @cache
        def runners(power: int) -> tuple[Callable[..., FloatArray], ...]:  # few, as each keeps its memory
            return model.program.runner(2**power), exact.form.program.runner(2**power)

        self._runners = runners

    def at(self, states: FloatArray) -> FloatArray:
        """Errors at states (3, N, n), shape (n, N)."""
        inputs = program_inputs(States(*states))
        power = min(states.shape[1], CHUNK).bit_length() - 1
        torque, exact_torque = (run(inputs) for run in self._runners(power))
        return np.asarray((torque - exact_torque) / self.allowed[:, None])

    def factors(self, q: FloatArray) -> FloatArray:
        """Values of all factors for every joint at positions (n, K), shape (n, factors, K)."""
        n, count = q.shape
        states = np.empty((3, len(self._inverse), count, n))
        states[0], states[1:] = q.T, self._moving[:, :, None]
        return np.asarray(self._inverse @ self.at(states.reshape(3, -1, n)).reshape(n, -1, count))

    def reached(self, q: FloatArray, joint: int) -> FloatArray:
        """Error of a joint at positions (n, K), see `Motion.reached`, shape (K,)."""
        return self.motion.reached(self.factors(q)[joint])

    def worst(self, q: FloatArray, joint: int) -> FloatArray:
        """States of the largest errors of a joint at positions (n, K), shape (3, K, n)."""
        _, velocities, pushes = self.motion.worst(self.factors(q)[joint])
        return np.stack([q.T, velocities.T * self.box.velocity, pushes.T * self.box.acceleration])


def worst_in_box(
    model: SimplifiedModel,
    exact: ExactDynamics,
    box: Box,
    allowed: FloatArray,
    seed: int,
    count: int = RANDOM_POSITIONS,
) -> tuple[FloatArray, FloatArray]:
    """Largest error of every joint that a search finds in a box, (n,), and states beyond, (3, M, n).

    Positions are drawn, and the error ascends from the worst of them; velocities and accelerations are the
    worst at each.
    """
    rng, n, errors = np.random.default_rng(seed), box.n_joints, BoxErrors(model, exact, box, allowed)
    joining = _JOINING_PER_JOINT
    largest, exceeding = np.zeros(n), [np.empty((3, 0, n))]
    for _ in range(count // POSITIONS_AT_ONCE):
        if (largest > 1.0).any():
            break  # the first ones have found enough
        q = rng.uniform(box.lower, box.upper, (POSITIONS_AT_ONCE, n)).T
        for i, values in enumerate(errors.factors(q)):
            top = q[:, np.argsort(-errors.motion.reached(values), kind="stable")[:joining]]
            highest, _ = local_maxima(partial(errors.reached, joint=i), box, top[:, :_ASCENTS])
            states = errors.worst(np.hstack([highest, top]), i)
            sizes = np.abs(errors.at(states))
            largest = np.maximum(largest, sizes.max(axis=1))
            exceeding.append(states[:, sizes[i] > 1.0])
    return largest * allowed, np.concatenate(exceeding, axis=1)
