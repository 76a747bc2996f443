"""Hypotheses on torques alone: sign, scale, columns, lag."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT
from gd_analyze.diagnosis.hypothesis import (
    CLEAR_REMAINDER_RATIO,
    COST_PER_NUMBER,
    KNOWN_ADVANTAGE,
    Candidate,
    Hypothesis,
    Problem,
    least,
    signs,
    standard_errors,
    swapped,
)
from gd_analyze.diagnosis.remedies import (
    Remedy,
    corrected,
    edited,
    in_digits,
    multiplied,
    reordered,
    with_constants,
)
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.motions.corrections import LONGEST_LAG_SECONDS
from gd_analyze.text import named_joints, number, percent, to_digits_of, with_error
from gd_analyze.units import TIME_UNITS

# Factors that units and gears make of torques, and what they are.
FACTORS = {
    1e-3: "N mm",
    1e-2: "N cm",
    1.0 / 9.80665: "N m for kgf m",
    9.80665: "kgf m",
    0.1129848: "lbf in",
    1.3558179: "lbf ft",
    2.0 * np.pi: "cycles for radians",
    0.5 / np.pi: "radians for cycles",
    1e3: "kN m",
    1e-6: "microN m",
}
# Step of a factor's logarithm over which a score's curvature is taken.
_CURVED_OVER = 0.1
# Currents and torques before the gears are, all together, less near to those of the joints than this: nearer
# factors are another arm's.
_CURRENTS_FACTOR = 4.0
# Factor between a unit and the number that fits best within which it may be that unit.
_NEAR_FACTOR = 1.5
# Least deviation from 1 of a factor that is more than constants are known to.
NOTICED_FACTOR = 1.25
# Standard deviation of the logarithms of joints' torque constants about their common mean.
_CONSTANTS_DEVIATION = 0.5


class TorqueSign(Hypothesis):
    """Torques of some joints are reversed: all, or one after the other as long as the score falls."""

    name = "torque sign"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """All; and the best set of some, if there is one."""
        n = problem.n

        def reversed_(joints: Sequence[int]) -> Remedy:
            return corrected(problem.samples, problem.unchanged.with_torque(signs(n, joints)))

        yield self.exact(problem, "All torques are reversed", reversed_(range(n)))
        chosen: list[int] = []
        best = 0.0
        while len(chosen) < len(problem.moving):
            remaining = [i for i in problem.moving if i not in chosen]
            scores = [problem.score(problem.mended(reversed_([*chosen, i]))) for i in remaining]
            if min(scores) > best - 10.0 and chosen:
                break
            best = min(scores)
            chosen.append(remaining[int(np.argmin(scores))])
        if chosen and len(chosen) < len(problem.moving):
            text = named_joints([i + 1 for i in sorted(chosen)], n)
            what = f"The torques of {text} are" if len(chosen) > 1 else f"The torque of {text} is"
            yield self.exact(problem, f"{what} reversed", reversed_(chosen), alternatives=n ** len(chosen))


class TorqueScale(Hypothesis):
    """All torques are in another unit, or times a factor."""

    name = "torque scale"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best known factor, or a free one where it is clearly better; or the unit that explains most."""
        all_joints = np.ones(problem.n)

        def score(logarithm: float) -> float:
            return problem.score(_scaled(problem, np.exp(logarithm) * all_joints))

        scores = {factor: score(np.log(factor)) for factor in FACTORS}
        best = min(scores, key=lambda factor: scores[factor])
        ends = [_least(score, np.log(begin)) for begin in (_ratio_of(problem), best)]
        free = float(np.exp(min(ends, key=score)))
        # Masses that a file is off by move the factor by no more than this.
        near = [factor for factor in FACTORS if 1.0 / _NEAR_FACTOR < factor / free < _NEAR_FACTOR]
        unit = min(near, key=lambda factor: scores[factor], default=free)
        is_known = bool(near) and scores[unit] < score(np.log(free)) + KNOWN_ADVANTAGE - COST_PER_NUMBER
        units = [unit] if is_known else []
        # Under another fault the best of scores may be absurd.
        remains = {
            factor: problem.fit(_scaled(problem, factor * all_joints)).remains for factor in (*FACTORS, free)
        }
        explains = min(FACTORS, key=lambda factor: remains[factor])
        if remains[explains] < CLEAR_REMAINDER_RATIO * remains[unit if is_known else free]:
            units.append(explains)
        told = [(factor, f"in another unit ({FACTORS[factor]})", number(factor), "") for factor in units]
        typed = [in_digits(factor, 4) for factor in units]
        if not is_known and not 1.0 / NOTICED_FACTOR < free < NOTICED_FACTOR:
            error = free * errors_of_logarithms(lambda x: score(x[0]), np.log([free]))[0]
            size, more = "too small" if free > 1 else "too large", ", as where it is of another size"
            told.append((free, size, with_error(free, error), more))
            typed.append(float(to_digits_of(free, error)))
        for (factor, what, times, more), constant in zip(told, typed, strict=True):
            yield Candidate(
                self.name,
                f"All torques are {what}: multiplied by {times} they fit",
                with_constants(problem.samples, constant * all_joints),
                _scaled(problem, factor * all_joints),
                numbers=1 if more else 0,
                alternatives=1 if more else len(FACTORS),
                unsure=f"all masses of the file are {number(factor)} times the robot's{more}",
            )


