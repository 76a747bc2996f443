"""A program written out: what its outputs are at every state, whatever it was made from.

Every step becomes a sum of exponentials exp(i m.q), powers of sliding variables, and products of at most two
rates or one acceleration, with a number before each. Two programs that compute the same have the same sums,
but for round-off, and a program that computes anything else than a torque, such as an angle itself or a cube
of a rate, is found out at the step that does. Nothing is sampled.

How far the numbers are off follows from the program run on magnitudes: every step's result then is at least
the sum of its numbers' magnitudes, and each is off by no more than a count of roundings times that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.torque_algebra import TorqueAlgebra, no_torque
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.operations.program import Program
from gd_analyze.text import LARGEST_COEFFICIENT

_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Expansion:
    """What a program's outputs are.

    Parameters
    ----------
    program
        The program.
    rows
        For every output a polynomial for each of `rate_factors`.
    roundings
        How many roundings follow one another in every output's numbers, shape (outputs,).
    degrees
        Sum of the multiples of all angles in every output, formally, shape (outputs, n).
    """

    program: Program
    rows: tuple[TrigonometricPolynomial, ...]
    roundings: NDArray[np.int64]
    degrees: NDArray[np.int64]

    def round_off(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """What rounding does to every output where no input is larger than this, shape (outputs,).

        It covers both the numbers in `rows` and the program's own evaluation, where every step is rounded
        once, and the argument of a sine or cosine as often as angles are added up in it.
        """
        limits = {"q": q, "qd": qd, "qdd": qdd}
        largest = {f"{name}{j + 1}": float(x) for name, xs in limits.items() for j, x in enumerate(xs)}
        value = self.program.carried_out(largest.__getitem__, _largest)
        reached = np.array([abs(float(value(output))) for output in self.program.outputs])
        arguments = self.degrees @ (2.0 + np.abs(q))
        return np.asarray(_EPS * (2 * self.roundings + arguments) * reached)


def expanded(program: Program, sliding: Sequence[bool]) -> Expansion:
    """Write a program out.

    Parameters
    ----------
    program
        Of inputs q1 .., qd1 .. and qdd1 ...
    sliding
        Whether each joint slides.

    Raises
    ------
    ModelError
        If it computes what no torque of an arm is: an angle outside of sines and cosines, a sine or cosine of
        anything but a sum of angles, more than two rates or an acceleration times a rate, too high a
        multiple or power; or if its numbers overflow, or it is too long to be written out.
    """
    algebra = TorqueAlgebra(sliding)
    with np.errstate(all="ignore"):
        value = program.carried_out(algebra.given, algebra.apply)
        sums = [algebra.lifted(value(output)) for output in program.outputs]
    if not all((np.abs(one.numbers) <= LARGEST_COEFFICIENT).all() for one in sums):
        raise no_torque("its numbers overflow")
    return Expansion(
        program,
        tuple(algebra.waves(one) for one in sums),
        np.array([one.roundings for one in sums], dtype=np.int64),
        np.array([one.degrees for one in sums], dtype=np.int64).reshape(-1, len(sliding)),
    )


def _largest(operation: str, *arguments: float) -> float:
    """Largest magnitude of a step's result, given those of its arguments."""
    if operation in ("cos", "sin"):
        return 1.0
    if operation == "multiply":
        return abs(arguments[0]) * abs(arguments[1])
    return sum(map(abs, arguments))
