"""Fit of a program's numbers to the exact torque, and replacements of its steps.

Torque is nearly linear in all numbers: a few weighted least squares minimize a high power of the errors. If u
times c replaces v, the error changes by slope_v (c u - v) to first order: for every pair of steps the best c
and the squares follow from two matrix products. The operations saved are those used only by v and not needed
by u. The most promising replacements are then evaluated together with a fit of all numbers.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.tape import Tape
from gd_analyze.simplification.recursion import NUMBER

# Powers on the way to a high one, and steps with each; with power p a step is 1 / (p - 1) of the usual.
_POWERS, _STEPS = (4.0, 8.0, 14.0), 2
# Errors above this share of the largest enter a fit; those below this share of the budget weigh equally.
_COUNTING, _SMALL = 0.25, 0.3
# Damping of steps, as a share of each number's square: numbers may change much while the torque hardly does.
# Damping is stronger if few errors enter: steps that reduce these would let others grow.
_HELD_BACK, _HELD_BACK_MORE = 1e-3, 0.1
# Shares of a step to try; the first that reduces the norm is taken.
_STRIDES = (1.0, 0.4, 0.15)
# Resolution of numbers, and decimals of error growth: rounding, which differs between processors, must not
# distinguish what is mathematically equal.
_SNAP, _DIGITS, _DIGITS_OF_SUMS = 2.0**23, 10, 7
# Steps for which a second is searched; replacements evaluated closely; these, and tries, per step.
_FIRST, _CLOSELY, _OF_EACH, _TRIED_OF_EACH = 2, 120, 4, 2
# Steps that are nearly multiples of each other do not determine two coefficients.
_APART = 1e-9


@dataclass(frozen=True, eq=False)
class Aim:
    """Target of a program at some states."""

    inputs: dict[str, FloatArray]
    torque: FloatArray  # (n, N), exact, over the allowed error
    scale: FloatArray  # (n,), one over the allowed error
    weights: FloatArray  # (n, N), weights of errors

    def at(self, states: NDArray[np.intp]) -> Aim:
        """The same at some of the states."""
        some = {name: values[states] for name, values in self.inputs.items()}
        return Aim(some, self.torque[:, states], self.scale, self.weights[:, states])

    def errors(self, tape: Tape, values: FloatArray) -> FloatArray:
        """Weighted error over the allowed one, shape (n, N)."""
        return (tape.results(values) * self.scale[:, None] - self.torque) * self.weights


@dataclass(frozen=True, eq=False)
class Fit:
    """Numbers of a program, with values and errors."""

    numbers: FloatArray  # (steps,)
    values: FloatArray  # (steps, N)
    errors: FloatArray  # (n, N), over the allowed ones

    @property
    def largest(self) -> float:
        """Largest error over the allowed one."""
        return float(np.abs(self.errors).max(initial=0.0))


def unfitted(tape: Tape, aim: Aim, numbers: FloatArray | None = None) -> Fit:
    """Take a program's own numbers, or others."""
    numbers = tape.numbers if numbers is None else numbers
    values = tape.values(aim.inputs, numbers)
    return Fit(numbers, values, aim.errors(tape, values))


def columns_of(tape: Tape, fit: Fit, slopes: FloatArray) -> FloatArray:
    """Effect of every number on the errors, shape (numbers, n N)."""
    found = slopes[tape.scaled] * fit.values[tape.multiplied][:, None, :]
    return found.reshape(len(tape.scaled), fit.errors.size)


def fitted(tape: Tape, aim: Aim, start: Fit, power: float, turns: int, enough: float = 0.0) -> Fit:
    """Fit numbers to minimize a norm of the errors, down to `enough`, in at most `turns` rounds."""
    here = start
    for _ in range(turns):
        if here.largest <= enough or not len(tape.scaled):
            break
        slopes = tape.slopes(here.values, here.numbers, aim.scale) * aim.weights
        step, _ = Columns(columns_of(tape, here, slopes)).least(here.errors.ravel(), power)
        before = norm(here.errors, power)
        for stride in _STRIDES:
            numbers = here.numbers.copy()
            numbers[tape.scaled] = snapped(numbers[tape.scaled] - stride * step)
            trial = unfitted(tape, aim, numbers)
            if norm(trial.errors, power) < before:
                break
        else:
            break
        here = trial
    return here


