"""What `read_log` takes and how its result shows."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.motions.read import read_log

LOG = "time,q_0,q_1\n" + "".join(f"{k / 10},{k / 100},0\n" for k in range(20))


def test_an_arm_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_text(LOG)
    logged = read_log(path, "two_link")
    assert repr(logged) == "Logged('run', 2 joints, 20 rows of q, readings)"
    assert read_trajectory(path, "two_link").n_joints == 2
