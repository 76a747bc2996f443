from __future__ import annotations

import subprocess
import sys

import cli_reference
import pytest

from gd_analyze.cli.app import app


def test_the_page_is_up_to_date():
    assert cli_reference.PAGE.read_text(encoding="utf-8") == cli_reference.page(), (
        "run `python tests/docs/cli_reference.py`"
    )


@pytest.mark.parametrize("verb", [(), *((name,) for name, c in app.commands.items() if not c.hidden)])
def test_the_page_shows_what_help_prints_on_80_columns(verb, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    code = "from gd_analyze.cli import main; main()"
    printed = subprocess.run(
        [sys.executable, "-c", code, *verb, "--help"], capture_output=True, text=True, check=True
    ).stdout
    assert f"```text\n{printed}```\n" in cli_reference.PAGE.read_text(encoding="utf-8")
    assert max(map(len, printed.splitlines())) <= 80
