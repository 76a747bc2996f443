"""What is possible but looks wrong: warnings, each naming the joint, the set point and the amount."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gd_analyze as gd
from remedies import remedies, typed


def motion(q: list[list[float]], **others: object) -> gd.Trajectory:
    """Set points every 0.1 s; velocities and accelerations of zero unless given."""
    rows = np.array(q, dtype=float)
    given = {"qd": 0 * rows, "qdd": 0 * rows} | others
    return gd.Trajectory(np.arange(len(rows)) / 10, rows, name="m", **given)


FAST = np.array([[0.0, 0.0], [-3.3, 4.0]])
SUSPECTS = ("joint 1 (waist)", "joint 2 (shoulder)", "joint 6 (flange)", "190 rad", "--map q=:deg")
CASES: dict[str, tuple[str, gd.Trajectory, list[tuple[str, ...]]]] = {
    "positions past both ends": (
        "two_link",
        motion([[0, 0], [np.deg2rad(190), 0], [0, np.deg2rad(-152)]]),
        [
            (
                *("joint 1 (shoulder)", "3.316 rad (190 deg)", "(10 deg) above", "set point 2 (0.1 s)"),
                *("joint 2 (elbow)", "-2.653 rad (-152 deg)", "(2 deg) below", "set point 3 (0.2 s)"),
            ),
        ],
    ),
    "velocities and accelerations": (
        "two_link",
        motion([[0, 0], [0, 0]], qd=FAST, qdd=5 * FAST),
        [
            ("joint 1 (shoulder)", "3.3 rad/s, 0.3 rad/s (10 %)"),
            ("joint 1", "16.5 rad/s^2", "joint 2", "20 rad/s^2, 5 rad/s^2 (33 %)"),
        ],
    ),
    "at a limit": ("two_link", motion([[np.pi, np.deg2rad(-150)]], qd=np.array([[3.0, -4.0]])), []),
    "past a limit by more than digits": ("two_link", motion([[np.pi + 1e-7, 0]]), [("joint 1",)]),
    "a limit's digits": ("two_link", motion([[3.1415926536, 0]]), []),
    "degrees for radians": (
        "puma560",
        motion([[33, -17, 187, 0, 1, -30], [108, -23, 190, 0, 1, 45]]),
        [SUSPECTS],
    ),
    "far out, no degrees": ("two_link", motion([[400, 0]]), [("above its upper limit",)]),
    "two turns without limits": ("slider", motion([[12.5, 0.1]]), []),
    "many turns without limits": ("slider", motion([[90, 0.1]]), [("joint 1", "90 rad (5157 deg)")]),
    "metres": ("slider", motion([[0, 20]]), [("20 m, 19.5 m above", "0.5 m", "--map q=:mm")]),
}


def assert_said(texts: list[str], expected: list[tuple[str, ...]]) -> None:
    assert len(texts) == len(expected)
    for text, facts in zip(texts, expected, strict=True):
        assert all(fact in text for fact in facts)


@pytest.mark.parametrize("case", CASES)
def test_warnings(case, slider, warned, tmp_path):
    arm, trajectory, expected = CASES[case]
    gd.write_trajectory(trajectory, tmp_path / "m.csv")
    with warned() as texts:
        gd.read_trajectory(tmp_path / "m.csv", slider if arm == "slider" else arm)
    assert_said(texts, expected)


def table(header: str, rows: list[str]) -> str:
    return "\n".join([header, *rows])


def test_the_remedy_for_degrees_reads_the_motion(puma, tmp_path, warned):
    """Where only q is in degrees, and where all are."""
    sound = gd.read_trajectory("pick-and-place", puma)
    gd.write_trajectory(sound, tmp_path / "sound.csv")
    header = (tmp_path / "sound.csv").read_text().splitlines()[0]
    for factor, advised in (
        (1.0, "if they are: --map q=:deg"),
        (math.degrees(1.0), "if they are: --map q=:deg --map qd=:deg --map qdd=:deg"),
    ):
        q, others = np.degrees(sound.q), factor * np.hstack([sound.qd, sound.qdd])
        rows = np.column_stack([sound.time, q, others])
        cells = [",".join(map(repr, row)) for row in rows.tolist()]
        path = tmp_path / "m.csv"
        path.write_text("\n".join([header, *cells]))
        with warned() as texts:
            gd.read_trajectory(path, puma)
        text = next(text for text in texts if "looks like degrees" in text)
        assert text.endswith(advised)
        ((words, _),) = remedies(text)
        with warned() as texts:
            read = gd.read_trajectory(path, puma, typed(words))
        assert texts == []
        # Degrees and back: two roundings.
        np.testing.assert_allclose(read.qdd, sound.qdd, rtol=1e-15, atol=1e-15)


CREEPING = [f"{k},{0.5 * np.sin(0.02 * k)},{0.3 * np.cos(0.02 * k)}" for k in range(300)]
TURNED = [f"{k / 10},{0.5 * k},1" for k in range(7)]
FILES: dict[str, tuple[str, list[tuple[str, ...]]]] = {
    "derived": (
        table("time,q1,q2", [f"{k / 100},{0.05 * (k == 5)},0" for k in range(12)]),
        [("velocity", "qd is derived"), ("acceleration", "qdd is derived")],
    ),
    "radians called degrees": (table("time,q1_deg,q2_deg", TURNED), [("within 3 of zero",)]),
    "degrees that move farther": (table("time,q1_deg,q2", [*TURNED[:-1], "0.6,4.0,1"]), []),
    "degrees at rest": (table("time,q1_deg,q2_deg", [f"{k},0,1" for k in range(7)]), []),
    "milliseconds": (
        table("time,q1,q2", [row.replace(",", "0,", 1) for row in CREEPING]),
        [("read as seconds", "--map time=:ms")],
    ),
    "seconds": (table("time,q1,q2", [f"{k / 100}{r[r.index(',') :]}" for k, r in enumerate(CREEPING)]), []),
    "at rest": (table("time,q1,q2", [f"{10 * k},0.1,{1e-3 * k / 300}" for k in range(300)]), []),
}


@pytest.mark.parametrize("case", FILES)
def test_files(case, log, two_link, warned):
    content, expected = FILES[case]
    with warned() as texts:
        gd.read_trajectory(log(content), two_link)
    assert_said(texts, expected)
