"""Bounds beside what is simulated, what motion is followed, and what is refused."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from changed_programs import fast_model
from gd_analyze import Trajectory
from gd_analyze.errors import ArmError, GdAnalyzeWarning, ModelError, TrajectoryError, UsageError
from gd_analyze.report.html import page_of
from gd_analyze.studies import control_law as laws
from gd_analyze.studies.control import followable
from gd_analyze.studies.control_law import CONTINUOUS, CONTROLLERS, EXACT, SIMPLIFIED, WITHOUT_H, Reference
from gd_analyze.studies.control_result import budget_for_tolerance, control_result, good_enough


def test_no_simulated_error_is_beyond_the_certified(puma_study):
    """In continuous time and without limits, as the certificate has it; and the bound is of use."""
    simulated = puma_study.loop(SIMPLIFIED, CONTINUOUS, 1.0).peak_error
    bound = puma_study.certified[1.0]
    assert (simulated <= bound.error).all()
    # The certificate is within 2.2 times the largest torque error here, and takes the errors of all joints
    # for the worst at a time.
    assert (bound.error < 4.0 * simulated).all()
    assert (puma_study.model.accuracy.errors.largest <= bound.torque_error).all()
    # The model of 1 % differs from D by a few percent where it counts.
    assert puma_study.feedback.share == pytest.approx(1.0, abs=0.2)


def test_what_is_expected_is_what_is_simulated_and_who_knows_more_tracks_better(puma_study):
    """To first order, and from above: the largest error for ever, and not only for a while."""
    peaks = {c: puma_study.loop(c, CONTINUOUS, 1.0).peak_error for c in CONTROLLERS}
    assert (puma_study.expected[EXACT, 1.0] < 1e-12).all()
    for controller, peak in peaks.items():
        if controller != EXACT and peak.max() < 0.01:
            expected = puma_study.expected[controller, 1.0]
            # Errors of 10 mrad change what is missing by about 1 %.
            assert (peak <= 1.01 * expected).all(), controller.title
            assert (expected <= 1.4 * peak).all(), controller.title
    order = [peaks[c].max() for c in (EXACT, SIMPLIFIED, WITHOUT_H, laws.PD)]
    assert sorted(order) == order


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [0.01, 0.1, 1.0])
def test_a_budget_for_the_tolerance_keeps_it(puma, pick_and_place, puma_study, degrees):
    """A model as rough as the tolerance allows: found by the budget, it tracks within it, and costs less."""
    settings = replace(puma_study.settings, tolerance=gd.types.Tolerance(np.radians(degrees)))
    asked = gd.control(puma_study.model, pick_and_place, settings)
    model = gd.simplify(puma, pick_and_place, budget_for_tolerance(asked))
    found = gd.control(model, pick_and_place, settings)
    peak = found.loop(laws.FIXED_GAINS, CONTINUOUS, 1.0).peak_error
    assert (peak <= found.tolerance).all()
    # The budget takes the errors of all joints for the largest at once, and searches leave some of it.
    assert peak.max() > 0.2 * found.tolerance.max()
    assert good_enough(found) is not None
    if degrees >= 0.1:
        assert model.operations.total < puma_study.model.operations.total / 2


@pytest.mark.slow
def test_a_budget_for_the_tolerance_keeps_it_of_two_joints(two_link, swing, swing_model):
    """Ten degrees, as less lets none of the few terms go."""
    tolerance = gd.types.Tolerance(np.radians(10.0))
    settings = gd.types.ControlSettings(rates=(CONTINUOUS,), speeds=(1.0,), limits=None, tolerance=tolerance)
    asked = gd.control(swing_model, swing, settings)
    model = gd.simplify(two_link, swing, budget_for_tolerance(asked))
    found = gd.control(model, swing, settings)
    peak = found.loop(laws.FIXED_GAINS, CONTINUOUS, 1.0).peak_error
    assert (peak <= found.tolerance).all()
    assert model.saves
    assert good_enough(found) is not None


def test_pd_rests_where_stiffness_holds_what_gravity_is_left(puma_study):
    model = puma_study.model
    q = np.array(Reference.of(puma_study.motion).at(np.linspace(0.0, 2.4, 500))[0]).T
    missing = gd.types.ArmDynamics(puma_study.arm).gravity_loading(q) - model.gravity_loading(q)
    expected = np.abs(missing).max(axis=0) / (400.0 * puma_study.diagonal)
    # The set points are among the study's instants, too.
    np.testing.assert_allclose(puma_study.at_rest, expected, rtol=1e-3, atol=1e-12)
    assert puma_study.at_rest.max() > 0.0


def test_dropping_h_costs_with_the_square_of_the_speed(swing_study):
    """And the tolerance is left within that law; nowhere, or everywhere, where it is wide or narrow."""
    slow, planned = (swing_study.loop(WITHOUT_H, CONTINUOUS, speed).peak_error.max() for speed in (0.5, 1.0))
    # The loop settles in a tenth of the motion's time; the rest is a few percent.
    assert planned / slow == pytest.approx(4.0, rel=0.1)
    held = float(swing_study.loop(WITHOUT_H, 200.0, 1.0).peak_error.max())
    tolerances = [gd.types.Tolerance(revolute=x) for x in (held / 2, 1.0, 1e-9)]
    settings = [replace(swing_study.settings, tolerance=tolerance) for tolerance in tolerances]
    half, wide, narrow = (replace(swing_study, settings=each) for each in settings)
    assert half.tracks_up_to(WITHOUT_H, 200.0) == pytest.approx(math.sqrt(0.5), rel=0.03)
    assert wide.tracks_up_to(WITHOUT_H, 200.0) == math.inf
    assert narrow.tracks_up_to(WITHOUT_H, 200.0) is None
    assert good_enough(wide)
    assert not good_enough(narrow)
    headlines = [control_result(study).headline for study in (narrow, wide)]
    assert ["exact model" in headline for headline in headlines] == [True, False]


@pytest.mark.slow
def test_a_model_without_inertia_has_no_feedback():
    """Along a motion in which the wrist hardly moves, a program drops its inertia; fixed gains help."""
    settings = gd.types.ControlSettings(rates=(200.0,), speeds=(1.0,))
    model = fast_model(gd.types.ExactDynamics.of("puma560", "large-slew"), "1%")
    study = gd.control(model, "large-slew", settings)
    assert study.feedback.share < 0.1
    # The wrist, and none of the joints that swing.
    assert set(study.feedback.joints) <= {4, 5, 6}
    assert not study.certified
    assert good_enough(study) == laws.FIXED_GAINS
    assert any(fact.label.startswith("Least feedback left") for fact in control_result(study).facts)
    fixed, simplified = (study.loop(c, 200.0, 1.0).peak_error.max() for c in (laws.FIXED_GAINS, SIMPLIFIED))
    assert fixed < simplified


def test_a_motion_beyond_the_torque_limits_is_the_cause_and_not_the_model(puma_study):
    """A hundred times too fast: the drives cannot follow, the model's D is as good as before."""
    slow = puma_study.motion
    motion = Trajectory.from_arrays(slow.time / 100.0, slow.q, 100.0 * slow.qd, 1e4 * slow.qdd, name="fast")
    settings = gd.types.ControlSettings(rates=(500.0,), speeds=(1.0,))
    with pytest.warns(gd.GdAnalyzeWarning):
        study = gd.control(puma_study.model, motion, settings, warned=("odd",))
    assert study.feedback.is_enough
    torque = gd.types.ArmDynamics(study.arm).torque(motion.q, motion.qd, motion.qdd, drives=True)
    needed = np.abs(torque).max(axis=0)
    # Between the set points, 4 ms apart, the torque is a few percent larger.
    np.testing.assert_allclose(study.needed, needed, rtol=0.1)
    assert "times its limit" in study.warnings[0]
    facts = {fact.label: fact.value for fact in control_result(study).facts}
    said = facts["Tracking error from model error, to first order"]
    assert "torque limit" in said
    assert "model" not in said


