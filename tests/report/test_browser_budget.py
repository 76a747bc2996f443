"""The budget in a real browser: dragged and pressed, equations and errors follow."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gd_analyze as gd
from browser import NARROW, Tab, opened
from gd_analyze.report.budget import BudgetPath, summands
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report
from gd_analyze.results.rows import budget_rows
from gd_analyze.types import Findings

# Over that of the allowed error.
WIDTHS = (
    "[...document.querySelectorAll('.of-allowed .fill')]"
    ".map((bar) => bar.clientWidth / bar.parentElement.clientWidth)"
)
SHOWN = "[...document.querySelectorAll('span.term')].filter((term) => term.offsetWidth).length"


@pytest.fixture(scope="module")
def tab(browser: Any, file: Path) -> Iterator[Tab]:
    with opened(browser, file, reduced_motion="reduce") as tab:
        yield tab
        assert not tab.said


def test_equations_count_and_errors_follow(tab: Tab, puma_findings: Findings) -> None:
    rows, path = budget_rows(puma_findings), BudgetPath.of(puma_findings)
    equations = []
    for place, row in enumerate(rows):
        tab.drag_budget(place)
        assert tab.page.inner_text("#budget-count") == str(row["operations"])
        assert tab.page.inner_text("#budget-apart") == str(row["operations_apart"])
        assert tab.page.inner_text("#budget-kept") == str(len(row["kept"]))
        written = [*map(summands, path.formulas(puma_findings, place))]
        assert tab.run(SHOWN) == sum(len([*terms]) for terms in written)
        shares = [min(used, 1.0) for used in path.data(puma_findings)["used"][place]]
        # Widths in whole pixels of 150 or more.
        np.testing.assert_allclose(tab.run(WIDTHS), shares, rtol=0, atol=1 / 150)
        assert shares == pytest.approx(np.divide(row["largest_error"], row["allowed_error"]), rel=1e-3)
        equations.append(tab.page.inner_text(".torques"))
    # Another set of terms is other equations.
    kept = [tuple(row["kept"]) for row in rows]
    changes = [a != b for a, b in pairwise(kept)]
    assert [a != b for a, b in pairwise(equations)] == changes
    assert sum(changes) > 6
    tab.click("#budget-reset")


def test_at_the_budget_asked_for_the_page_is_as_without_scripts(browser: Any, file: Path, tab: Tab) -> None:
    text = "document.querySelector('.torques').innerText.replace(/\\s+/g, ' ')"
    tab.drag_budget(8)
    tab.drag_budget(0)
    tab.click("#budget-reset")
    with opened(browser, file, java_script_enabled=False) as still:
        torques = still.page.inner_text(".torques")
        assert " ".join(torques.split()) == " ".join(tab.run(text).split())


def test_named_budgets_are_pressed(tab: Tab, puma_findings: Findings) -> None:
    stops = puma_findings.tables["stops"]
    for row in stops.to_dataframe().itertuples():
        tab.click(f'[data-stop="{row.position}"]')
        assert tab.run("Number(document.getElementById('budget-slider').value)") == row.position
        assert tab.page.inner_text("#budget-kept") == str(row.terms)
        assert tab.page.inner_text("#budget-apart") == str(row.operations_apart)
        assert tab.run("[...document.querySelectorAll('[data-stop][aria-pressed=true]')].length") == 1
        assert "(proven)" in tab.page.inner_text("#budget-proof")
    tab.click("#budget-reset")


def test_signs_and_brackets_stay_right(tab: Tab) -> None:
    """No line begins with a plus, and no bracket holds a single term, unless a sign needs it."""
    for place in range(0, 9, 2):
        tab.drag_budget(place)
        wrong = tab.run(
            "[...document.querySelectorAll('.equation-of > .line')].filter((line) => {"
            " if (!line.checkVisibility()) return false;"
            " const words = line.innerText.replace(/[\\s\\u2061]/g, '');"
            " const broken = words.includes('(+') || words.includes('()');"
            " return broken || words.startsWith('+') || words === ''; }).length"
        )
        assert wrong == 0
    tab.click("#budget-reset")


def test_terms_fade_before_they_go(browser: Any, file: Path) -> None:
    with opened(browser, file, reduced_motion="no-preference") as tab:
        before = tab.run(SHOWN)
        tab.drag_budget(8)
        # Terms that go are still there, beside those that a named budget's model has for itself.
        assert tab.run(SHOWN) >= before
        assert tab.run("document.querySelectorAll('.term.leaving').length") > 0
        tab.until(f"{SHOWN} < {before}")


def test_arrow_keys_move_it_and_it_tells_where_it_is(tab: Tab) -> None:
    tab.page.focus("#budget-slider")
    before = tab.page.inner_text("#budget-status")
    tab.page.keyboard.press("ArrowRight")
    assert tab.run("document.getElementById('budget-slider').value") == "4"
    told = tab.run("document.getElementById('budget-slider').getAttribute('aria-valuetext')")
    assert told == tab.page.inner_text("#budget-said") == "2 % of peak torque"
    # Said once the hand rests, not at every step.
    assert tab.page.inner_text("#budget-status") == before
    tab.until("document.getElementById('budget-status').textContent.includes('operations')")
    tab.page.keyboard.press("Home")
    assert tab.run("document.getElementById('budget-slider').value") == "0"
    tab.click("#budget-reset")
    assert tab.run("document.getElementById('budget-slider').value") == "3"
    assert tab.run("document.activeElement.id") == "budget-slider"


def test_what_is_proven_is_so_at_the_budget_of_the_report_only(tab: Tab) -> None:
    assert tab.page.is_visible(".proven-mark >> nth=0")
    tab.drag_budget(6)
    assert not tab.page.is_visible(".proven-mark >> nth=0")
    assert "not proven" in tab.page.inner_text("#budget-about")
    tab.click("#budget-reset")
    assert tab.page.is_visible(".proven-mark >> nth=0")


def test_it_stays_in_sight_over_the_equations(browser: Any, file: Path) -> None:
    with opened(browser, file, NARROW) as tab:
        tab.run("document.querySelector('.equation-of').scrollIntoView({ block: 'center' })")
        tab.frame()
        box = tab.page.locator("#budget-slider").bounding_box()
        assert 0 <= box["y"] <= tab.run("innerHeight") - box["height"]


def test_shares_of_what_is_allowed_follow_the_slider(browser: Any, tmp_path: Path) -> None:
    file = tmp_path / "in_torque.html"
    file.write_text(page_of(main_report(gd.analyze("two_link", "two-link-swing", budget="2"))), "utf-8")
    with opened(browser, file) as tab:
        for place in (0, 3, 6):
            tab.drag_budget(place)
            told = [tab.page.inner_text("#budget-worst")]
            told += tab.page.locator("#joint-errors td.value").all_inner_texts()
            shares = [float(text.removeprefix("up to ").strip("<% ")) for text in told]
            assert max(shares[1:]) == shares[0] <= 100
        assert shares[0] > 50
