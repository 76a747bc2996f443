"""Every formulation against every other, and all of them against Pinocchio.

Unit of the tolerances: `round_off_bounds`, argued there, is how far two programs of some 10 roundings per
joint and coordinate may differ. Products of 4x4 or 3x3 matrices take twice as many roundings per joint as
turning a vector does, and probing adds up whole torques; each formulation may therefore be off by twice that
bound, and two of them may differ by four times.
"""

from __future__ import annotations

import dataclasses
from itertools import combinations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze import load_arm
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import newton_euler_base, newton_euler_link
from gd_analyze.dynamics.base_parameters import inertial_parameters, link_regressor, parameters_of
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import (
    COMPARED_QUANTITIES,
    MOST_SET_POINTS,
    pinocchio_dynamics,
    pinocchio_model,
    round_off_bounds,
)
from gd_analyze.tables import cross_check
from gd_analyze.types import RobotArm
from parallel_axes import arms_with_runs, of_every_turn
from strategies import States, arms_with_states, examples, explicitly, motions, random_states
from transforms import derivative, link_frames

EPS = float(np.finfo(float).eps)
BUILT_IN = ["puma560", "stanford", "two_link"]
TO_PINOCCHIO, TO_EACH_OTHER = 2, 4

every_arm = st.one_of(
    arms_with_states(),
    st.builds(
        lambda arm, seed: (arm, random_states(arm.n_joints, 6, seed)),
        st.one_of(st.sampled_from(BUILT_IN).map(load_arm), arms_with_runs(8)),
        st.integers(0, 2**32 - 1),
    ),
)


def check(arm: RobotArm, states: States) -> None:
    q, qd, qdd = states.last
    bounds = round_off_bounds(arm, *states.arrays)
    ours = {}
    for name, method in METHODS.items():
        parts = vars(method.dynamics(arm, q, qd)).values()  # D, h and c
        ours[name] = (*parts, method.torque(arm, q, qd, qdd))
    theirs = pinocchio_dynamics(arm, *states.arrays)
    for k, quantity in enumerate(COMPARED_QUANTITIES):
        for name, found in ours.items():
            difference = np.abs(np.moveaxis(found[k], -1, 0) - theirs[quantity]).max()
            assert difference <= TO_PINOCCHIO * bounds[quantity], (name, quantity)
        for one, other in combinations(ours, 2):
            difference = np.abs(ours[one][k] - ours[other][k]).max()
            assert difference <= TO_EACH_OTHER * bounds[quantity], (one, other, quantity)
    for name, method in METHODS.items():
        weightless = method.torque(arm, q, qd, qdd, gravity=False)
        # Three results of one program, each off by its share.
        assert np.abs(ours[name][3] - weightless - ours[name][2]).max() <= 3 * bounds["torque"], name


@pytest.mark.parametrize("name", BUILT_IN)
def test_all_agree_on_built_in_arms(name):
    arm = load_arm(name)
    check(arm, random_states(arm.n_joints, 200, 1987))


@of_every_turn(states=6)
@examples(30)
@given(every_arm)
def test_all_agree_on_drawn_arms(case):
    check(*case)


def velocities_of_the_end(arm: RobotArm, q: FloatArray) -> FloatArray:
    """How the last link frame moves per unit velocity of each joint, from its pose alone: (n, 6, N).

    A complex step differentiates the 4x4 pose to the last bits; dR R^T is the cross product with the turning.
    """
    out = np.empty((arm.n_joints, 6, len(q)))
    rotation = link_frames(arm, q)[-1][:, :3, :3]
    for i, direction in enumerate(np.eye(arm.n_joints)):
        slope = derivative(lambda x: link_frames(arm, x)[-1], q, direction)
        turning = slope[:, :3, :3] @ rotation.swapaxes(1, 2)
        out[i, :3] = slope[:, :3, 3].T
        out[i, 3:] = np.array([turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]])
    return out


@pytest.mark.parametrize("formulation", [newton_euler_base, newton_euler_link])
@of_every_turn(states=6, seed=1)
@explicitly(map(load_arm, BUILT_IN), states=6, seed=1)
@examples(20)
@given(every_arm, st.integers(0, 2**32 - 1))
def test_an_external_wrench_costs_its_virtual_work(formulation, case, seed):
    """tau = J^T f, J from the hand's pose: what the arm adds to carry what its hand exerts."""
    (arm, states), load = case, np.random.default_rng(seed).uniform(-50, 50, (2, 3))
    expected = np.einsum("icN,c->iN", velocities_of_the_end(arm, states.q), load.ravel())
    bound = round_off_bounds(arm, *states.arrays)["torque"]
    reach = 1.0 + 2 * arm.n_joints + np.abs(states.q).sum(axis=1).max()
    # Two torques are subtracted; the load's own round-off is 20 roundings per joint of force times reach.
    tolerance = 2 * bound + 40 * arm.n_joints * EPS * reach * np.abs(load).sum()
    loaded = formulation.torque(arm, *states.last, external_wrench=load)
    assert np.abs(loaded - formulation.torque(arm, *states.last) - expected).max() <= tolerance


