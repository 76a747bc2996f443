"""A model over motions: errors, promises, measured torques, states outside a box, and JUnit XML."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze import Trajectory, evaluate
from gd_analyze.errors import ModelError, TrajectoryError, UsageError
from gd_analyze.studies.box_exits import box_exits, outside_of
from gd_analyze.studies.evaluation_result import evaluation_result, junit_xml
from gd_analyze.tables import states_of
from gd_analyze.types import Box, ExactForm
from made_models import ROUND_OFF, exact_model
from recordings import recorded, swung
from strategies import examples

SLOW, BRISK, FAST = swung(6.0, "slow"), swung(2.0, "brisk"), swung(1.0, "fast")


@pytest.fixture(scope="module")
def rough(two_link) -> gd.types.SimplifiedModel:
    """Made for a slow motion, where terms in velocities may go; 5 % of its peak torque."""
    return gd.simplify(two_link, SLOW, "5%")


def test_the_exact_model_is_off_by_round_off_alone(two_link, swing):
    found = evaluate(exact_model(two_link), [swing, BRISK], fail_over=f"{100 * ROUND_OFF}%")
    assert found.passed
    for one in found.motions:
        errors = one.errors
        assert (errors.largest <= ROUND_OFF * errors.peak_torque.max()).all()
        assert one.measured is None


def test_a_model_keeps_its_promise_where_it_was_made_and_not_beyond(rough):
    found = evaluate(rough, SLOW, fail_over="promise")
    (one,) = found.motions
    # The same program at the same states, so the same bits.
    np.testing.assert_array_equal(one.errors.largest, rough.accuracy.errors.largest)
    np.testing.assert_array_equal(one.most, rough.accuracy.allowed)
    assert found.passed
    judged, told = (evaluate(rough, FAST, fail_over=asked) for asked in ("promise", None))
    (one,) = told.motions
    expected = evaluate(rough, FAST).errors.largest > rough.accuracy.allowed
    assert expected.any()
    assert judged.motions[0].fails.tolist() == expected.tolist()
    assert [joint for _, joint in judged.failures] == np.flatnonzero(expected).tolist()
    assert (judged.passed, told.passed, one.most, told.failures) == (False, None, None, ())


def test_an_error_as_large_as_it_may_be_passes_and_its_instant_is_known(rough):
    largest = evaluate(rough, FAST).errors.largest
    found, below = (
        evaluate(rough, FAST, fail_over=gd.types.Budget.of_torques(x * largest)) for x in (1.0, 1.0 - 1e-12)
    )
    assert (found.passed, below.passed) == (True, False)
    (one,) = found.motions
    error = np.abs(one.torque - one.dynamics.torque)
    for joint, at in enumerate(one.at):
        assert error[FAST.time.tolist().index(at), joint] == error[:, joint].max()


def test_each_motion_is_judged_by_itself(two_link, rough):
    alone = [evaluate(rough, one, fail_over="1%").motions[0] for one in (SLOW, FAST)]
    for motions in ([SLOW, FAST], gd.pool([SLOW, FAST])):
        together = evaluate(rough, motions, fail_over="1%").motions
        assert [one.name for one in together] == ["slow", "fast"]
        for one, other in zip(together, alone, strict=True):
            np.testing.assert_array_equal(one.most, other.most)
            assert one.fails.tolist() == other.fails.tolist()
    model = gd.simplify(two_link, [SLOW, BRISK], "5%")
    found = evaluate(model, [SLOW, BRISK], fail_over="promise")
    assert found.passed
    for one, promised in zip(found.motions, model.accuracy.motions, strict=True):
        np.testing.assert_array_equal(one.most, promised.allowed)
        np.testing.assert_array_equal(one.errors.largest, promised.errors.largest)


def test_a_joint_that_needs_no_torque_is_judged_by_the_other_motions(puma, pick_and_place):
    model = exact_model(puma)
    q = np.tile(pick_and_place.q[:1], (2, 1))
    # Gravity moves nothing about the vertical axis of the first joint.
    rest = Trajectory(np.arange(2.0), q, 0 * q, 0 * q, "rest")
    still, moving = evaluate(model, [rest, pick_and_place], fail_over="1%").motions
    assert still.errors.peak_torque[0] == 0.0
    assert still.most[0] == moving.most[0] == 0.01 * moving.errors.peak_torque[0]
    assert still.most[1] == 0.01 * still.errors.peak_torque[1]


def test_the_box_is_the_arms_limits_or_the_one_given(two_link, rough):
    box, (one,) = Box.of(two_link), evaluate(rough, FAST).motions
    beyond = (FAST.q < box.lower) | (FAST.q > box.upper)
    beyond |= (np.abs(FAST.qd) > box.velocity) | (np.abs(FAST.qdd) > box.acceleration)
    assert beyond.any()
    assert one.outside.tolist() == beyond.any(axis=1).tolist()
    around = Box.around(FAST.q, FAST.qd, FAST.qdd)
    assert not evaluate(rough, FAST, box=around).motions[0].outside.any()


def test_friction_of_a_log_is_found_beside_the_exact_torque(two_link, rough):
    log = recorded(two_link, friction=(2.0, 0.7, 0.3))
    one, without = evaluate(rough, [log, SLOW]).motions
    assert without.measured is None
    # Sums of 500 readings of some 30 N m beside terms of the order of 1: round-off is far below.
    np.testing.assert_allclose(one.measured.exact.friction.terms, [[2.0, 0.7, 0.3]] * 2, rtol=1e-9)
    assert (one.measured.exact.friction.rms < 1e-9).all()
    # What was dropped is not friction, and stays.
    assert (one.measured.simplified.friction.rms > 1e-3).any()
    np.testing.assert_array_equal(one.measured.exact.rms, gd.compare_torque(two_link, log).rms)
    error = one.torque - log.recording.torque
    # RMS about nothing, of the same 500 numbers: roundings of their sum.
    np.testing.assert_allclose(one.measured.simplified.rms, np.sqrt((error**2).mean(axis=0)), rtol=1e-9)


def test_gravity_that_a_log_tells_is_an_option_of_the_verb_that_makes_the_model(two_link, rough):
    """`evaluate` has no option for it; a log that agrees needs none."""
    hanging = replace(two_link, gravity_vector=-two_link.gravity_vector)
    for arm, is_told in ((two_link, False), (hanging, True)):
        evaluation = evaluate(rough, recorded(arm, noise=1e-3))
        assert ("--gravity" in evaluation.log_verdict.text) == is_told
        assert any("--gravity" in notice for notice in evaluation_result(evaluation).notices) == is_told


@pytest.mark.parametrize(
    ("fail_over", "says", "where"),
    [
        ("1% frction", "not understood", "fail_over, entry 1"),
        ("1%,1%,1%", "wrong number of entries", "fail_over"),
        ("1% norm", "not to the norm of all", "fail_over"),
        ("10% friction", "the arm states none", "fail_over, joint 1, shoulder, of two_link"),
        (1.5, "this is not a budget", "fail_over"),
    ],
)
def test_what_is_no_verdict(rough, fail_over, says, where):
    with pytest.raises(UsageError, match=says) as caught:
        evaluate(rough, SLOW, fail_over=fail_over)
    assert caught.value.details["where"] == where


def test_what_is_of_another_arm(rough, pick_and_place, puma):
    for motions in (pick_and_place, []):
        with pytest.raises(TrajectoryError):
            evaluate(rough, motions)
    with pytest.raises(UsageError, match="box"):
        evaluate(rough, SLOW, box=Box.of(puma))


BOX = Box(np.array([-1.0, -2.0]), np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([5.0, 6.0]))


def exits(count: int = 11, gaps: tuple[int, ...] = (), **columns: list[float]):
    """Of a motion in the middle of the box every tenth of a second, but for columns such as q1, qd2."""
    states = {name: np.zeros((count, 2)) for name in ("q", "qd", "qdd")}
    for column, values in columns.items():
        states[column[:-1]][:, int(column[-1]) - 1] = values
    motion = Trajectory(np.arange(count) / 10, *states.values(), gaps=gaps)
    arm = gd.load_arm("two_link")
    return box_exits(arm, motion, BOX), np.flatnonzero(outside_of(arm, BOX, states_of(motion))).tolist()


def test_velocities_and_accelerations_count_by_magnitude_and_each_limit_by_itself():
    nine = [0.0] * 9
    found, outside = exits(q2=[-2.5, 2.5, *nine], qd1=[*nine, -3.5, 3.1], qdd2=[0.0, -7.0, *nine])
    farthest = [one.farthest for one in found]
    assert [(one.joint, one.quantity, one.value, one.limit, one.unit) for one in farthest] == [
        (1, "velocity", 3.5, 3.0, "rad/s"),
        (2, "position", -2.5, -2.0, "rad"),
        (2, "position", 2.5, 2.0, "rad"),
        (2, "acceleration", 7.0, 6.0, "rad/s^2"),
    ]
    assert outside == [0, 1, 9, 10]


@examples(60)
@given(st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=40), st.sets(st.integers(1, 39)))
def test_as_found_one_by_one(values, gaps):
    gaps = tuple(sorted(gap for gap in gaps if gap < len(values)))
    found, outside = exits(len(values), gaps=gaps, q1=values)
    time = np.arange(len(values)) / 10
    # The rounded digit is 1e-9, and a limit of 1.
    assert outside == [k for k, value in enumerate(values) if abs(value) - 1.0 > 1e-9]
    assert sum(e.set_points for e in found) == len(outside)
    for e in found:
        side = 1.0 if e.farthest.limit > 0 else -1.0
        beyond = [side * value - 1.0 > 1e-9 for value in values]
        assert e.first == time[beyond.index(True)]
        assert e.farthest.value == side * max(side * value for value in values)
        lengths, run = [], None
        for k, is_beyond in enumerate(beyond):
            run = None if not is_beyond else k if run is None or k in gaps else run
            lengths += [] if run is None else [time[k] - time[run]]
        assert e.end - e.begin == pytest.approx(max(lengths), abs=1e-15)


def test_a_motion_of_which_the_model_states_nothing_is_not_judged(two_link, rough):
    """It neither passes nor fails, and a strict verdict fails it; the numbers stand beside."""
    alone, both = evaluate(rough, FAST), evaluate(rough, [SLOW, FAST])
    assert (alone.verdict, alone.passed, alone.motions[0].passed) == ("not judged", None, None)
    assert (both.passed, [one.passed for one in both.motions]) == (True, [True, None])
    assert "1 of 2 motions" in both.in_words
    assert "1 not judged" in both.in_words
    assert [case.tag for case in ElementTree.fromstring(junit_xml(both)).iter("skipped")] == ["skipped"] * 2
    counts = ElementTree.fromstring(junit_xml(both)).attrib
    assert (counts["tests"], counts["failures"], counts["skipped"]) == ("4", "0", "2")
    strict = evaluate(rough, [SLOW, FAST], strict=True)
    assert (strict.passed, strict.failures, strict.verdict) == (False, (), "failed")
    counts = ElementTree.fromstring(junit_xml(strict)).attrib
    assert (counts["failures"], counts["skipped"]) == ("2", "0")
    assert evaluate(rough, SLOW, strict=True).passed
    with pytest.raises(UsageError, match="no verdict to be strict about"):
        evaluate(rough, SLOW, fail_over=None, strict=True)


def test_drawn_states_are_judged_where_the_model_was_fitted_on_them(two_link):
    model = gd.simplify(two_link, gd.tables.states_in_box(two_link, 50), "5%", at_set_points=True)
    for seed, passed in ((0, True), (1, None)):
        (one,) = evaluate(model, gd.tables.states_in_box(two_link, 50, seed)).motions
        assert one.passed is passed


def turned(arm: gd.types.RobotArm, joint: int, axis: list[float]) -> gd.types.RobotArm:
    joints = list(arm.joints)
    joints[joint] = replace(joints[joint], axis=np.array(axis))
    return replace(arm, joints=tuple(joints), name="other")


def test_an_arm_of_another_make_is_refused(puma, pick_and_place, two_link):
    """Of other joints, or other axes; a calibrated or longer version of the same arm is not."""
    model = exact_model(puma)
    others = [gd.load_arm("stanford"), two_link, turned(puma, 4, [0.0, 0.0, -1.0])]
    for other in [*others, turned(puma, 2, [0.0, np.sin(0.3), np.cos(0.3)])]:
        with pytest.raises(ModelError, match="does not fit"):
            evaluate(model, pick_and_place, other)
    askew = turned(puma, 2, [0.0, np.sin(0.01), np.cos(0.01)])
    longer = list(puma.links)
    frame = longer[1].frame
    longer[1] = replace(longer[1], frame=replace(frame, translation=1.2 * frame.translation))
    for version in (askew, replace(puma, links=tuple(longer))):
        assert evaluate(model, pick_and_place, version, fail_over=None).errors.largest.max() > 0.0


HOSTILE = ("]]></testcase><b>&\"'", "Ünïcødé \U0001f916", "\x00\x1b[2J\r\ta", "\ufffe\ud800", "")


@pytest.mark.parametrize("name", HOSTILE, ids=range(len(HOSTILE)))
def test_junit_has_a_case_per_motion_and_joint_and_hostile_names_stay_in_their_place(rough, name):
    form, arm = rough.form, rough.form.arm
    # An arm refuses what does not show; where it can be had, joint and arm bear the name, too.
    if name and name.isprintable():
        arm = replace(arm, name=name, joints=(replace(arm.joints[0], name=name), arm.joints[1]))
    model = replace(rough, form=ExactForm(arm, form.drives))
    found = evaluate(model, [SLOW, swung(1.0, name)], fail_over="promise")
    text = junit_xml(found)
    assert not any(ord(sign) < 32 and sign != "\n" for sign in text)
    root = ElementTree.fromstring(text.encode())
    counts = {"tests": "4", "failures": str(len(found.failures)), "errors": "0", "skipped": "0"}
    assert counts.items() <= root.attrib.items()
    assert [element.tag for element in root] == ["testsuite"] * 2
    for suite, one in zip(root, found.motions, strict=True):
        cases = suite.findall("testcase")
        assert [case.find("failure") is not None for case in cases] == one.fails.tolist()
        for joint, case in enumerate(cases):
            told = case.find("failure")
            told = case.findtext("system-out") if told is None else told.attrib["message"]
            assert told == one.error_text(joint)
        about = {p.attrib["name"]: p.attrib["value"] for p in suite.iter("property")}
        assert about["set points outside the box"] == str(int(one.outside.sum()))
    shown = root[1].attrib["name"]
    assert shown == name or not name.isprintable()
    assert cases[0].attrib["name"] == f"joint 1 {name}" or arm is form.arm


def test_what_a_model_states_is_held_against_the_arm_as_it_is_now(two_link, swing):
    """In its box, along its motion; elsewhere it states nothing, and there is no verdict."""
    heavier = replace(two_link, links=(*two_link.links[:-1], replace(two_link.links[-1], mass=2.0)))
    exact = gd.types.ExactDynamics.of(two_link, swing)
    box = Box.around(*(np.concatenate([1.1 * x, -x]) for x in exact.states.arrays))
    boxed = gd.simplify(two_link, swing, "30%", region=box, certified=True)
    tube = gd.simplify(two_link, swing, "30%", certified=True)
    plain = gd.simplify(two_link, swing, "30%")
    for model in (boxed, tube, plain):
        found = evaluate(model, [swing])
        assert found.fail_over == "stated"
        assert found.passed
        assert found.motions[0].most is not None
        assert not evaluate(model, [swing], arm=heavier).passed
        assert evaluate(model, [swing], arm=heavier, fail_over=None).passed is None
        assert evaluate(model, [FAST]).motions[0].most is None
    # Of a motion that is partly in the box that part counts.
    wider = replace(swing, qd=1.5 * swing.qd, qdd=2.0 * swing.qdd, name="wider")
    (partly,) = evaluate(boxed, [wider]).motions
    inside = np.abs(wider.qd) <= box.velocity
    inside = (inside & (np.abs(wider.qdd) <= box.acceleration)).all(axis=1)
    error = np.abs(partly.torque - partly.dynamics.torque)
    assert inside.any()
    np.testing.assert_allclose(partly.counted, error[inside].max(axis=0), atol=1e-12)
