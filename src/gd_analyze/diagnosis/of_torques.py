"""Hypotheses on torques alone: sign, scale, columns, lag."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations, combinations_with_replacement

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.correction import Correction
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT
from gd_analyze.diagnosis.hypothesis import (
    CLEAR_REMAINDER_RATIO,
    COST_PER_NUMBER,
    KNOWN_ADVANTAGE,
    Candidate,
    Hypothesis,
    Problem,
    signs,
    swapped,
)
from gd_analyze.diagnosis.remedies import comma_separated, map_of_torques, scaled_positions, seconds
from gd_analyze.text import named_joints, number, percent, to_digits_of, with_error

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
# Step of a factor's logarithm over which a score's curvature is taken, and its largest standard error told.
_CURVED_OVER, _LARGEST_ERROR = 0.1, 1.0
# Currents and torques before the gears are, all together, less near to those of the joints than this: nearer
# factors are another arm's.
_CURRENTS_FACTOR = 4.0
# Factor between a unit and the number that fits best within which it may be that unit.
_NEAR_FACTOR = 1.5
# Least deviation from 1 of a factor that is more than constants are known to.
_NOTICED_FACTOR = 1.25
# Standard deviation of the logarithms of joints' torque constants about their common mean.
_CONSTANTS_DEVIATION = 0.5


class TorqueSign(Hypothesis):
    """Torques of some joints are reversed: all, or one after the other as long as the score falls."""

    name = "torque sign"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """All; and the best set of some, if there is one."""
        n, correction = problem.n, problem.correction
        joints = list(range(n))
        yield Candidate(
            self.name,
            "All torques are reversed",
            "--torque-sign -1",
            correction.with_torque(signs(n, joints)),
        )
        chosen: list[int] = []
        best = 0.0
        while len(chosen) < len(problem.moving):
            remaining = [i for i in problem.moving if i not in chosen]
            scores = [problem.score(correction.with_torque(signs(n, [*chosen, i]))) for i in remaining]
            if min(scores) > best - 10.0 and chosen:
                break
            best = min(scores)
            chosen.append(remaining[int(np.argmin(scores))])
        if not chosen or len(chosen) == len(problem.moving):
            return
        words = ",".join("-1" if i in chosen else "1" for i in range(n))
        text = named_joints([i + 1 for i in sorted(chosen)], n)
        subject = f"The torques of {text} are" if len(chosen) > 1 else f"The torque of {text} is"
        yield Candidate(
            self.name,
            f"{subject} reversed",
            f"--torque-sign {words}",
            correction.with_torque(signs(n, chosen)),
            alternatives=n ** len(chosen),
        )


class TorqueScale(Hypothesis):
    """All torques are in another unit, or times a factor."""

    name = "torque scale"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best known factor, or a free one where it is clearly better; or the unit that explains most."""
        n, correction = problem.n, problem.correction

        def scaled(factor: float) -> Correction:
            return correction.with_torque(factor * np.eye(n))

        def score(logarithm: float) -> float:
            return problem.score(scaled(float(np.exp(logarithm))))

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
        remains = {factor: problem.fit(scaled(factor)).remains for factor in (*FACTORS, free)}
        explains = min(FACTORS, key=lambda factor: remains[factor])
        if remains[explains] < CLEAR_REMAINDER_RATIO * remains[unit if is_known else free]:
            units.append(explains)
        for factor in units:
            name = FACTORS[factor]
            sentence = f"All torques are in another unit ({name}): multiplied by {number(factor)} they fit"
            yield self._candidate(sentence, factor, scaled(factor), alternatives=len(FACTORS))
        if not is_known and not 1.0 / _NOTICED_FACTOR < free < _NOTICED_FACTOR:
            size = "small" if free > 1 else "large"
            error = free * _errors(lambda x: score(float(x[0])), np.log([free]))[0]
            sentence = f"All torques are too {size}: multiplied by {with_error(free, error)} they fit"
            constant, more = to_digits_of(free, error), ", as where it is of another size"
            yield self._candidate(sentence, free, scaled(free), constant=constant, numbers=1, more=more)

    def _candidate(
        self,
        sentence: str,
        factor: float,
        correction: Correction,
        constant: str = "",
        numbers: int = 0,
        alternatives: int = 1,
        more: str = "",
    ) -> Candidate:
        return Candidate(
            self.name,
            sentence,
            f"--torque-constant {','.join([constant or comma_separated([factor])] * len(correction.torque))}",
            correction,
            numbers=numbers,
            alternatives=alternatives,
            unsure=f"all masses of the file are {number(1.0 / factor)} times the robot's{more}",
        )


