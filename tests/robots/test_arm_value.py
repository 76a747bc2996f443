"""The arm as a value: valid once it exists, immutable, and the numbers of the shipped ones."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from arm_files import link
from hypothesis import given

import gd_analyze as gd
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ArmError
from gd_analyze.robots.parts import DHRow, Drive, Joint, LinkUncertainty, Placement
from strategies import arms, examples


def test_built_in_arms():
    assert list(gd.builtin_arms()) == ["puma560", "stanford", "two_link"]
    assert all(gd.load_arm(name).name == name for name in gd.builtin_arms())


def test_puma_numbers(puma):
    """Armstrong, Khatib, Burdick 1986 and [FGL87] Fig. 2.11."""
    assert puma.mass.tolist() == [0.0, 17.4, 4.8, 0.82, 0.34, 0.09]
    assert puma.inertia_com[1].diagonal().tolist() == [0.13, 0.524, 0.539]
    assert puma.com[1].tolist() == [-0.3638, 0.006, 0.07745]
    assert puma.com[3].tolist() == [0.0, 0.019, 0.0]
    assert puma.drive_inertia.tolist() == [1.14, 4.71, 0.827, 0.2, 0.179, 0.193]
    uncertain = [drive.inertia_uncertainty for drive in puma.drives]
    assert uncertain == [0.27, 0.54, 0.093, 0.016, 0.014, 0.016]
    assert [drive.torque_limit for drive in puma.drives] == [97.6, 186.4, 89.4, 24.2, 20.1, 21.3]
    lower, upper = [-160, -225, -45, -110, -100, -266], [160, 45, 225, 170, 100, 266]
    np.testing.assert_allclose(np.degrees(puma.limits("lower")), lower, rtol=4e-16)
    np.testing.assert_allclose(np.degrees(puma.limits("upper")), upper, rtol=4e-16)
    assert puma.gravity.tolist() == [0.0, 0.0, -9.8062]
    assert [row.a for row in puma.dh_table] == [0.0, 0.4318, -0.02032, 0.0, 0.0, 0.0]


def test_two_link_numbers(two_link):
    """[FGL87] section 3.2.6: slender rods of length l, m l^2 / 12 across and nothing along them."""
    assert [row.a for row in two_link.dh_table] == [1.0, 1.0]
    assert two_link.mass.tolist() == [2.0, 1.0]
    for rod in two_link.links:
        assert rod.com.tolist() == [-0.5, 0.0, 0.0]
        assert rod.inertia_com.tolist() == np.diag([0.0, rod.mass / 12, rod.mass / 12]).tolist()
    assert two_link.gravity.tolist() == [0.0, -9.8062, 0.0]


def one(**changes) -> gd.RobotArm:
    return gd.RobotArm(**{"name": "a", "joints": (Joint("1"),), "links": (link(),)} | changes)


def test_limits_that_are_unknown_are_infinite():
    assert [one().limits(what).tolist() for what in ("lower", "upper", "velocity_limit")] == [
        [-np.inf],
        [np.inf],
        [np.inf],
    ]


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: Joint("1", "spherical"), "unknown kind"),
        (lambda: Joint("1", axis=np.array([0, 0, 1 + 1e-5])), "not a unit vector"),
        (lambda: Joint("1", lower=1.0, upper=1.0), "range of joint 1 is empty"),
        (lambda: Joint("1", acceleration_limit=-1.0), "acceleration_limit of joint 1 is not positive"),
        (lambda: Joint("1", axis=np.array([np.nan, 0, 1])), "not finite"),
        (lambda: Joint("1", axis=None), "not made of numbers"),
        (lambda: Placement(np.diag([1.0, 1.0, -1.0])), "is not a rotation"),
        (lambda: link(mass=-1.0), "is negative"),
        (lambda: link(com=np.zeros(2)), "wrong shape"),
        (lambda: link(inertia_com=np.triu(np.ones((3, 3)))), "not symmetric"),
        (lambda: Drive(viscous={}), "viscous of a drive is not made of numbers"),
        (lambda: Drive(coulomb=(0.1,)), "coulomb of a drive has the wrong shape"),
        (lambda: DHRow(0.0, "1", 0.0, 0.0), "d of a Denavit-Hartenberg row is not made of numbers"),
        (lambda: LinkUncertainty(com=np.array([0.0, -0.1, 0.0])), "com of a link's uncertainty is negative"),
        (lambda: LinkUncertainty(inertia=np.triu(np.ones((3, 3)))), "uncertainty is not symmetric"),
        (lambda: one(joints=(), links=()), "has no joints"),
        (lambda: one(links=()), "one of its links per joint"),
        (lambda: one(drives=(Drive(),) * 2), "one of its drives"),
        (lambda: one(convention=7), "an arm's convention is not a name"),
        (lambda: one(sources=("\u200b",)), "not printable"),
    ],
)
def test_impossible_parts(build, says):
    with pytest.raises(ArmError, match=says):
        build()


def test_values_cannot_be_changed(puma):
    with pytest.raises(dataclasses.FrozenInstanceError):
        puma.name = "other"
    for array in (puma.gravity, puma.mass, puma.com, puma.inertia_com, puma.drive_inertia, puma.links[0].com):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    com = np.zeros(3)
    made = link(com=com)
    com[0] = 0.05
    assert made.com[0] == 0.0


@examples(20)
@given(arms())
def test_reach_bounds_every_pose(arm):
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (arm.n_joints, 20))
    q[[not revolute for revolute in arm.is_revolute]] = 0.0
    kinematics = solve_kinematics(arm, q)
    distance = np.linalg.norm(kinematics.link_origins - kinematics.joint_origins[0], axis=1).max()
    assert distance <= arm.reach * (1 + 1e-13)  # some 20 roundings per joint
