"""Agreement is measured, and a formulation that is wrong is noticed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given

from gd_analyze.arrays import CHUNK
from gd_analyze.dynamics.methods import METHODS, torque_of_states
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.agreement import agreement
from gd_analyze.studies.compare import compare
from gd_analyze.studies.timing import time_methods
from strategies import arms_with_states, examples


@examples(15)
@given(arms_with_states(max_joints=6))
def test_all_formulations_agree(drawn):
    arm, states = drawn
    found = agreement(arm, States(states.q, states.qd, states.qdd))
    assert found.holds, (found.torque, found.from_pinocchio, found.bounds)
    assert found.names == (*METHODS, "pinocchio")
    np.testing.assert_array_equal(found.torque, found.torque.T)
    assert not np.diagonal(found.torque).any()
    assert found.largest == max(found.worst_of(name) for name in found.names)


@pytest.mark.parametrize("quantity", ["torque", "dynamics"])
def test_a_wrong_formulation_is_noticed(two_link, quantity):
    states = states_in_box(two_link, 20)
    right = METHODS["newton_euler_link"]

    def wrong_torque(arm, q, qd, qdd, **rest):
        return right.torque(arm, q, qd, qdd, **rest) * (1 + 1e-9)

    def wrong_dynamics(arm, q, qd):
        given = right.dynamics(arm, q, qd)
        return dataclasses.replace(given, inertia=given.inertia * (1 + 1e-9))

    wrong = {"torque": wrong_torque, "dynamics": wrong_dynamics}[quantity]
    methods = METHODS | {"newton_euler_link": dataclasses.replace(right, **{quantity: wrong})}
    found = agreement(two_link, states, methods=methods)
    assert not found.holds
    worst = max(found.from_pinocchio, key=lambda name: max(found.from_pinocchio[name].values()))
    assert worst == "newton_euler_link"


def test_chunks_do_not_show():
    arm = load_arm("two_link")
    states = states_in_box(arm, CHUNK + 7)
    method = METHODS["composite_moments"]
    whole = torque_of_states(method, arm, states.q, states.qd, states.qdd)
    part = torque_of_states(method, arm, states.q[CHUNK:], states.qd[CHUNK:], states.qdd[CHUNK:])
    # Vector instructions may round the last elements of an array differently: a few roundings.
    np.testing.assert_allclose(whole[CHUNK:], part, rtol=0, atol=1e-14 * np.abs(whole).max())


def test_a_trajectory_of_another_arm_is_refused(two_link, puma):
    with pytest.raises(TrajectoryError, match="not for arm puma560"):
        compare(puma, read_trajectory("two-link-swing", two_link))


def test_times_are_measured_of_every_method(two_link):
    states = states_in_box(two_link, 50)
    done = []
    timing = time_methods(two_link, states, repeats=2, progress=done.append)
    assert list(timing.seconds) == list(METHODS)
    assert all(0 < seconds < 1 for seconds in (*timing.seconds.values(), timing.pinocchio))
    assert (timing.set_points, timing.repeats, sum(done)) == (50, 2, 3)
