"""Hypotheses on positions: direction, zero, order and coupling of joints, unit of time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.correction import Correction
from gd_analyze.diagnosis.hypothesis import (
    KNOWN_ADVANTAGE,
    Candidate,
    Hypothesis,
    Problem,
    inverse,
    signs,
    swapped,
)
from gd_analyze.diagnosis.remedies import couple, degrees, map_of_joints, map_of_positions, scaled_positions
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.motions.velocities import velocity_factors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number
from gd_analyze.units import TIME_UNITS

# Cosine between parallel axes.
_PARALLEL_COSINE = 0.999
# First steps of a search for a zero, as shares of the others: where half a step either way is worse than
# none, the valley of a small error may lie between.
_FIRST_STEPS = np.array([-0.5, -1.0 / 6.0, 0.0, 1.0 / 6.0, 0.5])
_SAID_BY_VELOCITIES = ", as the velocity columns say"

# Radians per unit of an angle, and what these are called: counts are those of encoders in a turn.
_DEGREE = np.pi / 180.0
_COUNTS = (*(2**k for k in range(10, 25)), 1000, 2000, 3600, 4000, 5000, 8000, 10000, 20000, 40000)
ANGLES = {
    _DEGREE: "degrees",
    1e-2 * _DEGREE: "hundredths of a degree",
    1e-3 * _DEGREE: "thousandths of a degree",
    1e-3: "milliradians",
    2.0 * np.pi: "turns",
    **{2.0 * np.pi / count: f"counts, {count} in a turn" for count in _COUNTS},
}


class PositionUnit(Hypothesis):
    """Positions are in degrees, millimetres or counts of an encoder: all, or those of one joint."""

    name = "unit of positions"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best unit of all joints that turn, and the best joint in a unit of its own."""
        turns = np.array(problem.arm.is_revolute)
        if turns[problem.moving].any():
            yield from self._best(problem, [(turns, size, unit) for size, unit in ANGLES.items()])
        single = []
        for i in problem.moving if problem.n > 1 else []:
            chosen = np.arange(problem.n) == i
            sizes = {_DEGREE: "degrees"} if turns[i] else {1e-3: "millimetres"}
            single += [(chosen, size, unit) for size, unit in sizes.items()]
        yield from self._best(problem, single)
        if self._are_read_as_degrees(problem):
            factors = np.where(turns, 1.0 / _DEGREE, 1.0)
            correction = problem.correction.with_position(np.diag(factors))
            yield Candidate(
                self.name,
                "Positions are in radians, and were read as degrees",
                "leave out --degrees, or name the columns q1_rad and so on",
                correction,
            )

    def _best(self, problem: Problem, units: list[tuple[Array, float, str]]) -> Iterator[Candidate]:
        factors = [np.where(chosen, size, 1.0) for chosen, size, _ in units]
        corrections = [problem.correction.with_position(np.diag(x)) for x in factors]
        for k in problem.best(corrections) if corrections else []:
            chosen, _, unit = units[k]
            joints = np.flatnonzero(chosen).tolist()
            subject = "Positions" if len(joints) > 1 else f"Positions of joint {joints[0] + 1}"
            is_option = unit == "degrees" and chosen.tolist() == list(problem.arm.is_revolute)
            remedy = "--degrees" if is_option else scaled_positions(factors[k], np.ones(problem.n))
            alternatives = len(units)
            sentence = f"{subject} are in {unit}"
            yield Candidate(self.name, sentence, remedy, corrections[k], alternatives=alternatives)

    def _are_read_as_degrees(self, problem: Problem) -> bool:
        recordings = (log.recording for log in problem.samples.logs)
        uses = [use for recording in recordings if recording for use in recording.columns if use.role == "q"]
        return any(use.unit == "deg" for use in uses)


