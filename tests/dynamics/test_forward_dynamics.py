"""Forward dynamics undoes inverse dynamics, by every formulation."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, pinocchio_model, round_off_bounds
from gd_analyze.dynamics.simulation import joint_accelerations
from gd_analyze.errors import ArmError, GdAnalyzeError, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Joint, Link
from strategies import States, arms_with_states, examples, random_states

EPS = float(np.finfo(float).eps)
BUILT_IN = ["puma560", "stanford", "two_link"]


def tolerance(arm: RobotArm, states: States, inertia: FloatArray) -> FloatArray:
    """Of qdd at each state, largest norm: |D^-1| times what torque and D qdd may be off by, shape (N,).

    tau - h - c differs from what inverse dynamics added by two torques' round-off (each formulation within
    twice the bound, as in their agreement), and D qdd likewise is within the bound for torque. Solving n
    equations adds a backward error of some n^2 eps |D| |qdd|; |D^-1| |D| is the condition number.
    """
    n = arm.n_joints
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["torque"]
    inverse = np.abs(np.linalg.inv(inertia)).sum(axis=-1).max(axis=-1)
    size = np.abs(inertia).sum(axis=-1).max(axis=-1)
    return inverse * (4 * bound + 4 * n**2 * EPS * size * np.abs(states.qdd).max(axis=-1))


def round_trip(arm: RobotArm, states: States) -> None:
    theirs = pinocchio_dynamics(arm, states.q, states.qd, states.qdd)
    allowed = tolerance(arm, states, theirs["inertia"])
    for name, method in METHODS.items():
        torque = method.torque(arm, *states.last).T
        found = joint_accelerations(arm, states.q, states.qd, torque, name)
        assert (np.abs(found - states.qdd).max(axis=-1) <= allowed).all(), name
        # Whatever the condition of D, the torque of what was found is the torque given, to Pinocchio as well:
        # twice the bound each way, and the backward error of the solution.
        given = pinocchio_dynamics(arm, states.q, states.qd, found)["torque"]
        bound = round_off_bounds(arm, states.q, states.qd, found)["torque"]
        assert np.abs(given - torque).max() <= 6 * bound, name


@pytest.mark.parametrize("name", BUILT_IN)
def test_accelerations_undo_torque_on_built_in_arms(name):
    arm = load_arm(name)
    states = random_states(arm.n_joints, 100, 1982)
    round_trip(arm, states)
    inertia = pinocchio_dynamics(arm, states.q, states.qd, states.qdd)["inertia"]
    assert tolerance(arm, states, inertia).max() < 1e-3  # of accelerations up to 10


@examples(15)
@given(arms_with_states(max_joints=6, massive=True))
def test_accelerations_undo_torque_on_drawn_arms(case):
    round_trip(*case)


@examples(15)
@given(arms_with_states(max_joints=8, massive=True))
def test_all_formulations_and_pinocchios_articulated_bodies_agree(case):
    """Pinocchio's aba never forms D: another algorithm altogether."""
    import pinocchio as pin

    arm, states = case
    torque = states.qdd * 5.0
    model = pinocchio_model(arm)
    data = model.createData()
    theirs = np.array(
        [
            pin.aba(model, data, q, qd, tau).copy()
            for q, qd, tau in zip(states.q, states.qd, torque, strict=True)
        ]
    )
    accelerated = States(states.q, states.qd, theirs)
    inertia = pinocchio_dynamics(arm, states.q, states.qd, theirs)["inertia"]
    # Articulated bodies invert one joint at a time, each inverse as good as the last one's condition.
    allowed = 2 * tolerance(arm, accelerated, inertia)
    for name in METHODS:
        found = joint_accelerations(arm, states.q, states.qd, torque, name)
        assert (np.abs(found - theirs).max(axis=-1) <= allowed).all(), name


def idle_at_the_end(two_link: RobotArm) -> RobotArm:
    """The two rods, and a third joint with nothing behind it."""
    nothing = Link("nothing", 0.0, np.zeros(3), np.zeros((3, 3)))
    return dataclasses.replace(
        two_link, joints=(*two_link.joints, Joint("idle")), links=(*two_link.links, nothing), dh_table=()
    )


@pytest.mark.parametrize("method", list(METHODS))
def test_a_joint_that_moves_nothing_is_named(two_link, method):
    arm = idle_at_the_end(two_link)
    q = np.array([[0.3, 0.4, 0.5], [0.1, -0.2, 0.3]])
    with pytest.raises(GdAnalyzeError, match=r"D is singular: joint 3 \(idle\)") as caught:
        joint_accelerations(arm, q, 0 * q, 0 * q, method)
    assert "mass, or inertia about the axis" in caught.value.details["next"]


def test_the_drives_inertia_helps(puma):
    """A last link without inertia about its axis needs its drive's."""
    rod = dataclasses.replace(puma.links[5], inertia_com=np.diag([1.5e-4, 1.5e-4, 0.0]))
    arm = dataclasses.replace(puma, links=(*puma.links[:5], rod))
    q = 0.3 * np.ones(6)
    with pytest.raises(GdAnalyzeError, match=r"joint 6 \(flange\)") as caught:
        joint_accelerations(arm, q, 0 * q, 0 * q)
    assert "count the drives' inertia" in caught.value.details["next"]
    assert np.isfinite(joint_accelerations(arm, q, 0 * q, 0 * q, drivetrain=Drivetrain(inertia=True))).all()


@examples(15)
@given(arms_with_states(max_joints=4), st.integers(0, 2**32 - 1))
def test_arms_with_massless_links_are_solved_or_refused(case, seed):
    """Never a number that is only round-off divided by round-off."""
    arm, states = case
    torque = np.random.default_rng(seed).uniform(-1, 1, states.q.shape)
    inertia = pinocchio_dynamics(arm, states.q, states.qd, states.qdd)["inertia"]
    floor = round_off_bounds(arm, states.q, states.qd, states.qdd)["inertia"]
    smallest = np.linalg.eigvalsh(inertia)[:, 0].min()
    try:
        found = joint_accelerations(arm, states.q, states.qd, torque)
    except GdAnalyzeError:
        # A pivot is at least the smallest eigenvalue.
        assert smallest <= 2 * floor
    else:
        assert np.isfinite(found).all()
        assert smallest > 0


def test_bad_input(puma, two_link):
    q = np.zeros(6)
    with pytest.raises(UsageError, match="no formulation 'newton_euler'") as caught:
        joint_accelerations(puma, q, q, q, "newton_euler")
    assert "did you mean" in caught.value.details["next"]
    with pytest.raises(UsageError, match="torque does not fit arm puma560"):
        joint_accelerations(puma, q, q, np.zeros((2, 6)))
    for asked in (Drivetrain(inertia=True), Drivetrain(friction=True)):
        with pytest.raises(ArmError, match="describes no drives"):
            joint_accelerations(two_link, np.zeros(2), np.zeros(2), np.zeros(2), drivetrain=asked)
    for drivetrain in (
        Drivetrain(damping=-q - 1.0),
        Drivetrain(damping=np.ones((2, 6))),
        Drivetrain(friction=True, rest_velocity=0.0),
        Drivetrain(friction=True, rest_velocity=np.nan),
    ):
        with pytest.raises(UsageError) as caught:
            joint_accelerations(puma, q, q, q, drivetrain=drivetrain)
        assert caught.value.details["where"] in ("damping", "rest_velocity")
