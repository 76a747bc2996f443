"""Files of set points: what they may look like, what is refused and where, and that writing keeps all."""

from __future__ import annotations

import io
import os
import tempfile
import threading
import time
import tracemalloc
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import gd_analyze as gd
from gd_analyze.errors import TrajectoryError
from gd_analyze.files import RESULT_FILES
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.text import LARGEST
from log_arms import arm_of
from recordings import Motion, swung
from strategies import examples

# Prismatic joints without limits: any number is a possible position, so no warning gets in the way.
RAILS = arm_of("1", "2", kinds=["prismatic"] * 2)
TABLE = np.column_stack([np.arange(7) / 10, *(0.1 * k + np.arange(7) / 100 for k in range(1, 7))])
FULL = ["time", "q1", "q2", "qd1", "qd2", "qdd1", "qdd2"]


def as_csv(names: list[str], table: np.ndarray, end: str = "\n") -> str:
    return end.join([",".join(names), *(",".join(map(repr, row)) for row in table.tolist()), ""])


@given(st.data())
@examples(40)
def test_reading_back_gives_the_same_numbers(data):
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


def test_layouts(log, two_link):
    order = [6, 0, 2, 1, 4, 3, 5]
    names = [f" {FULL[k].upper()} " for k in order]
    content = "\ufeff# a comment\n\n" + as_csv(names, TABLE[:, order], end="\n\n# more\n")
    read = gd.read_trajectory(log(content), two_link)
    np.testing.assert_array_equal(np.column_stack([read.time, read.q, read.qd, read.qdd]), TABLE)
    assert read.recording is None
    logged = gd.read_log(log(content), two_link)  # what the verb `columns` shows
    np.testing.assert_array_equal(logged.q, read.q)
    assert (logged.measured, logged.gaps) == (False, ())


def test_degrees_and_an_instant_to_begin_with(log, two_link):
    table = TABLE * [1, *[90.0] * 6] + [5.1, *[0.0] * 6]
    names = [name if name == "time" else f"{name}_deg" for name in FULL]
    read = gd.read_trajectory(log(as_csv(names, table)), two_link)
    np.testing.assert_allclose(read.q, np.deg2rad(table[:, 1:3]), rtol=1e-15)
    np.testing.assert_allclose(read.qdd, np.deg2rad(table[:, 5:]), rtol=1e-15)
    np.testing.assert_array_equal(read.time, table[:, 0])


def test_what_the_user_says_of_a_file_of_set_points(log, two_link):
    instants = np.arange(200) * 0.01
    q = np.column_stack([0.5 * np.sin(2 * instants), 0.4 * np.cos(3 * instants)])
    path = log(as_csv(FULL[:3], np.column_stack([1000 * instants, q])))
    plan = gd.read_trajectory(path, two_link, gd.types.Reading.of("time=:ms"))
    np.testing.assert_allclose(plan.time, instants, rtol=1e-15)
    np.testing.assert_array_equal(plan.q, q)
    assert gd.read_trajectory(
        path, two_link, gd.types.Reading.of("time=:ms", measured=True)
    ).recording.measured
    path = log(as_csv(["t", "target_q_0", "target_q_1"], TABLE[:, :3]))  # a plan in a log
    motion = gd.read_trajectory(path, two_link)
    np.testing.assert_array_equal(motion.q, TABLE[:, 1:3])
    assert (motion.derived, motion.origin) == (("qd", "qdd"), f"read from {path}")


ROWS = [f"{k / 10},0.{k},0.2" for k in range(7)]


def csv(header="time,q1,q2", rows=ROWS, line=0, text=""):
    """A file; `text` stands for one of its lines."""
    return "\n".join(text if k == line else row for k, row in enumerate([header, *rows], 1)) + "\n"


# What the message has to name beside the file: place or fact. Others are tested with the verbs.
WRONG: dict[str, tuple[str, str]] = {
    "no positions": (csv("time,qd1,qd2"), "line 1"),
    "velocities of some": (csv("time,q1,q2,qd1", [f"{row},0" for row in ROWS]), "line 1, column 4"),
    "overflow": (csv(line=5, text="0.3,1e999,0"), "line 5, column 2"),
    "digits of another script": (csv(line=4, text="0.2,\u0663,0.2"), "line 4, column 2"),
    "a cell of a page": (csv(line=4, text=f"0.2,{'x' * 9000},0"), "(9002 characters)"),
    "a row that breaks off": ("time,q1,q2\n0.0,0.0,", "line 2, column 3"),
    "unclosed quote": (csv(line=6, text='0.4,0.5,"0.6'), "line 6"),
    "one endless line": ("x" * 200_000, "line 1"),
    "XML": ("<robot name='x'>\n<link/>\n</robot>\n", "XML"),
    "overflowing derivatives": (csv(rows=[f"{k}e-300,{k * k},0" for k in range(8)]), "qd cannot be derived"),
    "few between gaps": (csv(rows=[*ROWS, "# gap", "1.7,0,0"]), "found: 1"),
}


@pytest.mark.parametrize("case", WRONG)
def test_refusals(case, log, two_link):
    content, says = WRONG[case]
    with pytest.raises(TrajectoryError) as caught:
        gd.read_trajectory(log(content), two_link)
    text = str(caught.value)
    assert "log.csv" in text
    assert max(map(len, text.splitlines())) < 700
    assert says in text


