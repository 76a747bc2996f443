"""Hypotheses on positions: direction, zero, order and coupling of joints, unit of time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.hypothesis import KNOWN_ADVANTAGE, Candidate, Hypothesis, Problem, signs, swapped
from gd_analyze.diagnosis.remedies import (
    ONE_DEGREE,
    at_pace,
    corrected,
    in_digits,
    in_unit,
    reordered,
)
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.motions.units_by_numbers import out_of_reach
from gd_analyze.motions.velocities import derivative_factors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number
from gd_analyze.units import UNITS

# Cosine between parallel axes.
_PARALLEL_COSINE = 0.999
# First steps of a search for a zero, as shares of the others: where half a step either way is worse than
# none, the valley of a small error may lie between.
_FIRST_STEPS = np.array([-0.5, -1.0 / 6.0, 0.0, 1.0 / 6.0, 0.5])

_MILLIMETRE = UNITS["length"]["mm"]
_NO_MOTION = 1e-6  # factor of a joint's positions that leaves no torque of its motion, but its direction

# Radians per unit of an angle, and what these are called: counts are those of encoders in a turn.
_COUNTS = (*(2**k for k in range(10, 25)), 1000, 2000, 3600, 4000, 5000, 8000, 10000, 20000, 40000)
ANGLES = {
    ONE_DEGREE: "degrees",
    1e-2 * ONE_DEGREE: "hundredths of a degree",
    1e-3 * ONE_DEGREE: "thousandths of a degree",
    1e-3: "milliradians",
    2.0 * np.pi: "turns",
    **{2.0 * np.pi / count: f"counts, {count} in a turn" for count in _COUNTS},
}


def doubtful_positions(problem: Problem) -> list[int]:
    """Joints, from 0, whose corrected positions are beyond what such joints reach: units come first."""
    q, *_ = problem.correction.states(problem.samples)
    return np.flatnonzero(out_of_reach(problem.arm, np.abs(q).max(axis=0, initial=0.0))).tolist()


class PositionUnit(Hypothesis):
    """Positions are in degrees, millimetres or counts of an encoder: all, or those of one joint."""

    name = "unit of positions"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best unit of all joints that turn, and the best joint in a unit of its own."""
        turns = np.array(problem.arm.is_revolute)
        if turns[problem.moving].any():
            yield from self._best(problem, [(turns, size, unit) for size, unit in ANGLES.items()])
        single = [
            (
                np.arange(problem.n) == i,
                *((ONE_DEGREE, "degrees") if turns[i] else (_MILLIMETRE, "millimetres")),
            )
            for i in problem.moving
            if problem.n > 1 and (turns[i] or self._may_be_in_millimetres(problem, i))
        ]
        yield from self._best(problem, single)
        if self._are_read_as_degrees(problem):
            sizes = np.where(turns, 1.0 / ONE_DEGREE, 1.0)
            yield Candidate(
                self.name,
                "Positions are in radians, and were read as degrees",
                in_unit(problem.samples, sizes),
                problem.correction.with_position(np.diag(sizes)),
            )

    def _best(self, problem: Problem, units: list[tuple[Array, float, str]]) -> Iterator[Candidate]:
        factors = [np.where(chosen, size, 1.0) for chosen, size, _ in units]
        corrections = [problem.correction.with_position(np.diag(x)) for x in factors]
        for k in problem.best(corrections):
            chosen, _, unit = units[k]
            joints = np.flatnonzero(chosen).tolist()
            subject = "Positions" if len(joints) > 1 else f"Positions of joint {joints[0] + 1}"
            yield Candidate(
                self.name,
                f"{subject} are in {unit}",
                in_unit(problem.samples, factors[k]),
                corrections[k],
                alternatives=len(units),
            )

    def _may_be_in_millimetres(self, problem: Problem, joint: int) -> bool:
        """Whether a sliding joint's positions are beyond its reach, or its motion would show in torques.

        A thousandth of its motion may be none: then friction and an offset explain any torque.
        """
        if joint in doubtful_positions(problem):
            return True

        def scaled(size: float) -> Trial:
            sizes = np.ones(problem.n)
            sizes[joint] = size
            return problem.correction.with_position(np.diag(sizes))

        resting, moving = (problem.score(scaled(size)) for size in (_NO_MOTION, _MILLIMETRE))
        return moving < resting - KNOWN_ADVANTAGE

    def _are_read_as_degrees(self, problem: Problem) -> bool:
        recordings = (log.recording for log in problem.samples.logs)
        uses = [use for recording in recordings if recording for use in recording.columns if use.role == "q"]
        return any(use.unit == "deg" for use in uses)


