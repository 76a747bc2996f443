"""The tutorials run as they stand."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_pages import ROOT

FOLDER = ROOT / "docs" / "tutorials"
SCRIPTS = sorted(FOLDER.glob("*.py"))
# The one that goes from a file to compiled code runs always, the others in the long tests.
QUICK = "urdf_to_controller"
# Blocks of text in cells of Markdown: what the script prints.
PRINTED = re.compile(r"^# ```text\n((?:# .*\n)+?)# ```$", re.MULTILINE)


@pytest.mark.parametrize(
    "script",
    [script if script.stem == QUICK else pytest.param(script, marks=pytest.mark.slow) for script in SCRIPTS],
    ids=lambda script: script.stem,
)
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
    stated = PRINTED.findall(script.read_text(encoding="utf-8"))
    assert all(text.replace("\n# ", "\n").removeprefix("# ") in done.stdout for text in stated)


def test_they_are_told_of() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(f"docs/tutorials/{script.name}" in readme for script in SCRIPTS)


def test_ten_tasks_are_short() -> None:
    """Of 60 lines of code at most: a task takes a few."""
    text = (FOLDER / "ten_tasks.py").read_text(encoding="utf-8")
    _, _, cells = text.split('"""', 2)
    lines = [line for line in cells.splitlines() if line.strip() and not line.startswith("#")]
    assert len(lines) <= 60
    assert text.count("\n# ## ") == 10
