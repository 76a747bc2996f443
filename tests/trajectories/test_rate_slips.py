"""Rates that contradict positions and instants: every slip is named, and no sound motion is suspected."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.motions.planning import Schedule, plan
from gd_analyze.motions.profiles import PROFILES
from gd_analyze.motions.rate_slips import rate_slips
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link
from strategies import examples

ARM = RobotArm(
    "three",
    tuple(Joint(str(i)) for i in (1, 2, 3)),
    tuple(Link(str(i), 1.0, np.zeros(3), 0.1 * np.eye(3)) for i in (1, 2, 3)),
)


def motion(n: int = 60, **changed: object) -> Trajectory:
    """Two joints that swing at different rates, and a third that does not move."""
    time = np.linspace(0, 3, n)
    still = np.zeros(n)
    numbers = {
        "time": time,
        "q": np.column_stack([np.sin(2 * time), np.cos(3 * time), still]),
        "qd": np.column_stack([2 * np.cos(2 * time), -3 * np.sin(3 * time), still]),
        "qdd": np.column_stack([-4 * np.sin(2 * time), -9 * np.cos(3 * time), still]),
    }
    return Trajectory(**(numbers | changed), name="m")


SOUND = motion()
NOISE = np.random.default_rng(1)

SLIPS: dict[str, tuple[dict[str, object], str]] = {
    "time in ms": (
        {"time": SOUND.time * 1e3},
        "qd of joints 1 and 2 is 1000 times the derivative of q, as if time",
    ),
    "time in us": ({"time": SOUND.time * 1e6}, "in microseconds"),
    "rates in degrees": (
        {"qd": np.degrees(SOUND.qd), "qdd": np.degrees(SOUND.qdd)},
        "columns in degrees are named qd1_deg",
    ),
    "angles in degrees": ({"q": np.degrees(SOUND.q)}, "columns in degrees are named q1_deg"),
    "no rates": (
        {"qd": 0 * SOUND.qd},
        "qd of joints 1 and 2 is 0 throughout while q changes: if unknown, leave",
    ),
    "no accelerations": ({"qdd": 0 * SOUND.qdd}, "qdd of joints 1 and 2 is 0 throughout while qd changes"),
    "other sign": ({"qd": -SOUND.qd}, "with the other sign"),
    "columns exchanged": ({"qd": SOUND.qd[:, [1, 0, 2]]}, "qd of joints 1 and 2 is not the derivative of q"),
    "one joint's rates": (
        {"qd": SOUND.qd * [1, 0.5, 1], "qdd": SOUND.qdd * [1, 0.5, 1]},
        "qd of joint 2 is not the derivative of q",
    ),
    "accelerations for rates": ({"qdd": SOUND.qd}, "qdd of joints 1 and 2 is not the derivative of qd"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_named_once(slip: str) -> None:
    changed, said = SLIPS[slip]
    told = rate_slips(motion(**changed))
    assert len(told) == 1
    assert said in told[0]


def test_sound_numbers_are_not_suspected() -> None:
    for n in range(2, 61):
        assert rate_slips(motion(n)) == []


def test_noise_and_a_sensor_s_own_scale_are_not_suspected() -> None:
    """At 1 kHz the differences of q are all noise: a thousandth of a radian is a radian per second."""
    fine = motion(3000)
    noisy = {
        "q": fine.q + 1e-3 * NOISE.normal(size=fine.q.shape),
        "qd": 0.95 * fine.qd + 0.05 * NOISE.normal(size=fine.q.shape),
        "qdd": fine.qdd + 1.0 * NOISE.normal(size=fine.q.shape),
    }
    assert rate_slips(motion(3000, **noisy)) == []


@given(data=st.data())
@examples(150)
def test_planned_motions_are_not_suspected(data: st.DataObject) -> None:
    """However coarse the set points, near each other the vias, and steep the movements between."""
    profile = data.draw(st.sampled_from(sorted(PROFILES)))
    counts = PROFILES[profile].via_counts or tuple(range(5))
    vias = data.draw(st.sampled_from(counts))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    knots = rng.uniform(-3, 3, (vias + 2, 3)) * rng.choice([0.0, 0.01, 1.0], 3)
    duration = data.draw(st.floats(0.1, 100))
    times = np.sort(rng.uniform(0.1, 0.9, vias)) * duration if data.draw(st.booleans()) and vias else None
    schedule = Schedule(duration, profile, data.draw(st.integers(2, 60)), times)
    try:
        made = plan(ARM, knots[0], knots[-1], list(knots[1:-1]), schedule=schedule)
    except TrajectoryError:  # all three joints stand still
        assume(False)
    assert rate_slips(made.trajectory) == []


def test_a_file_with_time_in_milliseconds(
    csv_file: Callable[[str], Path], warned: Callable[[], object]
) -> None:
    rows = np.column_stack([1e3 * SOUND.time, SOUND.q, SOUND.qd, SOUND.qdd])
    header = "time,q1,q2,q3,qd1,qd2,qd3,qdd1,qdd2,qdd3"
    with warned() as texts:
        read_trajectory(csv_file(as_csv(header, rows)), ARM)
    assert len(texts) == 1
    assert texts[0].startswith("trajectory motion: qd of joints 1 and 2 is 1000 times the derivative of q")
    # Derived from the same numbers, rates are what they say, however slow.
    with warned() as texts:
        read_trajectory(csv_file(as_csv("time,q1,q2,q3", rows[:, :4])), ARM)
    assert texts == []


def as_csv(header: str, rows: np.ndarray) -> str:
    return "\n".join([header, *(",".join(map(str, row)) for row in rows.tolist())])
