"""A trajectory as a value; velocities that are derived, and those that contradict positions."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import make_interp_spline

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.profiles import PROFILES
from gd_analyze.motions.velocities import contradictions
from log_arms import arm_of
from recordings import Motion, instants
from strategies import examples

EPS = np.finfo(float).eps
# Set points of a stretch from which derivatives follow; five are refused below.
FEWEST = 6
TIME = np.arange(3.0)
Q = np.arange(6.0).reshape(3, 2)


def test_arrays_are_read_only_copies_whose_numbers_make_the_fingerprint():
    source = Q.copy()
    trajectory = gd.Trajectory(TIME, source, Q, Q, name="a")
    source[0, 0] = 99.0
    assert trajectory.q[0, 0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        trajectory.q[0, 0] = 1.0
    assert gd.Trajectory(TIME, Q, Q, Q, name="b").fingerprint == trajectory.fingerprint
    changes = [(TIME + 1, Q, Q, Q), (TIME, Q + 1, Q, Q), (TIME, Q, Q + 1, Q), (TIME, Q, Q, Q + 1)]
    prints = {trajectory.fingerprint, *(gd.Trajectory(*changed).fingerprint for changed in changes)}
    assert len(prints) == 5


def test_arrays_that_nobody_can_write_to_are_no_copies():
    first = gd.Trajectory(TIME, Q, Q, Q)
    assert gd.Trajectory(first.time, first.q, first.qd, first.qdd).q is first.q
    owner = Q.copy()
    view = owner[:]
    view.flags.writeable = False
    trajectory = gd.Trajectory(TIME, view, Q, Q)
    owner[0, 0] = 99.0
    assert trajectory.q[0, 0] == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((TIME, Q[:0], Q, Q), "at least one set point"),
        ((TIME[:2], Q, Q, Q), "time has the wrong shape"),
        ((TIME, Q, Q[:, :1], Q), "qd has the wrong shape"),
        ((TIME, Q, Q, np.where(Q == 3, np.nan, Q)), "qdd is not finite.* at set point 2"),
        ((TIME, Q, Q, np.where(Q == 3, 1e13, Q)), "qdd is .* too large.* at set point 2"),
        ((TIME[::-1], Q, Q, Q), "set point 2"),
        ((TIME, [["a", "b"]], Q, Q), "q is not made of numbers"),
    ],
)
def test_impossible_values_are_refused(arguments, message):
    for make in (gd.Trajectory, gd.Trajectory.from_arrays):
        with pytest.raises(TrajectoryError, match=message):
            make(*arguments)
    for gaps in ((0,), (3,), (2, 1)):
        with pytest.raises(TrajectoryError, match="gaps"):
            gd.Trajectory(TIME, Q, Q, Q, gaps=gaps)


@examples(20)
@given(st.integers(FEWEST, 40), st.booleans(), st.booleans(), st.integers(0, 2**32 - 1))
def test_what_is_left_out_is_derived_as_from_a_file(n_set_points, has_qd, has_qdd, seed):
    # A quarter turn or so per joint in 2 s: smooth, so that these are set points and no readings.
    time, phase = np.linspace(0.0, 2.0, n_set_points), np.random.default_rng(seed).uniform(0, 1, 2)
    angle = time[:, None] + phase
    q, qd, qdd = np.sin(angle), np.cos(angle), -np.sin(angle)
    arguments = (qd if has_qd else None, qdd if has_qdd else None)
    trajectory = gd.Trajectory(time, q, *arguments, name="left-out", origin="here")
    expected = gd.Trajectory.from_arrays(time, q, *arguments)
    for name in ("time", "q", "qd", "qdd"):
        np.testing.assert_array_equal(getattr(trajectory, name), getattr(expected, name))
    assert trajectory.derivatives_from == expected.derivatives_from
    left_out = tuple(name for name, has in (("qd", has_qd), ("qdd", has_qdd)) if not has)
    assert trajectory.derived == left_out
    assert (trajectory.name, trajectory.origin) == ("left-out", "here")


def test_a_gap_splits_what_is_derived():
    time = np.concatenate([np.arange(10.0), 20 + np.arange(10.0)])
    q = np.stack([np.sin(time), np.where(time < 15, time, -time)], axis=1)
    trajectory = gd.Trajectory(time, q, gaps=(10,))
    for rows in (slice(0, 10), slice(10, 20)):
        alone = gd.Trajectory(time[rows], q[rows])
        np.testing.assert_array_equal(trajectory.qdd[rows], alone.qdd)


def test_from_arrays(two_link):
    motion, time = Motion.of(3), instants(125.0, 10.0)
    q, qd, qdd = (motion.at(time, order) for order in range(3))
    whole = gd.Trajectory.from_arrays(time, q, qd, qdd)
    assert whole.fingerprint == gd.Trajectory(time, q, qd, qdd).fingerprint
    derived = gd.Trajectory.from_arrays(time.tolist(), q.tolist(), name="mine")
    assert (derived.name, derived.derived) == ("mine", ("qd", "qdd"))
    np.testing.assert_allclose(derived.qdd, qdd, atol=1e-3)
    noisy = q + 1e-4 * np.random.default_rng(0).normal(size=q.shape)
    measured = gd.Trajectory.from_arrays(time, noisy, measured=True, arm=two_link)
    assert measured.recording.measured
    np.testing.assert_array_equal(measured.recording.q, noisy)
    with pytest.raises(TrajectoryError, match="too few set points to derive"):
        gd.Trajectory.from_arrays(time[:5], q[:5])


@given(
    arrays(float, (6, 2), elements=st.floats(-1.0, 1.0)),
    st.integers(FEWEST, 40),
    st.floats(0.01, 10.0),
)
def test_quintic_motions_are_differentiated_exactly(coefficients, n_set_points, duration):
    # The spline with not-a-knot ends contains every quintic, so only round-off is left: coefficients of up
    # to 1, divided by h per derivative; the banded system of a quintic spline has a condition below 1e5.
    x = np.linspace(0.0, 1.0, n_set_points)
    q, qd, qdd = (
        np.stack([np.polyval(np.polyder(c, order) if order else c, x) for c in coefficients.T], axis=1)
        / duration**order
        for order in range(3)
    )
    derived = gd.Trajectory(x * duration, q)
    h = duration / (n_set_points - 1)
    assert np.abs(derived.qd - qd).max() <= 1e5 * EPS * 6 / h
    assert np.abs(derived.qdd - qdd).max() <= 1e5 * EPS * 6 / h**2
    from_qd = gd.Trajectory(x * duration, q, qd)
    np.testing.assert_array_equal(from_qd.qd, qd)
    assert np.abs(from_qd.qdd - qdd).max() <= 1e5 * EPS * 6 * np.abs(qd).max(initial=1.0) / h
    assert from_qd.derived == ("qdd",)
    assert from_qd.derivatives_from.endswith("qd")


@pytest.mark.parametrize("count", [31_999, 32_000, 32_001, 64_003])
def test_a_spline_in_blocks_is_the_spline_of_the_whole(count):
    time = np.arange(count) * 1e-3
    q = np.sin(time[:, None] * [1.0, 3.0])
    motion = gd.Trajectory(time, q)
    from_velocities = gd.Trajectory(time, q, motion.qd)
    for derivative, values, order in (
        (motion.qd, q, 1),
        (motion.qdd, q, 2),
        (from_velocities.qdd, motion.qd, 1),
    ):
        whole = make_interp_spline(time, values, k=5).derivative(order)(time)
        # Round-off alone: of values of 1, divided by the time step per derivative.
        assert np.abs(derivative - whole).max() <= 100 * EPS / 1e-3**order


def test_a_clock_that_counts_from_1970_costs_nothing():
    # Steps of 1/64 s and a whole number of seconds add without rounding: the results are the same bits.
    time = np.arange(50) / 64
    q = np.sin(3 * time)[:, None]
    plain, shifted = (gd.Trajectory(time + start, q) for start in (0.0, 1.7e9))
    np.testing.assert_array_equal(plain.qd, shifted.qd)
    np.testing.assert_array_equal(plain.qdd, shifted.qdd)


ARM = arm_of("1", "2", "3")


T = np.linspace(0, 3, 60)


def swing(time: np.ndarray) -> list[np.ndarray]:
    """q, qd and qdd of two joints that swing at different frequencies, and of a third that does not move."""
    omega, phase, size = np.array([2, 3, 1]), np.array([0, np.pi / 2, 0]), np.array([1, 1, 0])
    turn = np.pi / 2
    return [size * omega**k * np.sin(omega * time[:, None] + phase + k * turn) for k in range(3)]


SQ, SQD, SQDD = swing(T)
SLIPS: dict[str, tuple[dict[str, object], str]] = {
    "time in ms": ({"time": T * 1e3}, "give --map time=:ms"),
    "time in us": ({"time": T * 1e6}, "give --map time=:us"),
    "velocities in degrees": ({"qd": np.degrees(SQD), "qdd": np.degrees(SQDD)}, "--map qd=:deg"),
    "angles in degrees": ({"q": np.degrees(SQ)}, "--map q=:deg"),
    "angles in degrees, time in ms": (
        {"q": np.degrees(SQ), "time": T * 1e3},
        "17.5 times the derivative of q, as if q were in deg and time were in ms",
    ),
    "no velocities": ({"qd": 0 * SQD}, "qd of joints 1 and 2 is 0 throughout"),
    "no accelerations": ({"qdd": 0 * SQDD}, "qdd of joints 1 and 2 is 0 throughout"),
    # Right velocities show that time is right, too.
    "huge accelerations": ({"qdd": 1e6 * SQDD}, "qdd of joints 1 and 2 is not the derivative of qd"),
    "other sign": ({"qd": -SQD}, "with the other sign"),
    "columns exchanged": ({"qd": SQD[:, [1, 0, 2]]}, "qd of joints 1 and 2 is not the derivative"),
    "of one joint": ({"qd": SQD * [1, 0.5, 1], "qdd": SQDD * [1, 0.5, 1]}, "qd of joint 2 is not"),
    "accelerations for velocities": ({"qdd": SQD}, "qdd of joints 1 and 2 is not the derivative of qd"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_named_once(slip):
    changed, fact = SLIPS[slip]
    (message,) = contradictions(**({"time": T, "q": SQ, "qd": SQD, "qdd": SQDD} | changed))
    assert fact in message


def test_sound_numbers_are_not_suspected():
    for n in range(2, 61):
        time = np.linspace(0, 3, n)
        assert contradictions(time, *swing(time)) == []
    # At 1 kHz the differences of q are all noise: a thousandth of a radian is a radian per second.
    time = np.linspace(0, 3, 3000)
    q, qd, qdd = swing(time)
    noise = np.random.default_rng(1).normal(size=(3, *q.shape))
    noisy = (time, q + 1e-3 * noise[0], 0.95 * qd + 0.05 * noise[1], qdd + noise[2])
    assert contradictions(*noisy) == []


@pytest.mark.parametrize(("share", "is_judged"), [(0.035, False), (0.07, True)])
def test_velocities_of_a_joint_that_hardly_moves_beside_another_are_not_judged(share, is_judged):
    """Below a twentieth of the largest movement: the second joint's velocities have the other sign."""
    time = np.linspace(0, 3, 60)
    q, qd = np.sin(2 * time), 2 * np.cos(2 * time)
    mistakes = contradictions(time, np.column_stack([q, share * q]), np.column_stack([qd, -share * qd]), None)
    assert bool(mistakes) == is_judged


