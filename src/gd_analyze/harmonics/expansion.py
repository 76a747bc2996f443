"""A program written out: exact expressions of its outputs at every state.

Every step becomes a sum of exponentials exp(i m.q) and powers of prismatic variables, times up to two
velocities or one acceleration, each with a coefficient. Programs that compute the same have the same sums up
to round-off. A program that does not compute a torque, but for example an angle or the cube of a velocity, is
refused at that step. Nothing is sampled.

Errors of the coefficients follow from running the program on magnitudes: the result of a step is at least the
sum of its coefficients' magnitudes, and a coefficient's error is at most a number of roundings times that.
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.transform import Harmonics, inertia_slopes
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial, numbers
from gd_analyze.operations.program import Program
from gd_analyze.text import LARGEST_COEFFICIENT

# Largest multiple of an angle, or power, in any step. A torque has `DEGREE`; an inertia in the base frame
# multiplied by three axes has more until sines and cosines cancel.
HIGHEST_DEGREE = 3 * DEGREE
# The exact torque of an arm of seven joints and 19 358 terms forms 2.8 million terms, all parts of the PUMA's
# elements 0.7 million.
# Most terms formed at one step, which takes about a second and 0.3 GB.
_MOST_TERMS_PER_STEP = 2**22
# Most terms formed in total, which takes about ten seconds.
_MOST_TERMS_IN_TOTAL = 2**26
# Number of roundings of the summands below which a sum counts as cancelled.
_CANCELLED_ROUNDINGS = 32
_EPS = float(np.finfo(float).eps)

# Factor of a polynomial in q: "1", an acceleration "qdd" (joint,) or a product "qd" (joint, joint).
VelocityFactor = tuple[str, tuple[int, ...]]


def expansion_factors(n: int) -> tuple[VelocityFactor, ...]:
    """Factors of the polynomials of every joint's torque, in this order."""
    pairs = itertools.combinations_with_replacement(range(n), 2)
    return ("1", ()), *(("qdd", (j,)) for j in range(n)), *(("qd", pair) for pair in pairs)


def exact_row(
    harmonics: Harmonics, inertia: Mapping[tuple[int, int], TrigonometricPolynomial], i: int
) -> tuple[TrigonometricPolynomial, list[int]]:
    """Summands of the exact torque of joint i, given D, and the index of each in `expansion_factors`.

    The factor of qd_j qd_k, j < k, is 2 h_ijk, that of qd_j^2 is h_ijj.
    """
    n = harmonics.arm.n_joints
    parts = [harmonics.gravity_loading[i], *(inertia[min(i, j), max(i, j)] for j in range(n))]
    places = list(range(n + 1))
    for place, (_, (j, k)) in enumerate(expansion_factors(n)[n + 1 :], start=n + 1):
        parts += [(1.0 if j == k else 2.0) * slope for slope in inertia_slopes(inertia, i, j, k)]
        places += [place] * 3
    return TrigonometricPolynomial.stacked(parts), places


class TooLongError(ModelError):
    """A program has too many terms to be written out, though it may compute a torque."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """The outputs of a program, written out."""

    program: Program
    rows: tuple[TrigonometricPolynomial, ...]  # for every output, one polynomial per `expansion_factors`
    roundings: NDArray[np.int64]  # (outputs,), most successive roundings of an output's coefficients
    degrees: NDArray[np.int64]  # (outputs, n), formal degree in every joint's variable

    def round_off(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Bound the round-off of every output for inputs within these magnitudes, shape (outputs,).

        It covers the coefficients in `rows` and running the program, where every step is rounded once, and
        the argument of a sine or cosine once per added angle.
        """
        arguments = self.degrees @ (2.0 + np.abs(q))
        return np.asarray(_EPS * (2 * self.roundings + arguments) * magnitudes(self.program, q, qd, qdd))


