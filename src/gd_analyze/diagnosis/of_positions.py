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
from gd_analyze.text import TIME_UNITS, number

# Cosine between parallel axes.
_PARALLEL = 0.999


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
    _STEP = np.pi / 5.0

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The two best joints, at a multiple of 90 degrees unless another angle is clearly better."""
        correction, settings = problem.correction, problem.settings
        joints = [i for i in problem.moving if problem.arm.is_revolute[i]]
        angles = self._STEP * np.arange(1, round(2.0 * np.pi / self._STEP))
        scores: dict[int, tuple[float, float]] = {}
        for i in joints:
            tried_scores = problem.roughly(correction.with_offset(i, float(a)) for a in angles)
            scores[i] = float(np.min(tried_scores)), float(angles[int(np.argmin(tried_scores))])
        for i in sorted(scores, key=lambda joint: scores[joint][0])[:2]:
            near = scores[i][1]
            if not problem.helps(scores[i][0]):
                continue

            def turned(angle: float, joint: int = i) -> Correction:
                return correction.with_offset(joint, angle)

            rough_angle = problem.along(turned, near - self._STEP, near + self._STEP, 9)
            angle = self._refined(problem, i, rough_angle)
            right = np.pi / 2.0 * np.round(angle / (np.pi / 2.0))
            right_angled = correction.with_offset(i, float(right))
            is_known = right % (2.0 * np.pi) > 0.1 and problem.score(right_angled) < (
                problem.score(correction.with_offset(i, angle)) + settings.known
            )
            angle = float(right) if is_known else angle
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

    def _refined(self, problem: Problem, joint: int, angle: float) -> float:
        """Vertex of a parabola through three scores."""
        step, correction = np.radians(1.5), problem.correction
        low, middle, high = (
            problem.score(correction.with_offset(joint, angle + k * step)) for k in (-1.0, 0.0, 1.0)
        )
        bend = low - 2.0 * middle + high
        return angle + float(np.clip(0.5 * (low - high) / bend, -2.0, 2.0)) * step if bend > 0.0 else angle


class JointOrder(Hypothesis):
    """Two joints are exchanged, or all are in reversed order, positions and torques alike."""

    name = "order of joints"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best exchange."""
        n, correction = problem.n, problem.correction
        orders = [
            (f"Joints {i + 1} and {j + 1} are exchanged", swapped(n, i, j))
            for i, j in combinations(problem.moving, 2)
            if problem.arm.is_revolute[i] == problem.arm.is_revolute[j]
        ]
        if len(problem.moving) == n and len(set(problem.arm.is_revolute)) == 1 and n > 2:
            orders.append(("The joints are in reversed order", np.eye(n)[::-1]))
        corrections = [correction.with_position(matrix).with_torque(matrix) for _, matrix in orders]
        for k in problem.best(corrections, 1) if corrections else []:
            sentence, matrix = orders[k]
            source = matrix.argmax(axis=1).tolist()
            yield Candidate(
                self.name, sentence, map_of_joints(problem, source), corrections[k], alternatives=len(orders)
            )


class Coupling(Hypothesis):
    """A joint is measured against the base, not against the link before it."""

    name = "coupled joints"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best pair of neighbours, torques by the transposed inverse."""
        correction, corrections = problem.correction, []
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
        correction, settings = problem.correction, problem.settings
        paces = [*self._KNOWN, 0.3, 0.6, 1.7, 3.5]
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
        is_known = pace in self._KNOWN and problem.score(corrections[k]) < (
            problem.score(replace(correction, pace=correction.pace * free)) + settings.known
        )
        pace = pace if is_known else free
        if 0.8 < pace < 1.25:
            return
        step = problem.samples.step * pace
        yield Candidate(
            self.name,
            f"Time is in another unit: {number(1.0 / pace)} of its seconds are one",
            self._remedy(problem, pace, step),
            replace(correction, pace=correction.pace * pace),
            numbers=0 if is_known else 1,
            alternatives=len(self._KNOWN) if is_known else 1,
        )

    def _remedy(self, problem: Problem, pace: float, step: float) -> str:
        recording = problem.samples.logs[0].recording
        columns = () if recording is None else recording.columns
        unit = next((use.unit for use in columns if use.role == "time"), "s")
        for name, size in TIME_UNITS.items():
            if np.isclose(size, TIME_UNITS.get(unit, 1.0) * pace, rtol=0.01):
                return f"--time-unit {name}"
        return f"--map time=none --rate {number(1.0 / step)}"
