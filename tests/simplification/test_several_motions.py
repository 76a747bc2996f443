"""One model for several motions: within the budget of each, ranked over all and along each, and stored."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from few_tries import few_tries
from gd_analyze import Trajectory, load_model, save_model
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.model_torque import model_torque
from recordings import swung
from strategies import arms_with_states, examples, random_states

# Allowed errors and shares of them are quotients, rounded once or twice.
ROUNDED = 1.0 + 4 * float(np.finfo(float).eps)

SLOW, FAST = swung(20.0, "slow"), swung(2.2, "fast")


def other_motion(arm, seed: int) -> Trajectory:
    states = random_states(arm.n_joints, 12, seed)
    # A tenth of the velocities and a hundredth of the accelerations: a slow one beside whatever the first is.
    return Trajectory(0.1 * np.arange(12), states.q, 0.1 * states.qd, 0.01 * states.qdd, "other")


@pytest.mark.slow
def test_the_shipped_motions_of_the_puma(puma):
    """The budget is nearly used up along each, and kept."""
    names = ["pick-and-place", "large-slew", "wrist-move"]
    model = gd.simplify(puma, names, "1%", level="term")
    assert model.saves
    for name, stated in zip(names, model.accuracy.motions, strict=True):
        found = model_torque(model, gd.read_trajectory(name, puma))
        assert (found.errors.largest <= ROUNDED * stated.allowed).all()
        scale = model.accuracy.allowed / gd.types.ExactDynamics.of(puma, names).allowed("1%")
        assert (found.errors.largest <= ROUNDED * scale * found.dynamics.allowed("1%")).all()
        assert (found.errors.largest > 0.3 * stated.allowed).any()


@pytest.mark.parametrize("budget", ["0.1%", "40%", "5% or 0.5", "0.3"])
@pytest.mark.parametrize("level", ["term", "energy"])
@examples(2)
@given(drawn=arms_with_states(max_joints=3, count=12, massive=True), seed=st.integers(0, 2**32 - 1))
@few_tries()
def test_the_model_is_within_the_budget_of_each(drawn, seed, budget, level):
    arm, states = drawn
    both = [Trajectory(0.1 * np.arange(12), *states.arrays, "first"), other_motion(arm, seed)]
    model = gd.simplify(arm, both, budget, level=level)
    for motion, stated in zip(both, model.accuracy.motions, strict=True):
        found = model_torque(model, motion)
        exact = found.dynamics
        needs = exact.peak_torque > 0.0
        np.testing.assert_allclose(stated.allowed[needs], exact.allowed(budget)[needs], rtol=1e-14)
        assert (found.errors.largest[needs] <= ROUNDED * exact.allowed(budget)[needs]).all()
        np.testing.assert_array_equal(stated.errors.peak_torque, exact.peak_torque)
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()


def test_a_budget_by_the_slow_motion_counts_for_the_slow_motion_only(two_link):
    """It would otherwise have to hold along the fast one, where torques are many times larger."""
    exact = gd.types.ExactDynamics.of(two_link, [SLOW, FAST])
    both = gd.simplify(two_link, [SLOW, FAST], "20%")
    least = gd.types.Budget.of_torques(np.min([one.allowed for one in both.accuracy.motions], axis=0))
    assert both.operations.total <= gd.simplify(two_link, [SLOW, FAST], least).operations.total
    np.testing.assert_array_equal(both.accuracy.allowed, exact.allowed("20%"))
    assert (both.accuracy.allowed >= [one.allowed for one in both.accuracy.motions]).all()


def test_a_joint_that_needs_no_torque_along_one_motion_is_as_free_as_along_the_other(two_link):
    """A share of nothing is nothing, and would forbid to drop anything."""
    flat = dataclasses.replace(two_link, gravity_vector=np.zeros(3))
    rest = Trajectory([0.0, 1.0], *np.zeros((3, 2, 2)), "rest")
    model = gd.simplify(flat, [rest, FAST], "20%")
    at_rest, _ = model.accuracy.motions
    np.testing.assert_array_equal(at_rest.allowed, model.accuracy.allowed)
    assert model.operations.total == gd.simplify(flat, FAST, "20%").operations.total


def test_it_comes_back_from_its_file(two_link, tmp_path):
    model = gd.simplify(two_link, [SLOW, FAST], level="element")
    save_model(model, tmp_path / "model.json")
    save_model(load_model(tmp_path / "model.json"), tmp_path / "again.json")
    assert (tmp_path / "again.json").read_text() == (tmp_path / "model.json").read_text()
    read = load_model(tmp_path / "model.json").accuracy
    assert read.fitted_on == model.accuracy.fitted_on
    assert read.fitted_on["motions"] == "slow, fast"
    for motion, own in zip((SLOW, FAST), model.accuracy.motions, strict=True):
        along = read.along(motion.fingerprint)
        assert (along.fitted_on["trajectory"], along.motions) == (motion.name, ())
        np.testing.assert_array_equal(along.allowed, own.allowed)
        np.testing.assert_array_equal(along.errors.largest, own.errors.largest)
    assert read.along("of another") is read


def test_a_trade_off_is_within_every_budget(two_link):
    exact = gd.types.ExactDynamics.of(two_link, [SLOW, FAST])
    points = gd.trade_off(exact, "20%", factors=(1.0, 4.0), levels=(TERM, ENERGY))
    assert all(point.error_share <= 0.2 * point.factor * ROUNDED for point in points)
    whole = gd.simplify(two_link, [SLOW, FAST], "20%")
    asked = {point.level.name: point for point in points if point.factor == 1.0}
    assert asked["term"].operations == whole.operations