class JointScale(Hypothesis):
    """The torque of a joint, or of every joint, is times a factor: currents, or torques before the gear."""

    name = "torque scale by joint"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """A factor of the joint for which it helps most; and factors of all."""
        ratios = np.array([_ratio_of(problem, i) for i in range(problem.n)])
        yield from self._of_one_joint(problem, ratios)
        if len(problem.moving) > 1:
            yield from self._of_all_joints(problem, ratios)

    def _of_one_joint(self, problem: Problem, ratios: FloatArray) -> Iterator[Candidate]:
        def factors_of(joint: int, factor: float) -> FloatArray:
            return np.where(np.arange(problem.n) == joint, factor, 1.0)

        def score(logarithm: float, joint: int) -> float:
            return problem.score(_scaled(problem, factors_of(joint, np.exp(logarithm))))

        ends = {i: _least(partial(score, joint=i), float(np.log(ratios[i]))) for i in problem.moving}
        joint = min(ends, key=lambda i: score(ends[i], i))
        factor = float(np.exp(ends[joint]))
        if 1.0 / NOTICED_FACTOR < factor < NOTICED_FACTOR:
            return
        error = factor * errors_of_logarithms(lambda x: score(x[0], joint), np.log([factor]))[0]
        yield Candidate(
            self.name,
            f"The torque of joint {joint + 1} is too {'small' if factor > 1 else 'large'}: "
            f"multiplied by {with_error(factor, error)} it fits",
            with_constants(problem.samples, factors_of(joint, float(to_digits_of(factor, error)))),
            _scaled(problem, factors_of(joint, factor)),
            numbers=1,
            alternatives=problem.n,
            unsure="the masses that this joint carries, if it is the first that is loaded",
        )

    def _of_all_joints(self, problem: Problem, ratios: FloatArray) -> Iterator[Candidate]:
        """Factors of all joints, found one after the other, twice."""
        moving = problem.moving
        common = float(np.log(_ratio_of(problem)))
        logarithms = np.clip(np.log(ratios[moving]), common - 1.0, common + 1.0)

        def factors_of(values: FloatArray) -> FloatArray:
            factors = np.ones(problem.n)
            factors[moving] = np.exp(values)
            return factors

        def score(values: FloatArray) -> float:
            # Joints of which a log tells little have a factor like the others'.
            deviations = (values - np.median(values)) / _CONSTANTS_DEVIATION
            return problem.score(_scaled(problem, factors_of(values))) + float(np.square(deviations).sum())

        def score_of(logarithm: float, place: int) -> float:
            return score(np.where(np.arange(len(moving)) == place, logarithm, logarithms))

        for k in [*range(len(moving))] * 2:
            logarithms[k] = _least(partial(score_of, place=k), float(logarithms[k]), width=0.7)
        factors = factors_of(logarithms)
        is_currents = not 1.0 / _CURRENTS_FACTOR < np.median(factors[moving]) < _CURRENTS_FACTOR
        if np.ptp(logarithms) <= np.log(NOTICED_FACTOR) or not is_currents:
            return
        errors = np.zeros(problem.n)
        errors[moving] = factors[moving] * errors_of_logarithms(score, logarithms)
        pairs = list(zip(factors.tolist(), errors.tolist(), strict=True))
        told = ", ".join(with_error(*pair) for pair in pairs)
        yield Candidate(
            self.name,
            f"Torques are currents, or before the gears: times {told} they fit",
            with_constants(problem.samples, np.array([float(to_digits_of(*pair)) for pair in pairs])),
            _scaled(problem, factors),
            numbers=len(moving),
            unsure="all masses are wrong by a common factor beside",
        )


