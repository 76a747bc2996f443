from __future__ import annotations

import re
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.limits import limit_report
from gd_analyze.motions.planning import Schedule, plan
from gd_analyze.motions.profiles import PROFILES
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link

FREE = RobotArm(
    "free",
    joints=(Joint("1"), Joint("2")),
    links=tuple(Link(name, 1.0, np.zeros(3), 0.1 * np.eye(3)) for name in "12"),
)
EPS = np.finfo(float).eps
# See test_profiles: condition of the systems behind the profiles, times eps, times 100.
TOLERANCE = 100 * 1e5 * EPS

# Steps of a microradian: numbers near the smallest floats say nothing about motions.
knots_of_two = st.integers(0, 2**32 - 1).map(
    lambda seed: [*map(tuple, np.random.default_rng(seed).uniform(-3.0, 3.0, (4, 2)).round(6).tolist())]
)


def via_of(profile: str, knots: list[tuple[float, float]]) -> list[tuple[float, float]]:
    return [] if PROFILES[profile].via_counts is None and knots[1][0] > 0.3 else knots[1:3]


def apart(knots: list[tuple[float, float]]) -> bool:
    """Stretches whose lengths differ by less than 25, their times by less than 5 (square root)."""
    steps = np.abs(np.diff(np.array(knots), axis=0)).max(axis=1)
    return bool(steps.min() > 6.0 / 25)


@given(knots_of_two, st.sampled_from(sorted(PROFILES)), st.floats(0.1, 30.0))
def test_set_points_carry_the_derivatives_of_the_positions(
    knots: list[tuple[float, float]], profile: str, duration: float
) -> None:
    assume(apart(knots) and apart([knots[0], knots[3]]))
    via = via_of(profile, knots)
    planned = plan(FREE, knots[0], knots[3], via, schedule=Schedule(duration, profile, n_set_points=2001))
    trajectory = planned.trajectory
    h = duration / 2000
    central_q = (trajectory.q[2:] - trajectory.q[:-2]) / (2 * h)
    central_qd = (trajectory.qd[2:] - trajectory.qd[:-2]) / (2 * h)
    inner = np.ones(1999, dtype=bool)
    if profile == "trapezoidal":
        # The acceleration jumps between pieces; there a difference quotient means nothing.
        changes = np.abs(np.diff(trajectory.qdd, axis=0)).max(axis=1)
        jumps = changes > 1e-6 * np.abs(trajectory.qdd).max()
        inner = ~(jumps[:-1] | jumps[1:])
    # The end set points of the cubic profile are one-sided, its inner ones are smooth.
    lipschitz = np.abs(np.diff(trajectory.qdd, axis=0))
    jerk = 0.0 if profile == "trapezoidal" else 1.1 * lipschitz.max() / h
    # Taylor: with qdd changing by at most jerk x time, the quotients err by jerk h^2 / 6 and jerk h / 2;
    # round-off of the values is divided by h.
    for quotient, derivative, source, taylor in (
        (central_q, trajectory.qd, trajectory.q, jerk * h**2 / 6),
        (central_qd, trajectory.qdd, trajectory.qd, jerk * h / 2),
    ):
        round_off = TOLERANCE * np.abs(source).max() / h
        assert np.abs(quotient - derivative[1:-1])[inner].max() <= taylor + round_off


@given(knots_of_two, st.sampled_from(sorted(PROFILES)), st.floats(0.1, 9.0), st.floats(1.0, 5.0))
def test_stretching_time_divides_velocities(
    knots: list[tuple[float, float]], profile: str, duration: float, stretch: float
) -> None:
    assume(apart(knots))
    plans = [
        plan(FREE, knots[0], knots[3], knots[1:3], schedule=Schedule(t, profile)).trajectory
        for t in (duration, stretch * duration)
    ]
    for order, what in enumerate(("q", "qd", "qdd")):
        quick, slow = (getattr(p, what) for p in plans)
        size = 1 + np.abs(quick).max()
        assert np.abs(quick - slow * stretch**order).max() <= TOLERANCE * size


