"""The motion of every profile, as a function of time, against the conditions that define it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from log_arms import arm_of
from scipy.interpolate import PPoly

from gd_analyze.motions.limits import limit_report
from gd_analyze.motions.profiles import PROFILES

NAMES = tuple(PROFILES)
EPS = np.finfo(float).eps

# For stretches whose lengths differ by a factor of 5 at most, the 14 x 14 systems of the three-segment
# profiles have conditions of up to 2.2e4 (measured over 500 draws and the extreme ratios). 1e5 bounds them,
# 100 covers sums of up to 14 terms and the evaluation; the splines' banded systems stay below that too.
# Derivatives of order r are held against steps / (shortest stretch)^r.
TOLERANCE = 100 * 1e5 * EPS


@st.composite
def motions(draw: st.DrawFn, names: tuple[str, ...] = NAMES) -> tuple[str, np.ndarray, np.ndarray]:
    name = draw(st.sampled_from(names))
    counts = PROFILES[name].via_counts or (0, 1, 2, 3)
    n_knots = draw(st.sampled_from(counts)) + 2
    widths = draw(arrays(float, n_knots - 1, elements=st.floats(0.2, 1.0)))
    duration = draw(st.floats(0.01, 100.0))
    times = np.concatenate([[0.0], np.cumsum(widths) / widths.sum() * duration])
    n_joints = draw(st.integers(1, 3))
    # Steps of a microradian: numbers near the smallest floats say nothing about motions.
    knots = draw(arrays(int, (n_knots, n_joints), elements=st.integers(-3_000_000, 3_000_000))) * 1e-6
    return name, times, knots


def scale(times: np.ndarray, knots: np.ndarray, order: int) -> float:
    """Size of a derivative of the motion, for tolerances; positions also carry the start."""
    step = np.abs(knots - knots[0]).max() / np.diff(times).min() ** order
    return float(step + (np.abs(knots).max() if order == 0 else 0.0))


def one_sided(path: object, order: int) -> tuple[np.ndarray, np.ndarray]:
    """A derivative at the end of each piece and at the beginning of the next."""
    derived = path.derivative(order) if order else path
    widths = np.diff(derived.x)
    before = np.array(
        [
            [np.polyval(derived.c[:, piece, joint], widths[piece]) for joint in range(derived.c.shape[2])]
            for piece in range(len(widths) - 1)
        ]
    ).reshape(len(widths) - 1, derived.c.shape[2])
    return before, derived.c[-1, 1:]


@given(motions())
def test_passes_through_every_knot_in_time(motion: tuple[str, np.ndarray, np.ndarray]) -> None:
    name, times, knots = motion
    error = np.abs(PROFILES[name].path(times, knots)(times) - knots).max()
    assert error <= TOLERANCE * scale(times, knots, 0)


@given(motions())
def test_is_at_rest_at_both_ends(motion: tuple[str, np.ndarray, np.ndarray]) -> None:
    name, times, knots = motion
    path = PROFILES[name].path(times, knots)
    for order in range(1, PROFILES[name].rest_orders + 1):
        assert np.abs(path(times[[0, -1]], order)).max() <= TOLERANCE * scale(times, knots, order)


@given(motions())
def test_is_as_smooth_as_it_says(motion: tuple[str, np.ndarray, np.ndarray]) -> None:
    name, times, knots = motion
    path = PROFILES[name].path(times, knots)
    smoothness = {"trapezoidal": 1, "quintic": 4}.get(name, 2)
    for order in range(smoothness + 1):
        before, after = one_sided(path, order)
        # Thirds of a stretch for the trapezoidal profile, quarters without vias for the three-segment
        # ones: pieces are up to four times shorter than the stretches.
        limit = TOLERANCE * scale(times, knots, order) * 4**order
        assert np.abs(before - after).max(initial=0.0) <= limit


@given(motions(("4-3-4", "3-5-3")))
def test_three_segments_have_the_degrees_of_their_name(motion: tuple[str, np.ndarray, np.ndarray]) -> None:
    name, times, knots = motion
    path = PROFILES[name].path(times, knots)
    assert path.c.shape[1] == 3
    for piece, degree in enumerate(map(int, name.split("-"))):
        assert not path.c[: path.c.shape[0] - degree - 1, piece].any()


@given(motions())
def test_a_joint_that_stays_put_stays_exactly(motion: tuple[str, np.ndarray, np.ndarray]) -> None:
    name, times, knots = motion
    knots = np.column_stack([knots, np.full(len(knots), 0.7)])
    path = PROFILES[name].path(times, knots)
    sampled = np.linspace(0.0, times[-1], 50)
    assert (path(sampled)[:, -1] == 0.7).all()
    assert not path(sampled, 1)[:, -1].any()
    assert not path(sampled, 2)[:, -1].any()


def values_of(path: PPoly) -> np.ndarray:
    """Lowest, highest, rate and acceleration of every joint, shape (4, n)."""
    rows = limit_report(arm_of(*map(str, range(path.c.shape[2]))), path).rows
    return np.array([(row.lowest, row.highest, row.velocity, row.acceleration) for row in rows]).T


@given(motions())
def test_exact_extremes_bound_a_dense_sampling_closely(motion: tuple[str, np.ndarray, np.ndarray]) -> None:
    name, times, knots = motion
    path = PROFILES[name].path(times, knots)
    lowest, highest, rate, acceleration = values_of(path)
    sampled = np.linspace(0.0, times[-1], 1001)
    step = times[-1] / 1000
    for order, exact, dense in (
        (0, highest, path(sampled).max(axis=0)),
        (0, -lowest, -path(sampled).min(axis=0)),
        (1, rate, np.abs(path(sampled, 1)).max(axis=0)),
        (2, acceleration, np.abs(path(sampled, 2)).max(axis=0)),
    ):
        round_off = 10 * TOLERANCE * scale(times, knots, order) * 4**order
        assert (dense <= exact + round_off).all()
        if name == "trapezoidal" and order == 2:
            # Constant on each piece, and no piece is shorter than a sampling step.
            assert (exact - dense <= round_off).all()
            continue
        # The nearest sample is within one step of the extreme, where the function changes by at most
        # step x (largest next derivative).
        steepest = np.abs(path(sampled, order + 1)).max(axis=0)
        assert (exact - dense <= 1.5 * step * steepest + round_off).all()


@pytest.mark.parametrize("name", NAMES)
def test_no_overshoot_without_vias(name: str) -> None:
    path = PROFILES[name].path(np.array([0.0, 2.0]), np.array([[-1.0, 2.0], [3.0, 0.5]]))
    lowest, highest, _, _ = values_of(path)
    # Round-off of the 14 x 14 solution, as above.
    np.testing.assert_allclose(lowest, [-1.0, 0.5], atol=4 * TOLERANCE)
    np.testing.assert_allclose(highest, [3.0, 2.0], atol=4 * TOLERANCE)


def test_quintic_without_vias_is_the_least_jerk_polynomial() -> None:
    path = PROFILES["quintic"].path(np.array([0.0, 2.0]), np.array([[0.0], [1.0]]))
    x = np.linspace(0, 1, 11)
    # Values up to 1 from a 6 x 6 system of condition 1e3 at most.
    np.testing.assert_allclose(path(2 * x)[:, 0], 10 * x**3 - 15 * x**4 + 6 * x**5, atol=1e3 * EPS)


def test_default_lift_off_lies_on_the_least_jerk_polynomial() -> None:
    x = 0.25
    on_quintic = 10 * x**3 - 15 * x**4 + 6 * x**5
    for name in ("4-3-4", "3-5-3"):
        path = PROFILES[name].path(np.array([0.0, 1.0]), np.array([[0.0], [1.0]]))
        np.testing.assert_array_equal(path.x, [0.0, 0.25, 0.75, 1.0])
        found = path([0.25, 0.75])[:, 0]
        np.testing.assert_allclose(found, [on_quintic, 1 - on_quintic], atol=TOLERANCE)


def test_cubic_without_vias_is_the_hermite_cubic() -> None:
    path = PROFILES["cubic"].path(np.array([0.0, 2.0]), np.array([[0.0], [1.0]]))
    x = np.linspace(0, 1, 11)
    np.testing.assert_allclose(path(2 * x)[:, 0], 3 * x**2 - 2 * x**3, atol=10 * EPS)


def test_trapezoidal_cruises_in_the_middle_third_and_stops_at_vias() -> None:
    times = np.array([0.0, 3.0, 9.0])
    path = PROFILES["trapezoidal"].path(times, np.array([[0.0], [2.0], [1.0]]))
    # 1.5 and 4.5 times distance over time and time squared; a few operations of round-off.
    np.testing.assert_allclose(path([1.5, 6.0], 1)[:, 0], [1.0, -0.25], rtol=10 * EPS)
    np.testing.assert_allclose(path([0.5, 1.5, 2.5], 2)[:, 0], [1.0, 0.0, -1.0], rtol=10 * EPS)
    assert abs(path(3.0, 1)[0]) <= 10 * EPS