# The regressor: times the parameters it is the torque, and Pinocchio has the same one.


@examples(25)
@given(arms_with_states(max_joints=6))
def test_the_regressor_is_pinocchios(case):
    """Column by column; Pinocchio's are of the joint's frame, in which our parameters are moved ones."""
    arm, states = case
    n = arm.n_joints
    per_unit = link_regressor(arm, *states.last)
    torque = np.einsum("ispn,sp->in", per_unit, parameters_of(arm))
    # Inertia about the origin is that about the centre of mass and m r r, taken off again by the first
    # moments' share: twice the bound of either program, and each is off by as much as two formulations are.
    bound = round_off_bounds(arm, *states.arrays)["torque"]
    assert np.abs(torque - newton_euler_link.torque(arm, *states.last)).max() <= 8 * bound

    model = pinocchio_model(arm)
    data = model.createData()
    moved = np.array([into_joint_frame(link.frame.rotation, link.frame.translation) for link in arm.links])
    # A row adds up motion of a link frame: over joints, velocities and accelerations times levers. Some 20
    # roundings per joint of that, here and there, and of moving a column.
    first = np.linalg.norm(arm.joints[0].placement.translation)
    reach = 1.0 + arm.reach + np.abs(states.q).sum(axis=1).max() + first
    velocities, accelerations = (np.abs(x).sum(axis=1).max() for x in (states.qd, states.qdd))
    size = reach**2 * (3 * velocities**2 + accelerations + np.linalg.norm(arm.gravity_vector))
    for found, q, qd, qdd in zip(np.moveaxis(per_unit, -1, 0), *states.arrays, strict=True):
        theirs = pin.computeJointTorqueRegressor(model, data, q, qd, qdd).reshape(n, n, 10)
        assert np.abs(np.einsum("isk,skp->isp", theirs, moved) - found).max() <= 80 * n * EPS * size


def into_joint_frame(rotation: FloatArray, translation: FloatArray) -> FloatArray:
    """Parameters in the joint's frame from those in the link's, (10, 10), by 4x4 pseudo-inertias."""
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = rotation, translation
    columns = []
    for mass, x, y, z, xx, xy, yy, xz, yz, zz in np.eye(10):
        half = 0.5 * (xx + yy + zz)
        there = frame @ np.array(
            [[half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z], [x, y, z, mass]]
        )
        there = there @ frame.T
        second = there[:3, :3]
        columns.append(inertial_parameters(there[3, 3], there[:3, 3], np.trace(second) * np.eye(3) - second))
    return np.column_stack(columns)


# The cross-check of every run must pass what is right, and must not pass what is wrong.


@examples(15)
@given(motions(max_joints=8))
def test_every_arm_passes_the_cross_check(case):
    arm, motion = case
    residuals = cross_check(arm, gd.decompose(arm, motion))
    assert tuple(dict.fromkeys(r.quantity for r in residuals)) == COMPARED_QUANTITIES
    assert all(0 <= r.largest <= r.bound for r in residuals)


@pytest.mark.parametrize("quantity", COMPARED_QUANTITIES)
@pytest.mark.parametrize("wrong", ["one number", "nan"])
def test_a_wrong_number_anywhere_is_caught(puma, pick_and_place, pick_and_place_dataset, quantity, wrong):
    bounds = round_off_bounds(puma, pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    spoiled = pick_and_place_dataset.copy(deep=True)
    values = spoiled[quantity].values
    # Twice the bound: what is left after the honest residual still exceeds it.
    values[(17, *(-1,) * (values.ndim - 1))] += 2 * bounds[quantity] if wrong == "one number" else np.nan
    with pytest.raises(gd.GdAnalyzeError, match=f"{quantity} .*Pinocchio"):
        cross_check(puma, spoiled)


def test_another_arm_drives_and_ends_are_told(two_link, puma, pick_and_place, pick_and_place_dataset):
    last = dataclasses.replace(puma.links[-1], mass=1.000001 * puma.links[-1].mass)
    heavier = dataclasses.replace(puma, links=(*puma.links[:-1], last))
    driven = gd.decompose(puma, pick_and_place, drives=True)
    cross_check(puma, driven)
    time = np.arange(5 * MOST_SET_POINTS) / 100
    q = np.stack([np.sin(time), np.cos(time)], axis=1)
    long = gd.decompose(two_link, gd.Trajectory(time, q, q, -q))
    cross_check(two_link, long)
    first, end = (long.assign(torque=long.torque + 1.0 * (long.time == at)) for at in time[[0, -1]])
    for arm, dataset in (
        (heavier, pick_and_place_dataset),
        (puma, driven.drop_vars("drive_torque")),
        (two_link, first),
        (two_link, end),
    ):
        with pytest.raises(gd.GdAnalyzeError, match="disagrees with Pinocchio"):
            cross_check(arm, dataset)