@pytest.mark.slow
def test_fixed_gains_of_a_slow_loop(swing_model, swing):
    """Half above the rate named they still track, and a third below it they do not."""
    settings = gd.types.ControlSettings(rates=(1000.0,), speeds=(1.0,))
    study = gd.control(swing_model, swing, settings)
    assert study.too_slow_for_fixed_gains == ()
    edge = settings.gains.damper * study.fixed_excess / 2.0
    rates = (round(0.6 * edge), round(1.5 * edge))
    slower = gd.control(swing_model, swing, replace(settings, rates=rates))
    assert slower.too_slow_for_fixed_gains == rates[:1]
    lost, kept = (slower.loop(laws.FIXED_GAINS, rate, 1.0).peak_error.max() for rate in rates)
    assert lost > 3 * kept


def test_the_reference_goes_through_every_set_point(swing):
    reference = Reference.of(swing)
    found = reference.at(swing.time / 2.0, 2.0)
    # Set points of the file, read with all digits; a sum of six terms.
    for values, expected, power in zip(found, (swing.q, swing.qd, swing.qdd), (0, 1, 2), strict=True):
        np.testing.assert_allclose(values.T, 2.0**power * expected, rtol=0, atol=1e-9)
    time = np.linspace(0.1, 1.4, 50)
    before, here, after = (np.array(reference.at(time + d)[0]) for d in (-1e-4, 0.0, 1e-4))
    # Central differences of fourth derivatives of some 1e3: 1e-8 times that over 6.
    np.testing.assert_allclose((after - before) / 2e-4, reference.at(time)[1], rtol=0, atol=1e-5)
    # And round-off of 1e-16 over 1e-8.
    np.testing.assert_allclose((after - 2 * here + before) / 1e-8, reference.at(time)[2], rtol=0, atol=1e-4)


