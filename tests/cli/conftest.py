from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import gd_analyze as gd
from gd_analyze.cli import terminal
from gd_analyze.cli.entry import main
from program import PROGRAM

# On a slow machine work takes longer than what is silent; stages are told only where a test asks for them.
NEVER = 1e6


@dataclass(frozen=True)
class Result:
    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        def refuse(constant: str) -> None:
            raise ValueError(f"{constant} is no JSON")

        assert self.out.isascii()
        return json.loads(self.out, parse_constant=refuse)

    @property
    def words(self) -> str:
        """What is shown, on 80 columns, with every space one space."""
        assert (self.code, self.err) == (0, "")
        assert max(map(len, self.out.splitlines())) <= 80
        return " ".join(self.out.split())


Run = Callable[..., Result]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(terminal, "SHORT_SECONDS", NEVER)
    return tmp_path


@pytest.fixture
def run(here: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Call the entry point as the console script does, in an empty folder; a text is split into its words."""

    def call(line: str, *words: object) -> Result:
        capsys.readouterr()
        code = 0
        try:
            main([*line.split(), *map(str, words)])
        except SystemExit as leaving:
            code = int(leaving.code or 0)
        captured = capsys.readouterr()
        return Result(code, captured.out, captured.err)

    return call


@pytest.fixture
def process(here: Path) -> Run:
    """Run the program in a process of its own; no stages are told before `silent` seconds."""

    def call(line: str, *words: object, before: str = "", silent: float = NEVER, **more: Any) -> Result:
        begin = f"from gd_analyze.cli import terminal\nterminal.SHORT_SECONDS = {silent}\n{before}\n{PROGRAM}"
        command = [sys.executable, "-c", begin, *line.split(), *map(str, words)]
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | more
        done = subprocess.run(command, text=True, check=False, timeout=120, **streams)
        return Result(done.returncode, done.stdout, done.stderr)

    return call


@pytest.fixture
def motion(here: Path) -> Path:
    """A gentle motion of the two-link arm, within all its limits."""
    path = here / "gentle.csv"
    rows = "".join(f"{0.25 * k},{0.02 * k * k},{-0.01 * k * k}\n" for k in range(9))
    path.write_text("time,q1,q2\n" + rows)
    return path


@pytest.fixture(scope="session")
def swing_model(two_link, swing) -> gd.types.SimplifiedModel:
    return gd.simplify(two_link, swing, "20%")


@pytest.fixture
def model(here: Path, swing_model) -> gd.types.SimplifiedModel:
    """The model of the swing, in model.json."""
    gd.save_model(swing_model, here / "model.json")
    return swing_model


@pytest.fixture
def listing(here: Path) -> Callable[[], set[str]]:
    """All files and folders, hidden ones too."""
    return lambda: {str(path.relative_to(here)) for path in here.rglob("*")}
