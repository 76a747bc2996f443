"""Two files of one robot: whatever their frames, the torques compared are those of the same motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from chains import generic_chain
from gd_analyze.arrays import turn_about
from gd_analyze.dynamics.same_base import SameBase
from gd_analyze.errors import ArmError
from gd_analyze.studies.comparison import Comparison, states_for_both
from gd_analyze.studies.comparison_result import compared_result
from gd_analyze.types import Drive, Joint, Link, Placement, RobotArm, States
from long_cases import long
from strategies import arms, examples, random_rotation, random_states

NAMES = ("a.urdf", "b.xml")


def otherwise_framed(
    arm: RobotArm, seed: int, signs: tuple[float, ...] = (), zeros: tuple[float, ...] = ()
) -> RobotArm:
    """The same arm in other base and link frames, and joints at sign q + zero where its own are at q."""
    rng = np.random.default_rng(seed)
    base, place = random_rotation(rng), rng.normal(size=3)
    joints, links, before = [], [], Placement(base, place)
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        placement = together(before, joint.placement)
        axis = joint.axis * (signs[i] if signs else 1.0)
        if zeros and zeros[i]:
            back = turn_about(axis, np.cos([zeros[i]]), -np.sin([zeros[i]]))[..., 0]
            placement = together(placement, Placement(back))
        joints.append(replace(joint, placement=placement, axis=axis))
        turn = Placement(random_rotation(rng), rng.normal(size=3))
        into = turn.rotation.T
        before = Placement(into, -into @ turn.translation)
        links.append(
            replace(
                link,
                frame=together(link.frame, turn),
                com=into @ (link.com - turn.translation),
                inertia_com=into @ link.inertia_com @ turn.rotation,
            )
        )
    return replace(
        arm,
        joints=tuple(joints),
        links=tuple(links),
        gravity_vector=base @ arm.gravity_vector,
        dh_table=(),
        convention="placement",
    )


def together(first: Placement, second: Placement) -> Placement:
    translation = first.rotation @ second.translation + first.translation
    return Placement(first.rotation @ second.rotation, translation)


def changed(arm: RobotArm, index: int, **numbers) -> RobotArm:
    links = list(arm.links)
    links[index] = replace(links[index], **numbers)
    return replace(arm, links=tuple(links), dh_table=(), convention="placement")


def compared(first: RobotArm, second: RobotArm, count: int = 40) -> Comparison:
    return Comparison.of(first, second, random_states(first.n_joints, count, 5))


@examples(20)
@given(arms(max_joints=6, massive=True), st.integers(0, 2**31))
def test_frames_make_no_difference(arm, seed):
    comparison = compared(arm, otherwise_framed(arm, seed))
    # Frames turned at random take some hundred roundings of each torque's summands, which may cancel.
    assert comparison.shares(comparison.largest).max() < 1e-6
    base = comparison.base
    assert (base.signs > 0).all()
    np.testing.assert_allclose(base.turned, 0, atol=1e-7)
    np.testing.assert_allclose(base.apart, 0, atol=1e-7 * max(arm.reach, 1.0))


@pytest.mark.slow
@examples(3)
@given(st.integers(0, 2**31), st.integers(0, 5))
def test_what_differs_is_found_in_any_frames(seed, index):
    """A link's mass and centre, drives, senses and zeros of joints, all at once."""
    arm, rng = (
        replace(gd.load_arm("puma560"), dh_table=(), convention="placement"),
        np.random.default_rng(seed),
    )
    link = arm.links[index]
    heavier = changed(arm, index, mass=1.3 * link.mass + 0.1, com=1.2 * link.com + 0.01)
    signs = tuple(rng.choice([1.0, -1.0], arm.n_joints).tolist())
    drives = tuple(replace(drive, inertia=drive.inertia * 1.1) for drive in arm.drives)
    # How the base is turned about the first axis, and the last joint's zero, no axis tells.
    zeros = (0.0, *rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], 4).tolist(), 0.0)
    other = otherwise_framed(replace(heavier, drives=drives), seed, signs, zeros)
    comparison = compared(arm, other)
    kinds = {(part.kind, part.link) for part in comparison.parts}
    # The wrist's axes meet in a point: two senses and a half turn may be one and the same.
    assert kinds - {("senses", None), ("zeros", None)} == {("link", index), ("drives", None)}
    steps = comparison.steps()
    left = [comparison.shares(step.left).max() for step in steps]
    assert left[-1] < 1e-9


