"""The arm as a value: valid once it exists, immutable, and identified by its numbers."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given

from gd_analyze.errors import ArmError
from gd_analyze.robots import (
    DHRow,
    Drive,
    Joint,
    Link,
    LinkUncertainty,
    Placement,
    RobotArm,
    arm_from_description,
    builtin_arms,
    describe,
    fingerprint,
    load_arm,
    slips_of,
    with_payload,
)
from strategies import arms, examples


def link(**changes) -> Link:
    return Link(**{"name": "l", "mass": 1.0, "com": np.zeros(3), "inertia_com": 0.1 * np.eye(3)} | changes)


def test_built_in_arms():
    assert list(builtin_arms()) == ["puma560", "stanford", "two_link"]
    for name in builtin_arms():
        arm = load_arm(name)
        assert arm.name == name
        assert arm.title
        assert arm.sources


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
    np.testing.assert_allclose(
        np.degrees(puma.limits("lower")), [-160, -225, -45, -110, -100, -266], rtol=4e-16
    )
    np.testing.assert_allclose(np.degrees(puma.limits("upper")), [160, 45, 225, 170, 100, 266], rtol=4e-16)
    assert puma.gravity.tolist() == [0.0, 0.0, -9.8062]
    assert [row.a for row in puma.dh_table] == [0.0, 0.4318, -0.02032, 0.0, 0.0, 0.0]
    assert isinstance(puma.dh_table[0], DHRow)


def test_two_link_numbers(two_link):
    """[FGL87] section 3.2.6: slender rods of length l, m l^2 / 12 across and nothing along them."""
    length = [row.a for row in two_link.dh_table]
    assert length == [1.0, 1.0]
    assert two_link.mass.tolist() == [2.0, 1.0]
    for link, side in zip(two_link.links, length, strict=True):
        assert link.com.tolist() == [-side / 2, 0.0, 0.0]
        across = link.mass * side**2 / 12
        assert link.inertia_com.tolist() == np.diag([0.0, across, across]).tolist()
    assert two_link.gravity.tolist() == [0.0, -9.8062, 0.0]


def test_limits_that_are_unknown_are_infinite():
    arm = RobotArm("a", (Joint("1"),), (link(),))
    assert arm.limits("lower").tolist() == [-np.inf]
    assert arm.limits("upper").tolist() == [np.inf]
    assert arm.limits("rate_limit").tolist() == [np.inf]


@pytest.mark.parametrize("axis", [(0, 0, 2.0), (0, 0, 0), (1, 1, 0), (0, 0, 1 + 1e-5)])
def test_axis_must_be_a_unit_vector(axis):
    with pytest.raises(ArmError, match="not a unit vector"):
        Joint("1", axis=np.array(axis, dtype=float))


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: Joint("1", "spherical"), "unknown kind"),
        (lambda: Joint("1", lower=1.0, upper=1.0), "range of joint 1 is empty"),
        (lambda: Joint("1", acceleration_limit=-1.0), "acceleration limit of joint 1 is not positive"),
        (lambda: Joint("1", axis=np.array([np.nan, 0, 1])), "not finite"),
        (lambda: Joint("1", axis=np.array([0.0, 1.0])), "wrong shape"),
        (lambda: Placement(2 * np.eye(3)), "is not a rotation"),
        (lambda: Placement(np.diag([1.0, 1.0, -1.0])), "is not a rotation"),
        (lambda: Placement(np.eye(3), np.array([np.inf, 0, 0])), "not finite"),
        (lambda: link(mass=-1.0), "is negative"),
        (lambda: link(mass=np.nan), "not finite"),
        (lambda: link(com=np.zeros(2)), "wrong shape"),
        (lambda: link(inertia_com=np.triu(np.ones((3, 3)))), "not symmetric"),
        (lambda: link(inertia_com=np.diag([1.0, 1.0, -0.5])), "not positive semidefinite"),
        (lambda: link(inertia_com=np.diag([1.0, 1.0, 3.0])), "breaks the triangle inequality"),
        (lambda: Drive(inertia=-1.0), "drive is negative"),
        (lambda: Drive(inertia=np.nan), "drive is not finite"),
        (lambda: Drive(viscous={}), "viscous friction of a drive is not made of numbers"),
        (lambda: Drive(gear_ratio=[1.0]), "gear ratio of a drive has the wrong shape"),
        (lambda: Drive(coulomb=(0.1,)), "Coulomb friction of a drive has the wrong shape"),
        (lambda: Drive(torque_limit=-1.0), "torque limit of a drive is negative"),
        (lambda: DHRow(0.0, "1", 0.0, 0.0), "d of a Denavit-Hartenberg row is not made of numbers"),
        (
            lambda: RobotArm("a", (Joint("1"),), (link(),), dh_table=(DHRow(0.0, 0.0, 0.0, 0.0),) * 2),
            "needs one of its table rows per joint",
        ),
        (lambda: RobotArm("a", (Joint("1"),), (link(),), convention=7), "an arm's convention is not text"),
        (lambda: Drive(inertia_uncertainty=-0.1), "uncertainty of a drive's inertia is negative"),
        (lambda: Drive(inertia_uncertainty=np.inf), "uncertainty of a drive's inertia is not finite"),
        (lambda: LinkUncertainty(mass=-0.1), "uncertainty of a link's mass is negative"),
        (lambda: LinkUncertainty(com=np.array([0.0, -0.1, 0.0])), "uncertainty of a link's com is negative"),
        (lambda: LinkUncertainty(com=np.zeros(2)), "uncertainty of a link's com has the wrong shape"),
        (
            lambda: LinkUncertainty(inertia=np.full((3, 3), np.nan)),
            "uncertainty of a link's inertia is not f",
        ),
        (lambda: LinkUncertainty(inertia=np.triu(np.ones((3, 3)))), "link's inertia is not symmetric"),
        (lambda: LinkUncertainty(body_mass=-1.0), "mass of an uncertain body is negative"),
        (lambda: RobotArm("a", (), ()), "has no joints"),
        (lambda: RobotArm("a", (Joint("1"),), ()), "one of its links per joint"),
        (lambda: RobotArm("a", (Joint("1"),), (link(), link())), "one of its links per joint"),
        (
            lambda: RobotArm("a", (Joint("1"),), (link(),), drives=(Drive(), Drive())),
            "one of its drives per joint",
        ),
        (lambda: RobotArm("a", (Joint("1"),), (link(),), np.array([0, 0])), "wrong shape"),
    ],
)
def test_impossible_parts(build, says):
    with pytest.raises(ArmError, match=says):
        build()


@pytest.mark.parametrize(
    ("excess", "outcome"), [(0.0005, "fine"), (0.002, "warns"), (0.0999, "warns"), (0.1001, "fails")]
)
def test_triangle_inequality_by_how_much(excess, outcome):
    """I_zz = 1 = I_xx + I_yy + excess: rounding below 0.1 %, a measurement's error below 10 %."""
    inertia = np.diag([0.5, 0.5 - excess, 1.0])
    if outcome == "fails":
        with pytest.raises(ArmError):
            link(inertia_com=inertia)
    elif outcome == "warns":
        assert "breaks the triangle inequality" in slip(link(inertia_com=inertia))
        assert "triangle" not in slip(link(inertia_com=inertia, as_measured=True))
    else:
        link(inertia_com=inertia)


