"""Models whose budget is proven: no state of the region breaks it, drawn or found."""

from __future__ import annotations

import numpy as np
import pytest
from attacks import drawn_motion, drawn_states, errors_at, largest_excess, round_off_in
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import UsageError
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, TERM
from strategies import arms, arms_with_states, examples


@examples(4)
@given(
    arms_with_states(max_joints=2, count=15, massive=True),
    st.integers(2, 30),
    st.sampled_from([TERM, ENERGY]),
    st.integers(0, 2**32 - 1),
)
def test_no_state_of_the_box_breaks_the_budget(case, percent, level, seed):
    arm, drawn = case
    states = gd.States(drawn.q, drawn.qd, drawn.qdd, {"box": "drawn", "states": 15, "seed": 0})
    box, budget = gd.Box.around(*states.arrays), gd.Budget.parse(f"{percent}%")
    exact = gd.ExactDynamics.of(arm, states)
    model, certificate = gd.simplify_certified(exact, budget, box, level=level)
    assert certificate.within(exact.allowed(budget)).all()
    attacked = drawn_states(box, 400, np.random.default_rng(seed))
    slack = 1e-10 * exact.peak_torque.max()
    assert (errors_at(model, *attacked).max(axis=0) <= certificate.certified + slack).all()
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    np.testing.assert_array_equal(model.accuracy.allowed, exact.allowed(budget))


@examples(4)
@given(arms(max_joints=2, massive=True), st.integers(2, 30), st.integers(0, 2**32 - 1))
def test_no_state_of_the_tube_breaks_the_budget(arm, percent, seed):
    rng = np.random.default_rng(seed)
    motion, budget = drawn_motion(arm, rng), gd.Budget.parse(f"{percent}%")
    exact = gd.ExactDynamics.of(arm, gd.States(motion.q, motion.qd, motion.qdd))
    if not exact.peak_torque.all():
        return
    tube = gd.Tube.along(arm, motion)
    model, certificate = gd.simplify_certified(exact, budget, tube)
    assert certificate.within(exact.allowed(budget)).all()
    assert largest_excess(model, tube, certificate.along, rng) <= round_off_in(model, tube)


@pytest.mark.parametrize("level", [TERM, ELEMENT])
def test_along_a_trajectory(puma, pick_and_place, level):
    exact, tube = gd.ExactDynamics.of(puma, pick_and_place, drives=True), gd.Tube.along(puma, pick_and_place)
    model, certificate = gd.simplify_certified(exact, "2%", tube, level=level)
    allowed = exact.allowed(gd.Budget.parse("2%"))
    assert certificate.region is tube
    assert certificate.within(allowed).all()
    bounds = np.broadcast_to(allowed, certificate.along.shape)
    assert largest_excess(model, tube, bounds, np.random.default_rng(2)) <= round_off_in(model, tube)
    assert model.accuracy.budget == "2%"
    stated = model.accuracy.certificate
    assert (stated.margin, stated.trajectory_fingerprint) == (str(gd.Margin()), pick_and_place.fingerprint)
    np.testing.assert_array_equal(stated.certified, certificate.certified)


def test_between_the_extremes_of_a_trajectory(puma, pick_and_place):
    """A budget kept at the set points only is broken between their extremes; a certified one is not."""
    exact = gd.ExactDynamics.of(puma, pick_and_place, drives=True)
    box = gd.Box.around(*exact.states.arrays)
    sampled = gd.simplify(puma, pick_and_place, "10%", level="term", drives=True, effort=0.1)
    assert not gd.certify(sampled, box).within(sampled.accuracy.allowed).all()
    rounds: list[int] = []
    options = {"level": TERM, "effort": 0.1, "progress": rounds.append}
    model, certificate = gd.simplify_certified(exact, "10%", box, **options)
    assert certificate.within(model.accuracy.allowed).all()
    assert 1 < len(rounds) <= 8
    assert model.operations.total >= sampled.operations.total
    assert model.accuracy.fitted_on["set_points"] == 31


def test_a_budget_below_what_a_bound_can_resolve_is_refused(two_link, swing):
    exact = gd.ExactDynamics.of(two_link, swing)
    with pytest.raises(UsageError, match="not even the exact model"):
        gd.simplify_certified(exact, "1e-13%", gd.Box.around(*exact.states.arrays))


def test_what_is_returned_and_stated_is_the_model_certified(two_link):
    """Program, operations by level and the search's last step; other levels had no proof."""
    exact, box = gd.ExactDynamics.of(two_link, gd.states_in_box(two_link, 300)), gd.Box.of(two_link)
    model, certificate = gd.simplify_certified(exact, "40%", box)
    assert gd.certify(model, box).certified.tolist() == certificate.certified.tolist()
    assert certificate.within(model.accuracy.allowed).all()
    counts = {one.level: one.operations for one in model.accuracy.levels}
    assert counts.pop(model.level.name) == model.operations.total
    assert set(counts.values()) <= {None}
    assert model.accuracy.steps[-1].operations == model.operations.total
