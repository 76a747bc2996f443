"""D that is singular or indefinite at a state asked for is refused, with the joint or the link to blame."""

from __future__ import annotations

import dataclasses
import re
import warnings

import numpy as np
import pytest
from hypothesis import given

import gd_analyze as gd
from gd_analyze.arrays import CHUNK
from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import ArmError
from gd_analyze.types import Drive, Joint, Link
from strategies import arms_with_states, examples


def at(*q: list[float]) -> gd.types.States:
    positions = np.array(q)
    return gd.types.States(positions, 0 * positions, 0 * positions)


def below_zero(two_link: gd.types.RobotArm, moment: float) -> gd.types.RobotArm:
    """The rods with a negative moment of the second about its axis: 0.25 + moment is its D_22."""
    second = dataclasses.replace(two_link.links[1], inertia_com=np.diag([0.0, 1 / 12, moment]))
    return dataclasses.replace(two_link, links=(two_link.links[0], second))


def test_an_inertia_that_no_body_has_but_that_leaves_d_positive_is_computed_with(two_link):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
        findings = gd.analyze(below_zero(two_link, -0.01), "two-link-swing")
    assert [text for text in findings.warnings if "negative" in text]
    assert findings.model.operations.total > 0


@pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")
@pytest.mark.parametrize("use", [gd.analyze, gd.simplify, gd.types.ExactDynamics.of])
def test_nothing_is_found_of_one_that_makes_it_indefinite(two_link, use):
    match = f"D is not positive definite.*link {two_link.links[1].name}"
    with pytest.raises(ArmError, match=match) as caught:
        use(below_zero(two_link, -0.5), "two-link-swing")
    assert re.search(r"two_link\.toml, line \d+", caught.value.details["where"])
    assert "-0.5, 0, 0.08333 kg m^2" in caught.value.details["found"]


def test_one_state_of_a_long_motion_is_found(two_link):
    """det D = D_11 D_22 - D_12^2 falls with |cos q2|: here it is positive at q2 = pi/2, negative at 0."""
    arm = below_zero(two_link, -0.2)
    q = np.full((3 * CHUNK, 2), np.pi / 2)
    require_positive_definite(arm, at(*q.tolist()), drives=False)
    q[2 * CHUNK + 17, 1] = 0.0
    with pytest.raises(ArmError) as caught:
        require_positive_definite(arm, at(*q.tolist()), drives=False)
    assert f"set point {2 * CHUNK + 18} of {3 * CHUNK} states" in caught.value.details["found"]


def test_a_joint_without_mass_is_named_and_its_drive_helps(two_link):
    nothing = Link("nothing", 0.0, np.zeros(3), np.zeros((3, 3)))
    joints, links = (*two_link.joints, Joint("idle")), (*two_link.links, nothing)
    drives = (Drive(), Drive(), Drive(0.1))
    arm = dataclasses.replace(two_link, joints=joints, links=links, drives=drives, dh_table=())
    require_positive_definite(arm, at([0.1, 0.2, 0.3]), drives=True)
    with pytest.raises(ArmError, match=r"singular.* joint 3 \(idle\)") as caught:
        require_positive_definite(arm, at([0.1, 0.2, 0.3]), drives=False)
    assert caught.value.details["where"].endswith("link nothing")
    assert "`lock='idle=0'`" in caught.value.details["next"]


def test_sliding_far_is_not_singular(two_link):
    """The rods on rails of a kilometre: D is as definite there as it is at home."""
    rail, along = Link("rail", 5.0, np.zeros(3), 0.1 * np.eye(3)), np.eye(3)[0]
    small = dataclasses.replace(two_link.links[1], mass=1e-3, com=np.zeros(3), inertia_com=1e-7 * np.eye(3))
    joints = (Joint("rail", "prismatic", axis=along), *two_link.joints)
    arm = gd.types.RobotArm("on rails", joints, (rail, two_link.links[0], small), two_link.gravity_vector)
    require_positive_definite(arm, at([1000.0, 0.2, 0.3], [-1000.0, 0.3, 0.4]), drives=False)


@examples(40)
@given(arms_with_states(max_joints=6))
def test_what_is_refused_is_what_pinocchio_finds_singular(case):
    """Where Pinocchio's smallest eigenvalue is clear of the tolerance, both agree."""
    arm, states = case
    still = 0 * states.q
    inertia = pinocchio_dynamics(arm, states.q, still, still)["inertia"]
    floor = arm.n_joints * round_off_bounds(arm, states.q, still, still)["inertia"]
    smallest = np.linalg.eigvalsh(inertia)[:, 0].min()
    # The tolerance has three products of lengths for one of the bound's, at the farthest of all positions.
    if smallest > 4 * 3 * floor:
        require_positive_definite(arm, states, drives=False)
    elif smallest < 1e-3 * floor:  # what is singular is so to a few roundings, far below any bound of them
        with pytest.raises(ArmError, match="mass matrix D is"):
            require_positive_definite(arm, states, drives=False)


@pytest.mark.parametrize("name", gd.builtin_arms())
@pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")
def test_shipped_arms_pass_everywhere(name):
    arm = gd.load_arm(name)
    require_positive_definite(arm, gd.tables.states_in_box(arm, 2000), drives=False)
