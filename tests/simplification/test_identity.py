"""Programs that compute something else somewhere are found out, wherever they hide it."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from chains import generic_chain
from gd_analyze import cache
from gd_analyze.errors import ModelError
from gd_analyze.harmonics.identity import (
    LEAST_DIFFERENCE,
    formal_degrees,
    largest_difference,
    states_needed,
    telling_states,
)
from gd_analyze.operations.program import Program, plain_program
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification import exact
from gd_analyze.simplification.kept_program import kept_programs
from gd_analyze.types import ExactForm, States
from strategies import arms, examples

TURNS = [True] * 7


def program_of(make) -> Program:
    trace = Trace()
    q, qd, qdd = (trace.inputs(name, 7)[:, 0] for name in ("q", "qd", "qdd"))
    return Program.of(trace, [make(q, qd, qdd)])


def bump(q, centre, doublings):
    """Product of (1 + cos(q - centre))/2, squared so often: 1 at the centre, less elsewhere."""
    product = 1.0
    for angle, own in zip(q, centre, strict=True):
        product = product * (0.5 + 0.5 * np.cos(angle - own))
    for _ in range(doublings):
        product = product * product
    return product


@examples(60)
@given(st.integers(1, 6), st.floats(1e-6, 0.9), st.integers(0, 2**32 - 1))
def test_a_trigonometric_polynomial_is_large_on_as_much_of_the_circle_as_stated(degree, share, seed):
    """The least share is that of powers of cosines moved to [-1, 1]; of any other there is more."""
    rng, angle = np.random.default_rng(seed), np.linspace(0.0, 2 * np.pi, 4001)
    numbers = rng.normal(size=(2, degree + 1)) * rng.random((2, degree + 1)) ** 4
    orders = np.arange(degree + 1)[:, None]
    least = 2 / np.pi * np.arccos(1 / np.cosh(np.arccosh(1 / share) / (2 * degree)))
    cut = least * np.pi  # half of the arc that Chebyshev's polynomial leaves
    lifted = (2 * np.cos(angle) + 1 - np.cos(cut)) / (1 + np.cos(cut))
    for values, exactly in (
        (numbers[0] @ np.cos(orders * angle) + numbers[1] @ np.sin(orders * angle), False),
        (np.cosh(degree * np.arccosh(np.maximum(lifted, 1.0))) * (lifted > 1.0), True),
    ):
        found = np.mean(np.abs(values) > share * np.abs(values).max())
        # Of the grid, two points at each of 4 degree crossings may be on the other side.
        assert found >= least - 8 * degree / 4001
        if exactly:
            assert found <= least + 8 * degree / 4001


def test_more_states_for_higher_degrees_and_looser_comparison():
    counts = [states_needed([degree] * 4, TURNS[:4], 1e-10) for degree in range(7)]
    assert counts == sorted(counts)
    assert counts[0] < 200
    assert states_needed([3] * 4, TURNS[:4], 1e-8) > counts[3]
    assert len(next(telling_states([program_of(lambda q, qd, qdd: np.cos(q[0]))], TURNS, 1e-10))) < 8192


@examples(20)
@given(arms(max_joints=4))
def test_degrees_bound_those_of_any_arm(arm):
    """D has degree 2 in every joint's variable; the recursion may have more before terms cancel."""
    program = ExactForm(arm).recursion
    degrees = formal_degrees(program, arm.is_revolute)
    assert degrees.max(initial=0) <= 4
    apart, size = largest_difference(program, program, arm.is_revolute, 1e-10)
    assert not apart.any()
    assert len(size) == arm.n_joints


@pytest.mark.parametrize(
    "make",
    [
        lambda q, qd, qdd: qd[0] * qd[1] * qd[2],
        lambda q, qd, qdd: qdd[0] * qd[1],
        lambda q, qd, qdd: q[0] * qd[1],
        lambda q, qd, qdd: q[0] + qd[1] * qd[1],
        lambda q, qd, qdd: q[0],
        lambda q, qd, qdd: np.cos(q[0] + np.sin(q[1])),
        lambda q, qd, qdd: np.cos(q[0] + q[0] + q[0] + q[0] + q[0] + q[0] + q[0]),
        lambda q, qd, qdd: bump(q, [0.1] * 7, 13),
    ],
)
def test_what_can_be_no_torque_is_refused(make):
    with pytest.raises(ModelError) as caught:
        formal_degrees(program_of(make), TURNS)
    assert caught.value.details["where"] == "program"


