"""The budget one can drag: its numbers are those of the table, and at the budget asked for the model's."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from page_reader import Page
from report_arms import swing

from few_tries import few_tries
from gd_analyze.report.budget_equations import budget_equations
from gd_analyze.report.budget_path import DECADES, BudgetPath, budget_words
from gd_analyze.report.main_page import render_html
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.main_job import Settings, find


@pytest.fixture(scope="module")
def path(puma_findings: Findings) -> BudgetPath:
    return BudgetPath.of(puma_findings)


def test_it_goes_from_a_tenth_to_ten_times_the_budget(path: BudgetPath, page: Page) -> None:
    factors = [row["factor"] for row in path.rows]
    assert (factors[0], factors[path.asked], factors[-1]) == (0.1, 1.0, 10.0)
    assert factors == sorted(factors)
    slider = next(a for a in page.all("input") if a.get("id") == "budget-slider")
    assert slider["type"] == "range"
    assert [slider[name] for name in ("min", "max", "value")] == ["0", str(len(factors) - 1), str(path.asked)]
    assert "budget-slider" in [a.get("for") for a in page.all("label")]


def test_numbers_are_those_of_the_table(puma_findings: Findings, path: BudgetPath, page: Page) -> None:
    table, shown = puma_findings.tables["budgets"], page.data["budgets"]
    assert shown["factor"] == table.factor.values.tolist()
    assert shown["operations"] == table.operations.values.tolist()
    assert shown["kept"] == table.kept.values.sum(axis=1).tolist()
    # Four digits are written.
    np.testing.assert_allclose(shown["largest_error"], table.largest_error.values, rtol=1e-3)
    assert len({len(shown[name]) for name in ("place", "limit", "label", "operations")}) == 1


def test_at_the_budget_asked_for_it_is_the_model(
    puma_findings: Findings, path: BudgetPath, page: Page
) -> None:
    model, shown = puma_findings.model, page.data["budgets"]
    assert shown["operations"][path.asked] == model.operations.total
    assert shown["kept"][path.asked] == len(model.torques)
    np.testing.assert_allclose(shown["largest_error"][path.asked], model.accuracy.errors.largest, rtol=1e-3)
    for term in page.of_class("span", "term"):
        assert ("hidden" in term) == (term["data-kept"][path.asked] == "0")


def test_every_term_says_which_budgets_keep_it(puma_findings: Findings, path: BudgetPath) -> None:
    kept, ranked = puma_findings.tables["budgets"].kept.values, list(puma_findings.ranked_terms)
    written = {
        summand.term: summand
        for torque in budget_equations(puma_findings, path)
        for groups in torque.lines.values()
        for group in groups
        for summand in group.terms
    }
    assert written.keys() == {term for term, any_of in zip(ranked, kept.any(axis=0), strict=True) if any_of}
    for rank, term in enumerate(ranked):
        if term in written:
            assert [flag == "1" for flag in written[term].kept] == kept[:, rank].tolist()
    assert {term for term, summand in written.items() if summand.now} == set(puma_findings.model.torques)


def test_signs_multiply_to_the_coefficients(puma_findings: Findings, path: BudgetPath) -> None:
    weights = dict(puma_findings.ranked_terms) | puma_findings.model.torques
    for torque in budget_equations(puma_findings, path):
        for groups in torque.lines.values():
            for group in groups:
                assert bool(group.behind) == (len(group.terms) > 1 and bool(group.terms[0].term.velocities))
                for summand in group.terms:
                    assert (summand.negative != group.negative) == (weights[summand.term] < 0)


def test_without_scripts_it_says_what_it_would_show(source: str) -> None:
    told = re.search(r'<noscript><p class="nogl">With scripts on, a slider.*?</noscript>', source, re.DOTALL)
    assert told is not None
    assert "the model at the budget of 1%" in told[0]


def test_where_nothing_can_be_dropped_it_says_so_in_place_of_a_slider(two_link: RobotArm) -> None:
    findings = find(two_link, swing(two_link), Settings(budget="0.001%"))
    assert not BudgetPath.of(findings).moves
    page = Page(render_html(findings))
    assert "budget-slider" not in page.identifiers
    assert "nothing can be left out that would save an operation" in re.sub(r"\s+", " ", page.text)
    assert "0.0001 % of peak torque to 0.01 % of peak torque" in page.text


@pytest.mark.parametrize(("level", "refit"), [("energy", False), ("term", True), ("energy", True)])
@few_tries()
def test_coefficients_that_other_budgets_change_are_said_to_be_the_reports(level: str, refit: bool) -> None:
    arm = load_arm("puma560")
    findings = find(arm, swing(arm), Settings(level=level, refit=refit))
    page = Page(render_html(findings))
    assert BudgetPath.of(findings).moves
    assert "Coefficients are those of this report's model" in page.text
    shown = [a for a in page.of_class("span", "term") if "hidden" not in a]
    assert len(shown) == len(findings.model.torques)


def test_budgets_are_named_in_their_own_terms() -> None:
    assert budget_words("5.01187%") == "5.01 % of peak torque"
    assert budget_words("0.5 N m") == "0.5 N m"
    assert budget_words("1% or 10% friction, 0.2 N m") == ("1 % of peak torque or 10 % of friction, 0.2 N m")


def test_errors_stand_on_one_axis_with_the_budget(
    puma_findings: Findings, page: Page, path: BudgetPath
) -> None:
    shown = page.data["budgets"]
    low, high = DECADES
    allowed = puma_findings.model.accuracy.allowed
    for row, places, limit in zip(path.rows, shown["place"], shown["limit"], strict=True):
        assert limit == pytest.approx(100 * (np.log10(row["factor"]) - low) / (high - low), abs=0.01)
        for error, one, place in zip(row["largest_error"], allowed, places, strict=True):
            # Places have two decimals; within the budget means left of its line.
            assert place <= limit + 0.01 or error > row["factor"] * one
            assert 0.0 <= place <= 100.0


def test_an_arm_of_too_many_terms_has_a_page_too(arms: dict[str, RobotArm]) -> None:
    arm = arms["sliding"]
    chain = replace(arm, name="chain", joints=arm.joints * 3, links=arm.links * 3, dh_table=(), drives=())
    page = Page(render_html(find(chain, swing(chain, 3))))
    assert not page.of_class("span", "term")
    # A recursion keeps neither terms nor parts that could be counted.
    assert page.data["budgets"]["keeps"] == ""