class Direction(Hypothesis):
    """A joint counts the other way: its positions with its torques, or its positions alone."""

    name = "direction of a joint"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best joint of either kind."""
        n, moving = problem.n, problem.moving
        groups = [[i] for i in moving] + ([[*range(n)]] if len(moving) > 1 else [])
        for what, reversed_by, most in (
            ("positions and torques", problem.unchanged.with_joints, 2),
            ("positions alone", problem.unchanged.with_position, 1),
        ):
            causes = []
            for group in groups:
                subject = "All joints count" if len(group) > 1 else f"Joint {group[0] + 1} counts"
                remedy = corrected(problem.samples, reversed_by(signs(n, group)))
                causes.append((f"{subject} the other way, {what}", remedy))
            yield from self.best(problem, causes, most, alternatives=2 * (n + 1))


class Zero(Hypothesis):
    """The zero of a joint is not the file's."""

    name = "zero of a joint"
    # Coarser steps miss the valley of a joint that carries much.
    _STEP_OF_TURN = np.pi / 5.0

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The two best joints, at a multiple of 90 degrees unless another angle is clearly better."""
        ends = np.arange(1.0, round(2.0 * np.pi / self._STEP_OF_TURN))
        grid = self._STEP_OF_TURN * np.concatenate([[-1.0], _FIRST_STEPS, ends, [ends[-1] + 1.0]])
        joints = [i for i in problem.moving if problem.arm.is_revolute[i]]
        for i, turned, low, high in _shifted(problem, dict.fromkeys(joints, grid), 2):
            angle = problem.refined(turned, problem.along(turned, low, high, 9), np.radians(1.5))
            right = float(np.pi / 2.0 * np.round(angle / (np.pi / 2.0)))
            is_known = right % (2.0 * np.pi) > 0.1 and problem.score(turned(right)) < (
                problem.score(turned(angle)) + KNOWN_ADVANTAGE
            )
            angle = right if is_known else angle
            angle -= 2.0 * np.pi * np.ceil(angle / (2.0 * np.pi) - 0.5)  # at most half a turn
            typed = in_digits(angle, 4, ONE_DEGREE)
            yield Candidate(
                self.name,
                f"The zero of joint {i + 1} is off by {typed / ONE_DEGREE:.4g} degrees",
                corrected(problem.samples, problem.unchanged.with_offset(i, typed)),
                turned(angle),
                numbers=0 if is_known else 1,
                alternatives=(3 if is_known else 1) * problem.n,
                unsure="the last link's masses are turned as far" if i == problem.n - 1 else "",
            )


class ZeroOfSlide(Hypothesis):
    """The zero of a prismatic joint is not the file's: seen by joints that turn what it shifts."""

    name = "zero of a joint"
    # Steps of a search from 0 to one end of the travel.
    _STEPS_OF_TRAVEL = 6

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best prismatic joint."""
        ends = np.arange(1.0, self._STEPS_OF_TRAVEL + 2.0)
        steps = np.concatenate([-ends[::-1], _FIRST_STEPS, ends])
        joints = [i for i in problem.moving if not problem.arm.is_revolute[i]]
        grids = {i: self._travel(problem.arm, i) / self._STEPS_OF_TRAVEL * steps for i in joints}
        for i, shifted, low, high in _shifted(problem, grids, 1):
            length = problem.along(shifted, low, high, 12)
            typed = in_digits(length, 3, _MILLIMETRE)
            yield Candidate(
                self.name,
                f"The zero of joint {i + 1} is off by {number(typed / _MILLIMETRE)} mm",
                corrected(problem.samples, problem.unchanged.with_offset(i, typed)),
                shifted(length),
                numbers=1,
                alternatives=len(joints),
            )

    def _travel(self, arm: RobotArm, joint: int) -> float:
        ends = (arm.joints[joint].lower, arm.joints[joint].upper)
        return max(
            (abs(end) for end in ends if end is not None and np.isfinite(end)), default=arm.reach or 1.0
        )


def _shifted(
    problem: Problem, grids: Mapping[int, FloatArray], most: int
) -> Iterator[tuple[int, Callable[[float], Trial], float, float]]:
    """The best joints, the correction that shifts each, and the points of its grid beside the best one."""
    brackets = []
    for i, grid in grids.items():
        tried = partial(problem.correction.with_offset, i)
        scores = problem.roughly(map(tried, grid[1:-1].tolist()))
        k = int(scores.argmin())
        brackets.append((float(scores[k]), i, tried, float(grid[k]), float(grid[k + 2])))
    for score, i, tried, low, high in sorted(brackets, key=lambda bracket: bracket[0])[:most]:
        if problem.helps(score):
            yield i, tried, low, high


class JointOrder(Hypothesis):
    """Two joints are exchanged, or all are in reversed order: positions with torques, or positions alone."""

    name = "order of joints"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best exchange of either kind."""
        n, turns = problem.n, problem.arm.is_revolute
        orders = [
            (f"joints {i + 1} and {j + 1} are exchanged", swapped(n, i, j))
            for i, j in combinations(problem.moving, 2)
            if turns[i] == turns[j]
        ]
        if len(problem.moving) == n and len(set(turns)) == 1 and n > 2:
            orders.append((f"joints 1 to {n} are in reversed order", np.eye(n)[::-1]))
        whole = [(what.capitalize(), reordered(problem.samples, order, order)) for what, order in orders]
        alone = [
            (f"The positions of {what}", reordered(problem.samples, order, np.eye(n)))
            for what, order in orders
        ]
        for causes in (whole, alone):
            yield from self.best(problem, causes, alternatives=2 * len(orders))


