"""The recursion pruned: within the budget on the program itself, repeatable, and never dearer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.expansion import expanded
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.pruning import joined_by_near_states, prune
from gd_analyze.simplification.recursion import Changes
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from parallel_axes import scara
from psdm_arms import kr6
from strategies import arms, examples, random_states

# Of the usual effort: what tenths of a second find.
_QUICK = 0.02


def _largest(exact: ExactDynamics, changes: Changes, allowed: FloatArray) -> float:
    """Largest error over allowed of the program that the changes make, run by itself."""
    program = exact.form.recursion.changed(changes)
    return float((np.abs(program.run(inputs_of(exact.states)).T - exact.torque) / allowed).max())


@examples(4)
@given(arm=arms(max_joints=4, massive=True), seed=st.integers(0, 2**16), share=st.sampled_from([0.003, 0.03]))
def test_the_budget_is_kept_and_nothing_dearer_comes_of_it(arm: RobotArm, seed: int, share: float) -> None:
    exact = ExactDynamics.of(arm, random_states(arm.n_joints, 60, seed))
    allowed = exact.allowed(f"{100 * share}%")
    changes = prune(exact, allowed, effort=_QUICK)
    # Statements of fitted numbers are rounded once more.
    assert _largest(exact, changes, allowed) <= 1.0 + 1e-9
    recursion = exact.form.recursion
    program = recursion.changed(changes)
    assert program.count.total <= recursion.program.count.total
    # It is still a torque: D(q) qdd + h(q, qd) + c(q), or it could not be written out.
    expanded(program, [not turns for turns in arm.is_revolute])


@pytest.mark.slow
def test_it_goes_on_from_changes_and_repeats_to_the_last_bit() -> None:
    exact = ExactDynamics.of(kr6(), random_states(6, 100, 0))
    tight, wide = (exact.allowed(budget) for budget in ("0.5%", "2%"))
    first = prune(exact, tight, effort=_QUICK)
    assert first == prune(exact, tight, effort=_QUICK)
    further = prune(exact, wide, effort=_QUICK, start=first)
    changed = exact.form.recursion.changed
    assert changed(further).count.total < changed(first).count.total
    assert _largest(exact, further, wide) <= 1.0 + 1e-9 < _largest(exact, further, tight)


@pytest.mark.slow
def test_roundings_decide_nothing() -> None:
    """With the states in another order every sum has other last digits, as on another processor."""
    states = random_states(4, 200, 3)
    order = np.random.default_rng(0).permutation(200)
    found = []
    for drawn in (states, states.at(order)):
        exact = ExactDynamics.of(scara(), drawn)
        found.append(prune(exact, exact.allowed("2%"), effort=_QUICK))
    first, second = found
    assert len(first) > 10
    assert first.keys() == second.keys()
    # A number that lies on the edge between two of seven digits may fall to either side.
    assert all(abs(first[change] - second[change]) <= 1e-6 * abs(first[change]) for change in first)


def test_a_zero_budget_leaves_the_recursion() -> None:
    exact = ExactDynamics.of(kr6(), random_states(6, 50, 0))
    changes = prune(exact, 1e-9 * exact.peak_torque, effort=_QUICK)
    assert _largest(exact, changes, 1e-9 * exact.peak_torque) <= 1.0 + 1e-9


@pytest.mark.slow
def test_errors_that_count_more_are_smaller() -> None:
    """Where an error counts ten times, a tenth of the budget is all there is."""
    states = random_states(6, 80, 3)
    weights = np.ones(states.q.shape)
    weights[:40] = 10.0
    exact = ExactDynamics.of(kr6(), replace(states, weights=weights))
    allowed = exact.allowed("5%")
    program = exact.form.recursion.changed(prune(exact, allowed, effort=_QUICK))
    errors = np.abs(program.run(inputs_of(states)).T - exact.torque) / allowed
    assert errors[:40].max() <= 0.1 * (1.0 + 1e-9)
    assert errors[40:].max() > 0.1


@pytest.mark.slow
def test_six_joints_of_general_make_take_little_more_than_half() -> None:
    """KR6 of PSDM's Table 1 at 1 % of every joint's peak: 481 operations are exact, 300 are asked for."""
    arm = kr6()
    exact = ExactDynamics.of(arm, states_in_box(arm, 1000))
    changes = prune(exact, exact.allowed("1%"), effort=0.1)
    assert exact.form.recursion.changed(changes).count.total <= 300


def test_states_near_a_motion_join_it_and_count_as_those_do(two_link, swing):
    exact = ExactDynamics.of(two_link, swing)
    states = replace(exact.states, weights=np.linspace(1.0, 2.0, 2 * len(swing.time)).reshape(-1, 2))
    exact = exact.at(states)
    joined = joined_by_near_states(exact).states
    count = len(states)
    assert len(joined) > 2 * count
    for own, more in zip(states.arrays, joined.arrays, strict=True):
        np.testing.assert_array_equal(more[:count], own)
    off = np.abs(joined.q[count:, None] - states.q).max(axis=2).min(axis=1)
    assert 0.0 < off.min() < off.max() <= np.radians(1.0)
    assert joined.weights.shape == joined.q.shape
    assert set(map(tuple, joined.weights[count:])) <= set(map(tuple, states.weights))


def test_states_of_no_motion_stay_as_they_are(two_link):
    exact = ExactDynamics.of(two_link, states_in_box(two_link, 10))
    assert joined_by_near_states(exact) is exact


@pytest.mark.slow
def test_the_budget_nearly_holds_near_the_motion():
    arm = gd.load_arm("stanford")
    start = np.array([0.1, -0.5, 0.4, 0.3, -0.6, 0.2])
    motion = gd.plan(arm, start, start + 0.3, schedule=gd.Schedule(2.0, "4-3-4", 15)).trajectory
    exact = ExactDynamics.of(arm, motion)
    model = simplify_exact(exact, "1%", SearchOptions(RECURSIVE, thorough=False))
    assert model.saves
    random = np.random.default_rng(7)
    q, qd, qdd = (np.repeat(x, 50, axis=0) for x in exact.states.arrays)
    margin = np.where([joint.kind == "revolute" for joint in arm.joints], np.radians(1.0), 1e-3)
    near = States(q + margin * random.uniform(-1.0, 1.0, q.shape), qd, qdd)
    off = np.abs(model.torque(*near.arrays) - exact.at(near).torque).max(axis=0)
    # Fitted to the set points alone it errs by more.
    assert (off <= 1.5 * model.accuracy.allowed).all()