@given(knots_of_two, st.sampled_from(sorted(PROFILES)))
def test_ends_hold_exactly_and_set_points_are_even(knots: list[tuple[float, float]], profile: str) -> None:
    assume(apart(knots))
    trajectory = plan(FREE, knots[0], knots[3], knots[1:3], schedule=Schedule(9.0, profile)).trajectory
    assert trajectory.n_set_points == 31
    assert trajectory.derivatives_from == "given"
    np.testing.assert_array_equal(trajectory.time, np.linspace(0, 9.0, 31))
    np.testing.assert_array_equal(trajectory.q[[0, -1]], [knots[0], knots[3]])
    assert not trajectory.qd[[0, -1]].any()
    if PROFILES[profile].rest_orders == 2:
        assert not trajectory.qdd[[0, -1]].any()


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_vias_are_passed_at_the_times_asked_for(two_link: RobotArm, profile: str) -> None:
    via = np.array([[0.3, -0.2], [0.1, 0.5]])
    times = [1.5, 4.0]
    planned = plan(
        two_link, [0, 0], [1, 1], via, schedule=Schedule(6.0, profile, n_set_points=13, via_times=times)
    )
    np.testing.assert_array_equal(planned.knot_times, [0, 1.5, 4.0, 6.0])
    at = np.searchsorted(planned.trajectory.time, times)
    assert np.abs(planned.trajectory.q[at] - via).max() <= TOLERANCE


def test_default_via_times_follow_the_slowest_joint(two_link: RobotArm) -> None:
    # Rate limits 3 and 4 rad/s: the stretches ask for 0.3 / 3 and 1.6 / 4 s, shares 1 : 2.
    planned = plan(two_link, [0, 0], [0.3, 1.6], [[0.3, 0.1]], schedule=Schedule(6.0, "cubic"))
    np.testing.assert_allclose(
        planned.knot_times, [0.0, 6.0 / (1 + np.sqrt(1.5 / 4 / 0.1)), 6.0], rtol=4 * EPS
    )


def test_accelerations_at_a_jump_are_those_just_after_it(two_link: RobotArm) -> None:
    # Set points 10 and 20 of 31 lie on the jumps at a third and two thirds, up to round-off.
    for duration in (1.0, 1.1, 1.3, 1.7, 2.9, 3.1):
        planned = plan(two_link, [0, 0], [0.5, 0.5], schedule=Schedule(duration, "trapezoidal")).trajectory
        signs = np.sign(np.round(planned.qdd[:, 0], 9))
        np.testing.assert_array_equal(signs, [1] * 10 + [0] * 10 + [-1] * 11)


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_shortest_duration_is_shortest(two_link: RobotArm, profile: str) -> None:
    ends = ([-1.0, -0.5], [1.0, 2.0])
    shortest = plan(two_link, *ends, schedule=Schedule(20.0, profile)).shortest_duration
    assert shortest is not None
    # Limits are judged with 1e-9 of slack, so 1e-8 either way decides.
    plan(two_link, *ends, schedule=Schedule(shortest * (1 + 1e-8), profile))
    with pytest.raises(TrajectoryError, match="too fast"):
        plan(two_link, *ends, schedule=Schedule(shortest * (1 - 1e-8), profile))


def test_limits_of_the_plan_are_those_of_the_motion_not_of_its_set_points(two_link: RobotArm) -> None:
    planned = plan(two_link, [0, 0], [1, 1], schedule=Schedule(2.0, "quintic", n_set_points=4))
    # The rate of the quintic peaks half-way, 15/8 of the mean; four set points miss it.
    assert planned.limits.rows[0].velocity == pytest.approx(15 / 16, rel=1e-12)
    assert limit_report(two_link, planned.trajectory).rows[0].velocity < 0.9


def test_too_fast_names_joint_amount_and_duration(two_link: RobotArm) -> None:
    with pytest.raises(TrajectoryError) as caught:
        plan(two_link, [0, 0], [1, 0.1], schedule=Schedule(0.5, "quintic"))
    text = str(caught.value)
    # 15/8 rad in 0.5 s is 3.75 rad/s, a quarter above 3; the acceleration 5.774 / 0.25 = 23.09 needs
    # sqrt(0.5774) = 0.76 s for 10.
    assert "joint 1 (shoulder): velocity 3.75 rad/s, 0.75 rad/s (25 %) above the limit 3 rad/s" in text
    assert "joint 1 (shoulder): acceleration 23.09 rad/s^2" in text
    assert "joint 2" not in text
    assert "a duration of 0.76 s" in text


def test_violations_can_be_allowed(two_link: RobotArm) -> None:
    with pytest.warns(GdAnalyzeWarning, match=r"joint 1 \(shoulder\): velocity .* a duration of 0.76 s"):
        planned = plan(two_link, [0, 0], [1, 0.1], schedule=Schedule(0.5, "quintic"), allow_violations=True)
    assert {v.quantity for v in planned.limits.violations} == {"velocity", "acceleration"}


