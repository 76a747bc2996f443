from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from gd_analyze.cli.entry import main


@dataclass(frozen=True)
class Result:
    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        def refuse(constant: str) -> None:
            raise ValueError(f"{constant} is no JSON")

        return json.loads(self.out, parse_constant=refuse)


Run = Callable[..., Result]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


@pytest.fixture
def run(here: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Call the entry point as the console script does, in an empty folder."""

    def call(*words: object) -> Result:
        capsys.readouterr()
        code = 0
        try:
            main([str(word) for word in words])
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        captured = capsys.readouterr()
        return Result(code, captured.out, captured.err)

    return call


@pytest.fixture
def process(here: Path) -> Run:
    """Run the program in a process of its own."""

    def call(*words: object, stdin: str = "", before: str = "", flags: tuple[str, ...] = ()) -> Result:
        code = f"{before}\nfrom gd_analyze.cli import main\nmain()"
        done = subprocess.run(
            [sys.executable, *flags, "-c", code, *(str(word) for word in words)],
            input=stdin,
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        return Result(done.returncode, done.stdout, done.stderr)

    return call


@pytest.fixture
def motion(here: Path) -> Path:
    """A gentle motion of the two-link arm, within all its limits."""
    path = here / "gentle.csv"
    rows = "".join(f"{0.25 * k},{0.02 * k * k},{-0.01 * k * k}\n" for k in range(9))
    path.write_text("time,q1,q2\n" + rows)
    return path


@pytest.fixture
def listing(here: Path) -> Callable[[], set[str]]:
    """All files and folders, hidden ones too."""
    return lambda: {str(path.relative_to(here)) for path in here.rglob("*")}
