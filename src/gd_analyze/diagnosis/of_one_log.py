"""Hypotheses on single logs: some differ from the others in load, friction, or scale of torques."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.hypothesis import Candidate, Hypothesis, Problem, least
from gd_analyze.diagnosis.of_the_arm import LEAST_MASS_SHARE, carried
from gd_analyze.diagnosis.of_torques import FACTORS, NOTICED_FACTOR, errors_of_logarithms
from gd_analyze.diagnosis.remedies import edited
from gd_analyze.diagnosis.trial import Added, Trial
from gd_analyze.text import enumerated, named_joints, number, with_error

# Change of Coulomb friction, and of viscous friction at the fastest motion: a share of the torque's RMS.
_FRICTION_SHARE = 0.2
# Fall of the score for which one more log differs.
_WORTHWHILE_FALL = 10.0
# Relative change of a joint's friction that is mentioned, if friction is more than a share of the torque, and
# the largest factor by which the temperature of drives changes friction.
_NOTICED_CHANGE, _NOTICED_FRICTION_SHARE, _LARGEST_FRICTION_FACTOR = 0.2, 0.03, 4.0
# Standard error of torque constants, of which no difference between logs tells: a UR10e's are a tenth off.
_SCALE_ERROR = 0.1
# What identification does with logs of an arm that carries something.
_LOADED = ", or identify with --loaded"
# Torques of a log over those of the others, to begin with: reversed, or as units and constants differ.
_FACTORS = (-1.0, *FACTORS, 0.4, 0.7, 1.4, 2.5)


class LoadOfLogs(Hypothesis):
    """In some logs the arm carries more than in the others, or less."""

    name = "load of a log"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The same body at the last link in the logs that differ most clearly."""
        load = carried(problem)

        def with_load(is_loaded: Array) -> Trial:
            return problem.correction.with_added(Added(load.columns * is_loaded[:, None], load.sizes))

        def mass_in(logs: list[int]) -> tuple[float, float]:
            fit = problem.fit(with_load(_of_logs(problem, logs)))
            mass, error = (float(x[-len(load.sizes)] * load.sizes[0]) for x in (fit.free, fit.errors))
            return mass, float(np.hypot(error, _SCALE_ERROR * mass))

        count, chosen = len(problem.samples.logs), _differing(problem, with_load)
        if not chosen:
            return
        mass, error = mass_in(chosen)
        if mass < 0.0 and 2 * len(chosen) == count:
            chosen = [k for k in range(count) if k not in chosen]
            mass, error = mass_in(chosen)
        if abs(mass) < LEAST_MASS_SHARE * problem.arm.mass.sum():
            return
        names = _names(problem, chosen)
        more, advice = ("more", _LOADED) if mass > 0.0 else ("less", "")
        yield Candidate(
            self.name,
            f"In {names} the arm carries {with_error(abs(mass), error)} kg {more} than in the others",
            edited(problem.samples, f"diagnose {names} apart from the others{advice}"),
            with_load(_of_logs(problem, chosen)),
            numbers=4,
            alternatives=count ** len(chosen),
        )


class FrictionOfLogs(Hypothesis):
    """Friction in some logs is not that of the others: drives are warmer, or colder."""

    name = "friction of a log"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """Friction of all joints in the logs that differ most clearly, and of one joint there."""
        if not np.isfinite(problem.correction.pace):
            return
        _, speed, _, direction = problem.correction.states(problem.samples)
        columns = np.stack([direction, speed], axis=-1)
        torque = problem.correction.of_torques(problem.correction.steady(problem.samples.torque))
        sizes = np.sqrt(np.square(torque).mean(axis=0)) + np.finfo(float).tiny

        def with_friction(is_other: Array, joints: Sequence[int]) -> Trial:
            added = _of_joints(columns * is_other[:, None, None], sizes, joints)
            return problem.correction.with_added(added)

        moving = problem.moving
        chosen = _differing(problem, lambda is_other: with_friction(is_other, moving))
        if not chosen:
            return
        is_other = _of_logs(problem, chosen)
        one = min(moving, key=lambda i: problem.score(with_friction(is_other, [i])))
        for joints in dict.fromkeys(((one,), tuple(moving))):
            correction = with_friction(is_other, joints)
            fit = problem.fit(correction)
            changes = (fit.free[-2 * len(joints) :] * correction.added[-1].sizes).reshape(-1, 2)
            ratios = {}
            for i, change in zip(joints, changes, strict=True):
                common, more = (columns[is_other, i] @ x for x in (fit.joint_numbers[i, 1:3], change))
                if np.square(common + more).mean() > (_NOTICED_FRICTION_SHARE * sizes[i]) ** 2:
                    ratios[i] = _slope(common + more, common)
            noticed = {i: ratio for i, ratio in ratios.items() if abs(ratio - 1.0) > _NOTICED_CHANGE}
            factors = [max(ratio, 1.0 / ratio) if ratio > 0.0 else np.inf for ratio in noticed.values()]
            if not noticed or max(factors) > _LARGEST_FRICTION_FACTOR:
                continue
            ends = dict.fromkeys(number(x, 2) for x in (min(noticed.values()), max(noticed.values())))
            whose = named_joints([i + 1 for i in noticed], problem.n)
            names = _names(problem, chosen)
            yield Candidate(
                self.name,
                f"In {names} friction of {whose} is {' to '.join(ends)} times that in the others",
                edited(problem.samples, f"diagnose {names} apart from the others"),
                correction,
                numbers=2 * len(joints),
                alternatives=len(problem.samples.logs) ** len(chosen),
            )