class Direction(Hypothesis):
    """A joint counts the other way: its positions with its torques, or its positions alone."""

    name = "direction of a joint"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best joint of either kind."""
        n, correction, moving = problem.n, problem.correction, problem.moving
        joints = list(range(n))
        groups = [[i] for i in moving] + ([joints] if len(moving) > 1 else [])
        with_torques = [
            correction.with_position(signs(n, group)).with_torque(signs(n, group)) for group in groups
        ]
        positions_alone = [correction.with_position(signs(n, group)) for group in groups]
        for k in problem.best(with_torques, 2):
            yield self._candidate(groups[k], with_torques[k], problem, with_torque=True)
        for k in problem.best(positions_alone, 1):
            yield self._candidate(groups[k], positions_alone[k], problem, with_torque=False)

    def _candidate(
        self, joints: list[int], correction: Correction, problem: Problem, *, with_torque: bool
    ) -> Candidate:
        n = problem.n
        words = ",".join("-1" if i in joints else "1" for i in range(n)) if len(joints) < n else "-1"
        subject = f"Joint {joints[0] + 1} counts" if len(joints) == 1 else "All joints count"
        sentence = f"{subject} the other way, {'positions and torques' if with_torque else 'positions alone'}"
        # --position-sign turns the torques, too.
        remedy = f"--position-sign {words}" + ("" if with_torque else f" --torque-sign {words}")
        return Candidate(self.name, sentence, remedy, correction, alternatives=2 * (n + 1))


class Zero(Hypothesis):
    """The zero of a joint is not the file's."""

    name = "zero of a joint"
    # Coarser steps miss the valley of a joint that carries much.
    _STEP_OF_TURN = np.pi / 5.0

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The two best joints, at a multiple of 90 degrees unless another angle is clearly better."""
        correction = problem.correction
        joints = [i for i in problem.moving if problem.arm.is_revolute[i]]
        ends = np.arange(1.0, round(2.0 * np.pi / self._STEP_OF_TURN))
        grid = self._STEP_OF_TURN * np.concatenate([[-1.0], _FIRST_STEPS, ends, [ends[-1] + 1.0]])
        brackets = {}
        for i in joints:

            def tried(angle: float, joint: int = i) -> Correction:
                return correction.with_offset(joint, angle)

            brackets[i] = _bracket(problem, tried, grid)
        for i in sorted(brackets, key=lambda joint: brackets[joint][0])[:2]:
            score, low, high = brackets[i]
            if not problem.helps(score):
                continue

            def turned(angle: float, joint: int = i) -> Correction:
                return correction.with_offset(joint, angle)

            rough_angle = problem.along(turned, low, high, 9)
            angle = problem.refined(turned, rough_angle, np.radians(1.5))
            right = np.pi / 2.0 * np.round(angle / (np.pi / 2.0))
            right_angled = correction.with_offset(i, float(right))
            is_known = right % (2.0 * np.pi) > 0.1 and problem.score(right_angled) < (
                problem.score(correction.with_offset(i, angle)) + KNOWN_ADVANTAGE
            )
            angle = float(right) if is_known else angle
            angle -= 2.0 * np.pi * np.ceil(angle / (2.0 * np.pi) - 0.5)  # at most half a turn
            text = degrees(angle)
            yield Candidate(
                self.name,
                f"The zero of joint {i + 1} is off by {text.removesuffix('deg')} degrees",
                f"--offset {i + 1}={text}",
                correction.with_offset(i, angle),
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
        correction, arm = problem.correction, problem.arm
        best: list[tuple[float, int, float, float]] = []
        for i in problem.moving:
            if arm.is_revolute[i]:
                continue
            joint = arm.joints[i]
            limits = (end for end in (joint.lower, joint.upper) if end is not None and np.isfinite(end))
            travel = max((abs(end) for end in limits), default=arm.reach or 1.0)
            step = travel / self._STEPS_OF_TRAVEL
            ends = np.arange(1.0, self._STEPS_OF_TRAVEL + 2.0)
            grid = step * np.concatenate([-ends[::-1], _FIRST_STEPS, ends])

            def tried(length: float, joint: int = i) -> Correction:
                return correction.with_offset(joint, length)

            score, low, high = _bracket(problem, tried, grid)
            best.append((score, i, low, high))
        for score, i, low, high in sorted(best)[:1]:
            if not problem.helps(score):
                return

            def shifted(length: float, joint: int = i) -> Correction:
                return correction.with_offset(joint, length)

            length = problem.along(shifted, low, high, 12)
            text = f"{1e3 * length:.3g}mm"
            yield Candidate(
                self.name,
                f"The zero of joint {i + 1} is off by {text.removesuffix('mm')} mm",
                f"--offset {i + 1}={text}",
                correction.with_offset(i, length),
                numbers=1,
                alternatives=len(best),
            )


def _bracket(
    problem: Problem, corrected: Callable[[float], Correction], grid: FloatArray
) -> tuple[float, float, float]:
    """Best score inside a grid, judged by few samples, and the points beside it."""
    scores = problem.roughly(corrected(float(x)) for x in grid[1:-1])
    k = int(scores.argmin())
    return float(scores[k]), float(grid[k]), float(grid[k + 2])


class JointOrder(Hypothesis):
    """Two joints are exchanged, or all are in reversed order: positions with torques, or positions alone."""

    name = "order of joints"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best exchange of either kind."""
        n, correction = problem.n, problem.correction
        orders = [
            (f"joints {i + 1} and {j + 1} are exchanged", swapped(n, i, j))
            for i, j in combinations(problem.moving, 2)
            if problem.arm.is_revolute[i] == problem.arm.is_revolute[j]
        ]
        if len(problem.moving) == n and len(set(problem.arm.is_revolute)) == 1 and n > 2:
            orders.append((f"joints 1 to {n} are in reversed order", np.eye(n)[::-1]))
        alone = [correction.with_position(matrix) for _, matrix in orders]
        whole = [corrected.with_torque(matrix) for corrected, (_, matrix) in zip(alone, orders, strict=True)]
        for subject, corrections, mapped in (
            ("", whole, map_of_joints),
            ("the positions of ", alone, map_of_positions),
        ):
            for k in problem.best(corrections) if corrections else []:
                what, matrix = orders[k]
                sentence = (subject + what).capitalize()
                remedy = mapped(problem, matrix.argmax(axis=1).tolist())
                alternatives = 2 * len(orders)
                yield Candidate(self.name, sentence, remedy, corrections[k], alternatives=alternatives)


