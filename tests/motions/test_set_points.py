"""Files of set points: what they may look like, what is refused and where, and that writing keeps all."""

from __future__ import annotations

import io
import os
import tempfile
import threading
import time
import tracemalloc
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import gd_analyze as gd
from gd_analyze.errors import TrajectoryError
from gd_analyze.files import RESULT_FILES, megabytes, read_at_most
from gd_analyze.motions import read as reader
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.trajectory import trajectory_csv
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.text import LARGEST
from recordings import Motion
from several_motions import swung

# Prismatic joints without limits: any number is a possible position, so no warning gets in the way.
RAILS = RobotArm(
    "rails",
    joints=tuple(Joint(name, kind="prismatic") for name in "12"),
    links=tuple(Link(name, 1.0, np.zeros(3), 0.1 * np.eye(3)) for name in "12"),
)
TABLE = np.column_stack([np.arange(7) / 10, *(0.1 * k + np.arange(7) / 100 for k in range(1, 7))])
FULL = ["time", "q1", "q2", "qd1", "qd2", "qdd1", "qdd2"]


def as_csv(names: list[str], table: np.ndarray, sign: str = ",", end: str = "\n") -> str:
    return end.join([sign.join(names), *(sign.join(map(repr, row)) for row in table.tolist()), ""])