def snapped(values: FloatArray) -> FloatArray:
    """Round to seven digits, so that decisions of a search are the same on every processor."""
    mantissas, exponents = np.frexp(values)
    return np.asarray(np.ldexp(np.round(mantissas * _SNAP), exponents) / _SNAP)


def norm(errors: FloatArray, power: float) -> float:
    """Norm of errors."""
    largest = float(np.abs(errors).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    return largest * float(((np.abs(errors) / largest) ** power).sum()) ** (1.0 / power)


class Columns:
    """Effects of numbers on errors, one row each (K, S), prepared for fits."""

    def __init__(self, columns: FloatArray) -> None:
        self._size = sizes_of(columns)
        # One row per error, so that large errors are selected quickly.
        self._scaled = np.ascontiguousarray((columns / self._size[:, None]).T)
        self._one = np.eye(len(columns))
        self._inverse = np.linalg.inv(self._scaled.T @ self._scaled + _HELD_BACK * self._one)

    def least(self, errors: FloatArray, power: float) -> tuple[FloatArray, FloatArray]:
        """Coefficients (K,) that minimize this power's norm of errors (S,), and the remaining errors."""
        x = self._inverse @ (errors @ self._scaled)
        for p in (*(p for p in _POWERS if p < power), *([power] if power > 2.0 else [])):
            for _ in range(_STEPS):
                left = errors - self._scaled @ x
                size = np.abs(left)
                largest = size.max(initial=0.0)
                if largest == 0.0:
                    break
                # Small errors are left out; the damping of numbers limits them.
                rows = np.flatnonzero(size > _COUNTING * largest)
                weights = (size[rows] / largest) ** (p - 2.0)
                root = np.sqrt(weights / weights.sum() * len(size))
                weighed = self._scaled[rows] * root[:, None]
                gram = weighed.T @ weighed + _HELD_BACK_MORE * self._one
                x = x + np.linalg.solve(gram, (root * left[rows]) @ weighed) / (p - 1.0)
        return x / self._size, errors - self._scaled @ x


def sizes_of(columns: FloatArray) -> FloatArray:
    """Norms of rows (K, S), none of them zero."""
    return np.asarray(np.sqrt(np.einsum("ks,ks->k", columns, columns)) + np.finfo(float).tiny)


class Replacement(NamedTuple):
    """A replacement of a step."""

    step: int
    by: tuple[tuple[int, float], ...]  # steps, or `NUMBER`, and their coefficients
    saved: float  # operations saved
    added: float  # growth of the mean square of the error over the allowed one

    def change(self, values: FloatArray) -> FloatArray:
        """Replacement minus the step itself, shape (N,), from the values of all steps."""
        change = -values[self.step]
        for u, c in self.by:
            change = change + (c if u == NUMBER else c * values[u])
        return change

    @property
    def order(self) -> tuple[float, float, int]:
        """Sort key: the best first; of equal ones the one that saves most, then the first."""
        merit = self.added / max(self.saved, 0.5) if self.added > 0.0 else self.added * self.saved
        return merit, -self.saved, self.step


def replacements(
    tape: Tape, fit: Fit, slopes: FloatArray, known: NDArray[np.bool_], power: float
) -> tuple[list[Replacement], float]:
    """List replacements, the best first, and the mean square error that a fit leaves without them.

    `slopes` are effects of steps on errors, (steps, n, N); `known` (steps,) can be stated as changes.
    """
    weights = np.maximum(np.abs(fit.errors), _SMALL) ** (power - 2)
    weights /= weights.mean()
    pool = _Pool(tape, fit, slopes, known, weights)
    found, mean_square = _beside_a_fit(tape, fit, slopes, pool.best(_CLOSELY), weights)
    kept = _of_each([one.step for one in found], _TRIED_OF_EACH)
    return [found[k] for k in kept], mean_square


def _of_each(steps: list[int], most: int) -> list[int]:
    """Indices of the first `most` for each step."""
    count: Counter[int] = Counter()
    kept = []
    for place, step in enumerate(steps):
        count[step] += 1
        if count[step] <= most:
            kept.append(place)
    return kept


def _beside_a_fit(
    tape: Tape, fit: Fit, slopes: FloatArray, promising: list[Replacement], weights: FloatArray
) -> tuple[list[Replacement], float]:
    """Evaluate closely: error added after a fit of all numbers."""
    root = np.sqrt(weights).ravel()
    error = fit.errors.ravel() * root
    made = [(slopes[one.step] * one.change(fit.values)).ravel() for one in promising]
    trials = np.array(made).reshape(-1, len(error)) * root + error
    columns = columns_of(tape, fit, slopes) * root
    if len(columns):
        columns /= sizes_of(columns)[:, None]
        gram = columns @ columns.T
        gram[np.diag_indices(len(gram))] += _HELD_BACK
        every = np.vstack([error, trials])
        every -= np.linalg.solve(gram, columns @ every.T).T @ columns
        error, trials = every[0], every[1:]
    base = float(error @ error) / len(error)
    added = np.einsum("ks,ks->k", trials, trials) / len(error) - base
    found = [one._replace(added=rounded(float(more))) for one, more in zip(promising, added, strict=True)]
    return sorted(found, key=lambda one: one.order), base


# Steps (K,), their replacements and numbers (K, 2), nan without a second; operations saved, and squares added
# (K,).
_Group: TypeAlias = tuple[NDArray[np.intp], NDArray[np.intp], FloatArray, FloatArray, FloatArray]


class _Pool:
    """Squares of the error as a quadratic form in the replacement of each step v: a + 2 b c + s c^2."""

    def __init__(
        self, tape: Tape, fit: Fit, slopes: FloatArray, known: NDArray[np.bool_], weights: FloatArray
    ) -> None:
        values = self.values = fit.values
        self.count, self.degree = fit.errors.size, tape.degree
        weighed = slopes * weights
        among = self.among = np.einsum("vin,vin->vn", slopes, weighed)
        left = np.einsum("vin,in->vn", weighed, fit.errors) - among * values
        self.left = left.sum(axis=1)
        # left = b - g v, so the constant part g v^2 - 2 b v is -(b + left) v.
        self.constant = -((2.0 * left + among * values) * values).sum(axis=1)
        # By v and u: coefficients, and operations saved before any multiplication.
        self.linear, self.square = left @ values.T, among @ (values**2).T
        self.by_itself = among.sum(axis=1)
        self.needs = tape.needs.T.astype(np.float32)
        self.alone = tape.alone_for * tape.operations
        self.total = self.alone.sum(axis=1).astype(float)
        self.alive = self.alone @ self.needs  # what u needs of the operations used only by v
        self.saved = self.total[:, None] - self.alive
        inputs = np.array([step.operation == "input" for step in tape.steps])
        never = tape.is_angle | ~known
        self.saved[tape.needs.T] = -np.inf
        self.saved[:, never] = -np.inf
        self.saved[never | inputs] = -np.inf
        # Torque stays D(q) qdd + h(q, qd) + c(q).
        v, u = tape.degree[:, None], tape.degree
        self.saved[~((u == v) | ((v == 2) & (u == 0)))] = -np.inf
        self.total[never | inputs] = -np.inf

    def best(self, most: int) -> list[Replacement]:
        """The `most` best ones by estimate, some for each step."""
        groups = [*self.by_one(), *self.by_two(), *self.by_number()]
        v, sources, numbers, saved, added = (np.concatenate(column) for column in zip(*groups, strict=True))
        added = np.round(added / self.count, _DIGITS)
        merit = np.where(added > 0.0, added / np.maximum(saved, 0.5), added * saved)
        order = np.lexsort((v, -saved, merit))
        chosen = order[_of_each(v[order].tolist(), _OF_EACH)[:most]]
        numbers = snapped(numbers[chosen])
        by = (
            tuple((u, c) for u, c in zip(*one, strict=True) if not math.isnan(c))
            for one in zip(sources[chosen].tolist(), numbers.tolist(), strict=True)
        )
        rest = (values[chosen].tolist() for values in (saved, added))
        return [Replacement(*one) for one in zip(v[chosen].tolist(), by, *rest, strict=True)]

    def by_one(self) -> Iterator[_Group]:
        """One step times the best number, 1 or -1."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            best = -self.linear / self.square
            ways = (
                (best, self.constant[:, None] + self.linear * best, self.saved - 1.0),
                (1.0, self.constant[:, None] + self.square + 2.0 * self.linear, self.saved),
                (-1.0, self.constant[:, None] + self.square - 2.0 * self.linear, self.saved),
            )
        for number, added, saved in ways:
            merit = _merit(added, saved).ravel()
            places = np.argpartition(merit, min(_OF_EACH * _CLOSELY, merit.size - 1))[: _OF_EACH * _CLOSELY]
            c = np.broadcast_to(number, added.shape).ravel()
            places = places[np.isfinite(merit[places]) & np.isfinite(c[places]) & (c[places] != 0.0)]
            v, u = np.divmod(places, len(self.total))
            yield v, _with(u), _with(c[places]), saved[v, u], added[v, u]

    def by_two(self) -> Iterator[_Group]:
        """Two steps: the first is one of the best alone, with the best second for each."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            alone = np.where(self.saved > 3.0, self.constant[:, None] - self.linear**2 / self.square, np.inf)
        alone = np.where(np.isfinite(alone), np.round(alone, _DIGITS_OF_SUMS), np.inf)
        several = np.flatnonzero((self.total >= 4.0) & np.isfinite(alone.min(axis=1, initial=np.inf)))
        if not several.size or alone.shape[1] <= _FIRST:
            return
        order = np.argpartition(alone[several], range(_FIRST), axis=1)[:, :_FIRST]
        for first in order.T:
            yield self._second(several, first, np.isfinite(alone[several, first]))

    def _second(self, v: NDArray[np.intp], first: NDArray[np.intp], fits: NDArray[np.bool_]) -> _Group:
        mixed = (self.among[v] * self.values[first]) @ self.values.T
        a, b = self.square[v, first][:, None], self.square[v]
        p, q = self.linear[v, first][:, None], self.linear[v]
        determinant = a * b - mixed**2
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            c = (q * mixed - p * b) / determinant
            d = (p * mixed - q * a) / determinant
            added = self.constant[v][:, None] + p * c + q * d
        both = (self.alone[v] * self.needs.T[first]) @ self.needs
        alive = self.alive[v] + self.alive[v, first][:, None] - both
        saved = np.where(np.isfinite(self.saved[v]), self.total[v][:, None] - alive - 3.0, -np.inf)
        merit = np.where((determinant > _APART * a * b) & fits[:, None], _merit(added, saved), np.inf)
        u, rows = merit.argmin(axis=1), np.arange(len(v))
        keep = np.isfinite(merit[rows, u]) & (c[rows, u] != 0.0) & (d[rows, u] != 0.0)
        rows, u = rows[keep], u[keep]
        both = np.stack([c[rows, u], d[rows, u]], axis=1)
        return v[rows], np.stack([first[rows], u], axis=1), both, saved[rows, u], added[rows, u]

    def by_number(self) -> Iterator[_Group]:
        """A number: the best, or 0."""
        v = np.flatnonzero(np.isfinite(self.total) & (self.total > 0.0))
        none = _with(np.zeros(len(v)))
        yield v, np.full((len(v), 2), NUMBER), none, self.total[v] + 1.0, self.constant[v]
        v = v[self.degree[v] != 1]
        left, square = self.left[v], self.by_itself[v]
        c = np.divide(-left, square, out=np.zeros_like(left), where=square > 0.0)
        yield v, np.full((len(v), 2), NUMBER), _with(c), self.total[v], self.constant[v] + left * c


def _with(one: NDArray[Any]) -> NDArray[Any]:
    """Sources or numbers without a second, shape (K, 2)."""
    return np.stack([one, np.full_like(one, NUMBER if one.dtype.kind == "i" else np.nan)], axis=1)


def rounded(added: float) -> float:
    """Growth of an error, in digits that do not depend on the processor."""
    return round(added, _DIGITS)


def _merit(added: FloatArray, saved: FloatArray) -> FloatArray:
    with np.errstate(invalid="ignore"):
        merit = np.where(added > 0.0, added / np.maximum(saved, 0.5), added * saved)
    return np.where((saved > 0.0) & np.isfinite(merit), np.round(merit, _DIGITS_OF_SUMS), np.inf)
