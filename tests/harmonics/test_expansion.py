"""Programs written out: what they compute, how far the numbers are off, and what is no torque."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.expansion import Expansion, expanded, expansion_factors
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.torque_program import COUNTING, ROUGH
from gd_analyze.types import LEVELS, ExactForm, RobotArm
from strategies import arms, examples, random_states


def torque_of(expansion: Expansion, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """Value of what was written out, shape (N, n)."""
    sources = {"1": qd, "qd": qd, "qdd": qdd}
    factors = [np.prod(sources[kind][:, list(js)], axis=1) for kind, js in expansion_factors(q.shape[1])]
    return np.stack([(row(q.T) * factors).sum(axis=0) for row in expansion.rows], axis=1)


def slides(arm: RobotArm) -> list[bool]:
    return [not turns for turns in arm.is_revolute]


@pytest.mark.parametrize("level", LEVELS.values(), ids=str)
@pytest.mark.parametrize("effort", [ROUGH, COUNTING])
@examples(3)
@given(arm=arms(max_joints=4), seed=st.integers(0, 2**32 - 1))
def test_it_is_what_the_program_computes(arm, seed, level, effort):
    form = ExactForm(arm)
    program = level.write(form, level.terms(form), effort)
    expansion = expanded(program, slides(arm))
    states = random_states(arm.n_joints, 40, seed)
    apart = np.abs(torque_of(expansion, *states.arrays) - program.run(program_inputs(states)).T).max(axis=0)
    # The sum of harmonics itself is rounded, too: once per harmonic and some, which the bound for all
    # states of the program's own magnitudes covers many times over.
    limits = (np.abs(x).max(axis=0) for x in states.arrays)
    assert (apart <= 2 * expansion.round_off(*limits) + 1e-300).all()


def test_round_off_is_small(puma):
    """Some 1e-13 of the torque at unit velocities."""
    form = ExactForm(puma)
    expansion = expanded(form_program(form), slides(puma))
    one = np.ones(6)
    sizes = np.array([np.abs(row.coefficients).sum() for row in expansion.rows])
    assert (expansion.round_off(one, one, one) <= 1e-12 * sizes).all()
    assert (expansion.round_off(one, one, one) > 0.0).all()


def form_program(form: ExactForm) -> Program:
    return LEVELS["term"].write(form, LEVELS["term"].terms(form), ROUGH)


def test_what_cancels_is_gone(puma):
    """Parts of elements turn vectors to and fro: of squares of sines and cosines ones are left."""
    form = ExactForm(puma)
    known = expanded(form_program(form), slides(puma))
    parts = expanded(ELEMENT.write(form, ELEMENT.terms(form), ROUGH), slides(puma))
    one = np.ones(6)
    noise = parts.round_off(one, one, one) + known.round_off(one, one, one)
    for row, other, off in zip(known.rows, parts.rows, noise, strict=True):
        assert np.abs((row + -1.0 * other).coefficients).max() <= off


def of(make: Callable[[Any, Any, Any], Any]) -> Program:
    """A program of one output, of two revolute joints and a prismatic one."""
    trace = Trace()
    q, qd, qdd = (trace.inputs(name, 3)[:, 0] for name in ("q", "qd", "qdd"))
    return Program.of(trace, [make(q, qd, qdd)])


SLIDING = [False, False, True]


def test_a_sum_of_angles_is_one_harmonic():
    expansion = expanded(of(lambda q, qd, qdd: np.cos(q[0] - q[1] + q[0]) * q[2] * qd[0] * qd[1]), SLIDING)
    (row,) = expansion.rows
    assert row.multiples.tolist() == [[2, -1, 1]]
    place = expansion_factors(3).index(("qd", (0, 1)))
    assert row.coefficients[place].tolist() == [1.0]
    assert np.count_nonzero(row.coefficients) == 1


def test_what_is_zero_everywhere_is_nothing():
    one = of(lambda q, qd, qdd: np.sin(q[0]) * np.sin(q[0]) + np.cos(q[0]) * np.cos(q[0]) - 1.0)
    nothing = expanded(one, SLIDING)
    assert np.abs(nothing.rows[0].coefficients).max(initial=0.0) == 0.0


def power(x: Any, exponent: int) -> Any:
    for _ in range(exponent.bit_length() - 1):
        x = x * x
    return x


NO_TORQUE = {
    "an angle": (lambda q, qd, qdd: q[0], "an angle outside"),
    "an angle to a power": (lambda q, qd, qdd: qdd[0] + power(q[0], 4096), "an angle outside"),
    "an angle and a velocity": (lambda q, qd, qdd: np.cos(q[0] + qd[0]), "an angle"),
    "a sine of a sine": (lambda q, qd, qdd: np.sin(np.sin(q[0])), "other than a sum of angles"),
    "a sine of a prismatic joint": (lambda q, qd, qdd: np.sin(q[2]), "other than a sum of angles"),
    "half an angle": (lambda q, qd, qdd: np.cos(0.5 * q[0]), "an angle outside"),
    "a prismatic joint to a power": (lambda q, qd, qdd: power(q[2], 4096), "degree in q3"),
    "a cosine to a power": (lambda q, qd, qdd: power(np.cos(q[1]), 4096), "degree in q2"),
    "a cosine of many turns": (lambda q, qd, qdd: np.cos(sum([q[0]] * 7)), "degree in q1"),
    "a cube of a velocity": (lambda q, qd, qdd: qd[0] * qd[1] * qd[0], "more than two velocities"),
    "an acceleration times a velocity": (lambda q, qd, qdd: qdd[0] * qd[0], "more than two velocities"),
    "numbers beyond any": (lambda q, qd, qdd: 1e300 * (1e300 * np.cos(q[0])), "overflow"),
    "linear in a velocity": (lambda q, qd, qdd: np.cos(q[0]) * qd[0], "linear in a velocity"),
}


@pytest.mark.parametrize(("make", "told"), NO_TORQUE.values(), ids=NO_TORQUE.keys())
def test_what_is_no_torque_is_refused(make, told):
    with pytest.raises(ModelError) as caught:
        expanded(of(make), SLIDING)
    assert caught.value.details["where"] == "program"
    assert told in str(caught.value)
    assert caught.value.details["next"]


def test_what_is_too_long_to_be_written_out_is_refused():
    """Each factor doubles the terms of the product, and there are eight of eight joints."""
    trace = Trace()
    q = trace.inputs("q", 8)[:, 0]
    value: Any = 1.0
    for _ in range(4):
        for x in q:
            value = value * (1.0 + np.cos(x) + 0.5 * np.sin(x))
    with pytest.raises(ModelError) as caught:
        expanded(Program.of(trace, [value]), [False] * 8)
    assert "terms" in caught.value.details["expected"]