def test_no_such_file(puma, slider, log, tmp_path):
    for given_, arm, says in (
        (tmp_path / "nothing.csv", puma, "there is no trajectory"),
        ("large_slew.csv", puma, "did you mean 'large-slew'"),
        (tmp_path, puma, "cannot read"),
        (3, puma, "this is not a trajectory"),
        ("/dev/zero", puma, "binary"),
        (log(csv("time,q1,q2_deg")), slider, "line 1, column 3"),  # degrees of a prismatic joint
    ):
        with pytest.raises(TrajectoryError, match=says):
            gd.read_trajectory(given_, arm)


def test_standard_input_and_pipes(two_link, tmp_path, monkeypatch):
    text = as_csv(["timestamp", "actual_q_0", "actual_q_1"], np.arange(600.0).reshape(200, 3) / 1000)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(text.encode())))
    motion = gd.read_trajectory("-", two_link)
    assert motion.name == "stdin"
    assert motion.origin.endswith("standard input")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(text,))
    writer.start()
    assert gd.read_trajectory(pipe, two_link).fingerprint == motion.fingerprint
    writer.join()


def test_a_header_is_understood_in_linear_time(log, puma):
    """A cubic expression took 80 s for 10 000 digits, and some for the 200 that a name may have."""
    names = ["time", *("1" * 199 + "x" for _ in range(400))]
    begin = time.process_time()  # not of the clock, which counts what else the machine does
    with pytest.raises(TrajectoryError):
        gd.read_trajectory(log(",".join(names) + "\n0\n"), puma)
    assert time.process_time() - begin < 2.0


def test_reading_takes_few_times_the_memory_of_the_text(tmp_path, two_link):
    q, qd, qdd = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 20_000, 2))
    path = tmp_path / "long.csv"
    gd.write_trajectory(gd.Trajectory(np.arange(20_000.0), q, qd, qdd), path)
    gd.read_trajectory("two-link-swing", two_link)  # what is imported and kept stays out of it
    tracemalloc.start()
    try:
        gd.read_trajectory(path, RAILS)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 8 * path.stat().st_size


def test_a_long_motion_is_held_once_while_it_is_read(tmp_path, puma):
    """Beside the numbers, comparing velocities takes 2.4 times their memory; a copy of all would add 1."""
    count = 60_000
    q, qd, qdd = np.zeros((3, count, 6))
    path = tmp_path / "long.csv"
    gd.write_trajectory(gd.Trajectory(np.arange(float(count)), q, qd, qdd), path)
    gd.read_trajectory("pick-and-place", puma)  # what is imported and kept stays out of it
    tracemalloc.start()
    try:
        motion = gd.read_trajectory(path, puma)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 3.9 * sum(x.nbytes for x in (motion.time, motion.q, motion.qd, motion.qdd))


def test_a_file_keeps_gaps_and_derives_stretch_by_stretch(two_link, tmp_path):
    instants = np.concatenate([np.arange(40), np.arange(40) + 60]) / 40
    q, qd, qdd = (0.2 * Motion.of(1).at(instants, order) for order in range(3))
    q[40:] += 1.0  # the second stretch is somewhere else
    torn = gd.Trajectory(instants, q, qd, qdd, name="torn", gaps=(40,))
    path = tmp_path / "torn.csv"
    gd.write_trajectory(torn, path)
    assert gd.read_trajectory(path, two_link).fingerprint == torn.fingerprint
    lines = path.read_text().strip().split("\n")
    assert lines.index("# gap") == 41
    path.write_text("\n".join(line if line == "# gap" else ",".join(line.split(",")[:3]) for line in lines))
    read = gd.read_trajectory(path, two_link)
    for stretch in torn.stretches:
        alone = gd.Trajectory.from_arrays(instants[stretch], q[stretch])
        np.testing.assert_array_equal(read.qdd[stretch], alone.qdd)
    for at in (0, 1, 41):  # before the first and after the last it means nothing
        path.write_text("\n".join([*lines[:at], "# gap", *lines[at:41]]))
        assert gd.read_trajectory(path, two_link).gaps == ()


def test_a_folder_stands_for_the_trajectories_in_it(two_link, puma, tmp_path, monkeypatch):
    folder = tmp_path / "motions"
    folder.mkdir()
    for name, duration in (("b", 4.0), ("a", 5.0), ("c", 6.0)):
        gd.write_trajectory(swung(duration, name), folder / f"{name}.csv")
    for name in (".hidden.csv", "notes.md", "arm.toml", *RESULT_FILES.values()):
        (folder / name).write_text("no trajectory")
    (folder / "deeper").mkdir()
    whole = trajectory_of(folder, two_link)
    assert [motion.name for motion in whole.motions] == ["a", "b", "c"]
    assert whole.name == "motions"
    # Beside others it is no folder's pool any more.
    assert trajectory_of([str(folder), swung(7.0, "d")], two_link).name == "a+3-more"
    with pytest.raises(TrajectoryError, match=r"a\.csv"):
        trajectory_of(folder, puma)
    (folder / "b.csv").write_text("x,y\n1,2\n")
    with pytest.raises(TrajectoryError, match=r"b\.csv"):
        trajectory_of(folder, two_link)
    (folder / "b.csv").unlink()
    bag = folder / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text("")
    with pytest.raises(TrajectoryError, match="bag"):
        trajectory_of(folder, two_link)
    monkeypatch.chdir(folder)
    (folder / "two-link-swing").mkdir()  # a shipped name comes before a folder
    assert trajectory_of("two-link-swing", two_link).n_set_points == 31


def test_a_folder_without_any(two_link, tmp_path):
    for k in range(7):
        (tmp_path / f"{k}.png").write_text("")
    with pytest.raises(TrajectoryError) as caught:
        trajectory_of(tmp_path, two_link)
    assert "and 2 more" in caught.value.details["found"]
