"""Files that are not what they seem: pointers, nested aliases, headers that lack."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import read_log
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.types import Reading

SHAPES = np.column_stack([np.sin(np.linspace(0.0, 1.0, 60) + joint) for joint in range(6)])
TIME = np.linspace(0.0, 1.0, 60)
SLOPES = np.column_stack([np.cos(TIME + joint) for joint in range(6)])
# With gravity, and so not the derivative of anything.
TORQUES = 20.0 * np.cos(SHAPES) - 3.0 * SHAPES


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mcap", ".yaml"])
def test_a_pointer_of_git_lfs_is_named_as_that(tmp_path, puma, suffix):
    path = tmp_path / f"log{suffix}"
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0123\nsize 12\n")
    with pytest.raises(GdAnalyzeError) as caught:
        read_log(path, puma)
    assert "Git LFS" in caught.value.details["found"]
    assert "git lfs pull" in caught.value.details["next"]


def test_lists_in_a_parquet_column_are_a_column_each(tmp_path, puma):
    arrow = pytest.importorskip("pyarrow", reason="reading Parquet is an extra")
    import pyarrow.parquet

    for kind in (arrow.list_(arrow.float32(), 6), arrow.list_(arrow.float64())):
        state = arrow.array(SHAPES.tolist(), type=kind)
        table = arrow.table({"timestamp": TIME, "observation.state": state, "note": ["x"] * 60})
        pyarrow.parquet.write_table(table, tmp_path / "log.parquet", row_group_size=25)
        reading = Reading.of(map=["q=observation.state_1..observation.state_6"])
        logged = read_log(tmp_path / "log.parquet", puma, reading)
        np.testing.assert_allclose(logged.q, SHAPES, atol=1e-7)  # of single precision
        np.testing.assert_allclose(logged.time, TIME)


@pytest.mark.parametrize(
    ("columns", "proposed"),
    [
        (SHAPES, "--map time=RATEHz --map 'q=#1..#6'"),
        (np.column_stack([TIME, SHAPES]), "--map 'time=#1' --map 'q=#2..#7'"),
        (np.column_stack([SHAPES, SLOPES]), "--map time=RATEHz --map 'q=#1..#6' --map 'qd=#7..#12'"),
        (
            np.column_stack([TIME, SHAPES, SLOPES, TIME]),
            "--map 'time=#1' --map 'q=#2..#7' --map 'qd=#8..#13'",
        ),
        (np.column_stack([TIME, SHAPES, SLOPES, -SHAPES]), "--map 'qd=#8..#13' --map 'qdd=#14..#19'"),
        (
            np.column_stack([TIME, SHAPES, SLOPES, TORQUES]),
            "'qd=#8..#13', and torque=#14..#19 where",
        ),
        (np.column_stack([TIME, SHAPES, TORQUES]), "'q=#2..#7', and torque=#8..#13 where"),
        (
            np.column_stack([SHAPES, SLOPES, TORQUES]),
            "'qd=#7..#12', and torque=#13..#18 where",
        ),
    ],
)
def test_what_is_proposed_without_a_header_is_what_the_numbers_are(puma, refused, columns, proposed):
    """Torques and currents are no accelerations, which would make a plan of a recording."""
    text = "\n".join(",".join(map(repr, row)) for row in columns.tolist())
    refused(proposed, text, puma)


def test_a_column_per_joint_in_one_word(tmp_path, puma):
    names = ["Time", *(f"mp{k}" for k in range(1, 7))]
    table = np.column_stack([TIME, SHAPES])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header=",".join(names), comments="")
    logged = read_log(tmp_path / "log.csv", puma, Reading.of(map=["q=mp1..mp6"]))
    np.testing.assert_allclose(logged.q, SHAPES, atol=1e-15)


def test_nested_aliases_are_refused(tmp_path):
    lines = ["a0: &a0 {x: 1}"]
    lines += [f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 9)}]}}" for k in range(1, 9)]
    (tmp_path / "limits.yaml").write_text("\n".join(lines))
    with pytest.raises(GdAnalyzeError) as caught:
        gd.load_arm("two_link", limits=[str(tmp_path / "limits.yaml")])
    assert "aliases" in caught.value.details["found"]


def test_currents_become_torques(tmp_path, puma):
    names = ["timestamp", *(f"q_{k}" for k in range(6)), *(f"current_{k}" for k in range(6))]
    table = np.column_stack([TIME, SHAPES, 2.0 * SHAPES])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header=",".join(names), comments="", fmt="%.17g")
    pairs = [f"torque:{k + 1}=current_{k}" for k in range(6)]
    reading = Reading.of(map=pairs, torque_constant="10,10.7,8.5,9,9.5,10.1")
    logged = read_log(tmp_path / "log.csv", puma, reading)
    np.testing.assert_allclose(logged.torque, 2.0 * SHAPES * [10, 10.7, 8.5, 9, 9.5, 10.1])
    with pytest.raises(GdAnalyzeError, match="found: 2"):
        read_log(tmp_path / "log.csv", puma, Reading.of(map=pairs, torque_constant="1,2"))
    with pytest.raises(GdAnalyzeError, match=r"map='torque=current_\*'"):
        read_log(tmp_path / "log.csv", puma, Reading.of(map=["torque=none"], torque_constant="1,2,3,4,5,6"))
    with pytest.raises(GdAnalyzeError, match="another word"):
        Reading.of(torque_constant="1,x")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of POSIX")
def test_a_pipe_is_read(tmp_path, puma):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    rows = "".join(f"{k / 10},{','.join(['0.1'] * 6)}\n" for k in range(20))
    writer = threading.Thread(target=path.write_text, args=["time,q1,q2,q3,q4,q5,q6\n" + rows])
    writer.start()
    assert read_log(path, puma).q.shape == (20, 6)
    writer.join()
