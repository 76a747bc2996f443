"""Formulations compared: counts of the code that runs, measured agreement, and what is shown of both."""

from __future__ import annotations

import dataclasses
import json
import sys

import numpy as np
import pytest
import sympy
from hypothesis import given

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.studies import formulations as module
from gd_analyze.studies.formulations import agreement, count_cost, formulations_compared
from gd_analyze.studies.symbolic import same, text_closed_forms, two_link_closed_forms
from gd_analyze.tables import states_in_box
from gd_analyze.types import ExactForm
from long_cases import long_but
from strategies import arms_with_states, examples


@examples(5)
@given(arms_with_states(max_joints=4, count=3))
def test_what_is_counted_is_the_torque(drawn):
    """The folded program, run on numbers, is the method: folding must not change a value."""
    arm, states = drawn
    n = arm.n_joints
    q, qd, qdd = states.last
    states = {"q": q, "qd": qd, "qdd": qdd}
    inputs = {f"{name}{i + 1}": row for name, rows in states.items() for i, row in enumerate(rows)}
    for method in METHODS.values():
        trace = Trace()
        traced = method.torque(arm, *(trace.inputs(name, n) for name in states))
        program = Program.of(trace, list(traced[:, 0]))
        assert count_cost(method, arm).folded == program.count
        wanted = method.torque(arm, q, qd, qdd)
        # Folding reorders sums of some 1000 terms no larger than the torques of this arm's worst joint
        # by a small factor (levers cancel): 1e-11 of it is 5e4 roundings.
        np.testing.assert_allclose(program.run(inputs), wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


def test_a_wrong_formulation_is_noticed(two_link):
    assert agreement(two_link, states_in_box(two_link, 20)).holds
    right = METHODS["newton_euler_link"]

    def wrong_torque(*words, **rest):
        return right.torque(*words, **rest) * (1 + 1e-9)

    def wrong_dynamics(*words):
        given = right.dynamics(*words)
        return dataclasses.replace(given, inertia=given.inertia * (1 + 1e-9))

    for wrong in ({"torque": wrong_torque}, {"dynamics": wrong_dynamics}):
        methods = METHODS | {"newton_euler_link": dataclasses.replace(right, **wrong)}
        found = agreement(two_link, states_in_box(two_link, 20), methods=methods)
        assert not found.holds
        worst = max(found.from_pinocchio, key=lambda name: max(found.from_pinocchio[name].values()))
        assert worst == "newton_euler_link"


def test_the_result_holds_everything(two_link, swing, monkeypatch):
    told = json.loads(json.dumps(formulations_compared(two_link, swing).values(), allow_nan=False))
    methods, differences = told["methods"], told["from_pinocchio"]
    assert [row["name"] for row in methods] == [row["name"] for row in differences[:-1]] == list(METHODS)
    for row in methods:
        assert row["executed"] == dataclasses.asdict(count_cost(METHODS[row["name"]], two_link).executed)
    largest = max(row["torque"] for row in differences[:-1])
    assert told["agrees"]
    assert largest <= told["largest_difference"] <= differences[-1]["torque"]
    assert told["operations_full"] == dataclasses.asdict(ExactForm(two_link).operations)
    found = agreement(two_link, states_in_box(two_link, 20))
    apart = dataclasses.replace(found, bounds=dict.fromkeys(found.bounds, 0.0))
    monkeypatch.setattr(module, "agreement", lambda *_, **__: apart)
    disagreeing = formulations_compared(two_link)
    assert not disagreeing.values()["agrees"]
    assert "DISAGREE" in disagreeing.headline


@pytest.mark.parametrize("method", long_but(("generalized_dalembert",), METHODS))
def test_every_formulation_gives_the_texts_closed_forms_exactly(method):
    found, text = two_link_closed_forms(method), text_closed_forms()
    for ours, theirs in zip(found, text, strict=True):
        assert (ours - theirs).applyfunc(sympy.simplify).is_zero_matrix
        assert not ours.atoms(sympy.Float)


def test_the_text_is_the_built_in_arm(two_link):
    """The closed forms with the arm's numbers put in are its numeric dynamics."""
    arm = two_link
    q, qd = np.array([[0.3], [-0.8]]), np.array([[1.2], [0.7]])
    numeric = METHODS["composite_moments"].dynamics(arm, q, qd)
    values = dict(zip(("theta1", "theta2", "thetad1", "thetad2"), (*q[:, 0], *qd[:, 0]), strict=True))
    values |= {"m1": arm.mass[0], "m2": arm.mass[1], "l": arm.dh_table[0].a, "g": -arm.gravity_vector[1]}
    text = text_closed_forms()
    assert same(text, text)
    assert not same(text._replace(gravity_loading=2 * text.gravity_loading), text)
    parts = (numeric.inertia[..., 0], numeric.coriolis_centrifugal, numeric.gravity_loading)
    for wanted, found in zip(text, parts, strict=True):
        numbers = {symbol: values[symbol.name] for symbol in wanted.free_symbols}
        expected = np.array(wanted.subs(numbers).tolist(), dtype=float)
        # Some twenty roundings of numbers no larger than the largest element.
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.abs(expected).max())


def test_symbols_need_sympy(monkeypatch):
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(UsageError, match="pip install sympy"):
        text_closed_forms()