@pytest.mark.parametrize("seed", [0, 1, *map(long, range(2, 6))])
def test_senses_and_zeros_of_joints(seed):
    arm, rng = generic_chain(4), np.random.default_rng(seed)
    signs = tuple(rng.choice([1.0, -1.0], 4).tolist())
    # How the base is turned about the first axis, no axis tells.
    zeros = (0.0, *rng.choice([0.0, np.pi / 2, -np.pi / 2, np.pi], 3).tolist())
    comparison = compared(arm, otherwise_framed(arm, seed, signs, zeros))
    assert comparison.base.signs.tolist() == list(signs)
    np.testing.assert_allclose(np.exp(1j * comparison.base.zeros), np.exp(1j * np.array(zeros)), atol=1e-9)
    assert {part.kind for part in comparison.parts} <= {"senses", "zeros"}
    assert all(comparison.shares(step.left).max() < 1e-9 for step in comparison.steps()[-1:])


def test_each_part_alone_and_what_is_left(two_link):
    arm = replace(two_link, dh_table=(), convention="placement")
    heavy = changed(arm, 1, mass=2.0 * arm.links[1].mass)
    moon = replace(heavy, gravity_vector=arm.gravity_vector / 6)
    comparison = compared(arm, moon, 200)
    first, last = comparison.steps()
    states = comparison.states
    for step, alone in zip(
        sorted((first, last), key=lambda step: step.part.kind),
        (replace(arm, gravity_vector=moon.gravity_vector), heavy),
        strict=True,
    ):
        dynamics = gd.types.ArmDynamics(alone).torque(*states.arrays) - comparison.torques[0]
        np.testing.assert_allclose(step.alone, np.abs(dynamics).max(axis=0), rtol=1e-9)
    assert comparison.shares(last.left).max() < 1e-9 < comparison.shares(first.left).max()
    values = compared_result(comparison, NAMES).values()
    assert [row["kind"] for row in values["parts"]] == [first.part.kind, last.part.kind]
    assert not values["agrees"]
    assert values["largest_share"] == pytest.approx(comparison.shares(comparison.largest).max())


def test_axes_that_differ_are_named(two_link):
    """The link's centre is stated from its far end, and moves with it."""
    longer = replace(two_link.links[0], frame=Placement(translation=np.array([1.1, 0.0, 0.0])))
    other = replace(two_link, links=(longer, two_link.links[1]), dh_table=(), convention="placement")
    comparison = compared(two_link, other)
    assert {(part.kind, part.link) for part in comparison.parts} == {("axes", None), ("link", 0)}
    np.testing.assert_allclose(comparison.base.apart, [0.0, 0.1], atol=1e-9)
    assert comparison.shares(comparison.steps()[-1].left).max() < 1e-9


@pytest.mark.parametrize("joint", [long(1), 2, long(3), long(4)])
def test_one_axis_elsewhere_leaves_the_links_as_they_are(joint):
    """In other frames, too, with senses and a zero that differ; along its axis a joint may be anywhere."""
    arm = generic_chain(5)
    moved = list(arm.joints)
    place = moved[joint].placement
    moved[joint] = replace(
        moved[joint], placement=Placement(place.rotation, place.translation + np.array([0.004, 0.0, 0.0]))
    )
    signs, zeros = (1.0, -1.0, 1.0, 1.0, -1.0), (0.0, 0.0, np.pi / 2, 0.0, 0.0)
    for other in (
        replace(arm, joints=tuple(moved)),
        otherwise_framed(replace(arm, joints=tuple(moved)), 3, signs, zeros),
    ):
        comparison = compared(arm, other)
        steps = comparison.steps()
        assert {"axes"} <= {step.part.kind for step in steps} <= {"axes", "senses", "zeros"}
        assert comparison.shares(steps[-1].left).max() < 1e-9


