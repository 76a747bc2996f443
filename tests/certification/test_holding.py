"""Models that hold over a region: no state breaks their budget, drawn or found."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from attacks import (
    ascended,
    damaged,
    drawn_box,
    drawn_motion,
    drawn_states,
    errors_at,
    largest_excess,
    round_off_in,
)
from gd_analyze import pool
from gd_analyze.certification import falsification
from gd_analyze.certification.holding import simplify_held
from gd_analyze.errors import UsageError
from gd_analyze.motions.pool import taken_apart
from gd_analyze.result import Fact
from gd_analyze.results.simplified_result import simplified_result
from gd_analyze.simplification import simplify
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.search import SearchOptions, selected_terms
from gd_analyze.simplification.simplify import simplify_exact
from long_cases import long
from recordings import swung
from strategies import arms, arms_with_states, examples


@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
@examples(3)
@given(
    case=arms_with_states(max_joints=2, count=15, massive=True),
    percent=st.integers(2, 30),
    seed=st.integers(0, 2**32 - 1),
)
def test_no_state_of_the_box_breaks_the_budget(case, percent, level, seed):
    arm, drawn = case
    states = gd.types.States(drawn.q, drawn.qd, drawn.qdd, {"box": "drawn", "states": 15, "seed": 0})
    box, budget = gd.types.Box.around(*states.arrays), gd.types.Budget.parse(f"{percent}%")
    exact = gd.types.ExactDynamics.of(arm, states)
    model, certificate = simplify_held(exact, budget, box, SearchOptions(level), certified=True)[:2]
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
    motion, budget = drawn_motion(arm, rng), gd.types.Budget.parse(f"{percent}%")
    exact = gd.types.ExactDynamics.of(arm, gd.types.States(motion.q, motion.qd, motion.qdd))
    if not exact.peak_torque.all():
        return
    tube = gd.types.Tube.along(arm, motion)
    model, certificate = simplify_held(exact, budget, tube, certified=True)[:2]
    assert certificate.within(exact.allowed(budget)).all()
    assert largest_excess(model, tube, certificate.along, rng) <= round_off_in(model, tube)


@pytest.mark.parametrize("level", [TERM, long(ENERGY)])
def test_along_a_trajectory(puma, pick_and_place, level):
    exact, tube = (
        gd.types.ExactDynamics.of(puma, pick_and_place, drives=True),
        gd.types.Tube.along(puma, pick_and_place),
    )
    model, certificate = simplify_held(exact, "2%", tube, SearchOptions(level), certified=True)[:2]
    allowed = exact.allowed(gd.types.Budget.parse("2%"))
    assert certificate.region is tube
    assert certificate.within(allowed).all()
    bounds = np.broadcast_to(allowed, certificate.along.shape)
    assert largest_excess(model, tube, bounds, np.random.default_rng(2)) <= round_off_in(model, tube)
    assert model.accuracy.budget == "2%"
    stated = model.accuracy.certificate
    assert (stated.margin, stated.trajectory_fingerprint) == (
        str(gd.types.Margin()),
        pick_and_place.fingerprint,
    )
    np.testing.assert_array_equal(stated.certified, certificate.certified)


@pytest.mark.slow
def test_between_the_extremes_of_a_trajectory(puma, pick_and_place, monkeypatch):
    """A budget kept at the set points only is broken between their extremes; a certified one is not."""
    exact = gd.types.ExactDynamics.of(puma, pick_and_place, drives=True)
    box = gd.types.Box.around(*exact.states.arrays)
    sampled = gd.simplify(puma, pick_and_place, "10%", level="term", drives=True)
    assert not gd.certify(sampled, box).within(sampled.accuracy.allowed).all()
    rounds = []

    def searched(*arguments):
        rounds.append(selected_terms(*arguments))
        return rounds[-1]

    monkeypatch.setattr(simplify, "selected_terms", searched)
    options = SearchOptions(level=TERM, effort=0.1)
    held = simplify_held(exact, "10%", box, options, certified=True)
    model, certificate = held[:2]
    assert certificate.within(model.accuracy.allowed).all()
    assert 1 < len(rounds) <= 8
    assert model.operations.total >= sampled.operations.total
    assert model.accuracy.fitted_on["set_points"] == 31


def test_a_budget_below_what_a_bound_can_resolve_is_refused(two_link, swing):
    exact = gd.types.ExactDynamics.of(two_link, swing)
    with pytest.raises(UsageError, match="not even the exact model"):
        simplify_held(exact, "1e-13%", gd.types.Box.around(*exact.states.arrays), certified=True)


def test_what_is_returned_and_stated_is_the_model_certified(two_link):
    """Program, operations and the search's last step."""
    exact, box = (
        gd.types.ExactDynamics.of(two_link, gd.tables.states_in_box(two_link, 300)),
        gd.types.Box.of(two_link),
    )
    model, certificate = simplify_held(exact, "40%", box, certified=True)[:2]
    assert gd.certify(model, box).certified.tolist() == certificate.certified.tolist()
    assert certificate.within(model.accuracy.allowed).all()
    assert model.accuracy.steps[-1].operations == model.functions.operations.total