def magnitudes(program: Program, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
    """Sum of the magnitudes of every output's terms for inputs within these magnitudes, shape (outputs,)."""
    limits = {"q": q, "qd": qd, "qdd": qdd}
    largest = {f"{name}{j + 1}": float(x) for name, xs in limits.items() for j, x in enumerate(xs)}
    value = program.carried_out(largest.__getitem__, _largest)
    return np.array([abs(float(value(output))) for output in program.outputs])


def expanded(program: Program, prismatic: Sequence[bool]) -> Expansion:
    """Write out a program with inputs among q1, qd1, qdd1, ...; `ModelError` if it is not a torque."""
    algebra = _TorqueAlgebra(prismatic)
    with np.errstate(all="ignore"):
        value = program.carried_out(algebra.input_value, algebra.apply)
        sums = [algebra.as_sum(value(output)) for output in program.outputs]
    if not all((np.abs(total.numbers) <= LARGEST_COEFFICIENT).all() for total in sums):
        raise no_torque("its numbers overflow")
    return Expansion(
        program,
        tuple(algebra.polynomial(total) for total in sums),
        np.array([total.roundings for total in sums], dtype=np.int64),
        np.array([total.degrees for total in sums], dtype=np.int64).reshape(-1, len(prismatic)),
    )


def _largest(operation: str, *arguments: float) -> float:
    """Largest magnitude of a step's result, given those of its arguments."""
    if operation in ("cos", "sin"):
        return 1.0
    if operation == "multiply":
        return abs(arguments[0]) * abs(arguments[1])
    return sum(map(abs, arguments))


class _Angle(NamedTuple):
    """A sum of angles: the multiple of every joint, and a constant, rad."""

    multiples: tuple[int, ...]
    constant: float = 0.0


@dataclass(frozen=True, eq=False)
class _Sum:
    """Coefficients by key; a key holds the multiples of all joints and the index of the velocity factor.

    Degrees are formal upper bounds: terms of that degree may have cancelled.
    """

    keys: NDArray[np.int64]
    numbers: Array
    degrees: NDArray[np.int64]
    roundings: int = 0


class _TorqueAlgebra:
    """Arithmetic on sums, on angles and on plain numbers."""

    def __init__(self, prismatic: Sequence[bool]) -> None:
        self.prismatic = tuple(prismatic)
        self.n = len(self.prismatic)
        self.factors = expansion_factors(self.n)
        # Single velocities come last: steps have them, torques do not.
        moving: list[VelocityFactor] = [*self.factors, *(("qd", (j,)) for j in range(self.n))]
        self.place = {factor: k for k, factor in enumerate(moving)}
        self.products = _products(moving, self.place)
        self.weights = [(2 * HIGHEST_DEGREE + 1) ** (self.n - 1 - j) for j in range(self.n)]
        self.work = 0
        if (2 * HIGHEST_DEGREE + 1) ** self.n * len(moving) >= 2**62:
            raise no_torque(f"it has {self.n} joints, too many to be written out")

    def input_value(self, name: str) -> _Angle | _Sum:
        """An input: an angle, or a sum of one term."""
        kind, joint = name.rstrip("0123456789"), int(name.lstrip("qd")) - 1
        if kind != "q":
            return self._term(0, self.place[kind, (joint,)], np.zeros(self.n, dtype=np.int64))
        alone = np.eye(self.n, dtype=np.int64)[joint]
        if self.prismatic[joint]:
            return self._term(self.weights[joint], 0, alone)
        return _Angle(tuple(alone.tolist()))

    def as_sum(self, x: Any) -> _Sum:
        """A number as a sum; an angle is refused."""
        if isinstance(x, _Sum):
            return x
        if isinstance(x, _Angle):
            raise no_torque("it uses an angle outside of sines and cosines")
        return self._term(0, 0, np.zeros(self.n, dtype=np.int64), float(x))

    def apply(self, operation: str, *arguments: Any) -> Any:
        """Carry an operation out."""
        if operation in ("cos", "sin"):
            return self._exponentials(operation, arguments[0])
        if any(isinstance(x, _Angle) for x in arguments) and operation != "multiply":
            return self._angle(operation, *arguments)
        sums = [self.as_sum(x) for x in arguments]
        if operation == "multiply":
            return self._product(*sums)
        if operation != "add":
            last = sums[-1]
            sums[-1] = _Sum(last.keys, -last.numbers, last.degrees, last.roundings)
        return self._added(*sums) if len(sums) == 2 else sums[0]

    def _angle(self, operation: str, *arguments: Any) -> _Angle:
        """Sum, difference or negative of angles and constants."""
        no_multiples = (0,) * self.n
        angles = [x if isinstance(x, _Angle) else _Angle(no_multiples, x) for x in arguments]
        if any(isinstance(x.constant, _Sum) for x in angles):
            raise no_torque("it adds an angle to something that is not an angle")
        first, second = angles if len(angles) == 2 else (_Angle(no_multiples), angles[0])
        sign = 1 if operation == "add" else -1
        multiples = (a + sign * b for a, b in zip(first.multiples, second.multiples, strict=True))
        return _Angle(tuple(multiples), first.constant + sign * second.constant)

    def polynomial(self, total: _Sum) -> TrigonometricPolynomial:
        """Write a sum in harmonics, one polynomial per `expansion_factors`."""
        angles, moving = np.divmod(total.keys, len(self.products))
        if (moving >= len(self.factors)).any():
            raise no_torque("an output is linear in a velocity")
        multiples = self._multiples(angles)
        # m and -m are conjugate; the one of positive sign stands for both.
        sign = numbers(multiples * ~np.array(self.prismatic))
        is_written = sign >= 0
        values = (total.numbers * np.where(sign > 0, 2.0, 1.0))[is_written]
        _, first, column = np.unique(numbers(multiples[is_written]), return_index=True, return_inverse=True)
        out = np.zeros((len(self.factors), len(first)), dtype=complex)
        out[moving[is_written], column] = values
        return TrigonometricPolynomial(self.prismatic, multiples[is_written][first], out)

    def _multiples(self, angles: NDArray[np.int64]) -> NDArray[np.int64]:
        out = np.empty((len(angles), self.n), dtype=np.int64)
        for j in reversed(range(self.n)):
            out[:, j] = (angles + HIGHEST_DEGREE) % (2 * HIGHEST_DEGREE + 1) - HIGHEST_DEGREE
            angles = (angles - out[:, j]) // (2 * HIGHEST_DEGREE + 1)
        return out

    def _term(self, angle: int, moving: int, degrees: NDArray[np.int64], number: float = 1.0) -> _Sum:
        keys = np.array([angle * len(self.products) + moving], dtype=np.int64)
        return _Sum(keys, np.array([number], dtype=complex), degrees)

    def _exponentials(self, operation: str, argument: Any) -> float | _Sum:
        if isinstance(argument, _Sum):
            raise no_torque(f"it takes the {operation} of something other than a sum of angles")
        multiples, constant = argument if isinstance(argument, _Angle) else ((0,) * self.n, argument)
        degrees = np.abs(np.array(multiples, dtype=object))
        self._require_low(degrees)
        angle = len(self.products) * sum(m * w for m, w in zip(multiples, self.weights, strict=True))
        if angle == 0:
            return math.cos(constant) if operation == "cos" else math.sin(constant)
        half = (0.5 if operation == "cos" else -0.5j) * cmath.exp(1j * constant)
        halves = np.array((half, half.conjugate()), complex)
        return _Sum(np.array([angle, -angle], dtype=np.int64), halves, degrees.astype(np.int64))

    def _added(self, a: _Sum, b: _Sum) -> _Sum:
        self._spend(len(a.keys) + len(b.keys))
        keys, values = np.concatenate([a.keys, b.keys]), np.concatenate([a.numbers, b.numbers])
        roundings = max(a.roundings, b.roundings) + 1
        return _gathered(keys, values, np.maximum(a.degrees, b.degrees), roundings)

    def _product(self, a: _Sum, b: _Sum) -> _Sum:
        degrees = a.degrees + b.degrees
        if (degrees > HIGHEST_DEGREE).any():
            # Squares of sines and cosines may have cancelled since, unlike their roundings.
            self._require_low(self._degrees(a) + self._degrees(b))
        self._spend(len(a.keys) * len(b.keys))
        (angle_a, moving_a), (angle_b, moving_b) = (np.divmod(x.keys, len(self.products)) for x in (a, b))
        moving = self.products[moving_a[:, None], moving_b]
        if (moving < 0).any():
            raise no_torque("it multiplies more than two velocities, or an acceleration by a velocity")
        keys = ((angle_a[:, None] + angle_b) * len(self.products) + moving).ravel()
        values = np.outer(a.numbers, b.numbers).ravel()
        # Rounding of complex products, and of sums of those that share a key.
        least = min(len(a.keys), len(b.keys))
        roundings = a.roundings + b.roundings + 2 + least
        if least == 1:
            return _Sum(keys, values, degrees, roundings)
        return _gathered(keys, values, degrees, roundings)

    def _spend(self, terms: int) -> None:
        self.work += terms
        if terms > _MOST_TERMS_PER_STEP or self.work > _MOST_TERMS_IN_TOTAL:
            raise TooLongError(
                "the program is too long to be written out",
                where="program",
                expected=f"up to {_MOST_TERMS_PER_STEP} terms at every step",
                found="more",
                next_step="`gd-analyze evaluate` tests the model at states",
            )

    def _degrees(self, total: _Sum) -> NDArray[np.int64]:
        """Largest multiple of every joint that occurs."""
        return np.abs(self._multiples(total.keys // len(self.products))).max(axis=0, initial=0)

    def _require_low(self, degrees: NDArray[Any]) -> None:
        if (degrees > HIGHEST_DEGREE).any():
            joint = int(np.argmax(degrees > HIGHEST_DEGREE))
            raise no_torque(f"its degree in q{joint + 1} is above {HIGHEST_DEGREE}")


def _products(moving: Sequence[VelocityFactor], place: dict[VelocityFactor, int]) -> NDArray[np.int64]:
    """Index of the product of two factors; -1 if no torque contains it."""
    out = np.full((len(moving), len(moving)), -1, dtype=np.int64)
    for (a, (kind, joints_a)), (b, (_, joints_b)) in itertools.product(enumerate(moving), repeat=2):
        if a == 0 or b == 0:
            out[a, b] = a + b
        elif kind == "qd" == moving[b][0] and len(joints_a) == len(joints_b) == 1:
            out[a, b] = place["qd", tuple(sorted(joints_a + joints_b))]
    return out


def _gathered(keys: NDArray[np.int64], values: Array, degrees: NDArray[np.int64], roundings: int) -> _Sum:
    """Sum the coefficients of equal keys, without those that cancel."""
    order = np.argsort(keys, kind="stable")
    keys, values = keys[order], values[order]
    starts = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1]])) if len(keys) else keys
    if len(starts) == len(keys):
        return _Sum(keys, values, degrees, roundings)
    totals = np.add.reduceat(values, starts)
    # Written so that nan stays.
    cancelled = np.abs(totals) <= _CANCELLED_ROUNDINGS * _EPS * np.add.reduceat(np.abs(values), starts)
    roundings += _CANCELLED_ROUNDINGS if cancelled.any() else 0
    return _Sum(keys[starts][~cancelled], totals[~cancelled], degrees, roundings)


def no_torque(reason: str) -> ModelError:
    """Error for a program that computes something else."""
    return ModelError(
        f"the program does not compute a torque of an arm: {reason}",
        where="program",
        expected="sines and cosines of sums of angles, times at most two velocities or one acceleration",
        next_step="make the model again with `gd-analyze simplify`",
    )
