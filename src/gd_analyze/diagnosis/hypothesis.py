"""What a hypothesis is given, and what it makes: corrections with their numbers, sentence and remedy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT, TorqueSums, corrected_columns, equations_of
from gd_analyze.diagnosis.fit import FileFit, fitted
from gd_analyze.diagnosis.remedies import Remedy
from gd_analyze.diagnosis.samples import FEWEST_SAMPLES, Samples
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.motions.correction import Correction
from gd_analyze.robots.arm import RobotArm

# Factor on torques beside which those of links vanish.
_WEIGHTLESS_FACTOR = 1e4
# Equations kept at a time.
_MOST_EQUATIONS_IN_MEMORY = 12
# Samples in a search for a number, and the fall of the score in it that is worth a closer look.
_SAMPLES_OF_SEARCH, _WORTHWHILE_FALL = 100, 3.0
# Cost of a fitted number, and of the logarithm of the number of alternatives.
COST_PER_NUMBER, _COST_PER_ALTERNATIVE = 3.9, 2.0
# A known value wins over a fitted one within this.
KNOWN_ADVANTAGE = 25.0
# Share of the torque that a cause leaves at most: half of it is explained.
MOST_REMAINDER = 0.5
# What remains with a cause, over what remains without: of 251 true causes two leave more, and a residual of a
# hundred independent samples is known to a twelfth.
CLEAR_REMAINDER_RATIO = 0.8


@dataclass(frozen=True, eq=False)
class Problem:
    """Samples of logs, and what is corrected already."""

    samples: Samples
    correction: Trial
    fewest_samples: int = FEWEST_SAMPLES  # of a joint that says anything, fitted and scored alike
    equations: OrderedDict[tuple[object, ...], TorqueSums] = field(default_factory=OrderedDict)

    @property
    def arm(self) -> RobotArm:
        """The arm as its file says."""
        return self.samples.arm

    @property
    def n(self) -> int:
        """Number of joints."""
        return self.arm.n_joints

    @property
    def unchanged(self) -> Correction:
        """A correction that changes nothing, to begin one with."""
        return Correction.none(self.n)

    @cached_property
    def null(self) -> FileFit:
        """The fit of the file's own error and friction alone."""
        return self.fit(self.correction)

    @cached_property
    def friction_score(self) -> float:
        """Score of an arm that weighs next to nothing: friction alone; infinite if most is unexplained."""
        light = self.correction.with_torque(_WEIGHTLESS_FACTOR * np.eye(self.n))
        explains = self.fit(light).remains <= MOST_REMAINDER
        return self.score(light) if explains else np.inf

    @cached_property
    def moving(self) -> list[int]:
        """Joints, from 0, that are compared."""
        if not self.samples.counts.any():
            return []
        return np.flatnonzero(np.isfinite(self.null.residuals)).tolist()

    @cached_property
    def rough(self) -> Problem:
        """The same with fewer samples, for a search."""
        step = self._step_of_search
        if step == 1:
            return self
        fewest = max(self.fewest_samples // step, 4)
        return Problem(self.samples.at(self._thinned), self.correction.at(self._thinned), fewest)

    @property
    def _step_of_search(self) -> int:
        return max(len(self.samples) // _SAMPLES_OF_SEARCH, 1)

    @property
    def _thinned(self) -> slice:
        return slice(self._step_of_search // 2, None, self._step_of_search)

    def fit(self, correction: Trial) -> FileFit:
        """Fit file and friction to corrected logs."""
        key = correction.key
        if key not in self.equations:
            self.equations[key] = equations_of(self.samples, correction)
            while len(self.equations) > _MOST_EQUATIONS_IN_MEMORY:
                self.equations.popitem(last=False)
        self.equations.move_to_end(key)
        return fitted(self.equations[key], correction.torque, self.fewest_samples, correction.freedom)

    def torques(self) -> tuple[FloatArray, FloatArray]:
        """Corrected torques and what the null hypothesis makes of them, (N, n) each; nan where none."""
        columns, counts, shared = corrected_columns(self.samples, self.correction)
        fit, end = self.null, shared + NUMBERS_OF_JOINT
        model = columns[:, :, :shared] @ fit.shared + columns[:, :, end]
        model += np.einsum("itc,ic->it", columns[:, :, shared:end], fit.joint_numbers)
        measured = self.correction.of_torques(self.correction.steady(self.samples.torque))
        return np.where(counts, measured, np.nan), np.where(counts, model.T, np.nan)

    def score(self, correction: Trial) -> float:
        """Score of a correction beside that of the null hypothesis at the same samples."""
        if not correction.mixes:
            return self.fit(correction).score - self.null.score
        *_, direction = correction.states(self.samples)
        rests = ~correction.counts(self.samples, direction)
        alone = self.fit(self.correction.without(rests))
        corrected = self.fit(correction.without(rests))
        return corrected.score - alone.score

    def rough_score(self, correction: Trial) -> float:
        """Score of a correction, judged by few samples."""
        return self.rough.score(correction.at(self._thinned))

    def roughly(self, corrections: Iterable[Trial]) -> FloatArray:
        """Scores of corrections, judged by few samples."""
        return np.array([self.rough_score(correction) for correction in corrections])

    def best(self, corrections: Iterable[Trial], most: int = 1) -> list[int]:
        """Places of the best corrections, judged by few samples."""
        return np.argsort(self.roughly(corrections))[:most].tolist()

    def mended(self, remedy: Remedy) -> Trial:
        """What is corrected already, and then what a remedy does to a log."""
        pace = self.correction.pace * remedy.pace
        # Lags are seconds as logged here, and right ones where they are typed.
        lag = self.correction.lag + remedy.change.lag / pace
        return replace(self.correction.then(remedy.read).then(remedy.change), lag=lag, pace=pace)

    def helps(self, score: float) -> bool:
        """Whether a score by few samples makes a closer look worth while."""
        return score < -_WORTHWHILE_FALL

    def along(self, correction: Callable[[float], Trial], low: float, high: float, steps: int = 14) -> float:
        """The number between two ends whose correction scores best, judged by few samples."""
        return least(lambda x: self.rough_score(correction(x)), low, high, steps)

    def refined(self, correction: Callable[[float], Trial], at: float, step: float) -> float:
        """Vertex of parabolas through three scores of all samples, the second of a fifth of the step."""
        for width in (step, step / 5.0):
            low, middle, high = (self.score(correction(at + k * width)) for k in (-1.0, 0.0, 1.0))
            bend = low - 2.0 * middle + high
            if bend > 0.0:
                at += float(np.clip(0.5 * (low - high) / bend, -2.0, 2.0)) * width
        return at


@dataclass(frozen=True, eq=False)
class Candidate:
    """One cause, with what a user does about it."""

    name: str  # of the kind of cause, for the table and JSON: "torque sign"
    what: str  # a sentence without its stop: "All torques are reversed"
    remedy: Remedy
    correction: Trial
    numbers: int = 0  # fitted
    alternatives: int = 1  # of the kind
    rare: float = 0.0  # cost of a cause that is seldom one
    evident: bool = False  # whether positions and velocities say so, without torques
    unsure: str = ""  # what cannot be told apart from it: "all masses are wrong by that factor"
    score: float = 0.0  # J beside that of the null hypothesis
    fall: float = 0.0  # of the score, costs included
    fit: FileFit | None = None


class Hypothesis(ABC):
    """A kind of cause: what it changes, its numbers, its sentence and its option."""

    name: str

    @abstractmethod
    def candidates(self, problem: Problem) -> Iterator[Candidate]:
        """The best causes of this kind; their fit and fall are added by `judged`."""

    def exact(self, problem: Problem, what: str, remedy: Remedy, **costs: Any) -> Candidate:
        """A cause whose remedy is typed without rounding: it does what is tried."""
        return Candidate(self.name, what, remedy, problem.mended(remedy), **costs)

    def best(
        self, problem: Problem, causes: Sequence[tuple[str, Remedy]], most: int = 1, **costs: Any
    ) -> Iterator[Candidate]:
        """The best of such causes, judged by few samples."""
        for k in problem.best([problem.mended(remedy) for _, remedy in causes], most):
            yield self.exact(problem, *causes[k], **costs)

    def judged(self, problem: Problem) -> list[Candidate]:
        """Candidates with fit and fall of the score."""
        out = []
        for candidate in self.candidates(problem):
            cost = COST_PER_NUMBER * candidate.numbers
            cost += _COST_PER_ALTERNATIVE * np.log(candidate.alternatives) + candidate.rare
            score = problem.score(candidate.correction)
            fit = problem.fit(candidate.correction)
            out.append(replace(candidate, fit=fit, score=score, fall=float(-score - cost)))
        return out


def least(
    score: Callable[[float], float], low: float, high: float, steps: int, tolerance: float = 1e-5
) -> float:
    """Place of the least score between two ends."""
    from scipy.optimize import minimize_scalar

    minimum = minimize_scalar(
        score, bounds=(low, high), method="bounded", options={"maxiter": steps, "xatol": tolerance}
    )
    return float(minimum.x)


def standard_errors(score: Callable[[FloatArray], float], at: FloatArray, step: float) -> FloatArray:
    """Standard errors, 1 at most, of numbers at which a score, minus twice that of a likelihood, is least."""
    steps = step * np.eye(len(at))
    curvature = np.zeros((len(at), len(at)))
    for i, j in combinations_with_replacement(range(len(at)), 2):
        corners = [(a * b, score(at + a * steps[i] + b * steps[j])) for a in (-1, 1) for b in (-1, 1)]
        curvature[i, j] = curvature[j, i] = sum(sign * value for sign, value in corners)
    sizes, ways = np.linalg.eigh(curvature / (2.0 * step) ** 2)
    # Half the second derivative is the inverse of the covariance.
    return np.asarray(np.sqrt(np.square(ways) @ (2.0 / np.maximum(sizes, 2.0))))


def signs(n: int, joints: Iterable[int]) -> FloatArray:
    """Matrix that reverses some of n joints, counted from 0."""
    out = np.ones(n)
    out[list(joints)] = -1.0
    return np.diag(out)


def swapped(n: int, i: int, j: int) -> FloatArray:
    """Matrix that exchanges two of n joints."""
    order = list(range(n))
    order[i], order[j] = j, i
    return np.eye(n)[order]