@pytest.mark.parametrize(
    ("name", "motion"), [("two_link", "two-link-swing"), long("puma560", "pick-and-place")]
)
def test_along_a_motion_the_budget_is_proven(name, motion):
    arm = gd.load_arm(name)
    tube = gd.types.Tube.along(arm, gd.read_trajectory(motion, arm))
    exact = gd.types.ExactDynamics.of(name, motion, drives=name == "puma560")
    budget = "2%" if name == "puma560" else "40%"
    held = simplify_held(exact, budget, tube, SearchOptions("term", effort=0.01))
    model, certificate = held.model, held.certificate
    assert model.saves
    assert held.tried == 0
    assert certificate.within(exact.allowed(budget)).all()
    assert model.accuracy.certificate.certified.tolist() == certificate.certified.tolist()
    bounds = np.broadcast_to(exact.allowed(budget), certificate.along.shape)
    assert largest_excess(model, tube, bounds, np.random.default_rng(2)) <= round_off_in(model, tube)


@pytest.mark.slow
def test_within_limits_an_ascent_finds_no_larger_error_than_is_stated(puma):
    """Fitted on 100 states alone, the budget is exceeded."""
    exact, box, rng = (
        gd.types.ExactDynamics.of(puma, gd.tables.states_in_box(puma, 100)),
        gd.types.Box.of(puma),
        np.random.default_rng(7),
    )
    quick = SearchOptions("term", thorough=False)
    held = simplify_held(exact, "5%", box, quick)
    allowed = exact.allowed("5%")
    assert held.model.saves
    assert (held.found <= allowed).all()
    # Both searches climb from the worst of many states, and end at the same maxima: measured, within 0.1 %.
    assert (ascended(held.model, box, rng, 2) <= 1.01 * held.found).all()
    assert (held.found >= 0.8 * allowed).any()
    assert (held.tried, held.tried_are, held.certificate) == (
        falsification.RANDOM_POSITIONS,
        "positions",
        None,
    )
    assert held.model.accuracy.fitted_on == exact.states.described
    sampled = simplify_exact(exact, "5%", quick)
    assert (ascended(sampled, box, rng, 1) > 1.05 * allowed).any()


def test_within_limits_level_energy_states_what_was_tried(two_link):
    """A model is its own witness: no error of the search's states, and none at its found ones, is larger."""
    exact, box = (
        gd.types.ExactDynamics.of(two_link, gd.tables.states_in_box(two_link, 300)),
        gd.types.Box.of(two_link),
    )
    held = simplify_held(exact, "40%", box, SearchOptions("energy", thorough=False))
    assert held.model.saves
    assert (held.model.accuracy.errors.largest <= held.found).all()
    assert (held.found <= exact.allowed("40%")).all()
    result = simplified_result(held, exact.states, 1.0, 3)
    assert ", found at 20 000 positions." in result.headline
    assert "at most" not in result.headline
    (shown,) = (fact.text for fact in result.facts if isinstance(fact, Fact) and fact.key == "tried")
    assert shown.startswith("20 000 positions")
    assert "worst" in shown


