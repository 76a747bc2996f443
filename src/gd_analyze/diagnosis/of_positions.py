"""Hypotheses on positions: direction, zero, order and coupling of joints, unit of time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from gd_analyze.diagnosis.correction import Correction
from gd_analyze.diagnosis.hypothesis import Candidate, Hypothesis, Problem, inverse, signs, swapped
from gd_analyze.diagnosis.remedies import couple, degrees, map_of_joints
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number

# Cosine between parallel axes.
_PARALLEL = 0.999


class Direction(Hypothesis):
    """A joint counts the other way: its positions with its torques, or its positions alone."""

    name = "direction of a joint"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best joint of either kind."""
        n, own, moving = problem.n, problem.correction, problem.moving
        every = list(range(n))
        groups = [[i] for i in moving] + ([every] if len(moving) > 1 else [])
        both = [own.with_position(signs(n, group)).with_torque(signs(n, group)) for group in groups]
        alone = [own.with_position(signs(n, group)) for group in groups]
        for k in problem.best(both, 2):
            yield self._candidate(groups[k], both[k], problem, with_torque=True)
        for k in problem.best(alone, 1):
            yield self._candidate(groups[k], alone[k], problem, with_torque=False)

    def _candidate(
        self, joints: list[int], correction: Correction, problem: Problem, *, with_torque: bool
    ) -> Candidate:
        n = problem.n
        words = ",".join("-1" if i in joints else "1" for i in range(n)) if len(joints) < n else "-1"
        who = f"Joint {joints[0] + 1} counts" if len(joints) == 1 else "All joints count"
        what = f"{who} the other way, {'positions and torques' if with_torque else 'positions alone'}"
        # --position-sign turns the torques, too.
        remedy = f"--position-sign {words}" + ("" if with_torque else f" --torque-sign {words}")
        return Candidate(self.name, what, remedy, correction, alternatives=2 * (n + 1))


class Zero(Hypothesis):
    """The zero of a joint is not the file's."""

    name = "zero of a joint"
    # Coarser steps miss the valley of a joint that carries much.
    _STEP = np.pi / 5.0

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The two best joints, at a multiple of 90 degrees unless another angle is clearly better."""
        own, settings = problem.correction, problem.settings
        joints = [i for i in problem.moving if problem.arm.is_revolute[i]]
        angles = self._STEP * np.arange(1, round(2.0 * np.pi / self._STEP))
        scores: dict[int, tuple[float, float]] = {}
        for i in joints:
            tried = problem.roughly(own.with_offset(i, float(a)) for a in angles)
            scores[i] = float(np.min(tried)), float(angles[int(np.argmin(tried))])
        for i in sorted(scores, key=lambda joint: scores[joint][0])[:2]:
            near = scores[i][1]
            if not problem.helps(scores[i][0]):
                continue

            def turned(angle: float, joint: int = i) -> Correction:
                return own.with_offset(joint, angle)

            found = problem.along(turned, near - self._STEP, near + self._STEP, 9)
            angle = self._refined(problem, i, found)
            right = np.pi / 2.0 * np.round(angle / (np.pi / 2.0))
            known = own.with_offset(i, float(right))
            is_known = right % (2.0 * np.pi) > 0.1 and problem.score(known) < (
                problem.score(own.with_offset(i, angle)) + settings.known
            )
            angle = float(right) if is_known else angle
            said = degrees(angle)
            yield Candidate(
                self.name,
                f"The zero of joint {i + 1} is off by {said.removesuffix('deg')} degrees",
                f"--offset {i + 1}={said}",
                own.with_offset(i, angle),
                numbers=0 if is_known else 1,
                alternatives=(3 if is_known else 1) * problem.n,
                unsure="the last link's masses are turned as far" if i == problem.n - 1 else "",
            )

    def _refined(self, problem: Problem, joint: int, angle: float) -> float:
        """Vertex of a parabola through three scores."""
        step, own = np.radians(1.5), problem.correction
        low, middle, high = (
            problem.score(own.with_offset(joint, angle + k * step)) for k in (-1.0, 0.0, 1.0)
        )
        bend = low - 2.0 * middle + high
        return angle + float(np.clip(0.5 * (low - high) / bend, -2.0, 2.0)) * step if bend > 0.0 else angle


class JointOrder(Hypothesis):
    """Two joints are exchanged, or all are in reversed order, positions and torques alike."""

    name = "order of joints"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best exchange."""
        n, own = problem.n, problem.correction
        orders = [
            (f"Joints {i + 1} and {j + 1} are exchanged", swapped(n, i, j))
            for i, j in combinations(problem.moving, 2)
            if problem.arm.is_revolute[i] == problem.arm.is_revolute[j]
        ]
        if len(problem.moving) == n and len(set(problem.arm.is_revolute)) == 1 and n > 2:
            orders.append(("The joints are in reversed order", np.eye(n)[::-1]))
        made = [own.with_position(matrix).with_torque(matrix) for _, matrix in orders]
        for k in problem.best(made, 1) if made else []:
            what, matrix = orders[k]
            source = matrix.argmax(axis=1).tolist()
            yield Candidate(
                self.name, what, map_of_joints(problem, source), made[k], alternatives=len(orders)
            )