def _scaled(problem: Problem, factors: FloatArray) -> Trial:
    """Torques times a factor by joint."""
    return problem.correction.with_torque(np.diag(factors))


def _least(score: Callable[[float], float], begin: float, width: float = 1.2) -> float:
    """Place of the least score near `begin`, of a logarithm."""
    return least(score, begin - width, begin + width, 10, 0.02)


def errors_of_logarithms(score: Callable[[FloatArray], float], logarithms: FloatArray) -> FloatArray:
    """Standard errors of logarithms of factors, of which a score is least here."""
    return standard_errors(score, logarithms, _CURVED_OVER)


def _ratio_of(problem: Problem, joint: int | None = None) -> float:
    """File's torque over the measured one, friction in neither, as RMS: of a joint or of all."""
    equations = problem.equations[problem.correction.key] if problem.null else None
    assert equations is not None
    total, file = equations.total, equations.shared + NUMBERS_OF_JOINT
    squares = np.zeros(2)
    for i in problem.moving if joint is None else [joint]:
        if not problem.null.residuals[i] >= 0.0:
            return 1.0
        basis = np.zeros((total.shape[1], NUMBERS_OF_JOINT + 2))
        basis[range(equations.shared, file + 1), range(NUMBERS_OF_JOINT + 1)] = 1.0
        basis[file + 1 :, -1] = problem.correction.torque[i]
        sums = basis.T @ total[i] @ basis
        scale = np.sqrt(np.maximum(np.diag(sums), 1e-300))
        sums = sums / np.outer(scale, scale)
        inner = sums[:-2, :-2] + 1e-9 * np.eye(NUMBERS_OF_JOINT)
        frictionless = sums[-2:, -2:] - sums[-2:, :-2] @ np.linalg.solve(inner, sums[:-2, -2:])
        squares += np.maximum(np.diag(frictionless), 1e-12) * scale[-2:] ** 2
    ratio = float(np.sqrt(squares[0] / squares[1])) if squares.all() else 1.0
    return float(np.clip(ratio, 1e-7, 1e7))


class MotorSide(Hypothesis):
    """Torques, positions or both are the motors': the file's own gear ratios make them those of joints."""

    name = "motor side"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """All three; none if the file states no gears."""
        ratios = np.array([drive.gear_ratio for drive in problem.arm.drives])
        if not (ratios != 1.0).any():
            return
        alone = np.ones(problem.n)
        for subject, position, torque in (
            ("Torques are", alone, ratios),
            ("Positions are", 1.0 / ratios, alone),
            ("Positions and torques are", 1.0 / ratios, ratios),
        ):
            yield Candidate(
                self.name,
                f"{subject} the motors': the file's own gear ratios fit",
                multiplied(problem.samples, position, torque),
                problem.correction.with_position(np.diag(position)).with_torque(np.diag(torque)),
                alternatives=3,
            )