def test_joints_are_paired_by_name_or_from_base_to_tip(two_link):
    arm = replace(two_link, dh_table=(), convention="placement")
    renamed = replace(arm, joints=tuple(replace(j, name=f"j{k}") for k, j in enumerate(arm.joints)))
    result = compared_result(compared(arm, renamed), NAMES)
    assert result.values()["agrees"]
    assert [row["second_joint"] for row in result.values()["joints"]] == ["j0", "j1"]
    names = arm.joint_names
    swapped = replace(
        arm, joints=tuple(replace(j, name=n) for j, n in zip(arm.joints, names[::-1], strict=True))
    )
    comparison = compared(arm, swapped)
    assert comparison.order == (1, 0)
    q, qd, qdd = (x[:, ::-1] for x in comparison.states.arrays)
    theirs = gd.types.ArmDynamics(swapped).torque(q, qd, qdd)[:, ::-1]
    np.testing.assert_allclose(comparison.torques[1], theirs, rtol=1e-12)
    told = compared_result(comparison, NAMES).values()
    assert "parts" not in told
    assert "paired by name" in told["notices"][0]


def test_arms_that_cannot_be_compared(two_link, puma):
    with pytest.raises(ArmError, match=r"different numbers of joints; found: two_link: 2 .*; puma560: 6"):
        compared(two_link, puma)
    slides = replace(two_link.joints[1], kind="prismatic")
    other = replace(two_link, joints=(two_link.joints[0], slides), dh_table=(), convention="placement")
    with pytest.raises(ArmError, match="joint 2"):
        compared(two_link, other)


def test_limits_of_either_file_bound_the_states(two_link):
    def bounded(joint: Joint, **limits: float) -> Joint:
        unknown = dict.fromkeys(("lower", "upper", "velocity_limit", "acceleration_limit"))
        return replace(joint, **(unknown | limits))

    ranges = replace(two_link, joints=tuple(bounded(j, lower=0.1, upper=0.2) for j in two_link.joints))
    others = replace(
        two_link,
        joints=tuple(bounded(j, velocity_limit=0.3, acceleration_limit=0.4) for j in two_link.joints),
    )
    states = states_for_both(ranges, others, 50, 0)
    assert (states.q.min(), states.q.max()) >= (0.1, 0.1)
    assert states.q.max() <= 0.2
    assert np.abs(states.qd).max() <= 0.3
    assert np.abs(states.qdd).max() <= 0.4


def test_friction_is_told_beside(two_link):
    drive = Drive(viscous=0.1)
    other = replace(two_link, drives=(Drive(), drive))
    result = compared_result(compared(two_link, other), NAMES)
    assert result.values()["agrees"]
    assert any("Friction" in notice and "joint 2" in notice for notice in result.notices)


def test_one_joint_alone(two_link):
    rod = Link("rod", 1.0, np.array([0.5, 0.0, 0.0]), np.diag([0.0, 0.1, 0.1]))
    arm = RobotArm("one", (Joint("a"),), (rod,), gravity_vector=np.array([0.0, -9.81, 0.0]))
    comparison = compared(arm, otherwise_framed(arm, 3))
    assert comparison.shares(comparison.largest).max() < 1e-9
    assert SameBase.of(arm, arm).signs.tolist() == [1.0]


def test_states_of_one_arm_are_those_of_the_other(two_link):
    states = States(*(np.full((1, 2), x) for x in (0.3, 0.2, 0.1)))
    assert Comparison.of(two_link, two_link, states).largest.max() == 0.0


def test_files_are_named_without_their_folders_unless_they_have_one_name(two_link):
    for names, title, heading in (
        (("here/a.urdf", "there/b.xml"), "a.urdf and b.xml", "b.xml"),
        (("here/a.urdf", "there/a.urdf"), "here/a.urdf and there/a.urdf", "second"),
    ):
        result = compared_result(compared(two_link, two_link), names)
        assert result.title == title
        assert [column.label for column in result.parts[0].columns][2] == heading
