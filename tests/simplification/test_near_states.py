"""Near a motion a model at level recursive errs hardly more than at its set points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import gd_analyze as gd
from gd_analyze.certification.tube import Margin
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.simplification import pruning
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.pruning import joined_by_near_states
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact


def test_as_near_as_what_is_proven_by_default():
    own = pruning.TURNING, pruning.SLIDING, pruning.RATE, pruning.ACCELERATION
    assert Margin(*own) == Margin()


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