class Coupling(Hypothesis):
    """A joint is measured against the base, not against the link before it."""

    name = "coupled joints"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best pair of neighbours, torques by the transposed inverse."""
        own, found = problem.correction, []
        parallel = parallel_to_next(problem.arm)
        pairs = [
            (i, j, sign)
            for i in problem.moving
            for j in problem.moving
            if abs(i - j) == 1 and parallel[min(i, j)]
            for sign in (1.0, -1.0)
        ]
        for i, j, sign in pairs:
            matrix = np.eye(problem.n)
            matrix[i, j] = sign
            found.append(own.with_position(matrix).with_torque(inverse(matrix).T))
        for k in problem.best(found, 1) if found else []:
            i, j, sign = pairs[k]
            relation = "the sum" if sign < 0 else "the difference"
            yield Candidate(
                self.name,
                f"Joint {i + 1} is logged as {relation} of joints {i + 1} and {j + 1}",
                couple(i, j, sign),
                found[k],
                alternatives=len(pairs),
            )


def parallel_to_next(arm: RobotArm) -> list[bool]:
    """Whether a revolute joint's axis is parallel to the next one's, as linked arms' are."""
    axes = solve_kinematics(arm, np.zeros((arm.n_joints, 1))).joint_axes[:, :, 0]
    turns = arm.is_revolute
    return [
        turns[i] and turns[i + 1] and abs(float(axes[i] @ axes[i + 1])) > _PARALLEL
        for i in range(arm.n_joints - 1)
    ]


class TimeUnit(Hypothesis):
    """Time is in another unit, or runs at another pace."""

    name = "unit of time"
    _KNOWN = (1e3, 1e-3, 60.0, 10.0, 0.1)

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best known factor, or a free one."""
        own, settings = problem.correction, problem.settings
        paces = [*self._KNOWN, 0.3, 0.6, 1.7, 3.5]
        tried = [replace(own, pace=own.pace * pace) for pace in paces]
        scores = problem.roughly(tried)
        k = int(np.argmin(scores))
        if not problem.helps(scores[k]):
            return
        pace = paces[k]
        low, high = np.log(pace) - 0.7, np.log(pace) + 0.7
        free = float(
            np.exp(problem.along(lambda x: replace(own, pace=own.pace * float(np.exp(x))), low, high, 10))
        )
        is_known = pace in self._KNOWN and problem.score(tried[k]) < (
            problem.score(replace(own, pace=own.pace * free)) + settings.known
        )
        pace = pace if is_known else free
        if 0.8 < pace < 1.25:
            return
        step = problem.samples.step * pace
        yield Candidate(
            self.name,
            f"Time is in another unit: {number(1.0 / pace)} of its seconds are one",
            self._remedy(problem, pace, step),
            replace(own, pace=own.pace * pace),
            numbers=0 if is_known else 1,
            alternatives=len(self._KNOWN) if is_known else 1,
        )

    def _remedy(self, problem: Problem, pace: float, step: float) -> str:
        from gd_analyze.motions.reading import TIME_UNITS

        recording = problem.samples.logs[0].recording
        columns = () if recording is None else recording.columns
        unit = next((use.unit for use in columns if use.role == "time"), "s")
        for name, size in TIME_UNITS.items():
            if np.isclose(size, TIME_UNITS.get(unit, 1.0) * pace, rtol=0.01):
                return f"--time-unit {name}"
        return f"--map time=none --rate {number(1.0 / step)}"