class JointScale(Hypothesis):
    """The torque of a joint, or of every joint, is times a factor: currents, or torques before the gear."""

    name = "torque scale by joint"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """A factor of the joint for which it helps most; and factors of all."""
        ratios = np.array([_ratio_of(problem, i) for i in range(problem.n)])
        yield from self._of_one_joint(problem, ratios)
        yield from self._of_all_joints(problem, ratios)

    def _of_one_joint(self, problem: Problem, ratios: FloatArray) -> Iterator[Candidate]:
        n = problem.n

        def factors_of(joint: int, factor: float) -> FloatArray:
            factors = np.ones(n)
            factors[joint] = factor
            return factors

        best: dict[int, tuple[float, float]] = {}
        for i in problem.moving:

            def score(logarithm: float, i: int = i) -> float:
                return _score_of(problem, factors_of(i, float(np.exp(logarithm))))

            logarithm = _least(score, float(np.log(ratios[i])))
            best[i] = score(logarithm), float(np.exp(logarithm))
        joint = min(best, key=lambda i: best[i][0])
        factor = best[joint][1]
        if 1.0 / _NOTICED_FACTOR < factor < _NOTICED_FACTOR:
            return
        factors = factors_of(joint, factor)
        error = (
            factor
            * _errors(lambda x: _score_of(problem, factors_of(joint, float(np.exp(x[0])))), np.log([factor]))[
                0
            ]
        )
        constants = ["1"] * n
        constants[joint] = to_digits_of(factor, error)
        yield Candidate(
            self.name,
            f"The torque of joint {joint + 1} is too {'small' if factor > 1 else 'large'}: "
            f"multiplied by {with_error(factor, error)} it fits",
            f"--torque-constant {','.join(constants)}",
            problem.correction.with_torque(np.diag(factors)),
            numbers=1,
            alternatives=n,
            unsure="the masses that this joint carries, if it is the first that is loaded",
        )

    def _of_all_joints(self, problem: Problem, ratios: FloatArray) -> Iterator[Candidate]:
        """Factors of all joints, found one after the other, twice."""
        moving = problem.moving

        def deviation(factors: FloatArray) -> float:
            # Joints of which a log tells little have a factor like the others'.
            logarithms = np.log(factors[moving])
            deviations = (logarithms - np.median(logarithms)) / _CONSTANTS_DEVIATION
            return float(np.square(deviations).sum())

        logarithms = np.zeros(problem.n)
        common = float(np.log(_ratio_of(problem)))
        logarithms[moving] = np.clip(np.log(ratios[moving]), common - 1.0, common + 1.0)
        for _ in range(2):
            for i in moving:

                def score(logarithm: float, i: int = i) -> float:
                    changed = logarithms.copy()
                    changed[i] = logarithm
                    return _score_of(problem, np.exp(changed)) + deviation(np.exp(changed))

                logarithms[i] = _least(score, float(logarithms[i]), width=0.7)
        if np.ptp(logarithms[moving]) <= np.log(_NOTICED_FACTOR) or len(moving) < 2:
            return
        factors = np.exp(logarithms)
        if 1.0 / _CURRENTS_FACTOR < np.median(factors[moving]) < _CURRENTS_FACTOR:
            return
        errors = np.zeros(problem.n)

        def score_of_moving(changed: FloatArray) -> float:
            all_factors = factors.copy()
            all_factors[moving] = np.exp(changed)
            return _score_of(problem, all_factors) + deviation(all_factors)

        errors[moving] = factors[moving] * _errors(score_of_moving, logarithms[moving])
        pairs = list(zip(factors.tolist(), errors.tolist(), strict=True))
        told = ", ".join(with_error(*pair) for pair in pairs)
        yield Candidate(
            self.name,
            f"Torques are currents, or before the gears: times {told} they fit",
            f"--torque-constant {','.join(to_digits_of(*pair) for pair in pairs)}",
            problem.correction.with_torque(np.diag(factors)),
            numbers=len(moving),
            unsure="all masses are wrong by a common factor beside",
        )


def _errors(score: Callable[[FloatArray], float], logarithms: FloatArray) -> FloatArray:
    """Standard errors of logarithms where a score, minus twice that of a likelihood, is least."""
    steps = _CURVED_OVER * np.eye(len(logarithms))
    curvature = np.zeros((len(steps), len(steps)))
    for i, j in combinations_with_replacement(range(len(steps)), 2):
        corners = [(a * b, score(logarithms + a * steps[i] + b * steps[j])) for a in (-1, 1) for b in (-1, 1)]
        curvature[i, j] = curvature[j, i] = sum(sign * value for sign, value in corners)
    sizes, ways = np.linalg.eigh(curvature / (2.0 * _CURVED_OVER) ** 2)
    # Half the second derivative is the inverse of the covariance.
    variances = 2.0 / np.maximum(sizes, 2.0 / _LARGEST_ERROR**2)
    return np.asarray(np.sqrt(np.square(ways) @ variances))


def _score_of(problem: Problem, factors: FloatArray) -> float:
    """Score of torques times a factor by joint."""
    return problem.score(problem.correction.with_torque(np.diag(factors)))


