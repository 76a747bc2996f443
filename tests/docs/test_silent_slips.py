"""Mistakes in files against the verbs; docs/diagnose.md lists those that pass unnoticed."""

from __future__ import annotations

import re

import pytest
import slips
from markdown_pages import ROOT

ALL = [(section, slip) for section, listed in slips.SECTIONS.items() for slip in listed]
RUNS = [
    pytest.param(slip, id=f"{section}: {slip.mistake}", marks=[pytest.mark.slow] * slip.slow)
    for section, slip in ALL
]


@pytest.mark.parametrize("slip", RUNS)
def test_the_outcome_is_the_stated_one(slip):
    assert slip.happens() == slip.outcome


def test_the_page_lists_the_silent_ones():
    page = (ROOT / "docs" / "diagnose.md").read_text(encoding="utf-8")
    section = page.partition("\n## Mistakes that pass unnoticed\n")[2].partition("\n## ")[0]
    silent = [slip.mistake for _, slip in ALL if slip.outcome == "silent" and slip.mistake != slips.RIGHT]
    assert re.findall(r"^- (.*)$", section, re.MULTILINE) == silent