@given(st.data())
def test_reading_back_gives_the_same_numbers(data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 7))  # of fewer than 8 set points velocities are not judged
    finite = st.floats(-LARGEST, LARGEST)
    instants = np.sort(np.array(data.draw(st.lists(finite, min_size=n, max_size=n, unique=True))))
    written = gd.Trajectory(instants, *(data.draw(arrays(float, (n, 2), elements=finite)) for _ in range(3)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "any.csv"
        gd.write_trajectory(written, path, ["a comment", "time,q1 - no header\nsecond line"])
        read = gd.read_trajectory(path, RAILS)
    for what in ("time", "q", "qd", "qdd"):
        np.testing.assert_array_equal(getattr(read, what), getattr(written, what))
    assert (read.name, read.derivatives_from) == ("any", "given")


@pytest.mark.parametrize(
    "content",
    [
        as_csv(FULL, TABLE),
        as_csv(FULL, TABLE, ";"),
        as_csv(FULL, TABLE, "\t", "\r\n"),
        "\ufeff# a comment\n\n" + as_csv([f" {name.upper()} " for name in FULL], TABLE, end="\n\n# more\n"),
        as_csv(FULL, TABLE, end="\r").rstrip("\r"),
        as_csv([f'"{name}"' for name in FULL], TABLE),
        as_csv([FULL[k] for k in (6, 0, 2, 1, 4, 3, 5)], TABLE[:, [6, 0, 2, 1, 4, 3, 5]]),
    ],
)
def test_layouts(content: str, csv_file, two_link) -> None:
    read = gd.read_trajectory(csv_file(content), two_link)
    found = np.column_stack([read.time, read.q, read.qd, read.qdd])
    np.testing.assert_array_equal(found, TABLE)
    assert read.recording is None


def test_degrees_and_an_instant_to_begin_with(csv_file, two_link) -> None:
    table = TABLE.copy()
    table[:, 0] += 5.1
    table[:, 1:] *= 90.0
    names = [name if name == "time" else f"{name}_deg" for name in FULL]
    read = gd.read_trajectory(csv_file(as_csv(names, table)), two_link)
    np.testing.assert_allclose(read.q, np.deg2rad(table[:, 1:3]), rtol=1e-15)
    np.testing.assert_allclose(read.qdd, np.deg2rad(table[:, 5:]), rtol=1e-15)
    np.testing.assert_array_equal(read.time, table[:, 0])


def test_columns_and_the_main_job_read_alike(csv_file, two_link) -> None:
    path = csv_file(as_csv(FULL, TABLE))
    logged, read = gd.read_log(path, two_link), gd.read_trajectory(path, two_link)
    np.testing.assert_array_equal(logged.q, read.q)
    assert (logged.measured, logged.gaps) == (False, ())
    path.write_text(as_csv(FULL, TABLE[::-1]))
    for reads in (gd.read_log, gd.read_trajectory):
        with pytest.raises(TrajectoryError, match="line 3, column 1"):
            reads(path, two_link)


def test_what_the_user_says_of_a_file_of_set_points(csv_file, two_link) -> None:
    instants = np.arange(200) * 0.01
    q = np.column_stack([0.5 * np.sin(2 * instants), 0.4 * np.cos(3 * instants)])
    path = csv_file(as_csv(FULL[:3], np.column_stack([1000 * instants, q])))
    plan = gd.read_trajectory(path, two_link, gd.Reading(time_unit="ms"))
    np.testing.assert_allclose(plan.time, instants, rtol=1e-15)
    np.testing.assert_array_equal(plan.q, q)
    measured = gd.read_trajectory(path, two_link, gd.Reading(time_unit="ms", measured=True))
    assert measured.recording.measured


def test_a_plan_in_a_log_is_taken_as_it_is(csv_file, two_link) -> None:
    path = csv_file(as_csv(["t", "target_q_0", "target_q_1"], TABLE[:, :3]))
    motion = gd.read_trajectory(path, two_link)
    np.testing.assert_array_equal(motion.q, TABLE[:, 1:3])
    assert motion.derived == ("qd", "qdd")
    assert motion.origin == f"read from {path}"


Q_ROWS = [f"{k / 10},0.{k},0.2" for k in range(7)]
Q_FILE = "\n".join(["time,q1,q2", *Q_ROWS]) + "\n"


def with_header(header: str) -> str:
    return Q_FILE.replace("time,q1,q2", header)


def with_row(number: int, row: str) -> str:
    """The positions file with its data row `number` (from 1, on line number + 1) replaced."""
    return "\n".join(["time,q1,q2", *Q_ROWS[: number - 1], row, *Q_ROWS[number:]]) + "\n"


# What the message has to name: place and fact.
WRONG: dict[str, tuple[str | bytes, list[str]]] = {
    "comments only": ("# a\n\n", ["empty"]),
    "no positions": (with_header("time,qd1,qd2"), ["line 1", "position"]),
    "velocities of some": (
        with_header("time,q1,q2,qd1").replace(",0.2", ",0.2,0"),
        ["line 1, column 4", "qd1"],
    ),
    "no instant": (with_row(4, "nan,0,0"), ["line 5, column 1", "time", "found: nan"]),
    "overflow": (with_row(4, "0.3,1e999,0"), ["line 5, column 2", "1e999"]),
    "underscores": (with_row(3, "0.2,1_000,0.2"), ["line 4, column 2", "'1_000'"]),
    "digits of another script": (with_row(3, "0.2,\u0663,0.2"), ["line 4, column 2"]),
    "a cell of a page": (with_row(3, f"0.2,{'x' * 9000},0"), ["line 4, column 2", "(9002 characters)"]),
    "unclosed quote": (with_row(5, '0.4,0.5,"0.6'), ["line 6", "quote"]),
    "time falls": (with_row(3, "0.05,0,0"), ["line 4, column 1", "0.05"]),
    "one endless line": ("x" * 200_000, ["line 1"]),
    "XML": ("<robot name='x'>\n<link/>\n</robot>\n", ["XML"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_refusals(case: str, csv_file, two_link) -> None:
    content, expected = WRONG[case]
    path = csv_file(content)
    with pytest.raises(TrajectoryError) as caught:
        gd.read_trajectory(path, two_link)
    text = str(caught.value)
    assert str(path) in text
    assert max(map(len, text.splitlines())) < 700
    for part in expected:
        assert part in text


def test_degrees_of_a_prismatic_joint(csv_file, slider) -> None:
    with pytest.raises(TrajectoryError, match="prismatic") as caught:
        gd.read_trajectory(csv_file(with_header("time,q1,q2_deg")), slider)
    assert "line 1, column 3" in str(caught.value)


@pytest.mark.parametrize("step", ["1e-300", "1e-9"])
def test_derivatives_that_overflow(step: str, csv_file, two_link) -> None:
    path = csv_file("\n".join(["time,q1,q2", *(f"{k}{step[1:]},{k * k / 10},0" for k in range(8))]))
    with pytest.raises(TrajectoryError, match="cannot be derived") as caught:
        gd.read_trajectory(path, two_link)
    assert str(path) in str(caught.value)


def test_no_such_file(puma, tmp_path) -> None:
    with pytest.raises(TrajectoryError, match="there is no trajectory"):
        gd.read_trajectory(tmp_path / "nothing.csv", puma)
    with pytest.raises(TrajectoryError, match="did you mean the shipped 'large-slew'"):
        gd.read_trajectory("large_slew.csv", puma)
    with pytest.raises(TrajectoryError, match="cannot read"):
        gd.read_trajectory(tmp_path, puma)
    with pytest.raises(TrajectoryError, match="this is no trajectory"):
        gd.read_trajectory(3, puma)


def test_an_endless_source_ends(two_link, tmp_path, monkeypatch) -> None:
    with pytest.raises(TrajectoryError, match="binary"):
        gd.read_trajectory("/dev/zero", two_link)
    monkeypatch.setattr(reader, "_LARGEST_STREAM", 10_000)
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)

    def write() -> None:
        with suppress(BrokenPipeError), pipe.open("wb") as file:
            while True:
                file.write(b"1,2,3\n")

    writer = threading.Thread(target=write)
    writer.start()
    with pytest.raises(TrajectoryError, match="too large to be read"):
        gd.read_trajectory(pipe, two_link)
    writer.join()


@pytest.mark.parametrize("size", [0, 2**20, 2**20 + 1])
def test_reading_ends_at_the_largest_size(tmp_path, size) -> None:
    path = tmp_path / "text"
    path.write_bytes(b"x" * size)
    assert read_at_most(path, size) == b"x" * size
    assert not size or read_at_most(path, size - 1) is None
    assert megabytes(10_000) == "0.01 MB"


def test_standard_input_and_pipes(two_link, tmp_path, monkeypatch) -> None:
    text = as_csv(["timestamp", "actual_q_0", "actual_q_1"], np.arange(600.0).reshape(200, 3) / 1000)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(text.encode())))
    motion = gd.read_trajectory("-", two_link)
    assert (motion.name, motion.origin, motion.recording.measured) == (
        "stdin",
        "read from standard input",
        True,
    )
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(text,))
    writer.start()
    assert gd.read_trajectory(pipe, two_link).fingerprint == motion.fingerprint
    writer.join()


def test_a_header_is_understood_in_linear_time(csv_file, puma) -> None:
    """A cubic expression took 80 s for 10 000 digits, and some for the 200 that a name may have."""
    names = ["time", *("1" * 199 + "x" for _ in range(400))]
    begin = time.perf_counter()
    with pytest.raises(TrajectoryError):
        gd.read_trajectory(csv_file(",".join(names) + "\n0\n"), puma)
    assert time.perf_counter() - begin < 2.0


def test_reading_takes_few_times_the_memory_of_the_text(csv_file, two_link) -> None:
    table = np.random.default_rng(0).uniform(-1.0, 1.0, (20_000, 6))
    motion = gd.Trajectory(np.arange(20_000.0), table[:, :2], table[:, 2:4], table[:, 4:])
    path = csv_file(trajectory_csv(motion))
    gd.read_trajectory("two-link-swing", two_link)  # what is imported and kept stays out of it
    tracemalloc.start()
    try:
        gd.read_trajectory(path, RAILS)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 8 * path.stat().st_size


TORN = np.concatenate([np.arange(40), np.arange(40) + 60]) / 40


@pytest.fixture
def torn() -> gd.Trajectory:
    """Two stretches, the second somewhere else."""
    motion = Motion.of(1)
    q, qd, qdd = (0.2 * motion.at(TORN, order) for order in range(3))
    q[40:] += 1.0
    return gd.Trajectory(TORN, q, qd, qdd, name="torn", gaps=(40,))


def test_a_file_keeps_gaps_and_derives_stretch_by_stretch(torn, two_link, tmp_path) -> None:
    path = tmp_path / "torn.csv"
    gd.write_trajectory(torn, path, ["two stretches"])
    assert path.read_text().split("\n")[42] == "# gap"
    assert gd.read_trajectory(path, two_link).fingerprint == torn.fingerprint
    lines = [
        line if line == "# gap" else ",".join(line.split(",")[:3]) for line in path.read_text().split("\n")
    ]
    path.write_text("\n".join(lines[1:]))
    read = gd.read_trajectory(path, two_link)
    for stretch in torn.stretches:
        alone = gd.Trajectory.from_arrays(torn.time[stretch], torn.q[stretch])
        np.testing.assert_array_equal(read.qdd[stretch], alone.qdd)


def test_too_few_set_points_between_gaps_are_refused(two_link, csv_file) -> None:
    rows = [f"{k / 10},{k / 10},0" for k in range(20)]
    with pytest.raises(TrajectoryError, match="too few set points to derive qd and qdd") as error:
        gd.read_trajectory(csv_file("\n".join(["time,q1,q2", *rows[:17], "# gap", *rows[17:]])), two_link)
    assert error.value.details["found"] == "3"


@pytest.mark.parametrize("at", [0, 1, 81])
def test_gaps_before_the_first_or_after_the_last_set_point_mean_nothing(torn, two_link, csv_file, at) -> None:
    lines = trajectory_csv(gd.Trajectory(torn.time, torn.q, torn.qd, torn.qdd)).strip().split("\n")
    assert gd.read_trajectory(csv_file("\n".join([*lines[:at], "# gap", *lines[at:]])), two_link).gaps == ()


@pytest.fixture
def folder(tmp_path) -> Path:
    place = tmp_path / "motions"
    place.mkdir()
    for name, duration in (("b", 4.0), ("a", 5.0), ("c", 6.0)):
        gd.write_trajectory(swung(duration, name), place / f"{name}.csv")
    return place


def test_a_folder_stands_for_the_trajectories_in_it(two_link, folder) -> None:
    for name in (".hidden.csv", "notes.md", "arm.toml", *RESULT_FILES.values()):
        (folder / name).write_text("no trajectory")
    (folder / "deeper").mkdir()
    (folder / "bag").mkdir()
    (folder / "bag" / "metadata.yaml").write_text("")
    names = [path.name for path in reader.trajectory_files(folder)]
    assert names == ["a.csv", "b.csv", "bag", "c.csv"]
    (folder / "bag" / "metadata.yaml").unlink()
    whole = trajectory_of(folder, two_link)
    assert [motion.name for motion in whole.motions] == ["a", "b", "c"]
    assert whole.name == "motions"
    # Beside others it is no folder's pool any more.
    assert trajectory_of([str(folder), swung(7.0, "d")], two_link).name == "a+3-more"


@pytest.mark.parametrize(
    ("names", "found"), [([], "nothing"), ([f"{k}.png" for k in range(7)], "and 2 more")]
)
def test_a_folder_without_any(two_link, tmp_path, names, found) -> None:
    for name in names:
        (tmp_path / name).write_text("")
    with pytest.raises(TrajectoryError, match="the folder holds no trajectories") as caught:
        trajectory_of(tmp_path, two_link)
    assert caught.value.details["where"] == str(tmp_path)
    assert found in caught.value.details["found"]


def test_in_a_folder_the_wrong_file_is_named(two_link, puma, folder, monkeypatch) -> None:
    (folder / "b.csv").write_text("x,y\n1,2\n")
    with pytest.raises(TrajectoryError, match=r"b\.csv"):
        trajectory_of(folder, two_link)
    with pytest.raises(TrajectoryError, match=r"a\.csv"):
        trajectory_of(folder, puma)
    monkeypatch.chdir(folder)
    (folder / "two-link-swing").mkdir()  # a shipped name comes before a folder
    assert trajectory_of("two-link-swing", two_link).n_set_points == 31
