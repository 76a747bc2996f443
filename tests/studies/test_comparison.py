"""Formulations compared: counts of the code that runs, measured agreement, and what is shown of both."""

from __future__ import annotations

import dataclasses
import itertools
import json
import sys
from fractions import Fraction

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import formulation_costs
from formulation_costs import (
    N_JOINTS,
    Polynomial,
    exact_polynomial,
    explanation,
    text_costs,
)
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.studies import comparison as module
from gd_analyze.studies.comparison import agreement, comparison, count_cost
from gd_analyze.studies.symbolic import same, text_closed_forms, two_link_closed_forms
from gd_analyze.tables import states_in_box
from long_cases import long_but
from strategies import arms_with_states, examples

ORDERS = {"n": 1, "n^2": 2, "n^3": 3, "n^4": 4}


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


@pytest.mark.parametrize("name", list(METHODS))
def test_the_order_is_that_of_the_equations_and_folding_only_saves(grown, name):
    """Exactly: from three joints on the counts are polynomials, and their degree is the stated order."""
    multiplications, additions = grown.polynomials[name]
    order = ORDERS[METHODS[name].growth]
    assert len(multiplications.coefficients) - 1 == len(additions.coefficients) - 1 == order
    for n, cost in zip(formulation_costs.SIZES, grown.costs[name], strict=True):
        if n >= 3:
            assert multiplications(n) == cost.executed.multiplications
            assert additions(n) == cost.executed.additions
        pairs = zip(dataclasses.astuple(cost.folded), dataclasses.astuple(cost.executed), strict=True)
        assert all(folded <= executed for folded, executed in pairs)


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
    told = json.loads(json.dumps(comparison(two_link, swing).document(), allow_nan=False))
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
    disagreeing = comparison(two_link)
    assert not disagreeing.document()["agrees"]
    assert "DISAGREE" in disagreeing.headline


def test_the_traces_of_lagrange_euler_are_as_told(grown):
    """One per h_ikm or D_ik and link in ours; in the text one per link and pair for D, n times that for h."""
    n, sentence = N_JOINTS, explanation("lagrange_euler", grown)
    assert f"takes {sum(j**2 + j**3 for j in range(1, n + 1))} traces" in sentence
    assert f"each of its {n * (n + 1) ** 2 * (n + 2) // 6} traces" in sentence


def test_counts_the_text_prints_and_rows_that_add_up():
    for table, method in (("3.1", "lagrange_euler"), ("3.4", "newton_euler_link")):
        rows, total = [x for x in text_costs().rows if x.table == table], text_costs().of(method, table)
        for n in range(1, 13):  # twelve values fix polynomials of the fourth degree
            assert sum(row.multiplications(n) for row in rows) == total.multiplications(n)
            assert sum(row.additions(n) for row in rows) == total.additions(n)
    dalembert = text_costs().of("generalized_dalembert")
    assert (dalembert.multiplications(6), dalembert.additions(6)) == (2963, 2209)
    assert "reconstructed" in dalembert.remark
    for cost in text_costs().totals:
        assert cost.name in METHODS
        assert all(cost.at(n).total > 0 for n in range(1, 13))
    rows = {row.name: row for row in text_costs().rows if row.table == "3.1"}
    for n, (name, times) in itertools.product(range(1, 13), (("jk", 0), ("jkm", 1))):
        # A trace is four products of 4x4 matrices.
        row, traces = rows[f"Tr(U_{name} J_j U_ji^T)"], n**times * n * (n + 1) * (n + 2) // 6
        assert (row.multiplications(n), row.additions(n)) == (256 * traces, (4 * 48 + 3) * traces)


@examples(30)
@given(
    st.lists(st.fractions(-50, 50, max_denominator=6), min_size=1, max_size=5).filter(lambda c: c[-1] != 0)
)
def test_a_polynomial_is_found_from_its_values(coefficients):
    sizes = range(3, 13)
    # Denominators up to 6: sixty times the values are whole, as counts are.
    values = [int(60 * sum(c * n**k for k, c in enumerate(coefficients))) for n in sizes]
    assert exact_polynomial(sizes, values).coefficients == tuple(60 * c for c in coefficients)
    values[4] += 1
    assert exact_polynomial(sizes, values) is None
    assert str(Polynomial((Fraction(-7), Fraction(), Fraction(128, 3)))) == "128/3 n^2 - 7"


@pytest.mark.parametrize("method", long_but(("generalized_dalembert", "lagrange_euler"), METHODS))
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
    values |= {"m1": arm.mass[0], "m2": arm.mass[1], "l": arm.dh_table[0].a, "g": -arm.gravity[1]}
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
