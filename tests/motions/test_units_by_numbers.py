"""Units that no name states: positions against integrated velocities, and what joints can reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import TrajectoryError, in_options
from gd_analyze.motions.units_by_numbers import joint_in_degrees, units_of_factors, usual_reach
from gd_analyze.motions.velocities import derivative_factors
from log_arms import arm_of
from remedies import remedies, typed
from strategies import examples

TIME = 0.004 * np.arange(1500)
RATES, PHASES = np.array([2.0, 3.1]), np.array([0.0, 1.0])
Q = 0.8 * np.sin(np.outer(TIME, RATES) + PHASES)
QD = 0.8 * RATES * np.cos(np.outer(TIME, RATES) + PHASES)
# rad of a joint's range at either side
END = 2.5


def limited(*names: str, kinds=()) -> gd.types.RobotArm:
    arm = arm_of(*names, kinds=kinds)
    return replace(arm, joints=tuple(replace(joint, lower=-END, upper=END) for joint in arm.joints))


ARM = limited("hip", "knee")


def text(time, q, qd=None, names="stamp,pos_1,pos_2,vel_1,vel_2"):
    columns = [time, q] if qd is None else [time, q, qd]
    header = ",".join(names.split(",")[: 3 if qd is None else None])
    rows = np.column_stack(columns).tolist()
    return "\n".join([header, *(",".join(map(repr, row)) for row in rows), ""])


@pytest.mark.parametrize(("unit", "size"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
@pytest.mark.parametrize(("q_size", "qd_size"), [(1.0, 1.0), (57.29577951, 1.0), (1.0, 57.29577951)])
def test_time_and_one_angle_in_another_unit(unit, size, q_size, qd_size, log, warned):
    """What the numbers say is read, told once, and silent where the options told are typed."""
    path = log(text(size * TIME, q_size * Q, qd_size * QD))
    with warned() as texts:
        logged = gd.read_log(path, ARM)
    # Seconds of a product of two roundings; degrees and back.
    np.testing.assert_allclose(logged.time, TIME, atol=1e-12)
    np.testing.assert_allclose(logged.q, Q, rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(logged.qd, QD, rtol=1e-8, atol=1e-12)
    (told,) = texts
    assert f"time in {unit}" in told
    ((words, complete),) = remedies(told)
    assert complete
    with warned() as texts:
        again = gd.read_log(path, ARM, typed(words))
    assert not texts
    np.testing.assert_array_equal(again.q, logged.q)
    np.testing.assert_array_equal(again.time, logged.time)


def test_all_angles_in_degrees_by_the_range(log, warned):
    path = log(text(TIME, np.degrees(Q), np.degrees(QD)))
    with warned() as texts:
        logged = gd.read_log(path, ARM)
    np.testing.assert_allclose(logged.q, Q, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(logged.qd, QD, rtol=1e-12, atol=1e-15)
    (told,) = texts
    assert "hip, whose limit is 2.5 rad, reaches" in told
    alone = log(text(TIME, np.degrees(Q)))
    with warned():
        np.testing.assert_allclose(gd.read_log(alone, ARM).q, Q, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("size", [1.0, 2.0, 1e4])
def test_what_is_no_degree_stays(size, log, warned):
    """Radians within the range and beyond it, and counts of an encoder, which degrees do not explain."""
    with warned() as texts:
        logged = gd.read_log(log(text(TIME, size * Q)), ARM)
    np.testing.assert_array_equal(logged.q, size * Q)
    assert not texts


def test_a_slide_keeps_its_metres(log, warned):
    arm = limited("turn", "slide", kinds=["revolute", "prismatic"])
    q = Q * [57.29577951, 1.0]
    with warned():
        logged = gd.read_log(log(text(TIME, q, QD)), arm)
    np.testing.assert_allclose(logged.q, Q, rtol=1e-8, atol=1e-12)
    assert [use.unit for use in logged.columns] == ["s", "deg", "m", "rad/s", "m/s"]


def test_stated_units_and_files_of_set_points_are_read_as_they_say(log, warned):
    names = "time [s],pos_1 [rad],pos_2 [rad],vel_1 [rad/s],vel_2 [rad/s]"
    with warned() as texts:
        logged = gd.read_log(log(text(TIME, np.degrees(Q), QD, names)), ARM)
    np.testing.assert_array_equal(logged.q, np.degrees(Q))
    assert not texts
    with warned():
        logged = gd.read_log(log(text(TIME, np.degrees(Q), QD, "time,q1,q2,qd1,qd2")), ARM)
    np.testing.assert_array_equal(logged.q, np.degrees(Q))


def test_a_count_of_samples_is_asked_for_with_the_rate_that_velocities_tell(log):
    path = log(text(np.arange(1500), Q, QD, "sample,pos_1,pos_2,vel_1,vel_2"))
    with pytest.raises(TrajectoryError) as caught:
        gd.read_log(path, ARM)
    assert caught.value.details["next"].startswith("`map='time=sample:250Hz'`")
    ((words, _),) = remedies(in_options(caught.value.details["next"]))
    np.testing.assert_allclose(gd.read_log(path, ARM, typed(words)).time, TIME, atol=1e-12)


def test_a_few_corrupt_rows_do_not_make_degrees():
    q = Q.copy()
    q[::40] = 50.0
    assert joint_in_degrees(ARM, usual_reach(q)) is None
    assert joint_in_degrees(ARM, usual_reach(np.degrees(Q))) == 0


@examples(40)
@given(
    st.sampled_from([1.0, 1e-3, 1e-6, 1e-9]),
    st.sampled_from(["", "q", "qd"]),
    st.floats(0.93, 1.07),
    st.integers(0, 1000),
)
def test_units_of_factors(second, in_degrees, miss, seed):
    """Velocities that miss the derivative by up to a fourteenth, with noise, still tell the units."""
    noise = 1e-3 * np.random.default_rng(seed).normal(size=Q.shape)
    q, qd = Q + noise, miss * (QD + 10 * noise)
    q = np.degrees(q) if in_degrees == "q" else q
    qd = np.degrees(qd) if in_degrees == "qd" else qd
    factors, _ = derivative_factors(TIME / second, q, qd)
    found = units_of_factors(factors, unstated={"q", "qd", "time"})
    unit = {1.0: "s", 1e-3: "ms", 1e-6: "us", 1e-9: "ns"}[second]
    assert found == {"time": unit} | ({in_degrees: "deg"} if in_degrees else {})
