"""Randomly drawn states that detect programs with different torques.

Every step of a torque's program is a trigonometric polynomial in each angle, and its formal degree d follows
from the steps. If such a polynomial reaches M, it exceeds e M on a share p of the circle with T_2d(1/cos(p
pi/2)) >= 1/e, where T is the Chebyshev polynomial: S. Tikhonov, P. Yuditskii, Sharp Remez inequality,
Constructive Approximation 52 (2020); for an interval, as of sliding joints, see E. Remez (1936). Applied
joint by joint this gives a lower bound on the probability that a difference shows at a random state. A high
degree, which could hide between states, is refused or answered by more states.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from operator import add
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.expansion import HIGHEST_DEGREE, magnitudes, no_torque
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program, program_inputs

# Difference of a coefficient of 1, qdd_j or qd_j qd_k that is to be found, as a share of the joint's torque.
LEAST_DIFFERENCE = 1e-3
# Largest probability that such a difference is missed.
MISS_PROBABILITY = 1e-6

# Most states times steps, some seconds; where the probability takes more, it is not reached.
_MOST_STEPS = 2.0**31
# States at a time, so that their steps fit the cache.
_STATES_AT_ONCE = 1024
# Most values of the steps at a time, half a gigabyte.
_VALUES_AT_ONCE = 2**26
# Share of a joint's torque that may be lost in the rounding of large terms.
_LOST_SHARE = 1e-6
# Share of the states that are at rest; at the others velocities and accelerations are -1, 0 or 1.
_REST_SHARE = 0.25
# Share of each coefficient that a state shows with a probability of at least `_SHOWN_PROBABILITY`. Second
# differences of f in qdd_j and qd_k, for example, consist of four values of f at equally likely states, so
# that the probability is at least 3/4 * (2/3)^2 / 4.
_SHOWN_SHARE = 0.5
_SHOWN_PROBABILITY = 1.0 / 12.0
# Range of sliding joints, m.
_SLIDE_RANGE = 2.0


class _Formal(NamedTuple):
    """Formal degrees of a step."""

    degrees: tuple[int, ...]  # in every joint's variable; for a sum of angles their signed multiples
    weight: int = 0  # a velocity counts 1, an acceleration 2
    is_angle: bool = False


def formal_degrees(program: Program, is_revolute: Sequence[bool]) -> FloatArray:
    """Bounds on a program's degrees in the joints' variables, (n,); ModelError if it cannot be a torque."""
    n = len(is_revolute)
    no_degrees = (0,) * n
    constant = _Formal(no_degrees)

    def input_degrees(name: str) -> _Formal:
        letters = name.rstrip("0123456789")
        joint = int(name[len(letters) :]) - 1
        if letters != "q":
            return _Formal(no_degrees, len(letters) - 1)
        return _Formal(tuple(int(j == joint) for j in range(n)), 0, is_revolute[joint])

    def apply(operation: str, first: Any, second: Any = constant) -> _Formal:
        (a, u, is_angle_a), (b, v, is_angle_b) = (
            x if isinstance(x, _Formal) else constant for x in (first, second)
        )
        if operation in ("cos", "sin"):
            if not is_angle_a and (u or a != no_degrees):
                raise no_torque(f"it takes the {operation} of something other than a sum of angles")
            return _Formal(tuple(map(abs, a)))
        if is_angle_a or is_angle_b:
            has_variable = (not is_angle_a and a != no_degrees) or (not is_angle_b and b != no_degrees)
            if operation == "multiply" or u or v or has_variable:
                raise no_torque("it uses an angle outside of sines and cosines")
            factor_a, factor_b = {"add": (1, 1), "subtract": (1, -1), "negative": (-1, 0)}[operation]
            return _Formal(tuple(factor_a * x + factor_b * y for x, y in zip(a, b, strict=True)), 0, True)
        if operation == "multiply":
            return _Formal(a if b == no_degrees else tuple(map(add, a, b)), u + v)
        return _Formal(a if a == b or b == no_degrees else tuple(map(max, a, b)), max(u, v))

    value = program.carried_out(input_degrees, apply)
    outputs = [x for x in map(value, program.outputs) if isinstance(x, _Formal)]
    if any(x.is_angle or x.weight > 2 for x in outputs):
        raise no_torque("it multiplies more than two velocities, or an acceleration by a velocity")
    degrees = np.array([no_degrees, *(x.degrees for x in outputs)]).max(axis=0)
    if degrees.max(initial=0) > HIGHEST_DEGREE:
        raise no_torque(
            f"its degree in q{int(degrees.argmax()) + 1} may be {degrees.max()}, above {HIGHEST_DEGREE}"
        )
    return degrees


def telling_states(
    programs: Sequence[Program], is_revolute: Sequence[bool], closeness: float, least: Any = 0
) -> Iterator[States]:
    """Blocks of random states; a difference below `closeness` of the torque counts as none.

    Degrees are those of the programs, but at least `least`. Raises a ModelError if one cannot be a torque.
    """
    n, turns = len(is_revolute), np.array(is_revolute)
    program_degrees = [formal_degrees(program, is_revolute) for program in programs]
    degrees = np.maximum(np.max([np.zeros(n), *program_degrees], axis=0), least)
    steps = sum(len(program.steps) for program in programs) or 1
    count = math.ceil(min(states_needed(degrees, is_revolute, closeness), _MOST_STEPS / steps))
    block = max(1, min(_STATES_AT_ONCE, _VALUES_AT_ONCE // steps))
    rng = np.random.default_rng()
    for _ in range(0, count, block):
        moving = rng.integers(-1, 2, (2, block, n)) * (rng.random((block, 1)) >= _REST_SHARE)
        q = rng.uniform(-1.0, 1.0, (block, n)) * np.where(turns, np.pi, _SLIDE_RANGE)
        yield States(q, *moving.astype(float))


def largest_difference(
    program: Program, reference: Program, is_revolute: Sequence[bool], closeness: float
) -> tuple[FloatArray, FloatArray]:
    """Largest difference of a program from a reference, and the reference's largest magnitude, (n,) each.

    Infinite if the program cannot be a torque, see `telling_states`, or cancels so much that a term could
    hide in its rounding.
    """
    difference, size = (np.zeros(len(reference.outputs)) for _ in range(2))
    runners: list[Callable[..., FloatArray]] = []
    with np.errstate(all="ignore"), suppress(ModelError):
        for states in telling_states((program, reference), is_revolute, closeness):
            runners = runners or [compared.runner(len(states)) for compared in (program, reference)]
            inputs = program_inputs(states)
            torque, reference_torque = (run(inputs) for run in runners)
            difference = np.maximum(difference, np.abs(torque - reference_torque).max(axis=1))
            size = np.maximum(size, np.abs(reference_torque).max(axis=1))
        unit = np.ones(len(is_revolute))
        lost = np.finfo(float).eps * magnitudes(program, np.pi * unit, unit, unit)
        return np.where(lost > _LOST_SHARE * size, np.inf, difference), size
    return np.full_like(difference, np.inf), size


def states_needed(
    degrees: Sequence[int] | FloatArray, is_revolute: Sequence[bool], closeness: float
) -> float:
    """Number of states that find a difference of `LEAST_DIFFERENCE` with the stated probability."""
    acting = [(int(d), turns) for d, turns in zip(degrees, is_revolute, strict=True) if d]
    probability = _SHOWN_PROBABILITY
    for d, turns in acting:
        part = math.acosh((_SHOWN_SHARE * LEAST_DIFFERENCE / closeness) ** (1 / len(acting))) / d
        probability *= 2 / math.pi * math.acos(1 / math.cosh(part / 2)) if turns else math.tanh(part / 2) ** 2
    return -math.log(MISS_PROBABILITY) / probability
