"""Numbers, units and names of others as a reader meets them."""

from __future__ import annotations

import math
import re
import unicodedata
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import are_possible
from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning
from gd_analyze.text import (
    LARGEST,
    amount,
    in_python,
    number,
    number_in,
    percent,
    pretty,
    rounded_up,
    share_up,
    significant,
    visible,
)
from strategies import examples

ACTING = ("\x1b[31m", "a\nb", "\x9b2J", "\u202eabc", "\x00", "\u2028", "\ud800")


def test_three_digits_and_a_unit_with_a_prefix() -> None:
    digits = ["0", "41.0", "0.00120", "2.10 × 10⁻¹⁴", "∞"]
    assert [significant(x) for x in (0.0, 41.0, 0.0012, 2.1e-14, np.inf)] == digits
    shares = ["0 %", "< 0.01 %", "1.2 %", "115 %", "∞"]
    assert [percent(x) for x in (0.0, 1e-6, 0.01234, 1.1502, np.inf)] == shares
    assert [percent(x) for x in (803.9, -803.9)] == ["more than 100 times", "less than -100 times"]
    assert [number(x, 2) for x in (240.4, 2.44, 12_345.0)] == ["240", "2.4", "12000"]
    assert amount(6.56e-5, "N m") == "65.6 µN m"
    assert amount(12_300.0, "N") == "12.3 kN"
    assert amount(4e-5, "kg m^2") == "40 mg m^2"


def test_an_e_in_a_hash_is_no_exponent() -> None:
    run = "gd-run:2c72af1e-3344aaf13a5dca1f"
    assert pretty(run) == run
    assert pretty("-2.1e-14 and 3e+05 kg m^2") == "-2.1 × 10⁻¹⁴ and 3 × 10⁵ kg m²"
    assert amount(2.1e-14, "N m") == "2.10e-14 N m"  # round-off is no quantity of the arm
    assert amount(0.01, "deg") == "0.01 deg"


@given(st.floats(1e-9, 1e9))
@examples(100)
def test_a_bound_is_never_shown_smaller_than_it_is(bound) -> None:
    assert bound <= rounded_up(bound) <= 1.01 * bound
    if bound > 100.0:
        assert percent(share_up(bound)) == "more than 100 times"
        return
    shown = float(percent(share_up(bound)).removesuffix(" %").removeprefix("< ")) / 100
    # Nine digits: the text is a decimal number, and a double beside it.
    assert bound <= shown * (1 + 1e-9)


@given(st.floats(allow_nan=False, allow_infinity=False))
@examples(100)
def test_every_number_that_python_writes_is_read(number: float) -> None:
    assert number_in(repr(number)) == number
    assert number_in(f" {number:+.17e} ") == number


def test_what_is_no_number_in_a_table() -> None:
    for text in ("1_000", "\uff11", "\u0661", "inf", "nan", "0x1", "1e", "1,5", ""):
        assert number_in(text) is None
    assert are_possible([[LARGEST, -LARGEST], [0.0, 1.0]])
    assert not any(are_possible([0.0, x]) for x in (math.nan, math.inf, np.nextafter(LARGEST, math.inf)))


@given(st.text() | st.sampled_from(ACTING))
@examples(100)
def test_no_text_acts_on_a_terminal(text):
    shown = visible(text)
    assert all(sign.isprintable() or unicodedata.category(sign) == "Zs" for sign in shown)
    assert shown == text or not text.isprintable()
    assert visible("1.2 %\u00a0kg m² – 関節") == "1.2 %\u00a0kg m² – 関節"


def test_values_that_python_does_not_write():
    deep: list[object] = []
    for _ in range(100_000):
        deep = [deep]
    assert [in_python(value)[:4] for value in (10**5000, deep, "0.1")] == ["int,", "list", "'0.1"]


def test_a_message_is_at_most_three_lines_with_the_place_first():
    whole = GdAnalyzeError("it is wrong", where="a.csv", expected="a number", found="b", next_step="mend it")
    assert str(whole).split("\n") == [
        "a.csv: it is wrong; found: b",
        "  expected: a number",
        "  next: mend it",
    ]
    assert str(GdAnalyzeError("--from has three values", where="--from")) == "--from has three values"


@pytest.mark.parametrize("part", ["what", "where", "expected", "found", "next_step"])
def test_no_part_of_a_message_acts_or_runs_on(part):
    evil = "\x1b[2J\nerror: all is well\u202e" + "x" * 100_000
    error = GdAnalyzeError(**{"what": "it is wrong", part: evil})
    lines = str(error).split("\n")
    assert len(lines) == (2 if part in ("expected", "next_step") else 1)
    assert all(line.isprintable() and len(line) <= 1100 for line in lines)
    assert re.search(r"\\x1b\[2J\\nerror", str(error))
    with pytest.warns(GdAnalyzeWarning) as caught:
        warnings.warn(evil[:20], GdAnalyzeWarning, stacklevel=1)
    assert str(caught[0].message).isprintable()
