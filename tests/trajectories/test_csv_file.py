"""What a trajectory file may look like, and that reading gives back what was written."""

from __future__ import annotations

import io
import tempfile
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gd_analyze.errors import OutputError
from gd_analyze.motions.csv_file import read_trajectory, shipped_trajectories
from gd_analyze.motions.csv_writing import recorded_command, trajectory_csv, write_trajectory
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.text import LARGEST

# Slides only, and no limits: any number is a possible position, so no warning gets in the way.
RAILS = RobotArm(
    "rails",
    joints=tuple(Joint(name, kind="prismatic") for name in "12"),
    links=tuple(Link(name, 1.0, np.zeros(3), 0.1 * np.eye(3)) for name in "12"),
)

TABLE = np.column_stack([np.arange(7) / 10, *(0.1 * k + np.arange(7) / 100 for k in range(1, 7))])
NAMES = ["time", "q1", "q2", "qd1", "qd2", "qdd1", "qdd2"]

CsvFile = Callable[[str | bytes], Path]


def as_csv(names: list[str], table: np.ndarray, delimiter: str = ",", newline: str = "\n") -> str:
    rows = [delimiter.join(map(repr, row)) for row in table.tolist()]
    return newline.join([delimiter.join(names), *rows, ""])


def assert_table(trajectory: Trajectory) -> None:
    found = np.column_stack([trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd])
    np.testing.assert_array_equal(found, TABLE)


finite = st.floats(-LARGEST, LARGEST)