@examples(4)
@given(arms(max_joints=3, massive=True), st.integers(0, 2**32 - 1))
def test_errors_over_a_box_follow_from_few_states_at_each_position(arm, seed):
    rng = np.random.default_rng(seed)
    model, box, n = damaged(arm, rng), drawn_box(arm, rng), arm.n_joints
    exact = gd.types.ExactDynamics.of(arm, gd.types.States(*drawn_states(box, 5, rng)), drives=model.drives)
    errors, q = falsification.BoxErrors(model, exact, box, np.ones(n)), rng.uniform(box.lower, box.upper)
    _, qd, qdd = drawn_states(box, 400, rng)
    drawn = np.stack([np.broadcast_to(q, qd.shape), qd, qdd])
    size = np.abs(model.torque(*drawn)).max() + np.abs(errors.at(drawn)).max()
    for joint in range(n):
        worst = errors.worst(q[:, None], joint)
        # The factors sum some 20 errors, each with round-off of the torques.
        slack = 1e-11 * size
        promised = errors.motion.worst(errors.factors(q[:, None])[joint])[0][0]
        assert abs(np.abs(errors.at(worst)[joint, 0]) - promised) <= slack
        assert np.abs(errors.at(drawn)[joint]).max() <= promised + slack
        assert (np.abs(worst[1:, 0]) <= [box.velocity, box.acceleration]).all()


def try_states(patch):
    """Take every bound near a motion for too loose, so that states are tried."""
    patch.setattr("gd_analyze.certification.holding.LOOSE_BOUND", 0.0)


def test_near_each_of_several_motions_its_own_budget_holds(two_link, monkeypatch):
    """By a proof, and by states drawn near each; a slow motion allows many times less than a fast one."""
    motions = pool([swung(20.0, "slow"), swung(2.2, "fast")])
    exact, tube = gd.types.ExactDynamics.of(two_link, motions), gd.types.Tube.along(two_link, motions)
    found = simplify_held(exact, "40%", tube, SearchOptions("term"))
    assert found.model.saves
    assert found.tried == 0
    try_states(monkeypatch)
    tried = simplify_held(exact, "40%", tube)
    assert tried.model.saves
    assert tried.tried == falsification.RANDOM_STATES
    rng = np.random.default_rng(0)
    for motion in taken_apart(motions):
        alone, own = gd.types.ExactDynamics.of(two_link, motion), gd.types.Tube.along(two_link, motion)
        allowed = alone.allowed("40%")
        assert gd.certify(found.model, own).within(allowed).all()
        bounds = np.broadcast_to(allowed, (len(own), 2))
        for model in (found.model, tried.model):
            assert largest_excess(model, own, bounds, rng) <= round_off_in(model, own)
    with pytest.raises(UsageError, match="other motions"):
        simplify_held(exact, "40%", own)


def test_where_the_proof_does_not_close_states_near_the_motion_are_tried(two_link, swing, monkeypatch):
    try_states(monkeypatch)
    exact, tube = gd.types.ExactDynamics.of(two_link, swing), gd.types.Tube.along(two_link, swing)
    held = simplify_held(exact, "60%", tube)
    assert held.model.saves
    assert (held.tried, held.where) == (falsification.RANDOM_STATES, tube.where)
    certificate = gd.certify(held.model, tube)
    assert (held.found <= exact.allowed("60%")).all()
    # An ascent to the ends of small boxes finds nearly all that the proof allows for.
    assert (held.found >= 0.9 * certificate.worst_found).all()
    assert "found at 200 000 states" in simplified_result(held, exact.states, 1.0, 3).headline


def test_an_ascent_stays_inside_and_never_descends():
    rng = np.random.default_rng(3)
    lower, slope = rng.normal(size=(3, 5, 2)), rng.normal(size=(3, 2))
    upper = lower + rng.uniform(0.0, 1.0, lower.shape)

    def share(states):
        return np.abs(np.einsum("ksn,kn->s", states, slope))[None]

    start = rng.uniform(lower, upper)
    joints = np.zeros(start.shape[1], dtype=int)
    reached = falsification._climbed(share, joints, start, lower, upper)
    assert ((reached >= lower) & (reached <= upper)).all()
    assert (share(reached) >= share(start)).all()
    # A linear error is largest at the ends that one of its two signs points to.
    ends = [np.where(sign * slope[:, None] > 0, upper, lower) for sign in (1, -1)]
    best = np.maximum(*map(share, ends))
    assert (share(reached) == best).mean() > 0.5


@pytest.mark.parametrize("region", ["motion", "box"])
def test_a_budget_beyond_any_torque_is_a_budget(two_link, swing, region):
    """1e12 % of some N m are more than the largest number of an arm."""
    exact = gd.types.ExactDynamics.of(two_link, swing)
    states = gd.types.Tube.along(two_link, swing) if region == "motion" else gd.types.Box.of(two_link)
    held = simplify_held(exact, "1e12 %", states, certified=True)
    assert held.certificate is not None
    assert held.certificate.within(held.model.accuracy.allowed).all()