def test_a_rod_without_thickness_is_possible():
    link(inertia_com=np.diag([0.0, 1 / 12, 1 / 12]))


def slip(of: Link) -> str:
    return "\n".join(slips_of(RobotArm("a", (Joint("1"),), (of,))))


def test_com_far_away_is_a_slip():
    assert "centre of mass of link l is 0.2 m from" in slip(link(com=np.array([0.2, 0, 0])))
    assert "centre of mass" not in slip(link(com=np.array([0.2, 0, 0]), mass=0.0))


def test_values_cannot_be_changed(puma):
    with pytest.raises(dataclasses.FrozenInstanceError):
        puma.name = "other"
    for array in (puma.gravity, puma.mass, puma.com, puma.inertia_com, puma.drive_inertia, puma.links[0].com):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_the_callers_arrays_stay_the_callers():
    com = np.zeros(3)
    made = link(com=com)
    com[0] = 0.05
    assert made.com[0] == 0.0


@examples(50)
@given(arms())
def test_description_round_trip(arm):
    text = json.dumps(describe(arm), allow_nan=False)
    again = arm_from_description(json.loads(text))
    assert fingerprint(again) == fingerprint(arm)
    assert describe(again) == describe(arm)


def test_description_of_the_shipped_arms(puma, two_link):
    for arm in (puma, two_link):
        again = arm_from_description(json.loads(json.dumps(describe(arm))))
        assert fingerprint(again, drives=True) == fingerprint(arm, drives=True)
        assert again.limits("upper").tolist() == arm.limits("upper").tolist()


def test_description_keeps_what_is_known_of_the_uncertainties(puma):
    stated = LinkUncertainty(0.1, np.array([0.01, 0.02, 0.03]), 0.004 * np.eye(3), "origin")
    carried = with_payload(
        dataclasses.replace(puma, links=(*puma.links[:-1], link(uncertainty=stated))), 1.0, [0, 0, 0.1]
    )
    bare = dataclasses.replace(puma, links=(*puma.links[:-1], link()))
    for arm in (puma, carried, bare):
        again = arm_from_description(json.loads(json.dumps(describe(arm))))
        assert describe(again) == describe(arm)
        assert [drive.inertia_uncertainty for drive in again.drives] == [
            drive.inertia_uncertainty for drive in puma.drives
        ]
    found = arm_from_description(describe(carried)).links[-1].uncertainty
    assert (found.mass, found.inertia_about, found.body_mass) == (0.1, "origin", 1.0)
    np.testing.assert_array_equal(found.com, stated.com)
    np.testing.assert_array_equal(found.inertia, stated.inertia)
    np.testing.assert_array_equal(found.body_com, np.zeros(3))