@given(st.data())
def test_reading_back_gives_the_same_numbers(data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 7))  # of fewer than 8 set points rates are not judged
    time = np.sort(np.array(data.draw(st.lists(finite, min_size=n, max_size=n, unique=True))))
    written = Trajectory(time, *(data.draw(arrays(float, (n, 2), elements=finite)) for _ in range(3)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "any.csv"
        write_trajectory(written, path, ["a comment", "time,q1 - no header\nsecond line"])
        read = read_trajectory(path, RAILS)
    for what in ("time", "q", "qd", "qdd"):
        np.testing.assert_array_equal(getattr(read, what), getattr(written, what))
    assert (read.name, read.rates_from) == ("any", "given")


def test_reading_takes_few_times_the_memory_of_the_text(csv_file: CsvFile) -> None:
    """The bytes, the text, its lines with what Python adds to each, and the numbers in half the room: 3.5."""
    count = 20_000
    table = np.random.default_rng(0).uniform(-1.0, 1.0, (count, 6))
    motion = Trajectory(np.arange(float(count)), table[:, :2], table[:, 2:4], table[:, 4:])
    path = csv_file(trajectory_csv(motion))
    read_trajectory("two-link-swing", load_arm("two_link"))  # what is imported and kept stays out of it
    tracemalloc.start()
    try:
        read_trajectory(path, RAILS)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 5 * path.stat().st_size


def test_columns_come_in_any_order(csv_file: CsvFile, two_link: RobotArm) -> None:
    order = [3, 6, 1, 0, 5, 2, 4]
    path = csv_file(as_csv([NAMES[i] for i in order], TABLE[:, order]))
    assert_table(read_trajectory(path, two_link))


@pytest.mark.parametrize(
    "content",
    [
        "\ufeff" + as_csv(NAMES, TABLE),
        as_csv(NAMES, TABLE, newline="\r\n"),
        as_csv(NAMES, TABLE, newline="\r"),
        as_csv([f" {name.upper()} " for name in NAMES], TABLE),
        as_csv(NAMES, TABLE, delimiter=";"),
        as_csv(NAMES, TABLE, delimiter="\t"),
        as_csv(NAMES, TABLE, delimiter=" , "),
        as_csv([f'"{name}"' for name in NAMES], TABLE),
        as_csv(NAMES, TABLE).rstrip("\n"),
        "# first\n\n  # second\n" + as_csv(NAMES, TABLE).replace("\n0.1,", "\n# between\n\n0.1,"),
    ],
    ids=["BOM", "CRLF", "CR", "spaces and case", "semicolon", "tab", "wide", "quotes", "no end", "comments"],
)
def test_ways_to_write_the_same(csv_file: CsvFile, two_link: RobotArm, content: str) -> None:
    assert_table(read_trajectory(csv_file(content), two_link))


@pytest.mark.parametrize("marked", [{"q1", "q2"}, {"q2"}, {"qd1", "qdd2"}, set(NAMES[1:])])
def test_degrees_are_marked_column_by_column(csv_file: CsvFile, two_link: RobotArm, marked: set[str]) -> None:
    columns = [NAMES.index(name) for name in marked]
    # 57 degrees and more: far enough from zero not to be taken for radians.
    radians = TABLE + (np.arange(7) > 0)
    degrees = radians.copy()
    degrees[:, columns] = np.rad2deg(degrees[:, columns])
    names = [f"{name}_deg" if name in marked else name for name in NAMES]
    trajectory = read_trajectory(csv_file(as_csv(names, degrees)), two_link)
    found = np.column_stack([trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd])
    # One multiplication there and one back, by constants rounded to half an eps each.
    np.testing.assert_allclose(found, radians, rtol=4 * np.finfo(float).eps)


def test_missing_rates_are_derived_and_said_so(csv_file: CsvFile, two_link: RobotArm) -> None:
    trajectory = read_trajectory(csv_file(as_csv(NAMES[:3], TABLE[:, :3])), two_link)
    assert trajectory.rates_from == "qd and qdd derived: C4 (quintic) spline through the given q"
    # Positions on a line of slope 0.1: round-off of q (eps/2 x 0.3) times the condition 1e5, over h and h^2.
    np.testing.assert_allclose(trajectory.qd, 0.1, atol=1e5 * np.finfo(float).eps * 0.3 / 0.1)
    np.testing.assert_allclose(trajectory.qdd, 0.0, atol=1e5 * np.finfo(float).eps * 0.3 / 0.1**2)


def test_one_set_point_with_rates_is_enough(csv_file: CsvFile, two_link: RobotArm) -> None:
    trajectory = read_trajectory(csv_file(as_csv(NAMES, TABLE[:1])), two_link)
    assert trajectory.n_set_points == 1


def test_shipped_ones_go_by_name(puma: RobotArm) -> None:
    trajectory = read_trajectory("pick-and-place", puma)
    assert trajectory.name == "pick-and-place"
    assert trajectory.origin.startswith(
        "shipped trajectory pick-and-place; made by: gd-analyze plan puma560 "
    )
    by_path = read_trajectory(shipped_trajectories()["pick-and-place"], puma)
    assert by_path.fingerprint == trajectory.fingerprint


def test_origin_of_a_file(csv_file: CsvFile, two_link: RobotArm) -> None:
    path = csv_file("# gd-analyze plan two_link --from 0,0\n" + as_csv(NAMES, TABLE))
    assert read_trajectory(path, two_link).origin == (
        f"read from {path}; made by: gd-analyze plan two_link --from 0,0"
    )
    plain = csv_file(as_csv(NAMES, TABLE))
    assert read_trajectory(plain, two_link).origin == f"read from {plain}"


def test_standard_input(monkeypatch: pytest.MonkeyPatch, two_link: RobotArm) -> None:
    stream = SimpleNamespace(buffer=io.BytesIO(as_csv(NAMES, TABLE).encode()))
    monkeypatch.setattr("sys.stdin", stream)
    trajectory = read_trajectory("-", two_link)
    assert_table(trajectory)
    assert (trajectory.name, trajectory.origin) == ("stdin", "read from standard input")


def test_recorded_command() -> None:
    text = "# about\n#gd-analyze plan puma560 -o a.csv \ntime,q1\n"
    assert recorded_command(text) == "gd-analyze plan puma560 -o a.csv"
    assert recorded_command("# about gd-analyze plan\ntime,q1\n") is None


def test_text_of_a_file() -> None:
    trajectory = Trajectory(np.array([0.5]), *(np.array([[0.1, -0.0]]) for _ in range(3)))
    assert trajectory_csv(trajectory, ["why", "", "two\nlines"]) == (
        "# why\n# two\n# lines\ntime,q1,q2,qd1,qd2,qdd1,qdd2\n0.5,0.1,0.0,0.1,0.0,0.1,0.0\n"
    )


def test_an_unwritable_place_leaves_nothing(tmp_path: Path) -> None:
    blocker = tmp_path / "file"
    blocker.write_text("not a folder")
    trajectory = Trajectory(np.zeros(1), *(np.zeros((1, 2)) for _ in range(3)))
    with pytest.raises(OutputError):
        write_trajectory(trajectory, blocker / "motion.csv")
    assert list(tmp_path.iterdir()) == [blocker]
