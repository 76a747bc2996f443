"""Equations on the page: the model's, what it keeps of how many, and the exact ones."""

from __future__ import annotations

from collections import Counter

import pytest
from page_reader import Page

from gd_analyze.formulas.formula import Product, Symbol
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.formulas.writing import parts_formulas, term_formula
from gd_analyze.report.main_page import TERMS_SHOWN, render_html
from gd_analyze.report.terms import exact_elements, tallies
from gd_analyze.results.findings import Findings
from gd_analyze.results.words import SYMBOLS
from gd_analyze.simplification.element import kept_effects, parts_of

MATHS = PageMathML()


def test_the_model_equations_hold_exactly_what_is_kept(puma_findings: Findings, source: str) -> None:
    n = puma_findings.arm.n_joints
    kept = {part.label for part in puma_findings.element_model.terms}
    for i, formula in enumerate(puma_findings.element_model.formulas):
        acting = {
            part.element.label
            for part in parts_of(n)
            if part.label in kept
            and i in (part.element.i, part.element.j if part.element.j is not None else -1)
        }
        symbols = [piece.product.powers[0].base for piece in formula.pieces]
        drives = [symbol for symbol in symbols if symbol.letter == "J"]
        assert drives == ([Symbol("J", str(i + 1))] if puma_findings.model.drives else [])
        symbols = [symbol for symbol in symbols if symbol not in drives]
        assert {symbol.letter + symbol.index for symbol in symbols} == acting
        for symbol in symbols:
            if symbol.word:
                other = {"tran": "rotation", "rot": "translation"}[symbol.word]
                assert f"{symbol.letter}{symbol.index} {other}" not in kept
            assert MATHS.symbol(symbol) in source


def test_drives_are_written_into_the_model(puma_findings: Findings) -> None:
    n = puma_findings.arm.n_joints
    formulas = parts_formulas(kept_effects(n, puma_findings.element_model.terms), n, drives=True)
    for i, formula in enumerate(formulas):
        assert Symbol("J", str(i + 1)) in [piece.product.powers[0].base for piece in formula.pieces]


def test_terms_and_their_equations_are_on_the_page(puma_findings: Findings, source: str, page: Page) -> None:
    model = puma_findings.model
    shown = [a for a in page.of_class("span", "term") if "hidden" not in a]
    assert len(shown) == len(model.torques)
    assert len(page.of_class("div", "torque")) == puma_findings.arm.n_joints
    for piece in (piece for formula in model.formulas for piece in formula.pieces):
        weight, powers = piece.product
        # Beside terms that other budgets keep, its rates may stand behind a bracket.
        inside = tuple(power for power in powers if not getattr(power.base, "dots", 0))
        assert any(f"<math>{MATHS.product(Product(weight, some))}" in source for some in (powers, inside))
    rows = [a for a in page.all("tr") if a.get("data-group") in SYMBOLS]
    assert len(rows) == TERMS_SHOWN
    for term, weight in [*puma_findings.ranked_terms.items()][:TERMS_SHOWN]:
        assert MATHS.elements(term_formula(term, weight))[0] in source


def test_the_glance_counts_every_term_once(puma_findings: Findings, page: Page) -> None:
    exact = puma_findings.model.form.torques
    kept, n = puma_findings.model.torques, puma_findings.arm.n_joints
    cells = [cell for line in tallies(exact, kept, n) for cell in line]
    assert sum(cell.kept for cell in cells) == len(puma_findings.model.torques)
    assert sum(cell.total for cell in cells) == len(exact)
    assert all(cell.kept <= cell.total for cell in cells)
    shown = [a["title"] for a in page.of_class("td", "tally-cell")]
    assert shown == [f"{cell.what}: {cell.kept} of {cell.total} terms kept" for cell in cells]


def test_the_exact_equations_say_where_terms_come_from(puma_findings: Findings, page: Page) -> None:
    written = exact_elements(puma_findings)
    assert [a for a in page.all("details") if a.get("class") == "exact"]
    effects = Counter(
        "gravity" if formula.left.letter == "c" else term.effect
        for formula, terms in written
        for term in terms
    )
    assert effects.keys() == {"translation", "rotation", "both", "gravity"}
    shown = Counter(a["class"] for a in page.all("span") if a.get("title", "").count(", link "))
    assert shown == {f"e-{effect}": count for effect, count in effects.items()}


def test_equations_too_long_to_read_are_left_to_the_command(
    puma_findings: Findings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gd_analyze.report.terms.MOST_EXACT_TERMS", 10)
    page = Page(render_html(puma_findings))
    assert not page.of_class("details", "exact")
    assert "too long to be read on a page" in page.text
