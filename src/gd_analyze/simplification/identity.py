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
from collections.abc import Iterator, Sequence
from contextlib import suppress
from operator import add
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.expansion import HIGHEST, magnitudes, no_torque
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Batch, Program
from gd_analyze.simplification.effort import inputs_of

# A coefficient of 1, qdd_j or qd_j qd_k that differs by this share of the joint's torque is missed with at
# most this probability, unless that takes more than this many states times steps, some seconds.
FOUND, ODDS = 1e-3, 1e-6
_MOST = 2.0**31
# States at a time, so that their steps fit the cache; and most values, half a gigabyte.
_BLOCK, _MOST_VALUES = 1024, 2**26
# Share of a joint's torque that may be lost in the rounding of large terms.
_LOST = 1e-6
# One state in four is at rest; otherwise velocities and accelerations are -1, 0 or 1. Second differences of f
# in qd_j and qd_k, for example, consist of four values of f at equally likely states: a state shows at least
# half of each coefficient with a probability of at least 3/4 * (2/3)^2 / 4.
_STILL, _SHOWN, _SHARE = 0.25, 1.0 / 12.0, 0.5
# Range of sliding joints, m.
_REACH = 2.0


class _Formal(NamedTuple):
    """Formal degrees of a step."""

    degrees: tuple[int, ...]  # in every joint's variable; for a sum of angles their signed multiples
    weight: int = 0  # a velocity counts 1, an acceleration 2
    is_angle: bool = False


def formal_degrees(program: Program, is_revolute: Sequence[bool]) -> FloatArray:
    """Bounds on a program's degrees in the joints' variables, (n,); ModelError if it cannot be a torque."""
    n = len(is_revolute)
    none = (0,) * n
    constant = _Formal(none)

    def given(name: str) -> _Formal:
        letters = name.rstrip("0123456789")
        joint = int(name[len(letters) :]) - 1
        if letters != "q":
            return _Formal(none, len(letters) - 1)
        return _Formal(tuple(int(j == joint) for j in range(n)), 0, is_revolute[joint])

    def apply(operation: str, first: Any, second: Any = constant) -> _Formal:
        (a, u, turns), (b, v, other) = (x if isinstance(x, _Formal) else constant for x in (first, second))
        if operation in ("cos", "sin"):
            if not turns and (u or a != none):
                raise no_torque(f"it takes the {operation} of something other than a sum of angles")
            return _Formal(tuple(map(abs, a)))
        if turns or other:
            if operation == "multiply" or u or v or (not turns and a != none) or (not other and b != none):
                raise no_torque("it uses an angle outside of sines and cosines")
            own, sign = {"add": (1, 1), "subtract": (1, -1), "negative": (-1, 0)}[operation]
            return _Formal(tuple(own * x + sign * y for x, y in zip(a, b, strict=True)), 0, True)
        if operation == "multiply":
            return _Formal(a if b == none else tuple(map(add, a, b)), u + v)
        return _Formal(a if a == b or b == none else tuple(map(max, a, b)), max(u, v))

    value = program.carried_out(given, apply)
    found = [x for x in map(value, program.outputs) if isinstance(x, _Formal)]
    if any(x.is_angle or x.weight > 2 for x in found):
        raise no_torque("it multiplies more than two velocities, or an acceleration by a velocity")
    degrees = np.array([none, *(x.degrees for x in found)]).max(axis=0)
    if degrees.max(initial=0) > HIGHEST:
        raise no_torque(f"its degree in q{int(degrees.argmax()) + 1} may be {degrees.max()}, above {HIGHEST}")
    return degrees


def telling_states(
    programs: Sequence[Program], is_revolute: Sequence[bool], closeness: float, least: Any = 0
) -> Iterator[States]:
    """Blocks of random states; a difference below `closeness` of the torque counts as none.

    Degrees are those of the programs, but at least `least`. Raises a ModelError if one cannot be a torque.
    """
    n, turns = len(is_revolute), np.array(is_revolute)
    found = [formal_degrees(program, is_revolute) for program in programs]
    degrees = np.maximum(np.max([np.zeros(n), *found], axis=0), least)
    steps = sum(len(program.steps) for program in programs) or 1
    left = math.ceil(min(states_needed(degrees, is_revolute, closeness), _MOST / steps))
    block, rng = max(1, min(_BLOCK, _MOST_VALUES // steps)), np.random.default_rng()
    for _ in range(0, left, block):
        moving = rng.integers(-1, 2, (2, block, n)) * (rng.random((block, 1)) >= _STILL)
        q = rng.uniform(-1.0, 1.0, (block, n)) * np.where(turns, np.pi, _REACH)
        yield States(q, *moving.astype(float))


def largest_apart(
    program: Program, known: Program, is_revolute: Sequence[bool], closeness: float
) -> tuple[FloatArray, FloatArray]:
    """Largest difference of two programs and the largest magnitude of the known one, by joint, (n,) each.

    Infinite if the program cannot be a torque, see `telling_states`, or cancels so much that a term could
    hide in its rounding.
    """
    apart, size = (np.zeros(len(known.outputs)) for _ in range(2))
    batches: list[Batch] = []
    with np.errstate(all="ignore"), suppress(ModelError):
        for states in telling_states((program, known), is_revolute, closeness):
            batches = batches or [Batch(one, len(states)) for one in (program, known)]
            inputs = inputs_of(states)
            found, torque = (batch.at(inputs) for batch in batches)
            apart = np.maximum(apart, np.abs(found - torque).max(axis=1))
            size = np.maximum(size, np.abs(torque).max(axis=1))
        unit = np.ones(len(is_revolute))
        lost = np.finfo(float).eps * magnitudes(program, np.pi * unit, unit, unit)
        return np.where(lost > _LOST * size, np.inf, apart), size
    return np.full_like(apart, np.inf), size


def states_needed(
    degrees: Sequence[int] | FloatArray, is_revolute: Sequence[bool], closeness: float
) -> float:
    """Number of states that find a difference of `FOUND` with the stated probability."""
    acting = [(int(d), turns) for d, turns in zip(degrees, is_revolute, strict=True) if d]
    shown = _SHOWN
    for d, turns in acting:
        part = math.acosh((_SHARE * FOUND / closeness) ** (1 / len(acting))) / d
        shown *= 2 / math.pi * math.acos(1 / math.cosh(part / 2)) if turns else math.tanh(part / 2) ** 2
    return -math.log(ODDS) / shown