def test_velocities_that_disagree_with_positions_are_not_followed():
    time = np.linspace(0.0, 2.0, 101)
    q = np.column_stack([np.sin(time), np.cos(time)])
    right = Trajectory(time, q, np.column_stack([np.cos(time), -np.sin(time)]), -q, "right")
    assert followable(right) is right
    with pytest.warns(GdAnalyzeWarning, match=r"wrong .*positions"):
        fixed = followable(replace(right, qd=right.qd + 0.05, name="wrong"))
    # The quintic spline's error: h^4 of its second derivative.
    np.testing.assert_allclose(fixed.qdd, -q, atol=1e-4)


def test_what_does_not_fit(swing, swing_model, puma):
    single = Trajectory(swing.time[:1], swing.q[:1], swing.qd[:1], swing.qdd[:1])
    for motion in (replace(swing, gaps=(10,)), single):
        with pytest.raises(TrajectoryError, match="motion"):
            gd.control(swing_model, motion)
    with pytest.raises(ModelError, match=r"two_link .*puma560"):
        gd.control(swing_model, swing, arm=puma)
    with pytest.raises(ArmError, match="describes no friction"):
        gd.control(swing_model, swing, gd.types.ControlSettings(friction=True))


def test_the_result_is_finite_states_lost_loops_and_names_are_only_text(swing_study):
    def lost(loop):
        if loop.controller not in (SIMPLIFIED, laws.FIXED_GAINS):
            return loop
        error, endless = np.where(loop.time[:, None] > 0.7, np.nan, loop.error), np.full(2, np.inf)
        return replace(loop, peak_error=endless, rms_error=endless, lost_at=0.7, error=error)

    arm = replace(swing_study.arm, title="<script>alert(1)</script>")
    loops = tuple(map(lost, swing_study.loops))
    result = control_result(replace(swing_study, arm=arm, warnings=("<b>odd",), loops=loops))
    told = json.loads(json.dumps(result.document(), allow_nan=False))
    assert len(told["loops"]) == len(swing_study.loops)
    assert set(told["tracks_up_to"]) == {c.title for c in CONTROLLERS}
    assert told["good_enough"] is None
    page = page_of(result)
    assert "<script>alert" not in page
    assert "<b>odd" not in page
    assert "lost (joint" in result.headline
    _, _, by_rate = result.parts[0].parts[2].shown()[1]
    assert by_rate[1] == "–"


def test_prismatic_joints_err_in_millimetres():
    s, start = np.linspace(0.0, 1.0, 11)[:, None], np.array([0.0, 0.3, 0.5, 0.2, 0.4, 0.0])
    q = start + (10 * s**3 - 15 * s**4 + 6 * s**5) * [0.02, 0.02, 0.05, 0.02, 0.02, 0.02]
    motion = Trajectory.from_arrays(0.4 * s[:, 0], q, name="short")
    settings = gd.types.ControlSettings(rates=(100.0,), speeds=(2.0,))
    study = gd.control(gd.simplify("stanford", motion, level="element"), motion, settings)
    shown = {column.label: unit for column, unit, _ in control_result(study).parts[0].parts[0].shown()}
    assert [shown[f"joint {i}"] for i in (2, 3)] == ["mrad", "mm"]
    np.testing.assert_array_equal(study.tolerance, np.where(study.arm.is_revolute, np.radians(0.1), 1e-3))


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ({"bandwidth": math.nan}, "bandwidth"),
        ({"damping": 0.0}, "damping"),
        ({"rates": ()}, "rates"),
        ({"rates": (500.0, 500.0)}, "different"),
        ({"rates": (10.0,)}, "too slow for its bandwidth"),
        ({"rates": (1e9,)}, "rate"),
        ({"speeds": (0.0,)}, "speed"),
        ({"limits": -1.0}, "limit"),
    ],
)
def test_settings_that_are_none(words, says):
    with pytest.raises(UsageError, match=says):
        gd.types.ControlSettings(**words)


@pytest.mark.parametrize("text", ["", "1parsec", "0.1deg,2mrad", "-1deg", "0deg"])
def test_tolerances(text):
    with pytest.raises(UsageError, match="tolerance"):
        gd.types.Tolerance.parse(text)
    assert gd.types.Tolerance.parse("2mrad, 0.5mm") == gd.types.Tolerance(revolute=0.002, prismatic=0.0005)