class ScaleOfLogs(Hypothesis):
    """Torques of some logs are reversed, or in another unit than those of the others."""

    name = "torque scale of a log"

    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best factor of the torques in the logs that differ most clearly."""
        correction = problem.correction
        if correction.gain is not None:
            return

        def with_gain(is_other: Array, factor: float) -> Trial:
            # The density of torques is that of a matrix: the mean of the gain's logarithm is 0.
            common = abs(factor) ** is_other.mean()
            gain = np.repeat(np.where(is_other, factor, 1.0)[:, None] / common, problem.n, axis=1)
            return replace(correction, gain=gain, torque=correction.torque / common)

        count = len(problem.samples.logs)
        if count < 2:
            return
        pairs = [(k, factor) for k in range(count) for factor in _FACTORS]
        scores = problem.roughly(with_gain(_of_logs(problem, [k]), factor) for k, factor in pairs)
        if not problem.helps(scores.min()):
            return
        begin = pairs[int(scores.argmin())][1]
        chosen = _differing(problem, lambda is_other: with_gain(is_other, begin))
        if not chosen:
            return
        is_other, sign = _of_logs(problem, chosen), np.sign(begin)

        def scaled(logarithm: float) -> Trial:
            return with_gain(is_other, sign * float(np.exp(logarithm)))

        middle = float(np.log(abs(begin)))
        logarithm = least(lambda x: problem.score(scaled(x)), middle - 0.5, middle + 0.5, 12, 1e-3)
        factor = float(np.exp(logarithm))
        is_near = 1.0 / NOTICED_FACTOR < factor < NOTICED_FACTOR
        is_reversed = is_near and sign < 0.0
        if is_near and not is_reversed:
            return
        error = factor * errors_of_logarithms(lambda x: problem.score(scaled(x[0])), np.array([logarithm]))[0]
        names = _names(problem, chosen)
        times = "reversed" if is_reversed else f"{with_error(sign * factor, error)} times those of the others"
        yield Candidate(
            self.name,
            f"In {names} all torques are {times}",
            edited(problem.samples, f"diagnose {names} apart from the others"),
            with_gain(is_other, -1.0) if is_reversed else scaled(logarithm),
            numbers=0 if is_reversed else 1,
            alternatives=2 * count ** len(chosen),
        )


# Kinds of what single logs differ in.
DIFFERENCES = (ScaleOfLogs.name, LoadOfLogs.name, FrictionOfLogs.name)


def _of_joints(columns: FloatArray, sizes: FloatArray, joints: Sequence[int]) -> Added:
    """Coulomb and viscous friction of some joints, of columns (N, n, 2), in shares of their torques."""
    fastest = np.abs(columns[:, :, 1]).max(axis=0)
    out = np.zeros((len(sizes), len(columns), 2 * len(joints)))
    for k, i in enumerate(joints):
        out[i, :, 2 * k : 2 * k + 2] = columns[:, i]
    plausible = [_FRICTION_SHARE * sizes[i] / np.array([1.0, fastest[i] or 1.0]) for i in joints]
    return Added(out, np.concatenate(plausible))


def _slope(torque: FloatArray, other: FloatArray) -> float:
    """Torque over another, by least squares."""
    squares = float(other @ other)
    return float(torque @ other) / squares if squares else np.inf


def _differing(problem: Problem, differs: Callable[[Array], Trial]) -> list[int]:
    """Logs, from 0, that differ most clearly alike, half of them at most; none if none does."""
    count = len(problem.samples.logs)
    chosen: list[int] = []
    best = 0.0
    while 2 * (len(chosen) + 1) <= count:
        others = [k for k in range(count) if k not in chosen]
        scores = [problem.score(differs(_of_logs(problem, [*chosen, k]))) for k in others]
        if min(scores) > best - _WORTHWHILE_FALL:
            break
        best = min(scores)
        chosen.append(others[int(np.argmin(scores))])
    return sorted(chosen)


def _of_logs(problem: Problem, chosen: list[int]) -> Array:
    """Samples of some logs, (N,)."""
    return np.isin(problem.samples.log, chosen)


def _names(problem: Problem, chosen: list[int]) -> str:
    """Some logs by name: "log a", "logs a and b"."""
    names = enumerated([problem.samples.logs[k].name for k in chosen])
    return f"logs {names}" if len(chosen) > 1 else f"log {names}"