class TorqueColumns(Hypothesis):
    """Torque columns are in another order than the positions'."""

    name = "order of torques"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best pair that is swapped, the reversed order, and a shift by one."""
        n = problem.n
        orders = [
            (f"The torques of joints {i + 1} and {j + 1} are exchanged", swapped(n, i, j))
            for i, j in combinations(problem.moving, 2)
        ]
        whole = []
        if len(problem.moving) == n and n > 2:
            whole = [
                ("The torques are in reversed order", np.eye(n)[::-1]),
                ("The torques are one column late", np.roll(np.eye(n), -1, axis=0)),
                ("The torques are one column early", np.roll(np.eye(n), 1, axis=0)),
            ]
        for group in (orders, whole):
            remedies = [reordered(problem.samples, np.eye(n), order) for _, order in group]
            scores = [problem.score(problem.mended(remedy)) for remedy in remedies]
            for k in np.argsort(scores, kind="stable")[:1].tolist():
                yield self.exact(problem, group[k][0], remedies[k], alternatives=len(group))


class Lag(Hypothesis):
    """Torques are late, or early, as against positions."""

    name = "lag of torque"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best lag, unless it is below half a sample."""
        correction, step = problem.correction, problem.samples.step
        if correction.lag or not np.isfinite(correction.pace):
            return
        sizes = np.array([max(0.015, step), max(0.05, 3.0 * step), max(0.15, 8.0 * step)])
        lags = np.concatenate([-sizes[::-1], [0.0], sizes])
        scores = problem.roughly(replace(correction, lag=float(lag)) for lag in lags)
        place = int(np.argmin(scores))
        if not problem.helps(scores[place] - scores[len(sizes)]):
            return
        low, high = lags[max(place - 1, 0)], lags[min(place + 1, len(lags) - 1)]
        lag = problem.along(lambda x: replace(correction, lag=x), float(low), float(high), 10)
        told = lag * correction.pace
        if abs(lag) < 0.5 * step or abs(told) > LONGEST_LAG_SECONDS:
            return
        size = f"{1e3 * abs(told):.3g} ms" if abs(told) < 1.0 else f"{abs(told):.3g} s"
        typed = in_digits(told, 3, TIME_UNITS["ms"])
        yield Candidate(
            self.name,
            f"Torques are {size} {'late' if lag > 0 else 'early'}",
            corrected(problem.samples, replace(problem.unchanged, lag=typed)),
            replace(correction, lag=lag),
            numbers=1,
        )


class Drift(Hypothesis):
    """The gain of all torques, or of one joint's, changes steadily over a log: drives warm up."""

    name = "drift of torques"
    # Logarithms of the gain at the end over that at the beginning, to begin with, and a step near the best.
    _GRID = np.array([-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0])
    _STEP = 0.05

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best change, from the first sample to the last: of all joints, and of one."""
        samples, correction = problem.samples, problem.correction
        if len(samples.logs) > 1 or correction.gain is not None:
            return
        elapsed = (samples.time - samples.time[0]) / max(float(np.ptp(samples.time)), samples.step)

        def drifting(logarithm: float, chosen: Array) -> Trial:
            gain = 1.0 + np.expm1(logarithm) * elapsed
            # The scale of torques is another cause's: the gain's logarithm has a mean of 0.
            gain /= np.exp(np.log(gain).mean())
            return replace(correction, gain=np.where(chosen, gain[:, None], 1.0))

        joints = np.eye(problem.n, dtype=bool)[problem.moving]
        for group in (np.ones((1, problem.n), dtype=bool), joints):
            pairs = [(k, place) for k in range(len(group)) for place in range(1, len(self._GRID) - 1)]
            scores = problem.roughly(drifting(float(self._GRID[place]), group[k]) for k, place in pairs)
            k, place = pairs[int(scores.argmin())]
            if not problem.helps(scores.min()):
                continue

            def drifts(logarithm: float, chosen: Array = group[k]) -> Trial:
                return drifting(logarithm, chosen)

            low, high = float(self._GRID[place - 1]), float(self._GRID[place + 1])
            logarithm = problem.refined(drifts, problem.along(drifts, low, high, 9), self._STEP)
            change = float(np.expm1(logarithm))
            whose = "all torques" if group[k].all() else f"joint {int(group[k].argmax()) + 1}'s torque"
            way = "grows" if change > 0.0 else "falls"
            yield Candidate(
                self.name,
                f"The gain of {whose} {way} by {percent(abs(change))} over the log",
                edited(samples, "record when the drives are warm, or calibrate the torques"),
                drifts(logarithm),
                numbers=1,
                alternatives=problem.n + 1,
            )
