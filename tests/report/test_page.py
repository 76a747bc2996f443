"""The page of the main report: whole, offline, and of the numbers of the run."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import Trajectory
from gd_analyze.report.budget import BudgetPath, summands
from gd_analyze.report.document import result_document
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report, main_result
from gd_analyze.report.pdf import pdf_of
from gd_analyze.report.terminal import text_of
from gd_analyze.result import Column, Fact, Result, Table
from gd_analyze.robots.parts import JointKind
from gd_analyze.types import Findings, RobotArm
from long_cases import long
from page_reader import Page
from report_cases import HOSTILE, made_findings

EIGHT: list[JointKind] = [*("prismatic",) * 5, *("revolute",) * 3]
LONG_EDGES = ("eight joints", "ten prismatic joints")
EDGES = {
    "one joint": lambda: made_findings(["revolute"]),
    "one prismatic joint": lambda: made_findings(["prismatic"]),
    "ten prismatic joints": lambda: made_findings(["prismatic"] * 10),
    "eight joints": lambda: made_findings(EIGHT, level="element"),
    "one set point": lambda: made_findings(["revolute"] * 2, set_points=1),
    "long": lambda: made_findings(["revolute"] * 2, set_points=5000),
}


def words_of(page: Page) -> str:
    return " ".join(page.text.split())


def test_it_asks_the_network_for_nothing(page: Page, source: str) -> None:
    assert "default-src 'none'" in next(a["content"] for a in page.all("meta") if "http-equiv" in a)
    assert not [a for tag, a in page.elements for name in ("src", "srcset") if name in a]
    assert {a["href"][0] for a in page.all("a")} == {"#"}
    assert not re.findall(r"url\(|@import|https?://(?!www\.w3\.org)", source.partition("<main>")[0])
    assert len(source.encode()) < 600_000


def test_identifiers_are_unique_and_links_lead_to_them(page: Page) -> None:
    assert len(set(page.identifiers)) == len(page.identifiers)
    assert {a["href"][1:] for a in page.all("a")} <= set(page.identifiers)
    assert page.headings_go_down_by_one


def test_it_answers_with_the_numbers_of_the_run(puma_findings: Findings, page: Page) -> None:
    words, model = words_of(page), puma_findings.model
    opening = main_report(puma_findings).content
    for said in (opening["title"], opening["headline"], *(fact["text"] for fact in opening["facts"])):
        assert " ".join(said.split()) in words
    assert f"{model.operations.pair} instead of {model.operations_full.pair}" in words
    for warning in puma_findings.warnings:
        assert warning.replace("`", "") in words
    for label, value in opening["provenance"]:
        assert " ".join(value.split()) in words, label


def test_what_is_numbered_is_there_once(page: Page) -> None:
    for kind, place in (("Figure", "figure-"), ("Table", "table-")):
        found = [int(number) for number in re.findall(rf"{kind} (\d+)\.", page.text)]
        assert sorted(found) == list(range(1, len(found) + 1))
        assert len(found) >= sum(name.startswith(place) for name in page.identifiers) > 0


def test_tables_of_one_name_have_numbers_and_places_of_their_own(measured_findings: Findings) -> None:
    page = Page(page_of(main_report(measured_findings)))
    found = [int(number) for number in re.findall(r"Table (\d+)\.", page.text)]
    assert found == list(range(1, len(found) + 1))
    assert len(set(page.identifiers)) == len(page.identifiers)


def test_terms_that_are_shown_are_the_model(puma_findings: Findings, page: Page) -> None:
    path, table = BudgetPath.of(puma_findings), puma_findings.tables["budgets"]
    shown = page.data["budgets"]
    terms = page.of_class("span", "term")
    for place in range(len(path.rows)):
        written = [*map(summands, path.formulas(puma_findings, place))]
        assert sum(term["data-kept"][place] == "1" for term in terms) == sum(len([*one]) for one in written)
    written = [*map(summands, puma_findings.model.equations.formulas)]
    assert sum("hidden" not in term for term in terms) == sum(len([*one]) for one in written)
    assert shown["operations"] == table.operations.values.tolist()
    assert shown["operations"][path.asked] == puma_findings.model.operations.total
    # Four digits are written.
    np.testing.assert_allclose(shown["largest_error"], table.largest_error.values, rtol=1e-3)
    assert shown["apart"] == table.operations_apart.values.tolist()
    assert [*map(len, (row["kept"] for row in path.rows))] == shown["kept"]


def test_where_nothing_can_be_dropped_there_is_no_slider() -> None:
    page = Page(page_of(main_report(gd.analyze("two_link", "two-link-swing", budget="0.001%"))))
    assert "budget-slider" not in page.identifiers
    assert "would not save an operation" in words_of(page)


@pytest.mark.filterwarnings("ignore::gd_analyze.GdAnalyzeWarning")  # of what is odd about these
@pytest.mark.parametrize(
    "make",
    [long(make) if name in LONG_EDGES else make for name, make in EDGES.items()],
    ids=EDGES,
)
def test_any_arm_has_a_page_and_a_pdf(make: Callable[[], Findings]) -> None:
    report = main_report(make())
    page = Page(page_of(report))
    assert page.of_class("svg", "panel")
    assert "nan" not in page.text.lower().split()
    assert pdf_of(report).startswith(b"%PDF-")


def test_text_of_the_user_is_text() -> None:
    findings = made_findings(["revolute", "prismatic"], title=HOSTILE)
    joints = tuple(
        dataclasses.replace(joint, name='<img src=x onerror="a">') for joint in findings.arm.joints
    )
    arm = dataclasses.replace(findings.arm, joints=joints, sources=("<b>_",))
    page = Page(page_of(main_report(dataclasses.replace(findings, arm=arm))))
    assert not page.all("img")
    assert len(page.all("script")) == 2
    assert "<script>alert(1)</script>" in page.text


@pytest.mark.parametrize("level", ["element", "term", "energy"])
def test_every_level_has_its_own_parts(level: str, by_level: dict[str, Findings]) -> None:
    page = Page(page_of(main_report(by_level[level])))
    assert ("elements" in page.identifiers) == (level != "element")
    assert bool(page.of_class("span", "term")) == (level != "element")
    assert ("Coefficients are those of this report" in words_of(page)) == (level == "energy")


@pytest.mark.filterwarnings("ignore:.*single terms are not:gd_analyze.GdAnalyzeWarning")
@pytest.mark.parametrize("why", ["too many in all", "too many for the budget"])
def test_without_a_readable_model_the_dominant_elements_are_shown(
    why: str, puma: RobotArm, pick_and_place: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Named on page and terminal: why there is no model, the exact torque, and what to do."""
    if why == "too many in all":
        monkeypatch.setattr("gd_analyze.simplification.exact.MOST_TERMS", 3)
        monkeypatch.setattr("gd_analyze.simplification.candidates.MOST_TERMS", 3)
    else:
        for module in (
            "studies.budget_stops",
            "studies.steps.simplify",
            "results.run_facts",
            "results.findings",
        ):
            monkeypatch.setattr(f"gd_analyze.{module}.READABLE", 13)
        # At 10 % ten terms exceed the budget alone, and the model has few more.
        monkeypatch.setattr("gd_analyze.studies.budget_stops._LIKELY_SHARE", 0.8)
    findings = gd.analyze(puma, pick_and_place)
    assert findings.is_unreadable
    reason = "Too many terms matter within 1%" if why == "too many in all" else "No model with at most"
    assert reason in findings._repr_html_()
    assert findings.model.is_exact
    full = findings.model.operations_full.total
    words = words_of(Page(page_of(main_report(findings))))
    terminal = " ".join(text_of(result_document(main_result(findings))).split())
    for said in (words, terminal):
        assert f"the exact torque in {full} operations" in said
        assert "too many" in said
        # A larger error helps where terms can be chosen at all.
        assert ("`--budget 10%`" in terminal) == (why != "too many in all")
    if why != "too many in all":  # and the one named works
        wider = gd.analyze(puma, pick_and_place, budget="10%")
        assert not wider.is_unreadable
        assert wider.model.saves
    assert "dominant parts" in words
    assert pdf_of(main_report(findings)).startswith(b"%PDF-")


def test_any_result_has_a_page() -> None:
    table = Table("t", "Things <b>", (Column("torque", [1.5, None], "N m"),), values={"y": [1, 2]})
    facts = (Fact("a", "Label", 0.014, shown="percent"),)
    page = Page(page_of(result_document(Result("Title", facts=facts, parts=(table,)))))
    assert "Things <b>" in page.text
    assert "1.4\N{NO-BREAK SPACE}%" in page.text
    assert len(page.all("th")) == 1
