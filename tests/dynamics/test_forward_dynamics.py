"""Forward dynamics undoes inverse dynamics, by every formulation, and is refused where D is singular."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze import load_arm
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, pinocchio_model, round_off_bounds
from gd_analyze.errors import ArmError, GdAnalyzeError, UsageError
from gd_analyze.tables import joint_accelerations
from gd_analyze.types import Drivetrain, RobotArm
from strategies import States, arms_with_states, examples, random_states

EPS = float(np.finfo(float).eps)


def tolerance(arm: RobotArm, states: States) -> np.ndarray:
    """Of qdd at each state, largest norm: |D^-1| times what torque and D qdd may be off by, shape (N,).

    tau - h - c differs from what inverse dynamics added by two torques' round-off (each formulation within
    twice the bound, as in their agreement), and D qdd likewise is within the bound for torque. Solving n
    equations adds a backward error of some n^2 eps |D| |qdd|; |D^-1| |D| is the condition number.
    """
    inertia = pinocchio_dynamics(arm, *states.arrays)["inertia"]
    bound = round_off_bounds(arm, *states.arrays)["torque"]
    inverse = np.abs(np.linalg.inv(inertia)).sum(axis=-1).max(axis=-1)
    size = np.abs(inertia).sum(axis=-1).max(axis=-1)
    return inverse * (4 * bound + 4 * arm.n_joints**2 * EPS * size * np.abs(states.qdd).max(axis=-1))


def round_trip(arm: RobotArm, states: States) -> None:
    allowed = tolerance(arm, states)
    for name, method in METHODS.items():
        torque = method.torque(arm, *states.last).T
        found = joint_accelerations(arm, states.q, states.qd, torque, name)
        assert (np.abs(found - states.qdd).max(axis=-1) <= allowed).all(), name
        # Whatever the condition of D, the torque of what was found is the torque given, to Pinocchio as well:
        # twice the bound each way, and the backward error of the solution.
        given = pinocchio_dynamics(arm, states.q, states.qd, found)["torque"]
        bound = round_off_bounds(arm, states.q, states.qd, found)["torque"]
        assert np.abs(given - torque).max() <= 6 * bound, name


@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_accelerations_undo_torque_on_built_in_arms(name):
    arm = load_arm(name)
    states = random_states(arm.n_joints, 100, 1982)
    round_trip(arm, states)
    assert tolerance(arm, states).max() < 1e-3  # of accelerations up to 10


@examples(15)
@given(arms_with_states(max_joints=8, massive=True))
def test_accelerations_are_those_of_pinocchios_articulated_bodies(case):
    """Pinocchio's aba never forms D: another algorithm altogether."""
    arm, states = case
    round_trip(arm, states)
    torque = states.qdd * 5.0
    model = pinocchio_model(arm)
    data = model.createData()
    every = zip(states.q, states.qd, torque, strict=True)
    theirs = np.array([pin.aba(model, data, *state) for state in every])
    # Articulated bodies invert one joint at a time, each inverse as good as the last one's condition.
    allowed = 2 * tolerance(arm, States(states.q, states.qd, theirs))
    for name in METHODS:
        found = joint_accelerations(arm, states.q, states.qd, torque, name)
        assert (np.abs(found - theirs).max(axis=-1) <= allowed).all(), name


def test_the_drives_inertia_helps(puma):
    """A last link without inertia about its axis needs its drive's."""
    rod = dataclasses.replace(puma.links[5], inertia_com=np.diag([1.5e-4, 1.5e-4, 0.0]))
    arm = dataclasses.replace(puma, links=(*puma.links[:5], rod))
    q = 0.3 * np.ones(6)
    with pytest.raises(GdAnalyzeError, match=r"joint 6 \(flange\)") as caught:
        joint_accelerations(arm, q, 0 * q, 0 * q)
    assert "drives" in caught.value.details["next"]
    assert np.isfinite(joint_accelerations(arm, q, 0 * q, 0 * q, drivetrain=Drivetrain(inertia=True))).all()


@examples(15)
@given(arms_with_states(max_joints=4), st.integers(0, 2**32 - 1))
def test_arms_with_massless_links_are_solved_or_refused(case, seed):
    """Never a number that is only round-off divided by round-off."""
    arm, states = case
    torque = np.random.default_rng(seed).uniform(-1, 1, states.q.shape)
    inertia = pinocchio_dynamics(arm, *states.arrays)["inertia"]
    smallest = np.linalg.eigvalsh(inertia)[:, 0].min()
    try:
        found = joint_accelerations(arm, states.q, states.qd, torque)
    except GdAnalyzeError:
        # A pivot is at least the smallest eigenvalue.
        assert smallest <= 2 * round_off_bounds(arm, *states.arrays)["inertia"]
    else:
        assert np.isfinite(found).all()
        assert smallest > 0


def test_bad_input(puma, two_link):
    q = np.zeros(6)
    with pytest.raises(UsageError, match="no such method") as caught:
        joint_accelerations(puma, q, q, q, "newton_euler")
    assert "did you mean" in caught.value.details["next"]
    with pytest.raises(UsageError) as caught:
        joint_accelerations(puma, q, q, np.zeros((2, 5)))
    assert (caught.value.details["where"], caught.value.details["found"]) == ("torque", "(2, 5)")
    assert joint_accelerations(puma, q, q, np.zeros((2, 6))).shape == (2, 6)
    for asked in (Drivetrain(inertia=True), Drivetrain(friction=True)):
        with pytest.raises(ArmError, match="describes no drives"):
            joint_accelerations(two_link, np.zeros(2), np.zeros(2), np.zeros(2), drivetrain=asked)
    friction = {"friction": True}
    for wrong in ({"damping": -q - 1.0}, {"damping": np.ones((2, 6))}, {"rest_velocity": 0.0} | friction):
        with pytest.raises(UsageError) as caught:
            joint_accelerations(puma, q, q, q, drivetrain=Drivetrain(**wrong))
        assert caught.value.details["where"] in wrong