def test_overshoot_past_a_position_limit_is_an_error(two_link: RobotArm) -> None:
    near_limit = np.deg2rad([[179.0, 0.0], [179.5, 10.0]])
    with pytest.raises(TrajectoryError, match="between its knots") as caught:
        plan(two_link, [0, 0], [0, 0.1], near_limit, schedule=Schedule(20.0, "cubic"), allow_violations=True)
    assert re.search(
        r"joint 1 \(shoulder\): position .* above its upper limit 3.142 rad \(180 deg\), at",
        str(caught.value),
    )
    plan(two_link, [0, 0], [0, 0.1], near_limit, schedule=Schedule(20.0, "trapezoidal"))


def test_joints_without_limits_are_not_checked_and_said_so(slider: RobotArm) -> None:
    planned = plan(slider, [0, 0.1], [100, 0.2], schedule=Schedule(1.0))
    assert planned.limits.violations == ()
    row = planned.limits.rows[0]
    assert row.highest == pytest.approx(100)


def test_messages_about_sliding_joints_speak_of_metres(slider: RobotArm) -> None:
    with pytest.raises(TrajectoryError, match=r"joint 2 \(slide\)") as caught:
        plan(slider, [0, 0.1], [1, 0.7], schedule=Schedule(1.0))
    assert "0 m .. 0.5 m" in str(caught.value)
    with pytest.raises(TrajectoryError, match=r"m/s\^2"):
        plan(slider, [0, 0.1], [1, 0.4], schedule=Schedule(0.1))


def test_there_and_back_is_a_motion(two_link: RobotArm) -> None:
    trajectory = plan(
        two_link, [0, 0], [0, 0], [[0.5, 0.5]], schedule=Schedule(3.0, "quintic", n_set_points=3)
    ).trajectory
    assert np.abs(trajectory.q[1] - 0.5).max() <= TOLERANCE


@pytest.mark.parametrize("profile", sorted(PROFILES))
def test_a_joint_may_move_by_next_to_nothing(profile: str) -> None:
    for least in (1e-320, 1e-300, 1e-17):
        planned = plan(FREE, [0, 0], [1, least], schedule=Schedule(1.0, profile))
        assert planned.limits.rows[1].highest <= 2 * least


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"duration": 0.0}, ["duration", "1e-06 s to 1e+12 s", "found: 0"]),
        (
            {"via": [[0.1, 0.1], [0.2, 0.2]], "via_times": [1e-300, 2e-300]},
            ["via_times", "2 increasing instants"],
        ),
        ({"duration": float("nan")}, ["duration", "nan"]),
        ({"n_set_points": 1}, ["n_set_points", "2 to 1000000"]),
        ({"profile": "quintc"}, ["no profile 'quintc'", "4-3-4, 3-5-3", "did you mean 'quintic'?"]),
        ({"start": [0.0, 0.0, 0.0]}, ["start does not fit arm two_link", "2 joint variables", "3 values"]),
        ({"goal": [[1.0, 1.0]]}, ["goal does not fit", "shape (1, 2)"]),
        ({"goal": ["a", 0.0]}, ["goal is not made of numbers"]),
        ({"goal": [np.nan, 0.0]}, ["goal is not finite"]),
        ({"via": [[0.1, 0.1], [0.2, np.inf]]}, ["via 2 is not finite"]),
        ({"via": [[0.1, 0.1]]}, ["cannot take this number of vias", "none, or two", "1", "quintic"]),
        ({"via": [[0.1, 0.1], [0.1, 0.1]]}, ["via 1 and via 2 are the same"]),
        ({"goal": [0.0, 0.0]}, ["start and goal are the same", "no movement"]),
        ({"goal": [4.0, 0.0]}, ["goal lies outside the range of joint 1 (shoulder)", "(180 deg)", "4 rad"]),
        (
            {"via": [[0.1, 0.1], [0.2, 0.2]], "via_times": [1.0]},
            ["via_times", "2 increasing instants between 0 and 5 s"],
        ),
        ({"via": [[0.1, 0.1], [0.2, 0.2]], "via_times": [3.0, 2.0]}, ["via_times"]),
    ],
)
def test_bad_arguments_are_named(two_link: RobotArm, changes: dict[str, object], expected: list[str]) -> None:
    arguments = {"start": [0.0, 0.0], "goal": [1.0, 1.0], "duration": 5.0} | changes
    when = {field.name: arguments.pop(field.name) for field in fields(Schedule) if field.name in arguments}
    with pytest.raises(TrajectoryError) as caught:
        plan(two_link, **arguments, schedule=Schedule(**when))
    for text in expected:
        assert text in str(caught.value)