@pytest.mark.parametrize(
    "moving", [lambda qd, qdd: 1.0, lambda qd, qdd: qdd[5], lambda qd, qdd: qd[2] * qd[5]]
)
def test_the_highest_bump_of_a_low_degree_is_found(moving):
    """Of an arm of six joints, as large as a thousandth of its torque at one state, nothing 3 rad away."""
    arm = generic_chain(6)
    known = ExactForm(arm).recursion
    size = largest_difference(known, known, arm.is_revolute, 1e-10)[1]
    trace, centre = Trace(), np.random.default_rng().uniform(-math.pi, math.pi, 6)
    q, qd, qdd = (trace.inputs(name, 6)[:, 0] for name in ("q", "qd", "qdd"))
    value = known.folded(trace, {})
    hidden = LEAST_DIFFERENCE * size[3] * moving(qd, qdd) * bump(q, centre, 1)
    forged = Program.of(trace, [value(x) + hidden * (i == 3) for i, x in enumerate(known.outputs)])
    apart, _ = largest_difference(forged, known, arm.is_revolute, 1e-10)
    assert apart[3] > 1e-10 * size[3]
    assert not np.delete(apart, 3).any()


def test_a_forged_entry_of_the_cache_is_written_anew(two_link, tmp_path, monkeypatch):
    """Nothing is wrong at the states that earlier versions looked at, nor in the number of operations."""
    arm = replace(two_link, name="another")  # whose program is not shipped
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    kept_programs.cache_clear()
    honest = ExactForm(arm).program
    (entry,) = tmp_path.iterdir()
    name = entry.name.removesuffix(".gd.json")
    assert cache.kept(name) == json.loads(json.dumps([plain_program(honest)]))
    trace = Trace()
    q2 = trace.inputs("q", 2)[1, 0]
    value, wave = honest.folded(trace, {}), 1.0
    for known in np.random.default_rng(0).uniform(-3.0, 3.0, (3, 4, 2))[0, :2, 1]:
        wave = wave * np.sin(q2 - float(known))
    forged = Program.of(trace, [value(x) + 0.01 * wave for x in honest.outputs])
    for bad in (forged, program_of(lambda q, qd, qdd: 0.0 * q[0] + qd[0] * qd[1] * qd[2])):
        cache.keep(name, [plain_program(bad)])
        kept_programs.cache_clear()
        again = ExactForm(arm).program
        assert plain_program(again) == plain_program(honest)
        assert cache.kept(name) == json.loads(json.dumps([plain_program(honest)]))
    # One that computes the same in more operations than the recursion would make savings look larger.
    trace = Trace()
    value, spare = honest.folded(trace, {}), 0.0
    for k, input_ in enumerate(trace.inputs("q", 2)[:, 0]):
        for j in range(60):
            spare = spare + np.sin(input_ + (1.0 + j + 100.0 * k))
    cache.keep(name, [plain_program(Program.of(trace, [value(x) + 1e-30 * spare for x in honest.outputs]))])
    kept_programs.cache_clear()
    assert ExactForm(arm).program.count == honest.count


@pytest.mark.slow
def test_models_are_not_kept(puma, tmp_path, monkeypatch):
    """The cache holds exact programs alone, which the shipped arm needs none of."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    states = gd.tables.states_in_box(puma, 50)
    assert gd.simplify(puma, states, "20%").saves
    assert not list(tmp_path.iterdir())


def test_states_are_new_each_time():
    program = program_of(lambda q, qd, qdd: np.cos(q[0]))
    first, second = (next(telling_states([program], TURNS, 1e-10)) for _ in range(2))
    assert isinstance(first, States)
    assert not (first.q == second.q).any()
    assert exact.REWRITTEN < LEAST_DIFFERENCE
