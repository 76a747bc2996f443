"""The page in a real browser: values under the pointer, the arm that plays, tables, folds, paper, themes."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from browser import NARROW, WIDE, Tab, opened
from gd_analyze.types import Findings
from long_cases import long

PANEL = "svg.panel[data-key='pile2']"


def test_a_pointer_tells_the_torque_and_its_parts(tab: Tab, puma_findings: Findings) -> None:
    tab.page.locator(PANEL).scroll_into_view_if_needed()
    box = tab.page.locator(PANEL).bounding_box()
    tab.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    lines = tab.page.inner_text(".tip").replace("−", "-").split("\n")
    told = {name: float(rest.split()[0]) for name, _, rest in (line.partition(": ") for line in lines[1:])}
    total = told.pop("torque")
    time = float(lines[0].split()[0])
    torque = puma_findings.exact_torque[:, 1]
    near = puma_findings.trajectory.time
    wanted = float(np.interp(time, near, torque))
    # Three digits are told, of a drawing that is a twentieth of a point fine.
    assert total == pytest.approx(wanted, abs=0.02 * abs(torque).max())
    assert sum(told.values()) == pytest.approx(total, abs=0.03 * abs(torque).max())
    tab.page.mouse.move(2, 2)
    assert not tab.page.is_visible(".tip")


def test_the_arm_plays_and_turns(tab: Tab, puma_findings: Findings) -> None:
    pose = "document.querySelector('#scene .pose').getAttribute('d')"
    before = tab.run(pose)
    tab.run("viewer.goTo(5)")
    assert tab.run(pose) != before
    assert tab.run("document.querySelectorAll('svg.panel .now').length") == puma_findings.arm.n_joints
    told = tab.page.locator("#state tr:first-child td:last-child").inner_text()
    assert told.endswith("N m")
    tab.click("#play")
    tab.until("viewer.frame !== 5")
    tab.click("#play")
    tab.run("viewer.goTo(0)")
    tab.run("const t = document.getElementById('turn'); t.value = 30; t.dispatchEvent(new Event('input'))")
    assert tab.run("viewer.azimuth") == 30
    tab.run("const u = document.getElementById('turn'); u.value = -50; u.dispatchEvent(new Event('input'))")


def test_a_cell_opens_its_element(tab: Tab, puma_findings: Findings) -> None:
    tab.page.focus(".cell[data-element='D11']")
    tab.page.keyboard.press("ArrowRight")
    tab.page.keyboard.press("Enter")
    assert tab.run("document.querySelector('.cell[aria-pressed=true]').dataset.element") == "D12"
    assert tab.page.is_visible("#element svg[data-key='D12'] .combined")
    formulas = {f"{f.left.letter}{f.left.index}": f for f in puma_findings.model.equations.formulas}
    kept = tab.page.locator("#element dd").last.inner_text()
    assert kept.startswith("D12 = ")
    assert len(re.findall(r"[+−]", kept.removeprefix("D12 = −"))) + 1 == len(formulas["D12"].pieces)
    tab.page.keyboard.press("ArrowDown")
    assert tab.run("document.activeElement.dataset.element") == "D22"
    tab.page.click("#element .close")
    assert not tab.page.is_visible("#element")
    assert tab.run("document.activeElement.dataset.element") == "D12"


def test_tables_sort(tab: Tab) -> None:
    ranks = (
        "[...document.querySelector('#table-dominance').tBodies[0].rows].map((row) => row.cells[0].innerText)"
    )
    tab.click("#table-dominance thead th:first-child button")
    up = tab.run(ranks)
    tab.click("#table-dominance thead th:first-child button")
    assert tab.run(ranks) == up[::-1]
    assert up == [str(k) for k in range(1, len(up) + 1)]


def test_curves_are_shown_by_their_role(tab: Tab) -> None:
    shown = "getComputedStyle(document.querySelector('svg.panel .coriolis')).display"
    assert tab.run(shown) == "none"
    tab.click("button[data-role='coriolis']")
    assert tab.run(shown) == "inline"
    tab.click("button[data-role='coriolis']")
    assert tab.run(shown) == "none"


def test_themes_recolour_drawings(tab: Tab) -> None:
    colours = (
        "[getComputedStyle(document.body).backgroundColor,"
        " getComputedStyle(document.querySelector('svg.panel text')).fill]"
    )
    before = tab.run(colours)
    tab.click("#theme")
    assert not {*before} & {*tab.run(colours)}
    tab.click("#theme")


@pytest.mark.parametrize(("width", "most"), [long(WIDE, 5000), (NARROW, 9000)])
def test_folded_the_page_is_short_and_never_scrolls_sideways(
    browser: Any, file: Path, width: int, most: int
) -> None:
    with opened(browser, file, width) as tab:
        assert tab.run("document.documentElement.scrollHeight") < most
        if width == WIDE:
            for selector in ("h1", ".headline", ".verdicts", ".cell[data-element='D66']", ".bar-of-joint"):
                assert tab.page.locator(selector).last.bounding_box()["y"] < 800
        tab.unfold()
        assert tab.run("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("width", [1440, 1024])
def test_tables_and_links_to_all_sections_fit(browser: Any, file: Path, width: int) -> None:
    with opened(browser, file, width) as tab:
        tab.unfold()
        for places in (".scroll:has(table)", ".bar nav"):
            narrow = (
                f"[...document.querySelectorAll('{places}')].filter((e) => e.scrollWidth > e.clientWidth + 1)"
            )
            assert tab.run(f"{narrow}.map((e) => e.ariaLabel)") == []
        # What a link leads to is not hidden below the bar.
        tab.page.click("nav a[href='#ranking']")
        tab.frame()
        bar, section = (tab.page.locator(name).bounding_box() for name in (".bar", "#ranking"))
        assert section["y"] >= bar["y"] + bar["height"] - 1


def test_cells_say_what_they_hold_and_their_labels_are_read_in_focus(tab: Tab) -> None:
    assert tab.run("[...document.querySelectorAll('.cell')].every((cell) => cell.title === cell.ariaLabel)")
    tab.page.focus(".cell[tabindex='0']")
    tab.page.keyboard.press("ArrowRight")
    look = tab.run(
        "(({ outlineOffset, outlineWidth }) => [outlineOffset, outlineWidth])"
        "(getComputedStyle(document.activeElement))"
    )
    assert look == ["-2px", "2px"]


def test_links_and_addresses_open_what_they_lead_to(browser: Any, file: Path) -> None:
    with opened(browser, file) as tab:
        assert not tab.run("document.getElementById('beyond').open")
        tab.page.click("nav a[href='#beyond']")
        tab.until("document.getElementById('beyond').open")
        tab.page.goto(f"{file.as_uri()}#ranking")
        tab.until("document.getElementById('ranking').open")
        tab.click("#open-all")
        assert tab.run("[...document.querySelectorAll('details')].every((fold) => fold.open)")


def test_without_scripts_it_is_whole(browser: Any, file: Path) -> None:
    with opened(browser, file, java_script_enabled=False) as tab:
        assert tab.page.is_visible(".cell svg.panel >> nth=0")
        assert tab.page.is_visible("#figure-inertia svg.panel >> nth=0")
        assert not tab.page.is_visible(".only-script")
        assert not tab.page.is_visible("#budget-slider")
