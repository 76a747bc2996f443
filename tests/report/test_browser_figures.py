"""Figures in a real browser: drawn before they are seen, switched, read, enlarged, played."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import NARROW, WIDE, Tab, opened

from gd_analyze.results.findings import Findings

WITHIN = "(name) => [...document.querySelectorAll(`.plot.small[data-figure='${name}'] "
CURVES = WITHIN + ".curve`)].map((curve) => curve.classList[1])"
LABELS = WITHIN + "text`)].map((text) => text.textContent)"
BLANK = "document.querySelectorAll('.plot:not(:has(svg))').length"


def test_every_figure_is_drawn(tab: Tab) -> None:
    wanted = tab.run("document.querySelectorAll('.plot').length")
    drawn = tab.run("document.querySelectorAll('.plot:has(svg path)').length")
    assert wanted == drawn > 30
    assert tab.run("document.querySelectorAll('#scene .limb').length") > 2


@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_nothing_in_sight_is_blank_however_fast_one_scrolls(browser: Any, file: Path, width: int) -> None:
    with opened(browser, file, width) as tab:
        tab.unfold()
        height = tab.run("document.documentElement.scrollHeight")
        for place in range(0, height, 3000):
            tab.run("(y) => scrollTo(0, y)", place)
            assert tab.run(BLANK) == 0


def test_curve_switches_act_on_all_panels(tab: Tab) -> None:
    for role in ("translation", "rotation", "combined"):
        tab.click(f"button[data-role={role}]")
        assert tab.run("(s) => document.querySelector(s).ariaPressed", f"button[data-role={role}]") == "false"
        for figure in ("D11", "D36", "h4"):
            assert role not in tab.run(CURVES, figure)
        tab.click(f"button[data-role={role}]")
        for figure in ("D11", "D36", "h4"):
            assert role in tab.run(CURVES, figure)
    assert "coriolis" not in tab.run(CURVES, "h4")
    tab.click("button[data-role=coriolis]")
    assert "coriolis" in tab.run(CURVES, "h4")
    tab.click("button[data-role=coriolis]")


def test_time_in_seconds_or_set_points(tab: Tab, puma_findings: Findings) -> None:
    last = "report.data.axes.all[report.state.x].at(-1)"
    assert tab.run(last) == pytest.approx(puma_findings.trajectory.time[-1])
    assert any(label.endswith(" s") for label in tab.run(LABELS, "D22"))
    tab.click("button[data-x=point]")
    assert tab.run(last) == puma_findings.trajectory.n_set_points
    assert not any(label.endswith(" s") for label in tab.run(LABELS, "D22"))
    tab.click("button[data-x=time]")


def test_shared_scale(tab: Tab) -> None:
    plot = "document.querySelector(`.plot.small[data-figure='${name}']`)"
    largest = f"(name) => report.plots.get({plot}).box.atY(1e-3)"
    own = [tab.run(largest, name) for name in ("D11", "D66")]
    assert abs(own[0] - own[1]) > 1
    tab.click("button[data-shared='1']")
    shared = [tab.run(largest, name) for name in ("D11", "D66")]
    assert shared[0] == pytest.approx(shared[1], abs=0.5)
    tab.click("button[data-shared='']")
    assert [tab.run(largest, name) for name in ("D11", "D66")] == own


def test_pointing_shows_all_three_values(tab: Tab, puma_findings: Findings) -> None:
    tab.page.hover(".plot.small[data-figure='D23']")
    text = tab.page.inner_text(".panel[data-element='D23'] .readout")
    assert text.startswith("#")
    point = int(text[1:].partition(",")[0]) - 1
    parts = puma_findings.decomposition.inertia.values[point, :, 1, 2]
    for value in (*parts, parts.sum()):
        assert f"{value:.4g}" in text


def test_pointing_at_a_torque_tells_what_makes_it(tab: Tab) -> None:
    tab.page.hover(".plot[data-figure='pile-2']")
    tip = tab.page.inner_text(".tip")
    assert "gravity" in tip
    assert "N m" in tip
    tab.page.hover("h1")
    assert not tab.page.is_visible(".tip")


def test_an_element_can_be_enlarged_and_read_with_the_keyboard(tab: Tab) -> None:
    tab.click(".panel[data-element='h3'] .enlarge")
    assert tab.run("document.getElementById('lens').dataset.element") == "h3"
    tab.click(".panel[data-element='D12'] .enlarge")
    tab.page.focus("#lens .plot")
    read = []
    for _ in range(2):
        tab.page.keyboard.press("ArrowRight")
        read.append(tab.page.inner_text("#lens .readout"))
    assert [text.partition(",")[0] for text in read] == ["#1", "#2"]
    assert "kg m²" in read[0]


def test_dragging_over_the_enlarged_element_zooms(tab: Tab) -> None:
    tab.page.locator("#lens .plot").scroll_into_view_if_needed()
    box = tab.page.locator("#lens .plot").bounding_box()
    middle = box["y"] + box["height"] / 2
    tab.page.mouse.move(box["x"] + box["width"] * 0.4, middle)
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + box["width"] * 0.6, middle)
    tab.page.mouse.up()
    window = "report.plots.get(document.querySelector('#lens .plot')).window"
    first, last = tab.run(window)
    assert 0 < first < last
    tab.page.dblclick("#lens .plot")
    assert tab.run(window) is None


def test_theme_switch_recolours_page_and_figures(tab: Tab) -> None:
    look = (
        "[['body', 'backgroundColor'], ['.plot.small .curve.translation', 'stroke'],"
        " ['#scene .limb', 'stroke'], ['.plot.small text', 'fill']]"
        ".map(([selector, property]) => getComputedStyle(document.querySelector(selector))[property])"
    )
    before = tab.run(look)
    tab.click("#theme")
    after = tab.run(look)
    assert all(a != b for a, b in zip(before, after, strict=True))
    tab.click("#theme")
    assert tab.run(look) == before


def test_the_arm_plays(tab: Tab) -> None:
    hand = "document.querySelector('#scene .now .joint:last-of-type').getAttribute('cx')"
    tab.run("report.viewer.goTo(0)")
    start = tab.run(hand)
    tab.run("document.getElementById('speed').value = '4'; document.getElementById('play').click()")
    tab.until("report.viewer.frame > 5")
    assert tab.run("document.getElementById('play').ariaPressed") == "true"
    tab.click("#play")
    frame = tab.run("report.viewer.frame")
    assert tab.run(hand) != start
    assert tab.run("Number(document.getElementById('frame').value)") == frame
    assert f"set point {frame + 1} " in tab.page.inner_text("#clock")
    assert tab.run("document.querySelectorAll('.plot .now').length") == 6
    tab.page.locator("#frame").fill("2")
    assert tab.run("report.viewer.frame") == 2


def test_the_arm_turns_and_stays_in_its_frame(tab: Tab) -> None:
    boxes = (
        "[...document.querySelectorAll('#scene, #scene path, #scene circle, #scene text')]"
        ".map((one) => one.getBoundingClientRect()).map((box) => [box.left, box.top, box.right, box.bottom])"
    )
    for angle in ("-180", "-90", "40", "130"):
        tab.page.locator("#turn").fill(angle)
        every = np.array(tab.run(boxes))
        frame, drawn = every[0], every[1:]
        low, high = drawn.min(axis=0)[:2], drawn.max(axis=0)[2:]
        # A pixel of stroke.
        assert (low >= frame[:2] - 1).all()
        assert (high <= frame[2:] + 1).all()
        # It fills its frame in one direction at least.
        assert ((high - low) / (frame[2:] - frame[:2])).max() > 0.75


def test_the_arm_says_what_is_what(tab: Tab) -> None:
    said = tab.run("[...document.querySelectorAll('#scene text')].map((text) => text.textContent)")
    assert {"start", "end", "x", "z"} <= set(said)
    assert any(text.startswith("grid ") and text.endswith(" m") for text in said)
    assert "path of the hand" in said