class Coupling(Hypothesis):
    """A joint is measured against the base, not against the link before it: parallel axes."""

    name = "coupled joints"
    _HAS_PARALLEL_AXES = True  # whether the axes of the pairs are parallel
    _RARITY_COST = 0.0  # cost of the cause

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best pair of neighbours, torques by the transposed inverse."""
        turns, parallel = problem.arm.is_revolute, parallel_to_next(problem.arm)
        causes = []
        for i, j in permutations(problem.moving, 2):
            are_neighbours = abs(i - j) == 1 and turns[i] and turns[j]
            if are_neighbours and parallel[min(i, j)] == self._HAS_PARALLEL_AXES:
                for sign, relation in ((1.0, "the difference"), (-1.0, "the sum")):
                    matrix = np.eye(problem.n)
                    matrix[i, j] = sign
                    what = f"Joint {i + 1} is logged as {relation} of joints {i + 1} and {j + 1}"
                    causes.append((what, corrected(problem.samples, problem.unchanged.with_joints(matrix))))
        yield from self.best(problem, causes, alternatives=len(causes), rare=self._RARITY_COST)


class WristCoupling(Coupling):
    """A joint moves its neighbour across: motors that drive two joints of a wrist."""

    # Torque of one joint that a neighbour's sensor feels looks alike, as in a Panda's log (a fall of 120).
    _HAS_PARALLEL_AXES, _RARITY_COST = False, 150.0


def parallel_to_next(arm: RobotArm) -> list[bool]:
    """Whether a revolute joint's axis is parallel to the next one's, as linked arms' are."""
    axes = solve_kinematics(arm, np.zeros((arm.n_joints, 1))).joint_axes[:, :, 0]
    turns = arm.is_revolute
    return [
        turns[i] and turns[i + 1] and abs(float(axes[i] @ axes[i + 1])) > _PARALLEL_COSINE
        for i in range(arm.n_joints - 1)
    ]


class TimeUnit(Hypothesis):
    """Time is in another unit, or runs at another pace."""

    name = "unit of time"
    _KNOWN_PACES = (1e3, 1e-3, 60.0, 10.0, 0.1)
    _FEWEST_JOINTS = 2  # least joints whose velocity columns have one factor
    _LARGEST_SPREAD = 0.2  # of these factors, as a share of their median

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best known factor, or a free one."""
        correction = problem.correction
        if not np.isfinite(correction.pace):
            return
        factor = self._of_velocities(problem)
        if factor is not None and 0.8 < factor * correction.pace < 1.25:
            return  # velocities are as logged times and positions say
        if factor is not None:
            yield self._candidate(problem, 1.0 / (factor * correction.pace), evident=True)

        def paced(pace: float) -> Trial:
            return replace(correction, pace=correction.pace * pace)

        paces = [*self._KNOWN_PACES, 0.3, 0.6, 1.7, 3.5]
        scores = problem.roughly(map(paced, paces))
        pace = paces[int(np.argmin(scores))]
        if not problem.helps(scores.min()):
            return
        low, high = np.log(pace) - 0.7, np.log(pace) + 0.7
        free = float(np.exp(problem.along(lambda x: paced(float(np.exp(x))), low, high, 10)))
        is_known = pace in self._KNOWN_PACES and problem.score(paced(pace)) < (
            problem.score(paced(free)) + KNOWN_ADVANTAGE
        )
        pace = pace if is_known else free
        # At rest there is no unit of time: the motion must show at the pace that is claimed.
        resting, moving = problem.score(paced(np.inf)), problem.score(paced(pace))
        if 0.8 < pace < 1.25 or moving > resting - KNOWN_ADVANTAGE:
            return
        told = self._candidate(problem, pace)
        yield replace(told, alternatives=len(self._KNOWN_PACES)) if is_known else replace(told, numbers=1)

    def _candidate(self, problem: Problem, pace: float, *, evident: bool = False) -> Candidate:
        reason = ", as the velocity columns say" if evident else ""
        what = f"Time is in another unit{reason}: {number(1.0 / pace)} of its seconds are one"
        return self.exact(problem, what, at_pace(problem.samples, pace), evident=evident)

    def _of_velocities(self, problem: Problem) -> float | None:
        """Factor by which the velocity columns of all joints are too large; None without a common one."""
        factors = []
        for log in problem.samples.logs:
            recording = log.recording
            if recording is not None and recording.qd is not None:
                factors.append(derivative_factors(log.time, recording.q, recording.qd, log.gaps)[0])
        known_factors = np.concatenate(factors) if factors else np.zeros(0)
        known_factors = known_factors[np.isfinite(known_factors) & (known_factors > 0.0)]
        if len(known_factors) < self._FEWEST_JOINTS:
            return None
        median = float(np.median(known_factors))
        return None if np.ptp(known_factors) > self._LARGEST_SPREAD * median else median
