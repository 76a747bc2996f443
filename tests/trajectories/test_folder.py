"""A folder stands for the trajectories in it: which files count, and what is said where one is none."""

from __future__ import annotations

from pathlib import Path

import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.files import RESULT_FILES
from gd_analyze.motions.csv_writing import write_trajectory
from gd_analyze.motions.folder import is_folder_of_motions, trajectory_files
from gd_analyze.motions.pool import trajectory_of
from several_motions import swung


@pytest.fixture
def folder(tmp_path) -> Path:
    place = tmp_path / "motions"
    place.mkdir()
    for name, duration in (("b", 4.0), ("a", 5.0), ("c", 6.0)):
        write_trajectory(swung(duration, name), place / f"{name}.csv")
    return place


def test_all_of_them_by_name(two_link, folder):
    whole = trajectory_of(folder, two_link)
    assert [motion.name for motion in whole.motions] == ["a", "b", "c"]
    assert whole.name == "motions"
    assert trajectory_of(str(folder), two_link).fingerprint == whole.fingerprint
    # Beside others it is no folder's pool any more.
    assert trajectory_of([folder, swung(7.0, "d")], two_link).name == "a+3-more"


def test_what_is_passed_over(two_link, folder):
    (folder / ".hidden.csv").write_text("no trajectory")
    (folder / "notes.md").write_text("no trajectory")
    (folder / "arm.toml").write_text("no trajectory")
    (folder / "deeper").mkdir()
    (folder / "deeper" / "d.csv").write_text("no trajectory")
    for name in RESULT_FILES.values():
        (folder / name).write_text("no trajectory")
    assert [path.name for path in trajectory_files(folder)] == ["a.csv", "b.csv", "c.csv"]


def test_one_motion_in_a_folder_is_that_motion(two_link, folder):
    (folder / "a.csv").unlink()
    (folder / "b.csv").unlink()
    alone = trajectory_of(folder, two_link)
    assert (alone.name, alone.motions) == ("c", ())


def test_what_is_none_is_named(two_link, folder):
    (folder / "b.csv").write_text("x,y\n1,2\n")
    with pytest.raises(TrajectoryError) as caught:
        trajectory_of(folder, two_link)
    assert str(folder / "b.csv") in str(caught.value)


def test_a_motion_of_another_arm_is_named(puma, folder):
    with pytest.raises(TrajectoryError, match="do not fit arm puma560") as caught:
        trajectory_of(folder, puma)
    assert "a.csv" in caught.value.details["where"]


@pytest.mark.parametrize(
    ("names", "found"),
    [
        ([], "nothing"),
        (["notes.md"], "notes.md"),
        ([f"{k}.png" for k in range(7)], "0.png, 1.png, 2.png, 3.png, 4.png and 2 more"),
    ],
)
def test_a_folder_without_any(two_link, tmp_path, names, found):
    for name in names:
        (tmp_path / name).write_text("")
    with pytest.raises(TrajectoryError, match="the folder holds no trajectories") as caught:
        trajectory_of(tmp_path, two_link)
    assert caught.value.details["where"] == str(tmp_path)
    assert caught.value.details["found"] == found
    assert ".csv" in caught.value.details["expected"]


def test_a_recording_that_is_a_folder_is_one_motion(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("")
    assert not is_folder_of_motions(tmp_path / "bag")
    assert [path.name for path in trajectory_files(tmp_path)] == ["bag"]


def test_a_shipped_name_comes_before_a_folder(two_link, swing, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two-link-swing").mkdir()
    assert trajectory_of("two-link-swing", two_link).fingerprint == swing.fingerprint
