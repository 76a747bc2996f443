"""Numbers of a program fitted so that it comes closest to the exact torque, its largest errors foremost.

Torque is linear in each number alone, not in all of them; near a good program it is so nearly enough. A few
weighted least squares, each from where the last one led, make a high power of the errors small, and with it
the largest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.tape import Tape

# Powers on the way to a high one, and steps with each; with a power p a step is 1 / (p - 1) of the usual.
_POWERS, _STEPS = (4.0, 8.0, 14.0), 2
# Errors above this share of the largest count.
_SMALL = 0.25
# How much steps are held back, as a share of each number's own square: numbers may change by much while the
# torque hardly does, and it is linear in them only nearby. Much more where few errors count: steps that bring
# those down would let all others grow.
_HELD_BACK, _HELD_BACK_MORE = 1e-3, 0.1
# Numbers are taken to so many parts.
_SNAP = 2.0**23
# Shares of a step to try, the first that leads down is taken.
_STRIDES = (1.0, 0.4, 0.15)


@dataclass(frozen=True, eq=False)
class Aim:
    """What a program shall compute, at some states."""

    inputs: dict[str, FloatArray]
    torque: FloatArray  # exact, over the allowed error, (n, N)
    scale: FloatArray  # one over the allowed error, (n,)
    weights: FloatArray  # how much errors count, (n, N)

    def at(self, states: NDArray[np.intp]) -> Aim:
        """The same at some of the states."""
        some = {name: values[states] for name, values in self.inputs.items()}
        return Aim(some, self.torque[:, states], self.scale, self.weights[:, states])

    def errors(self, tape: Tape, values: FloatArray) -> FloatArray:
        """Error over the allowed one, as it counts, shape (n, N)."""
        return (tape.results(values) * self.scale[:, None] - self.torque) * self.weights


@dataclass(frozen=True, eq=False)
class Fit:
    """Numbers of a program, what its steps are with them, and its errors over the allowed ones."""

    numbers: FloatArray
    values: FloatArray
    errors: FloatArray

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
    """What every number makes of the errors, shape (numbers, n N)."""
    found = slopes[tape.scaled] * fit.values[tape.multiplied][:, None, :]
    return found.reshape(len(tape.scaled), fit.errors.size)


def fitted(tape: Tape, aim: Aim, start: Fit, power: float, turns: int, enough: float = 0.0) -> Fit:
    """Fit numbers of a program from a start, by so many least squares at most: the least norm of that power.

    A power of 2 makes squares least, 12 nearly the largest error; it ends with a largest error of `enough`.
    """
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
    """Round to seven digits: what follows from them is then the same on every processor.

    The last digits of sums hang on the order in which a processor adds; a search that takes hundreds of
    decisions by them would end elsewhere.
    """
    mantissas, exponents = np.frexp(values)
    return np.asarray(np.ldexp(np.round(mantissas * _SNAP), exponents) / _SNAP)


def norm(errors: FloatArray, power: float) -> float:
    """Norm of errors."""
    largest = float(np.abs(errors).max(initial=0.0))
    if largest == 0.0:
        return 0.0
    return largest * float(((np.abs(errors) / largest) ** power).sum()) ** (1.0 / power)


class Columns:
    """Effects of numbers on errors, one row each (K, S), ready to bring any errors down."""

    def __init__(self, columns: FloatArray) -> None:
        self._size = sizes_of(columns)
        self._scaled = columns / self._size[:, None]
        self._one = np.eye(len(columns))
        self._inverse = np.linalg.inv(self._scaled @ self._scaled.T + _HELD_BACK * self._one)

    def least(self, errors: FloatArray, power: float) -> tuple[FloatArray, FloatArray]:
        """Coefficients (K,) that bring errors (S,) to the least norm of that power, and what is left."""
        x = self._inverse @ (self._scaled @ errors)
        for p in (*(p for p in _POWERS if p < power), *([power] if power > 2.0 else [])):
            for _ in range(_STEPS):
                left = errors - x @ self._scaled
                size = np.abs(left)
                largest = size.max(initial=0.0)
                if largest == 0.0:
                    break
                # Those that hardly count are left out, and held back with the numbers.
                rows = np.flatnonzero(size > _SMALL * largest)
                scaled, weights = self._scaled[:, rows], (size[rows] / largest) ** (p - 2.0)
                root = np.sqrt(weights / weights.sum() * len(size))
                weighed = scaled * root
                gram = weighed @ weighed.T + _HELD_BACK_MORE * self._one
                x = x + np.linalg.solve(gram, weighed @ (root * left[rows])) / (p - 1.0)
        return x / self._size, errors - x @ self._scaled


def sizes_of(columns: FloatArray) -> FloatArray:
    """Norms of rows (K, S), none of them zero."""
    return np.asarray(np.sqrt(np.einsum("ks,ks->k", columns, columns)) + np.finfo(float).tiny)
