from __future__ import annotations

import subprocess
import sys

import cli_reference
import pytest


def test_the_page_is_up_to_date():
    page = cli_reference.page()
    assert cli_reference.PAGE.read_text(encoding="utf-8") == page, "run `python tests/docs/cli_reference.py`"


@pytest.mark.parametrize("verb", [(), ("simplify",)])
def test_the_page_shows_what_help_prints_on_80_columns(verb, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    words = [sys.executable, "-c", "from gd_analyze.cli import main; main()", *verb, "--help"]
    printed = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert cli_reference.help_of(*verb) == printed
    assert max(map(len, printed.splitlines())) <= 80