class Coupling(Hypothesis):
    """A joint is measured against the base, not against the link before it: parallel axes."""

    name = "coupled joints"
    _HAS_PARALLEL_AXES = True  # whether the axes of the pairs are parallel
    _RARITY_COST = 0.0  # cost of the cause

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best pair of neighbours, torques by the transposed inverse."""
        correction, corrections, turns = problem.correction, [], problem.arm.is_revolute
        parallel = parallel_to_next(problem.arm)
        pairs = []
        for i, j in permutations(problem.moving, 2):
            are_neighbours = abs(i - j) == 1 and turns[i] and turns[j]
            if are_neighbours and parallel[min(i, j)] == self._HAS_PARALLEL_AXES:
                pairs += [(i, j, 1.0), (i, j, -1.0)]
        for i, j, sign in pairs:
            matrix = np.eye(problem.n)
            matrix[i, j] = sign
            corrections.append(correction.with_position(matrix).with_torque(inverse(matrix).T))
        for k in problem.best(corrections, 1) if corrections else []:
            i, j, sign = pairs[k]
            relation = "the sum" if sign < 0 else "the difference"
            yield Candidate(
                self.name,
                f"Joint {i + 1} is logged as {relation} of joints {i + 1} and {j + 1}",
                couple(i, j, sign),
                corrections[k],
                alternatives=len(pairs),
                rare=self._RARITY_COST,
            )


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
            yield self._candidate(problem, 1.0 / (factor * correction.pace), 0, 1, _SAID_BY_VELOCITIES)
        paces = [*self._KNOWN_PACES, 0.3, 0.6, 1.7, 3.5]
        corrections = [replace(correction, pace=correction.pace * pace) for pace in paces]
        scores = problem.roughly(corrections)
        k = int(np.argmin(scores))
        if not problem.helps(scores[k]):
            return
        pace = paces[k]
        low, high = np.log(pace) - 0.7, np.log(pace) + 0.7
        free = float(
            np.exp(
                problem.along(
                    lambda x: replace(correction, pace=correction.pace * float(np.exp(x))), low, high, 10
                )
            )
        )
        is_known = pace in self._KNOWN_PACES and problem.score(corrections[k]) < (
            problem.score(replace(correction, pace=correction.pace * free)) + KNOWN_ADVANTAGE
        )
        pace = pace if is_known else free
        # At rest there is no unit of time: the motion must show at the pace that is claimed.
        resting, moving = (
            problem.score(replace(correction, pace=x * correction.pace)) for x in (np.inf, pace)
        )
        if 0.8 < pace < 1.25 or moving > resting - KNOWN_ADVANTAGE:
            return
        yield self._candidate(problem, pace, 0 if is_known else 1, len(self._KNOWN_PACES) if is_known else 1)

    def _candidate(
        self, problem: Problem, pace: float, numbers: int, alternatives: int, reason: str = ""
    ) -> Candidate:
        correction = problem.correction
        return Candidate(
            self.name,
            f"Time is in another unit{reason}: {number(1.0 / pace)} of its seconds are one",
            self._remedy(problem, pace, problem.samples.step * pace),
            replace(correction, pace=correction.pace * pace),
            numbers=numbers,
            alternatives=alternatives,
            evident=bool(reason),
        )

    def _of_velocities(self, problem: Problem) -> float | None:
        """Factor by which the velocity columns of all joints are too large; None without a common one."""
        factors = []
        for log in problem.samples.logs:
            recording = log.recording
            if recording is not None and recording.qd is not None:
                factors.append(velocity_factors(log.time, recording.q, recording.qd, log.gaps))
        known_factors = np.concatenate(factors) if factors else np.zeros(0)
        known_factors = known_factors[np.isfinite(known_factors) & (known_factors > 0.0)]
        if len(known_factors) < self._FEWEST_JOINTS:
            return None
        median = float(np.median(known_factors))
        return None if np.ptp(known_factors) > self._LARGEST_SPREAD * median else median

    def _remedy(self, problem: Problem, pace: float, step: float) -> str:
        recording = problem.samples.logs[0].recording
        columns = () if recording is None else recording.columns
        unit = next((use.unit for use in columns if use.role == "time"), "s")
        for name, size in TIME_UNITS.items():
            if np.isclose(size, TIME_UNITS.get(unit, 1.0) * pace, rtol=0.01):
                return f"--time-unit {name}"
        return f"--map time=none --rate {number(1.0 / step)}"
