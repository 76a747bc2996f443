"""Models whose budget is proven for a whole box: no state in it breaks it, drawn or found."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from budgets import of_shares
from gd_analyze.certification.box import Box
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.simplify import simplify
from gd_analyze.simplification.term import TERM
from strategies import arms_with_states, examples


def largest_errors(model, box: Box, count: int, seed: int) -> np.ndarray:
    """Largest error per joint over states drawn from a box, half of them at its corners."""
    rng = np.random.default_rng(seed)
    n = box.n_joints
    q = rng.uniform(box.lower, box.upper, (count, n))
    signs = rng.choice([-1.0, 1.0], (2, count, n))
    size = np.where(rng.random((count, 1)) < 0.5, 1.0, rng.random((count, n)))
    qd, qdd = signs[0] * size * box.velocity, signs[1] * size * box.acceleration
    exact = decompose_states(model.arm, States(q, qd, qdd), christoffel=False, drives=model.drives)["torque"]
    return np.abs(model.torque(q, qd, qdd) - exact).max(axis=0)


@examples(8)
@given(
    arms_with_states(max_joints=2, count=15, massive=True),
    st.floats(0.02, 0.3),
    st.sampled_from([TERM, ENERGY]),
    st.integers(0, 2**32 - 1),
)
def test_no_state_of_the_box_breaks_the_budget(case, share, level, seed):
    arm, drawn = case
    states = States(drawn.q, drawn.qd, drawn.qdd, {"box": "drawn", "states": 15, "seed": 0})
    box = Box.around(*states.arrays)
    exact = ExactDynamics.of(arm, states)
    budget = of_shares(share)
    model, certificate = simplify_certified(exact, budget, box, level=level)
    allowed = exact.allowed(budget)
    assert (certificate.certified <= allowed).all()
    # Two programs of the same torque: round-off, far below what a budget of 2 % of the peak leaves unsaid.
    slack = 1e-10 * exact.peak_torque.max()
    assert (largest_errors(model, box, 400, seed) <= certificate.certified + slack).all()
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    np.testing.assert_array_equal(model.accuracy.allowed, allowed)


def test_along_a_trajectory(puma, pick_and_place):
    """A budget held at the set points only is broken between their extremes; a certified one is not."""
    exact = ExactDynamics.of(puma, pick_and_place, drives=True)
    box = Box.around(*exact.states.arrays)
    sampled = simplify(puma, pick_and_place, Budget.parse("2%"), level="energy", drives=True)
    assert (gd.certify(sampled, box).certified > sampled.accuracy.allowed).any()
    rounds: list[int] = []
    model, certificate = simplify_certified(
        exact, Budget.parse("2%"), box, level=ENERGY, progress=rounds.append
    )
    assert certificate.within(model.accuracy.allowed).all()
    assert len(rounds) > 1
    assert model.operations.total >= sampled.operations.total
    assert model.accuracy.budget == "2%, certified"
    assert model.accuracy.fitted_on["set_points"] == 31


def test_a_budget_below_what_a_bound_can_resolve(two_link, swing):
    """No budget at all cannot be proven: the identification's noise is in every bound."""
    exact = ExactDynamics.of(two_link, swing)
    with pytest.raises(UsageError, match="not even the exact model"):
        simplify_certified(exact, of_shares(0.0), Box.around(*exact.states.arrays))


def test_levels_and_steps_are_told_of_the_certified_model(two_link, swing, monkeypatch):
    monkeypatch.setattr("gd_analyze.simplification.simplify._FEW_JOINTS", 0)
    monkeypatch.setattr("gd_analyze.simplification.simplify._FEW", 0.0)
    exact = ExactDynamics.of(two_link, swing)
    box = Box.around(*exact.states.arrays)
    model, _ = simplify_certified(exact, "60%", box, effort=0.01)
    counts = {one.level: one.operations for one in model.accuracy.levels}
    assert counts.pop(model.level.name) == model.operations.total
    assert list(counts.values()) == [None]
    (why,) = (one.why for one in model.accuracy.levels if one.operations is None)
    assert why.startswith("without a proof it took ")
    assert model.accuracy.steps[-1].operations == model.operations.total
