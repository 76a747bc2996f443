"""Every formulation against every other, and all of them against Pinocchio.

Unit of the tolerances: `round_off_bounds`, argued there, is how far two programs of some 10 roundings per
joint and coordinate may differ. Products of 4x4 or 3x3 matrices take twice as many roundings per joint as
turning a vector does, and probing adds up whole torques; each formulation may therefore be off by twice that
bound, and two of them may differ by four times.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics import lagrange_euler, newton_euler_base, newton_euler_link, probing
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from parallel_axes import arms_with_runs
from strategies import States, arms_with_states, examples, random_states
from transforms import derivative, link_frames

BUILT_IN = ["puma560", "stanford", "two_link"]
TO_PINOCCHIO, TO_EACH_OTHER = 2, 4
QUANTITIES = ("inertia", "coriolis_centrifugal", "gravity_loading", "torque")

built_in = st.builds(
    lambda name, seed: (load_arm(name), random_states(load_arm(name).n_joints, 6, seed)),
    st.sampled_from(BUILT_IN),
    st.integers(0, 2**32 - 1),
)
parallel = st.builds(
    lambda arm, seed: (arm, random_states(arm.n_joints, 6, seed)),
    arms_with_runs(8),
    st.integers(0, 2**32 - 1),
)
every_arm = st.one_of(arms_with_states(), built_in, parallel)


def by_every_method(arm: RobotArm, states: States) -> dict[str, dict[str, FloatArray]]:
    """D, h, c and torque by method, set points first."""
    q, qd, qdd = states.last
    out = {}
    for name, method in METHODS.items():
        dynamics = method.dynamics(arm, q, qd)
        torque = method.torque(arm, q, qd, qdd)
        last = dict(
            zip(
                QUANTITIES,
                (dynamics.inertia, dynamics.coriolis_centrifugal, dynamics.gravity_loading, torque),
                strict=True,
            )
        )
        out[name] = {key: np.moveaxis(value, -1, 0) for key, value in last.items()}
    return out


def check(arm: RobotArm, states: States) -> None:
    bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)
    ours = by_every_method(arm, states)
    theirs = pinocchio_dynamics(arm, states.q, states.qd, states.qdd)
    for quantity in QUANTITIES:
        for name, found in ours.items():
            difference = np.abs(found[quantity] - theirs[quantity]).max()
            assert difference <= TO_PINOCCHIO * bounds[quantity], (name, quantity)
        for one, other in combinations(ours, 2):
            difference = np.abs(ours[one][quantity] - ours[other][quantity]).max()
            assert difference <= TO_EACH_OTHER * bounds[quantity], (one, other, quantity)


@pytest.mark.parametrize("name", BUILT_IN)
def test_all_agree_on_built_in_arms(name):
    arm = load_arm(name)
    check(arm, random_states(arm.n_joints, 200, 1987))


@examples(30)
@given(arms_with_states())
def test_all_agree_on_drawn_arms(case):
    check(*case)


@examples(12)
@given(every_arm)
def test_gravity_switched_off_leaves_the_rest(case):
    arm, states = case
    q, qd, qdd = states.last
    bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)
    for name, method in METHODS.items():
        full, without = (method.torque(arm, q, qd, qdd, gravity=gravity) for gravity in (True, False))
        c = method.dynamics(arm, q, qd).gravity_loading
        # Three results of one program, each off by its share.
        assert np.abs(full - without - c).max() <= 3 * bounds["torque"], name


@examples(12)
@given(every_arm)
def test_probed_christoffel_is_the_christoffel(case):
    """Problem 3.12: h_ijk by polarisation of Newton-Euler torques, of either recursion."""
    arm, states = case
    q = states.q.T.copy()
    n, count = q.shape
    kinematics = solve_kinematics(arm, q)
    moments = composite.composite_moments(arm, kinematics)
    direct = composite.christoffel(moments, composite.brackets(moments)).sum(axis=0)
    bound = round_off_bounds(arm, states.q, 0 * states.qd, 0 * states.qdd)["inertia"]

    def link(qd: FloatArray, qdd: FloatArray, *, gravity: bool) -> FloatArray:
        return newton_euler_link.torque(arm, q, qd, qdd, gravity=gravity)

    def base(qd: FloatArray, qdd: FloatArray, *, gravity: bool) -> FloatArray:
        return newton_euler_base.torque(arm, q, qd, qdd, gravity=gravity)

    # h_ijk sums the products of masses and two levers that D_ij sums; of e_j + e_k it holds four of them, of
    # e_j and e_k one each: half of six, and what it is compared with.
    for ask in (link, base):
        assert np.abs(probing.christoffel(ask, n, count) - direct).max() <= 4 * bound
    assert np.abs(lagrange_euler.solve(arm, q).christoffel - direct).max() <= 4 * bound


loads = st.builds(
    lambda seed: np.random.default_rng(seed).uniform(-50, 50, (2, 3)), st.integers(0, 2**32 - 1)
)


def velocities_of_the_end(arm: RobotArm, q: FloatArray) -> FloatArray:
    """How the last link frame moves per unit rate of each joint, from its pose alone: (n, 6, N).

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


@examples(30)
@given(every_arm, loads)
def test_an_external_wrench_costs_its_virtual_work(case, load):
    """tau = J^T f, J from the hand's pose: what the arm adds to carry what its hand exerts."""
    arm, states = case
    q, qd, qdd = states.last
    expected = np.einsum("icN,c->iN", velocities_of_the_end(arm, states.q), load.ravel())
    bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)
    reach = 1.0 + 2 * arm.n_joints + np.abs(states.q).sum(axis=1).max()
    # Two torques are subtracted; the load's own round-off is 20 roundings per joint of force times reach.
    tolerance = 2 * bounds["torque"] + 40 * arm.n_joints * np.finfo(float).eps * reach * np.abs(load).sum()
    for name, found in {
        "base": newton_euler_base.torque(arm, q, qd, qdd, external_wrench=load)
        - newton_euler_base.torque(arm, q, qd, qdd),
        "link": newton_euler_link.torque(arm, q, qd, qdd, external_wrench=load)
        - newton_euler_link.torque(arm, q, qd, qdd),
    }.items():
        assert np.abs(found - expected).max() <= tolerance, name


@examples(30)
@given(every_arm, st.integers(0, 2**32 - 1))
def test_damping_adds_its_share_at_each_joint(case, seed):
    arm, states = case
    q, qd, qdd = states.last
    damping = np.random.default_rng(seed).uniform(0, 5, arm.n_joints)
    pairs = (
        (
            newton_euler_base.torque(arm, q, qd, qdd, damping=damping),
            newton_euler_base.torque(arm, q, qd, qdd),
        ),
        (
            newton_euler_link.torque(arm, q, qd, qdd, damping=damping),
            newton_euler_link.torque(arm, q, qd, qdd),
        ),
    )
    for damped, free in pairs:
        share = damping[:, None] * qd
        # One more sum on top of equal torques: an eps of what is added up, here and in the difference.
        slack = 2 * np.finfo(float).eps * (np.abs(free) + np.abs(share)).max()
        assert np.abs(damped - free - share).max() <= slack
