"""Contrast, names and keyboard in a real browser, by axe-core's rules for WCAG 2.2 A and AA."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from browser import NARROW, WIDE, Tab, opened
from gd_analyze import load_arm
from gd_analyze.report.document import result_document
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report
from gd_analyze.studies.formulations import formulations_compared
from gd_analyze.types import Findings
from long_cases import long

RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]


def violations(tab: Tab) -> list[str]:
    """What breaks a rule, and the first element that does."""
    pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    # Evaluated, not inserted: the page's policy lets no script from elsewhere in.
    tab.run(files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    found = tab.run("(rules) => axe.run(document, { runOnly: rules, resultTypes: ['violations'] })", RULES)
    return [f"{one['id']}: {one['nodes'][0]['html']}" for one in found["violations"]]


@pytest.mark.parametrize(("width", "scheme"), [long(WIDE, "light"), long(NARROW, "dark")])
def test_no_rule_is_broken(browser: Any, file: Path, width: int, scheme: str) -> None:
    with opened(browser, file, width, color_scheme=scheme, reduced_motion="reduce") as tab:
        tab.drag_budget(8)
        tab.unfold()
        assert violations(tab) == []


def test_no_rule_is_broken_by_a_comparison(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "comparison.html"
    path.write_text(page_of(result_document(formulations_compared(load_arm("two_link")))), encoding="utf-8")
    with opened(browser, path, color_scheme="dark") as tab:
        tab.unfold()
        assert violations(tab) == []


@pytest.mark.slow
def test_no_rule_is_broken_by_several_motions(browser: Any, tmp_path: Path, two_motions: Findings) -> None:
    path = tmp_path / "report.html"
    path.write_text(page_of(main_report(two_motions)), encoding="utf-8")
    with opened(browser, path, NARROW) as tab:
        tab.unfold()
        assert violations(tab) == []


def test_the_keyboard_goes_through_the_answer_in_the_order_it_is_read(browser: Any, file: Path) -> None:
    with opened(browser, file) as tab:
        tab.page.keyboard.press("Tab")
        assert tab.run("document.activeElement.className") == "skip"
        assert tab.page.locator(".skip").bounding_box()["x"] >= 0
        seen = []
        for _ in range(40):
            tab.page.keyboard.press("Tab")
            seen.append(
                tab.run("((now) => now.id || now.dataset.element || now.tagName)(document.activeElement)")
            )
            outline = tab.run("getComputedStyle(document.activeElement).outlineStyle")
            assert outline != "none", f"no sign of the focus on {seen[-1]}"
            if seen[-1] == "open-all":
                break
        wanted = ["theme", "D11", "budget-slider", "open-all"]
        assert [name for name in seen if name in wanted] == wanted
