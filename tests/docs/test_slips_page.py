"""The mistakes that docs/diagnose.md lists against the verbs: what each of them meets is what it says."""

from __future__ import annotations

import pytest
import slips

ALL = {(section, slip.mistake): slip for section, listed in slips.SECTIONS.items() for slip in listed}
RUNS = [
    pytest.param(*place, id=f"{place[0]}: {place[1]}", marks=[pytest.mark.slow] * slip.slow)
    for place, slip in ALL.items()
]


def test_every_slip_is_on_the_page_and_no_other():
    rows = slips.rows_of(slips.PAGE.read_text(encoding="utf-8"))
    assert set(rows) == {place for place in ALL if place[1] != slips.RIGHT}


@pytest.mark.parametrize(("section", "mistake"), RUNS)
def test_the_page_tells_what_happens(section, mistake):
    rows = slips.rows_of(slips.PAGE.read_text(encoding="utf-8"))
    expected = "silent" if mistake == slips.RIGHT else rows[section, mistake]
    assert ALL[section, mistake].outcome() == expected, "run `python tests/docs/slips.py`"


@pytest.mark.slow
def test_the_page_is_up_to_date():
    text = slips.PAGE.read_text(encoding="utf-8")
    assert slips.page(text) == text, "run `python tests/docs/slips.py`"