def _ratio_of(problem: Problem, joint: int | None = None) -> float:
    """File's torque over the measured one, friction in neither, as RMS: of a joint or of all."""
    equations = problem.equations[problem.correction.key] if problem.null else None
    assert equations is not None
    shared, total = equations.shared, equations.total
    file = shared + NUMBERS_OF_JOINT
    joint_columns = list(range(shared, file))
    squares = np.zeros(2)
    for i in problem.moving if joint is None else [joint]:
        torque = np.zeros(total.shape[1])
        torque[file + 1 :] = problem.correction.torque[i]
        if not problem.null.residuals[i] >= 0.0:
            return 1.0
        sums = np.zeros((len(joint_columns) + 2, len(joint_columns) + 2))
        basis = np.zeros((total.shape[1], len(joint_columns) + 2))
        basis[joint_columns, range(len(joint_columns))] = 1.0
        basis[file, -2], basis[:, -1] = 1.0, torque
        sums = basis.T @ total[i] @ basis
        scale = np.sqrt(np.maximum(np.diag(sums), 1e-300))
        sums = sums / np.outer(scale, scale)
        inner = sums[:-2, :-2] + 1e-9 * np.eye(len(joint_columns))
        frictionless = sums[-2:, -2:] - sums[-2:, :-2] @ np.linalg.solve(inner, sums[:-2, -2:])
        squares += np.maximum(np.diag(frictionless), 1e-12) * scale[-2:] ** 2
    ratio = float(np.sqrt(squares[0] / squares[1])) if squares.all() else 1.0
    return float(np.clip(ratio, 1e-7, 1e7))


def _least(score: Callable[[float], float], begin: float, width: float = 1.2) -> float:
    """Place of the least score near `begin`, of a logarithm."""
    from scipy.optimize import minimize_scalar

    minimum = minimize_scalar(
        score, bounds=(begin - width, begin + width), method="bounded", options={"xatol": 0.02, "maxiter": 10}
    )
    return float(minimum.x)


class MotorSide(Hypothesis):
    """Torques, positions or both are the motors': the file's own gear ratios make them those of joints."""

    name = "motor side"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """All three; none if the file states no gears."""
        correction = problem.correction
        ratios = np.array([drive.gear_ratio for drive in problem.arm.drives])
        if not (ratios != 1.0).any():
            return
        alone = np.ones(problem.n)
        for subject, position, torque in (
            ("Torques are", alone, ratios),
            ("Positions are", 1.0 / ratios, alone),
            ("Positions and torques are", 1.0 / ratios, ratios),
        ):
            corrected = correction.with_position(np.diag(position)).with_torque(np.diag(torque))
            remedy = scaled_positions(position, torque)
            sentence = f"{subject} the motors': the file's own gear ratios fit"
            yield Candidate(self.name, sentence, remedy, corrected, alternatives=3)


class TorqueColumns(Hypothesis):
    """Torque columns are in another order than the positions'."""

    name = "order of torques"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best pair that is swapped, the reversed order, and a shift by one."""
        n, correction = problem.n, problem.correction
        pairs = list(combinations(problem.moving, 2))
        orders = [
            (f"The torques of joints {i + 1} and {j + 1} are exchanged", swapped(n, i, j)) for i, j in pairs
        ]
        whole = []
        if len(problem.moving) == n and n > 2:
            whole = [
                ("The torques are in reversed order", np.eye(n)[::-1]),
                ("The torques are one column late", np.roll(np.eye(n), -1, axis=0)),
                ("The torques are one column early", np.roll(np.eye(n), 1, axis=0)),
            ]
        for group in (orders, whole):
            if not group:
                continue
            scores = [problem.score(correction.with_torque(matrix)) for _, matrix in group]
            sentence, matrix = group[int(np.argmin(scores))]
            source = matrix.argmax(axis=1).tolist()
            yield Candidate(
                self.name,
                sentence,
                map_of_torques(problem, source),
                correction.with_torque(matrix),
                alternatives=len(group),
            )


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
        if abs(lag) < 0.5 * step:
            return
        yield Candidate(
            self.name,
            f"Torques are {seconds(abs(lag) * correction.pace)} {'late' if lag > 0 else 'early'}",
            f"--lag {seconds(lag * correction.pace).replace(' ', '')}",
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

        def drifting(logarithm: float, chosen: Array) -> Correction:
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

            def drifts(logarithm: float, chosen: Array = group[k]) -> Correction:
                return drifting(logarithm, chosen)

            low, high = float(self._GRID[place - 1]), float(self._GRID[place + 1])
            logarithm = problem.refined(drifts, problem.along(drifts, low, high, 9), self._STEP)
            change = float(np.expm1(logarithm))
            whose = "all torques" if group[k].all() else f"joint {int(group[k].argmax()) + 1}'s torque"
            way = "grows" if change > 0.0 else "falls"
            yield Candidate(
                self.name,
                f"The gain of {whose} {way} by {percent(abs(change))} over the log",
                "record when the drives are warm, or calibrate the torques",
                drifts(logarithm),
                numbers=1,
                alternatives=problem.n + 1,
            )
