"""Names and cells of others, as they reach terminals and pages."""

from __future__ import annotations

import re
import unicodedata
import warnings

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
from gd_analyze.text import in_python, shortened, visible

ACTING = ("\x1b[31m", "a\nb", "a\rb", "\x9b2J", "\u202eabc", "\u2066x", "\x00", "\u2028", "\x85", "\ud800")


@pytest.mark.parametrize("text", ACTING)
def test_what_acts_is_written_out(text):
    assert visible(text).isprintable()
    assert "\\" in visible(text)


@pytest.mark.parametrize("text", ["", "Unimation PUMA 560", "1.2 %\u00a0kg m²", "τ₁ – ö 関節", "a\\b"])
def test_what_shows_stays(text):
    assert visible(text) == text


@given(st.text())
def test_no_text_acts(text):
    assert all(sign.isprintable() or unicodedata.category(sign) == "Zs" for sign in visible(text))


@given(st.text(min_size=1), st.integers(90, 400))
def test_a_long_text_is_cut_to_a_length_and_keeps_its_ends(text, most):
    long = "start " + text * 500 + " end of it"
    cut = shortened(long, most)
    assert len(cut) == most
    assert cut.startswith("start ")
    assert cut.endswith(" end of it")
    assert f"({len(long)} characters)" in cut


def test_values_that_python_does_not_write():
    deep: list[object] = []
    for _ in range(100_000):
        deep = [deep]
    assert in_python(10**5000) == "int, too large to be shown"
    assert in_python(deep) == "list, too large to be shown"
    assert in_python([1, "a"]) == "[1, 'a']"


@pytest.mark.parametrize("part", ["what", "where", "expected", "found", "next_step"])
def test_no_part_of_a_message_acts_or_runs_on(part):
    evil = "\x1b[2J\nerror: all is well\u202e" + "x" * 100_000
    error = GdAnalyzeError(**{"what": "it is wrong", part: evil})
    lines = str(error).split("\n")
    assert len(lines) == (1 if part == "what" else 2)
    assert all(line.isprintable() and len(line) <= 1100 for line in lines)
    assert re.search(r"\\x1b\[2J\\nerror", str(error))


def test_a_value_found_is_told_on_a_line_or_two():
    assert len(GdAnalyzeError("no", found="9" * 100_000).details["found"]) <= 160
    listed = GdAnalyzeError("no", found=["joint 1 is late", "joint 2 is late"])
    assert listed.details["found"] == "joint 1 is late; joint 2 is late"


@pytest.mark.parametrize("text", ACTING)
def test_no_warning_acts(text):
    with pytest.warns(GdAnalyzeWarning) as told:
        warnings.warn(f"the link {text} is odd", GdAnalyzeWarning, stacklevel=1)
    assert str(told[0].message) == f"the link {visible(text)} is odd"
