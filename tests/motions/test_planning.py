"""Planned motions: the conditions that define every profile, exact extremes, limits, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.limits import limit_report
from gd_analyze.motions.planning import plan_motion
from gd_analyze.motions.profiles import PROFILES
from log_arms import arm_of
from strategies import examples

FREE = arm_of("1", "2")
EPS = np.finfo(float).eps
# For stretches whose lengths differ by a factor of 5 at most, the 14 x 14 systems of the three-segment
# profiles have conditions of up to 2.2e4 (measured over 500 draws and the extreme ratios). 1e5 bounds them,
# 100 covers sums of up to 14 terms and the evaluation; the splines' banded systems stay below that too.
# Derivatives of order r are held against steps / (shortest stretch)^r.
TOLERANCE = 100 * 1e5 * EPS


@st.composite
def motions(draw: st.DrawFn) -> tuple[str, np.ndarray, np.ndarray]:
    name = draw(st.sampled_from(sorted(PROFILES)))
    n_knots = draw(st.sampled_from(PROFILES[name].via_counts or (0, 1, 2, 3))) + 2
    widths = draw(arrays(float, n_knots - 1, elements=st.floats(0.2, 1.0)))
    times = np.concatenate([[0.0], np.cumsum(widths) / widths.sum() * draw(st.floats(0.01, 100.0))])
    # Steps of a microradian: numbers near the smallest floats say nothing about motions.
    knots = draw(arrays(int, (n_knots, 2), elements=st.integers(-3_000_000, 3_000_000))) * 1e-6
    return name, times, knots


def scale(times: np.ndarray, knots: np.ndarray, order: int) -> float:
    """Size of a derivative of the motion, for tolerances; positions also carry the start."""
    step = np.abs(knots - knots[0]).max() / np.diff(times).min() ** order
    return float(step + (np.abs(knots).max() if order == 0 else 0.0))


@given(motions())
def test_conditions_of_a_profile(motion):
    name, times, knots = motion
    profile = PROFILES[name]
    path = profile.path(times, np.column_stack([knots, np.full(len(knots), 0.7)]))
    assert np.abs(path(times)[:, :2] - knots).max() <= TOLERANCE * scale(times, knots, 0)
    for order in range(1, profile.rest_orders + 1):
        assert np.abs(path(times[[0, -1]], order)).max() <= TOLERANCE * scale(times, knots, order)
    # A joint that stays put stays exactly.
    sampled = np.linspace(0.0, times[-1], 50)
    assert (path(sampled)[:, 2] == 0.7).all()
    assert not path(sampled, 1)[:, 2].any()
    for order in range({"trapezoidal": 1, "quintic": 4}.get(name, 2) + 1):
        derived = path.derivative(order) if order else path
        for piece, width in enumerate(np.diff(derived.x)[:-1]):
            before = [np.polyval(derived.c[:, piece, joint], width) for joint in range(3)]
            # Pieces are up to four times shorter than the stretches.
            limit = TOLERANCE * scale(times, knots, order) * 4**order
            assert np.abs(before - derived.c[-1, piece + 1]).max() <= limit
    if "-" in name:
        for piece, degree in enumerate(map(int, name.split("-"))):
            assert not path.c[: path.c.shape[0] - degree - 1, piece].any()


@given(motions())
def test_exact_extremes_bound_a_dense_sampling_closely(motion):
    name, times, knots = motion
    path = PROFILES[name].path(times, knots)
    rows = limit_report(FREE, path).rows
    sampled, step = np.linspace(0.0, times[-1], 1001), times[-1] / 1000
    for order, exact, dense in (
        (0, [row.highest for row in rows], path(sampled).max(axis=0)),
        (0, [-row.lowest for row in rows], -path(sampled).min(axis=0)),
        (1, [row.velocity for row in rows], np.abs(path(sampled, 1)).max(axis=0)),
        (2, [row.acceleration for row in rows], np.abs(path(sampled, 2)).max(axis=0)),
    ):
        round_off = 10 * TOLERANCE * scale(times, knots, order) * 4**order
        assert (dense <= exact + round_off).all()
        # The nearest sample is within one step of the extreme, where the function changes by at most
        # step x (largest next derivative); trapezoidal accelerations are constant on each piece.
        steepest = np.abs(path(sampled, order + 1)).max(axis=0) * (name != "trapezoidal" or order < 2)
        assert (exact - dense <= 1.5 * step * steepest + round_off).all()


@pytest.mark.parametrize("name", PROFILES)
def test_without_vias(name):
    path = PROFILES[name].path(np.array([0.0, 2.0]), np.array([[-1.0, 2.0], [3.0, 0.5]]))
    rows = limit_report(FREE, path).rows
    np.testing.assert_allclose([row.lowest for row in rows], [-1.0, 0.5], atol=4 * TOLERANCE)
    np.testing.assert_allclose([row.highest for row in rows], [3.0, 2.0], atol=4 * TOLERANCE)
    x = np.linspace(0, 1, 9)
    jerk = 10 * x**3 - 15 * x**4 + 6 * x**5
    closed = {"quintic": jerk, "cubic": 3 * x**2 - 2 * x**3}
    if name in closed:
        # Values up to 4 from a 6 x 6 system of condition 1e3 at most.
        np.testing.assert_allclose(path(2 * x)[:, 0], 4 * closed[name] - 1, atol=4e3 * EPS)
    elif "-" in name:  # lift-off and set-down lie on the polynomial of least jerk
        np.testing.assert_allclose(path(2 * x[[2, 6]])[:, 0], 4 * jerk[[2, 6]] - 1, atol=4 * TOLERANCE)


def test_trapezoidal_cruises_in_the_middle_third_and_stops_at_vias():
    path = PROFILES["trapezoidal"].path(np.array([0.0, 3.0, 9.0]), np.array([[0.0], [2.0], [1.0]]))
    # 1.5 and 4.5 times distance over time and time squared; a few operations of round-off.
    np.testing.assert_allclose(path([1.5, 6.0], 1)[:, 0], [1.0, -0.25], rtol=10 * EPS)
    np.testing.assert_allclose(path([0.5, 1.5, 2.5], 2)[:, 0], [1.0, 0.0, -1.0], rtol=10 * EPS)
    assert abs(path(3.0, 1)[0]) <= 10 * EPS


# Steps of a microradian, as above.
knots_of_two = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).uniform(-3.0, 3.0, (4, 2)).round(6)
)


@pytest.mark.parametrize("profile", sorted(PROFILES))
@examples(20)
@given(knots=knots_of_two, duration=st.floats(0.1, 9.0), stretch=st.floats(1.0, 5.0))
def test_set_points(knots, profile, duration, stretch):
    # Stretches whose lengths differ by less than 25, their times by less than 5 (square root).
    assume(np.abs(np.diff(knots, axis=0)).max(axis=1).min() > 6.0 / 25)
    quick, slow = (
        gd.plan(FREE, knots[0], knots[3], t, via=knots[1:3], profile=profile, n_set_points=501)
        for t in (duration, stretch * duration)
    )
    np.testing.assert_array_equal(quick.time, np.linspace(0, duration, 501))
    np.testing.assert_array_equal(quick.q[[0, -1]], knots[[0, 3]])
    assert not quick.qd[[0, -1]].any()
    assert PROFILES[profile].rest_orders < 2 or not quick.qdd[[0, -1]].any()
    for order, what in enumerate(("q", "qd", "qdd")):  # velocities go with 1 / time, accelerations squared
        first, second = (getattr(motion, what) for motion in (quick, slow))
        size = 1 + np.abs(first).max()
        assert np.abs(first - second * stretch**order).max() <= TOLERANCE * size


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_vias_are_passed_at_the_times_asked_for(two_link, profile):
    via, times = np.array([[0.3, -0.2], [0.1, 0.5]]), [1.5, 4.0]
    planned = plan_motion(
        two_link, [0, 0], [1, 1], 6.0, via=via, profile=profile, n_set_points=13, via_times=times
    )
    np.testing.assert_array_equal(planned.knot_times, [0, 1.5, 4.0, 6.0])
    at = np.searchsorted(planned.trajectory.time, times)
    assert np.abs(planned.trajectory.q[at] - via).max() <= TOLERANCE


def test_default_via_times_follow_the_slowest_joint(two_link):
    # Velocity limits 3 and 4 rad/s: the stretches ask for 0.3 / 3 and 1.6 / 4 s, shares 1 : 2.
    planned = plan_motion(two_link, [0, 0], [0.3, 1.6], 6.0, via=[[0.3, 0.1]], profile="cubic")
    middle = 6.0 / (1 + np.sqrt(1.5 / 4 / 0.1))
    np.testing.assert_allclose(planned.knot_times, [0.0, middle, 6.0], rtol=4 * EPS)


def test_accelerations_at_a_jump_are_those_just_after_it(two_link):
    # Set points 10 and 20 of 31 lie on the jumps at a third and two thirds, up to round-off.
    for duration in (1.0, 1.1, 1.3, 1.7, 2.9, 3.1):
        planned = gd.plan(two_link, [0, 0], [0.5, 0.5], duration, profile="trapezoidal")
        signs = np.sign(np.round(planned.qdd[:, 0], 9))
        np.testing.assert_array_equal(signs, [1] * 10 + [0] * 10 + [-1] * 11)


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_shortest_duration_is_shortest(two_link, profile):
    ends = ([-1.0, -0.5], [1.0, 2.0])
    shortest = plan_motion(two_link, *ends, 20.0, profile=profile).shortest_duration
    # Limits are judged with 1e-9 of slack, so 1e-8 either way decides.
    gd.plan(two_link, *ends, shortest * (1 + 1e-8), profile=profile)
    with pytest.raises(TrajectoryError, match="too fast"):
        gd.plan(two_link, *ends, shortest * (1 - 1e-8), profile=profile)


def test_limits_are_those_of_the_motion_not_of_its_set_points(two_link):
    planned = plan_motion(two_link, [0, 0], [1, 1], 2.0, profile="quintic", n_set_points=4)
    # The velocity of the quintic peaks half-way, 15/8 of the mean; four set points miss it.
    assert planned.limits.rows[0].velocity == pytest.approx(15 / 16, rel=1e-12)
    assert limit_report(two_link, planned.trajectory).rows[0].velocity < 0.9


def test_too_fast_names_joint_amount_and_duration(two_link):
    with pytest.raises(TrajectoryError) as caught:
        gd.plan(two_link, [0, 0], [1, 0.1], 0.5, profile="quintic")
    text = str(caught.value)
    # 15/8 rad in 0.5 s is 3.75 rad/s, a quarter above 3; the acceleration 5.774 / 0.25 = 23.09 needs
    # sqrt(0.5774) = 0.76 s for 10.
    for fact in ("joint 1", "3.75 rad/s", "0.75 rad/s (25 %)", "23.09 rad/s^2", "0.76 s"):
        assert fact in text
    assert "joint 2" not in text
    with pytest.warns(GdAnalyzeWarning, match=r"joint 1 \(shoulder\).*0.76 s"):
        planned = plan_motion(two_link, [0, 0], [1, 0.1], 0.5, profile="quintic", allow_violations=True)
    assert {v.quantity for v in planned.limits.violations} == {"velocity", "acceleration"}


def test_overshoot_past_a_position_limit_is_an_error(two_link):
    ends, via = ([0, 0], [0, 0.1]), np.deg2rad([[179.0, 0.0], [179.5, 10.0]])
    with pytest.raises(TrajectoryError, match=r"(?s)between its knots.*joint 1.*180 deg"):
        gd.plan(two_link, *ends, 20.0, via=via, profile="cubic", allow_violations=True)
    gd.plan(two_link, *ends, 20.0, via=via, profile="trapezoidal")


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_a_joint_may_move_by_next_to_nothing(profile):
    for least in (1e-320, 1e-300, 1e-17):
        planned = plan_motion(FREE, [0, 0], [1, least], 1.0, profile=profile)
        assert planned.limits.rows[1].highest <= 2 * least


VIAS = [[0.1, 0.1], [0.2, 0.2]]


@pytest.mark.parametrize(
    ("changes", "where", "found"),
    [
        ({"duration": float("nan")}, "duration", "nan"),
        ({"n_set_points": 1}, "n_set_points", "1"),
        ({"goal": [[1.0, 1.0]]}, "goal", "shape (1, 2)"),
        ({"goal": ["a", 0.0]}, "goal", "['a', 0.0]"),
        ({"via": [[0.1, 0.1], [0.2, np.inf]]}, "via 2[1]", "inf"),
        ({"via": VIAS[:1]}, "via", "1"),
        ({"via": [[0.1, 0.1], [0.1, 0.1]]}, "via 2", "no movement"),
        ({"goal": [4.0, 0.0]}, "goal", "4 rad (229.2 deg)"),
        ({"via": VIAS, "via_times": [1.0]}, "via_times", "[1.0]"),
        ({"via": VIAS, "via_times": [1e-300, 2e-300]}, "via_times", "[1e-300, 2e-300]"),
    ],
)
def test_bad_arguments_are_named(two_link, changes, where, found):
    arguments = {"start": [0.0, 0.0], "goal": [1.0, 1.0], "duration": 5.0} | changes
    with pytest.raises(TrajectoryError) as caught:
        gd.plan(two_link, **arguments)
    assert (caught.value.details["where"], caught.value.details["found"]) == (where, found)
