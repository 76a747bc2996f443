"""Counts: of the code that runs, complete, and of the order that the equations have."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.studies.costs import count_cost, exponent
from strategies import arms_with_states, examples

ORDERS = {"n": 1, "n^2": 2, "n^3": 3, "n^4": 4}


@examples(8)
@given(arms_with_states(max_joints=4, count=3))
def test_what_is_counted_is_the_torque(drawn):
    """The folded program, run on numbers, is the method: folding must not change a value."""
    arm, states = drawn
    n = arm.n_joints
    q, qd, qdd = states.last
    inputs = {
        f"{name}{i + 1}": values[i] for name, values in (("q", q), ("qd", qd), ("qdd", qdd)) for i in range(n)
    }
    for method in METHODS.values():
        trace = Trace()
        symbols = (trace.inputs(name, n) for name in ("q", "qd", "qdd"))
        traced = method.torque(arm, *symbols)
        program = Program.of(trace, list(traced[:, 0]))
        assert count_cost(method, arm).folded == program.count
        wanted = method.torque(arm, q, qd, qdd)
        # Folding reorders sums of some 1000 terms no larger than the torques of this arm's worst joint
        # by a small factor (levers cancel): 1e-11 of it is 5e4 roundings.
        np.testing.assert_allclose(program.run(inputs), wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize("name", list(METHODS))
def test_the_order_is_that_of_the_equations(grown, name):
    """Exactly: from three joints on the counts are polynomials, and their degree is the stated order."""
    multiplications, additions = grown.polynomials[name]
    order = ORDERS[METHODS[name].growth]
    assert len(multiplications.coefficients) - 1 == order
    assert len(additions.coefficients) - 1 == order
    for n, cost in zip(grown.sizes, grown.costs[name], strict=True):
        if n >= 3:
            assert multiplications(n) == cost.executed.multiplications
            assert additions(n) == cost.executed.additions


def test_folding_only_saves(grown):
    for costs in grown.costs.values():
        for cost in costs:
            assert cost.folded.multiplications <= cost.executed.multiplications
            assert cost.folded.additions <= cost.executed.additions
            assert cost.folded.sines_cosines <= cost.executed.sines_cosines


def test_recursions_win_in_the_end(grown):
    last = {name: costs[-1].executed.total for name, costs in grown.costs.items()}
    assert last["newton_euler_link"] < last["newton_euler_base"] < last["recursive_lagrangian"]
    assert last["recursive_lagrangian"] < last["composite_moments"]
    assert last["composite_moments"] < last["generalized_dalembert"] < last["lagrange_euler"]


def test_the_slope_of_a_power_is_its_exponent():
    # Seven logarithms fitted by a straight line: some tens of roundings.
    assert exponent([6, 8, 12], [6**3, 8**3, 12**3]) == pytest.approx(3, rel=1e-13)
