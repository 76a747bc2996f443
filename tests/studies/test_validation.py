"""A model over motions: errors, promises, measured torques, states outside a box, and JUnit XML."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.certification.box import Box
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.simulation import Integration, simulate
from gd_analyze.errors import TrajectoryError, UsageError
from gd_analyze.motions.pool import pool, taken_apart
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.validation import Validation, box_exits, validate
from gd_analyze.studies.validation_result import junit_xml
from made_models import ROUND_OFF, exact_model
from recorded_logs import recorded, with_torques
from several_motions import swung


@pytest.fixture(scope="module")
def rough(two_link: RobotArm) -> SimplifiedModel:
    """Made for a slow motion, where terms in rates may go; 5 % of its peak torque."""
    return gd.simplify(two_link, swung(6.0, "slow"), "5%")


def test_the_exact_model_is_off_by_round_off_alone(two_link, swing):
    found = validate(exact_model(two_link), [swing, swung(2.0, "brisk")], fail_over=f"{100 * ROUND_OFF}%")
    assert found.passed
    for one in found.motions:
        errors = one.evaluation.errors
        assert (errors.largest <= ROUND_OFF * errors.peak_torque.max()).all()
        assert one.keeps_promise.all()
        assert one.measured is None


def test_a_model_keeps_its_promise_where_it_was_made(rough):
    found = validate(rough, swung(6.0, "slow"), fail_over="promise")
    (one,) = found.motions
    # The same program at the same states, so the same bits.
    np.testing.assert_array_equal(one.evaluation.errors.largest, rough.accuracy.errors.largest)
    np.testing.assert_array_equal(one.most, rough.accuracy.allowed)
    assert found.passed
    assert one.keeps_promise.all()


def test_a_model_beyond_its_promise_fails(rough):
    fast = swung(1.0, "fast")
    judged, told = (validate(rough, fast, fail_over=asked) for asked in ("promise", None))
    (one,) = told.motions
    expected = gd.evaluate(rough, fast).errors.largest > rough.accuracy.allowed
    assert expected.any()
    assert one.keeps_promise.tolist() == (~expected).tolist()
    assert judged.motions[0].fails.tolist() == expected.tolist()
    assert [joint for _, joint in judged.failures] == np.flatnonzero(expected).tolist()
    assert not judged.passed
    assert told.passed
    assert (one.most, told.failures) == (None, ())


def test_an_error_as_large_as_it_may_be_passes(rough):
    fast = swung(1.0, "fast")
    largest = gd.evaluate(rough, fast).errors.largest
    for factor, passes in ((1.0, True), (1.0 - 1e-12, False)):
        budget = Budget.of_torques(factor * largest)
        assert validate(rough, fast, fail_over=budget).passed == passes


def test_the_instant_of_the_largest_error(rough):
    fast = swung(1.0, "fast")
    (one,) = validate(rough, fast).motions
    error = np.abs(one.evaluation.torque - one.evaluation.dynamics.torque)
    for joint, at in enumerate(one.at):
        assert error[fast.time.tolist().index(at), joint] == error[:, joint].max()


def test_each_motion_is_judged_by_itself(rough):
    slow, fast = swung(6.0, "slow"), swung(1.0, "fast")
    alone = [validate(rough, one, fail_over="1%").motions[0] for one in (slow, fast)]
    together = validate(rough, [slow, fast], fail_over="1%")
    assert [one.name for one in together.motions] == ["slow", "fast"]
    for one, other in zip(together.motions, alone, strict=True):
        np.testing.assert_array_equal(one.most, other.most)
        assert one.fails.tolist() == other.fails.tolist()
    pooled = validate(rough, pool([slow, fast]), fail_over="1%")
    assert [one.fails.tolist() for one in pooled.motions] == [one.fails.tolist() for one in alone]


def test_a_joint_that_needs_no_torque_is_judged_by_the_other_motions(puma, pick_and_place):
    model = exact_model(puma)
    q = np.tile(pick_and_place.q[:1], (2, 1))
    # Gravity moves nothing about the vertical axis of the first joint.
    rest = Trajectory(np.arange(2.0), q, 0 * q, 0 * q, "rest")
    still, moving = validate(model, [rest, pick_and_place], fail_over="1%").motions
    assert still.evaluation.errors.peak_torque[0] == 0.0
    assert still.most[0] == moving.most[0] == 0.01 * moving.evaluation.errors.peak_torque[0]
    assert still.most[1] == 0.01 * still.evaluation.errors.peak_torque[1]


def test_the_promise_along_one_of_several_motions(two_link):
    motions = [swung(6.0, "slow"), swung(2.0, "brisk")]
    model = gd.simplify(two_link, motions, "5%")
    found = validate(model, motions, fail_over="promise")
    assert found.passed
    for one, promised in zip(found.motions, model.accuracy.motions, strict=True):
        np.testing.assert_array_equal(one.most, promised.allowed)
        np.testing.assert_array_equal(one.evaluation.errors.largest, promised.errors.largest)


def test_a_promise_of_the_norm_is_kept_by_all_joints_or_none(two_link):
    slow, fast = swung(6.0, "slow"), swung(1.0, "fast")
    model = gd.simplify(two_link, slow, "5% norm at 95%")
    kept, broken = validate(model, [slow, fast]).motions
    assert (kept.keeps_promise.tolist(), kept.allowed) == ([True, True], None)
    asked = model.accuracy.asked.norm
    assert broken.keeps_promise.tolist() == [broken.evaluation.keeps(asked)] * 2
    assert not broken.keeps_promise.any()
    with pytest.raises(UsageError, match="promises no joint an error of its own") as caught:
        validate(model, slow, fail_over="promise")
    assert caught.value.details["where"] == "--fail-over"


def test_the_box_is_the_arms_limits_or_the_one_given(two_link, rough):
    fast = swung(1.0, "fast")
    box = Box.of(two_link)
    (one,) = validate(rough, fast).motions
    beyond = (
        (fast.q < box.lower)
        | (fast.q > box.upper)
        | (np.abs(fast.qd) > box.velocity)
        | (np.abs(fast.qdd) > box.acceleration)
    )
    assert beyond.any()
    assert one.outside.tolist() == beyond.any(axis=1).tolist()
    around = Box.around(fast.q, fast.qd, fast.qdd)
    assert not validate(rough, fast, box=around).motions[0].outside.any()


def test_friction_of_a_log_is_found_beside_the_exact_torque(two_link, rough):
    log = recorded(two_link, friction=(2.0, 0.7, 0.3))
    (one,) = validate(rough, log).motions
    # Sums of 500 readings of some 30 N m beside terms of the order of 1: round-off is far below.
    np.testing.assert_allclose(one.measured.exact.friction.terms, [[2.0, 0.7, 0.3]] * 2, rtol=1e-9)
    assert (one.measured.exact.friction.rms < 1e-9).all()
    # What was dropped is not friction, and stays.
    assert (one.measured.simplified.friction.rms > 1e-3).any()
    alone = gd.compare_torque(two_link, log)
    np.testing.assert_array_equal(one.measured.exact.rms, alone.rms)
    error = one.evaluation.torque - log.recording.torque
    # RMS about nothing, of the same 500 numbers: roundings of their sum.
    np.testing.assert_allclose(one.measured.simplified.rms, np.sqrt((error**2).mean(axis=0)), rtol=1e-9)


def test_friction_of_a_simulation_is_found(two_link):
    damping = np.array([1.5, 0.4])

    def pushed(t, q, qd):
        return np.array([12.0 + 9.0 * np.sin(5.0 * t), 3.0 * np.cos(7.0 * t)])

    how = Integration(rtol=1e-6, atol=1e-6, set_points=200)
    run = simulate(
        two_link, pushed, np.array([0.3, -0.4]), np.zeros(2), 2.0, Drivetrain(damping=damping), how
    )
    log = with_torques(run.as_trajectory("simulated"), run.torque)
    (one,) = validate(exact_model(two_link), log).motions
    for of in (one.measured.exact, one.measured.simplified):
        # qdd solves D qdd = torque - h - c - damping qd at every set point to round-off, however coarse the
        # integration: 1e-13 N m of torques of some ten.
        np.testing.assert_allclose(of.friction.terms[:, 1], damping, rtol=1e-9)
        np.testing.assert_allclose(of.friction.terms[:, [0, 2]], 0.0, atol=1e-9)


def test_motions_without_torques_beside_such_with(two_link, rough):
    log = recorded(two_link)
    with_, without = validate(rough, [log, swung(6.0, "slow")]).motions
    assert with_.measured is not None
    assert without.measured is None
    # A pool keeps no readings of its parts, see `taken_apart`.
    assert taken_apart(pool([log, swung(6.0, "slow")]))[0].recording is None


@pytest.mark.parametrize(
    ("fail_over", "says", "where"),
    [
        ("1% frction", "not understood", "--fail-over, entry 1"),
        ("1%,1%,1%", "wrong number of entries", "--fail-over"),
        ("1% norm", "cannot be had with a budget of the norm", "--fail-over"),
        ("much norm", "not understood", "--fail-over"),
        ("10% friction", "the arm states none", "--fail-over, joint 1, shoulder, of two_link"),
        (0.01, "this is no budget", "budget"),
    ],
)
def test_what_is_no_verdict(rough, fail_over, says, where):
    with pytest.raises(UsageError, match=says) as caught:
        validate(rough, swung(6.0, "slow"), fail_over=fail_over)
    assert caught.value.details["where"] == where


def test_what_is_of_another_arm(rough, pick_and_place, puma):
    with pytest.raises(TrajectoryError, match="pick-and-place is not for arm two_link"):
        validate(rough, pick_and_place)
    with pytest.raises(TrajectoryError, match="there are no motions"):
        validate(rough, [])
    with pytest.raises(UsageError, match="the box does not fit the arm"):
        validate(rough, swung(6.0, "slow"), box=Box.of(puma))


TWO_LINK = load_arm("two_link")
BOX = Box(np.array([-1.0, -2.0]), np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([5.0, 6.0]))


def motion(count: int = 11, gaps: tuple[int, ...] = (), **columns: list[float]) -> Trajectory:
    """At rest in the middle of the box every tenth of a second, but for columns such as q1, qd2."""
    states = {name: np.zeros((count, 2)) for name in ("q", "qd", "qdd")}
    for column, values in columns.items():
        states[column[:-1]][:, int(column[-1]) - 1] = values
    return Trajectory(np.arange(count) / 10, *states.values(), gaps=gaps)


def test_a_rounded_digit_beyond_a_limit_is_none():
    exits, _ = box_exits(TWO_LINK, motion(q1=[1.0 + 1e-10] * 11, qd1=[-3.0 - 1e-10] * 11), BOX)
    assert exits == ()


def test_a_ramp_leaves_at_a_known_instant():
    ramp = [0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.1, 0.8, 0.5, 0.2, 0.0]
    (found,), outside = box_exits(TWO_LINK, motion(q1=ramp), BOX)
    farthest = found.farthest
    assert (farthest.joint, farthest.name, farthest.quantity) == (1, "shoulder", "position")
    assert (farthest.value, farthest.limit, farthest.time, farthest.unit) == (1.5, 1.0, 0.5, "rad")
    assert (found.set_points, found.first, found.begin, found.end) == (3, 0.4, 0.4, 0.6)
    assert np.flatnonzero(outside).tolist() == [4, 5, 6]


def test_velocities_and_accelerations_count_by_magnitude_and_each_limit_by_itself():
    there = motion(q2=[-2.5, 2.5, *[0.0] * 9], qd1=[*[0.0] * 9, -3.5, 3.1], qdd2=[0.0, -7.0, 6.5, *[0.0] * 8])
    exits, outside = box_exits(TWO_LINK, there, BOX)
    told = [
        (e.farthest.joint, e.farthest.quantity, e.farthest.value, e.farthest.limit, e.farthest.unit)
        for e in exits
    ]
    assert told == [
        (1, "velocity", 3.5, 3.0, "rad/s"),
        (2, "position", -2.5, -2.0, "rad"),
        (2, "position", 2.5, 2.0, "rad"),
        (2, "acceleration", 7.0, 6.0, "rad/s^2"),
    ]
    assert np.flatnonzero(outside).tolist() == [0, 1, 2, 9, 10]


def test_the_longest_stretch_ends_at_a_gap():
    beyond = [0.0, 2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 2.0, 2.0, 2.0, 0.0]
    whole, parted = (box_exits(TWO_LINK, motion(q1=beyond, gaps=gaps), BOX)[0][0] for gaps in ((), (3,)))
    assert (whole.begin, whole.end, whole.set_points) == (0.1, 0.4, 7)
    # 1, 2 | 3, 4 and 7 to 9.
    assert (parted.begin, parted.end, parted.set_points, parted.first) == (0.7, 0.9, 7, 0.1)


@given(
    st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=40),
    st.sets(st.integers(1, 39)),
)
def test_as_found_one_by_one(values, gaps):
    gaps = tuple(sorted(gap for gap in gaps if gap < len(values)))
    there = motion(len(values), gaps=gaps, q1=values)
    exits, outside = box_exits(TWO_LINK, there, BOX)
    # The rounded digit is 1e-9, and a limit of 1.
    expected = [abs(value) - 1.0 > 1e-9 for value in values]
    assert outside.tolist() == expected
    assert sum(e.set_points for e in exits) == sum(expected)
    for e in exits:
        side = 1.0 if e.farthest.limit > 0 else -1.0
        beyond = [side * value - 1.0 > 1e-9 for value in values]
        assert e.first == there.time[beyond.index(True)]
        assert e.farthest.value == side * max(side * value for value in values)
        lengths, run = [], None
        for k, is_beyond in enumerate(beyond):
            run = None if not is_beyond else k if run is None or k in gaps else run
            if run is not None:
                lengths.append(there.time[k] - there.time[run])
        assert e.end - e.begin == pytest.approx(max(lengths), abs=1e-15)


def counted(element: ElementTree.Element) -> dict[str, int]:
    return {name: int(element.attrib[name]) for name in ("tests", "failures", "errors", "skipped")}


def read(found: Validation) -> ElementTree.Element:
    return ElementTree.fromstring(junit_xml(found).encode())


def test_a_case_per_motion_and_joint(rough):
    found = validate(rough, [swung(6.0, "slow"), swung(1.0, "fast")], fail_over="promise")
    root = read(found)
    assert root.tag == "testsuites"
    assert counted(root) == {"tests": 4, "failures": len(found.failures), "errors": 0, "skipped": 0}
    assert [suite.attrib["name"] for suite in root] == ["slow", "fast"]
    for suite, one in zip(root, found.motions, strict=True):
        cases = suite.findall("testcase")
        assert [case.attrib["name"] for case in cases] == ["joint 1 shoulder", "joint 2 elbow"]
        assert {case.attrib["classname"] for case in cases} == {one.name}
        assert [case.find("failure") is not None for case in cases] == one.fails.tolist()
        assert counted(suite)["failures"] == int(one.fails.sum())
        for joint, case in enumerate(cases):
            failure = case.find("failure")
            told = case.findtext("system-out") if failure is None else failure.attrib["message"]
            assert told == one.error_text(joint)
    about = {p.attrib["name"]: p.attrib["value"] for p in root[1].iter("property")}
    assert about["fail over"] == "promise"
    assert about["set points outside the box"] == str(int(found.motions[1].outside.sum()))


HOSTILE = (
    "<b>&\"'",
    "]]>",
    "--><!--",
    "</testcase><failure/>",
    "&#0;&lt;",
    "Ünïcødé \U0001f916",
    "\x00\x01\x08\x1b[2J",
    "line\nbreak\r\ttab",
    "\ufffe\uffff\ud800\u202e",
    "",
)


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_names_stay_in_their_place(rough, name):
    form = rough.form
    joints = form.arm.joints
    # An arm refuses what does not show; where it can be had, joint and arm bear the name, too.
    arm = form.arm
    if name and name.isprintable():
        arm = replace(arm, name=name, joints=(replace(joints[0], name=name), joints[1]))
    model = replace(rough, form=ExactForm(arm, form.drives))
    found = validate(model, swung(1.0, name), fail_over="1%")
    text = junit_xml(found)
    text.encode("utf-8")
    assert not any(ord(sign) < 32 and sign != "\n" for sign in text)
    root = ElementTree.fromstring(text.encode())
    assert [element.tag for element in root] == ["testsuite"]
    assert len(root.findall("testsuite/testcase")) == counted(root)["tests"] == 2
    assert len(list(root.iter("failure"))) == counted(root)["failures"]
    shown = root[0].attrib["name"]
    assert "\n" not in shown
    if name.isprintable():
        assert shown == name
    if arm is not form.arm:
        assert root.findall("testsuite/testcase")[0].attrib["name"] == f"joint 1 {name}"