@pytest.mark.parametrize(("turns", "is_plan"), [(8, True), (10, False)])
def test_a_few_jumps_of_acceleration_make_no_noise(turns, is_plan):
    """Full acceleration one way and the other, in forty set points: four changes of sign are not counted.

    The others are 2 a each. Their mean square over the 35 changes that count is below half of a^2 with four
    of them, and above it with six.
    """
    signs = np.where(np.arange(40) * (turns + 1) // 40 % 2, -1.0, 1.0)
    time, qdd = 0.01 * np.arange(40), 0.5 * signs[:, None]
    qd = 0.01 * np.cumsum(qdd, axis=0)
    q = 0.01 * np.cumsum(qd, axis=0)
    assert np.count_nonzero(np.diff(signs)) == turns
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # says that it is treated as a recording
        motion = gd.Trajectory.from_arrays(time, q, qd, qdd)
    assert (motion.recording is None) == is_plan


def test_a_jump_across_a_gap_is_no_contradiction():
    q = SQ + np.repeat(np.arange(6), 10)[:, None]
    gaps = tuple(range(10, 60, 10))
    assert contradictions(T, q, SQD, SQDD, gaps) == []
    assert contradictions(T, q, SQD, SQDD)
    assert "57.3 times" in contradictions(T, q, np.degrees(SQD), SQDD, gaps)[0]


@pytest.mark.parametrize(
    ("profile", "vias"),
    [(name, vias) for name in sorted(PROFILES) for vias in PROFILES[name].via_counts or range(5)],
)
@given(data=st.data())
@examples(4)
def test_planned_motions_are_not_suspected(profile, vias, data):
    """However coarse the set points, near each other the vias, and steep the movements between."""
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    knots = rng.uniform(-3, 3, (vias + 2, 3)) * rng.choice([0.0, 0.01, 1.0], 3)
    duration = data.draw(st.floats(0.1, 100))
    times = np.sort(rng.uniform(0.1, 0.9, vias)) * duration if data.draw(st.booleans()) and vias else None
    how = {"profile": profile, "n_set_points": data.draw(st.integers(2, 60)), "via_times": times}
    try:
        planned = gd.plan(ARM, knots[0], knots[-1], duration, via=list(knots[1:-1]), **how)
    except TrajectoryError:  # all three joints stand still
        assume(False)
    assert contradictions(planned.time, planned.q, planned.qd, planned.qdd) == []


def test_coarse_set_points_between_near_vias_are_not_suspected():
    """Between eight set points the arm turns at four vias: two of the intervals left out would not do."""
    via = [[-0.0259], [-0.0232], [-0.0222], [-0.0098]]
    times = [10.18, 66.74, 79.89, 84.6]
    options = {"profile": "trapezoidal", "n_set_points": 8, "via_times": times}
    planned = gd.plan(arm_of("1"), [-0.0163], [0.0234], 95.0, via=via, **options)
    assert contradictions(planned.time, planned.q, planned.qd, planned.qdd) == []
