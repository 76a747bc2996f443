"""The tutorials run as they stand, and what they are run on is what the other pages are run on."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_pages import ROOT
from own_robot import write_own_robot

FOLDER = ROOT / "docs" / "tutorials"
SCRIPTS = sorted(FOLDER.glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_they_run(script: Path, tmp_path: Path) -> None:
    if "gcc" in script.read_text(encoding="utf-8") and shutil.which("gcc") is None:
        pytest.skip("gcc compiles the controller, and is not installed")
    for file in ("my_robot.urdf", "log.csv"):
        shutil.copy(FOLDER / file, tmp_path)
    words = [sys.executable, "-W", "error", str(script)]
    environment = os.environ | {"MPLBACKEND": "Agg"}
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_they_are_told_of() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(f"docs/tutorials/{script.name}" in readme for script in SCRIPTS)


def test_their_robot_is_that_of_the_pages(tmp_path: Path) -> None:
    write_own_robot(tmp_path)
    assert (tmp_path / "my_robot.urdf").read_text() == (FOLDER / "my_robot.urdf").read_text()
    # Noise and waves may differ in their last digit between processors.
    ours, theirs = ((folder / "log.csv").read_text().splitlines() for folder in (tmp_path, FOLDER))
    assert ours[0] == theirs[0]
    assert len(ours) == len(theirs)