def test_a_description_without_uncertainties_is_of_an_arm_that_states_none(puma):
    """As in files written before arms could state any."""
    old = describe(puma)
    del old["drive_inertia_uncertainty"]
    for entry in old["links"]:
        del entry["uncertainty"]
    again = arm_from_description(old)
    assert all(entry.uncertainty is None for entry in again.links)
    assert all(drive.inertia_uncertainty is None for drive in again.drives)
    assert fingerprint(again, drives=True) == fingerprint(puma, drives=True)


def test_uncertainties_are_no_part_of_the_fingerprint():
    """What acts on torque is; how well it is known changes no result that was made for the arm."""
    plain = RobotArm("a", (Joint("1"),), (link(),), drives=(Drive(1.0),))
    stated = RobotArm(
        "a",
        (Joint("1"),),
        (link(uncertainty=LinkUncertainty(0.1, 0.01 * np.ones(3), 0.001 * np.eye(3))),),
        drives=(Drive(1.0, 0.1),),
    )
    assert fingerprint(stated, drives=True) == fingerprint(plain, drives=True)
    # As it was before arms could state uncertainties: model files name arms by it.
    assert fingerprint(plain) == "e2d53fe166ba8618a5c5d9d0ef23435d8285b50c9e8f86a907855992e3ab1eb6"


def test_the_pumas_link_inertias_are_good_to_ten_percent(puma):
    for part in puma.links:
        assert (part.uncertainty.mass, part.uncertainty.com) == (None, None)
        # Both are typed as decimal numbers: a rounding each, and one of the product.
        np.testing.assert_allclose(part.uncertainty.inertia, 0.1 * part.inertia_com, rtol=1e-15)


def leaves(value, keys=()):
    """Places of all numbers and words in nested JSON values."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*keys, key))
    elif isinstance(value, list):
        for key, inner in enumerate(value):
            yield from leaves(inner, (*keys, key))
    else:
        yield keys, value


ACTING = {"gravity", "kind", "placement", "axis", "mass", "com", "inertia_com", "frame"}


def test_fingerprint_changes_with_every_number_that_acts_and_with_nothing_else(puma):
    """Through the fingerprint of an edited description, where that still describes a possible arm."""
    before = fingerprint(puma)
    changed = unchanged = 0
    for keys, value in leaves(describe(puma)):
        edited = json.loads(json.dumps(describe(puma)))
        inner = edited
        for key in keys[:-1]:
            inner = inner[key]
        if isinstance(value, bool) or value is None:
            continue
        # The smallest change there is; numbers of rotations and inertias stay within what is possible.
        inner[keys[-1]] = value + "x" if isinstance(value, str) else float(np.nextafter(value, 2.0))
        if keys[-1] == "kind":
            inner[keys[-1]] = "prismatic"
        if "axial_only" in str(keys):
            continue
        try:
            after = fingerprint(arm_from_description(edited))
        except ArmError:
            continue  # e.g. an inertia edited on one side of its diagonal
        if ACTING & set(keys) and "uncertainty" not in keys:
            assert after != before, keys
            changed += 1
        else:
            assert after == before, keys
            unchanged += 1
    assert changed > 150
    assert unchanged > 30


def test_fingerprint_of_drives_on_request(puma):
    other = dataclasses.replace(puma, drives=(Drive(9.0), *puma.drives[1:]))
    assert fingerprint(other) == fingerprint(puma)
    assert fingerprint(other, drives=True) != fingerprint(puma, drives=True)


def test_fingerprint_does_not_care_how_a_number_was_typed():
    one = RobotArm("a", (Joint("1"),), (link(mass=2),))
    same = RobotArm("b", (Joint("other name"),), (link(mass=np.float32(2.0), name="x"),))
    assert fingerprint(one) == fingerprint(same)


@examples(50)
@given(arms())
def test_reach_bounds_every_pose(arm):
    from gd_analyze.kinematics import solve_kinematics

    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (arm.n_joints, 20))
    slides = [not revolute for revolute in arm.is_revolute]
    q[slides] = 0.0
    kinematics = solve_kinematics(arm, q)
    distance = np.linalg.norm(kinematics.link_origins - kinematics.joint_origins[0], axis=1).max()
    assert distance <= arm.reach * (1 + 1e-13)  # some 20 roundings per joint
