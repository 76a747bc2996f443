"""Two depths in a real browser: folds open for links and paper; nothing is wider than the screen."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest
from browser import NARROW, WIDE, Tab, opened


@pytest.mark.parametrize(("width", "most"), [(WIDE, 5000), (NARROW, 9000)])
def test_folded_the_page_is_short(browser: Any, file: Path, width: int, most: int) -> None:
    with opened(browser, file, width) as tab:
        assert tab.run("document.documentElement.scrollHeight") < most


def test_the_first_screen_has_the_answer(browser: Any, file: Path) -> None:
    with opened(browser, file) as tab:
        for selector in (
            "h1",
            ".headline",
            "#scene",
            ".piles",
            "#budget-slider",
            "#joint-errors",
            ".plot.trade",
        ):
            assert tab.page.locator(selector).bounding_box()["y"] < 800


@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_the_page_never_scrolls_sideways(browser: Any, file: Path, width: int) -> None:
    with opened(browser, file, width) as tab:
        tab.unfold()
        assert tab.run("document.documentElement.scrollWidth") <= width


def test_a_table_wider_than_its_room_shows_and_scrolls(browser: Any, file: Path) -> None:
    with opened(browser, file, NARROW) as tab:
        tab.unfold()
        room = "document.querySelector('.scroll:has(#dominance)')"
        assert tab.run(f"[{room}.className, {room}.tabIndex]") == ["scroll more-right", 0]
        tab.run(f"{room}.scrollLeft = 1e6")
        tab.until(f"{room}.className === 'scroll more-left'")
        right = tab.run("document.querySelector('#dominance caption span').getBoundingClientRect().right")
        assert right <= NARROW


def test_links_and_addresses_open_what_they_lead_to(browser: Any, file: Path) -> None:
    with opened(browser, file) as tab:
        assert not tab.run("document.getElementById('beyond').open")
        tab.page.click("nav a[href='#beyond']")
        tab.until("document.getElementById('beyond').open")
        assert 0 <= tab.page.locator("#beyond").bounding_box()["y"] < 800
        tab.run("document.getElementById('beyond').open = false")
        tab.page.click("nav a[href='#beyond']")
        tab.until("document.getElementById('beyond').open")
        tab.page.goto(f"{file.as_uri()}#gravity")
        tab.page.reload()
        assert tab.run("document.getElementById('effects').open")
        assert tab.run("document.getElementById('gravity').getBoundingClientRect().top") < 800


def test_all_unfold_at_once(browser: Any, file: Path) -> None:
    with opened(browser, file) as tab:
        closed = "document.querySelectorAll('details:not([open])').length"
        tab.page.click("#open-all")
        assert tab.run(closed) == 0
        tab.until("document.getElementById('open-all').textContent === 'Fold all'")
        tab.page.click("#open-all")
        assert tab.run(closed) > 0


@pytest.mark.parametrize("scripts", [True, False])
def test_on_paper_everything_is_open_light_and_whole(
    browser: Any, file: Path, tmp_path: Path, scripts: bool
) -> None:
    with opened(browser, file, color_scheme="dark", java_script_enabled=scripts) as tab:
        printed = tmp_path / "printed.pdf"
        tab.page.pdf(path=printed, prefer_css_page_size=True, print_background=True)
        text = subprocess.run(["pdftotext", printed, "-"], capture_output=True, text=True, check=True).stdout
        assert "Provenance" in text
        assert "Inertia matrix" in text
        if scripts:
            # Drawn though nobody has scrolled or unfolded anything.
            assert tab.run("document.querySelectorAll('.plot:not(:has(svg path))').length") == 0
            assert tab.run("document.querySelectorAll('details.appendix[open]').length") == 0
            assert not tab.run("document.documentElement.classList.contains('printing')")
            assert tab.run("document.documentElement.dataset.theme ?? ''") == ""


def test_the_ranking_sorts_and_filters(tab: Tab) -> None:
    rows = "[...document.querySelectorAll('#dominance tbody tr')]"
    column = f"{rows}.map((row) => row.cells[5].dataset.value)"
    button = "#dominance thead th:nth-child(6) button"
    tab.click(button)
    falling = [float(value) for value in tab.run(column)]
    assert falling == sorted(falling, reverse=True)
    assert tab.run("document.querySelector('#dominance th:nth-child(6)').ariaSort") == "descending"
    tab.click(button)
    assert [float(value) for value in tab.run(column)] == sorted(falling)
    tab.click(".filter[data-table=dominance] [data-group=rotation]")
    shown = tab.run(f"{rows}.filter((row) => row.offsetHeight).map((row) => row.dataset.group)")
    assert set(shown) == {"rotation"}
    tab.click(".filter[data-table=dominance] [data-group='']")
    tab.click("#dominance thead th:first-child button")


def test_the_terms_sort_and_filter_by_themselves(tab: Tab) -> None:
    rows = "[...document.querySelectorAll('#term-ranking tbody tr')]"
    others = "document.querySelectorAll('#dominance tbody tr:not([hidden])').length"
    before = tab.run(others)
    tab.click("#term-ranking thead th:nth-child(6) button")
    torques = [float(value) for value in tab.run(f"{rows}.map((row) => row.cells[5].dataset.value)")]
    assert torques == sorted(torques, reverse=True)
    tab.click(".filter[data-table=term-ranking] [data-group=inertia]")
    shown = tab.run(f"{rows}.filter((row) => row.offsetHeight).map((row) => row.dataset.group)")
    assert set(shown) == {"inertia"}
    assert tab.run(others) == before
    tab.click(".filter[data-table=term-ranking] [data-group='']")
    tab.click("#term-ranking thead th:first-child button")


def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(browser: Any, file: Path) -> None:
    with opened(browser, file) as tab:
        tab.unfold()
        assert tab.asked == [file.as_uri()]
        assert not tab.said
