"""The PDF of the main report: the numbers of the run, whatever the arm, without a font of the machine."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.figures.elements import subscripted
from gd_analyze.report import pdf
from gd_analyze.report.document import result_document
from gd_analyze.report.main_report import main_report
from gd_analyze.report.pdf import pdf_of, typeset
from gd_analyze.result import Column, Result, Table
from gd_analyze.results.model_facts import H_NOTE
from gd_analyze.types import Findings
from pdf_reader import read
from report_cases import HOSTILE, made_findings

NOW = "2024-05-01T00:00:00+00:00"


@pytest.fixture(scope="module")
def puma_pdf(puma_findings: Findings) -> bytes:
    return pdf_of(main_report(puma_findings))


def test_first_page_answers_the_question(puma_pdf: bytes, puma_findings: Findings, tmp_path: Path) -> None:
    words = " ".join(read(puma_pdf, tmp_path, "-l", "1").split())
    opening = main_report(puma_findings).content
    labels = (fact["label"] for fact in opening["facts"])
    for said in (opening["title"], opening["headline"], *labels):
        # Exponents are raised, and are lines of their own for the reader.
        assert said.partition("^")[0] in words
    for joint in puma_findings.arm.joints:
        assert joint.name in words
    for fact in opening["parts"]["verdicts"][0]["facts"]:
        assert fact["label"] in words
    labels = [subscripted(label) for label in puma_findings.dominance.element.values.tolist()]
    assert all(label in words for label in labels)
    assert "The model" in words
    assert H_NOTE.partition(" (")[0] in words
    for stop in opening["parts"]["stops"][0]["facts"]:
        assert f"{stop['label']}: {stop['text']}" in words
    assert {"Figure 1.", "Figure 2."} <= set(re.findall(r"(?:Figure|Table) \d\.", words))


def test_d_and_h_by_effect_follow_the_first_page(
    puma_pdf: bytes, puma_findings: Findings, tmp_path: Path
) -> None:
    words = read(puma_pdf, tmp_path, "-f", "2", "-l", "3")
    labels = [label for label in puma_findings.dominance.element.values.tolist() if label[0] in "Dh"]
    assert all(subscripted(label) in words for label in labels)


def test_every_part_is_there_in_order(puma_pdf: bytes, puma_findings: Findings, tmp_path: Path) -> None:
    words = " ".join(read(puma_pdf, tmp_path).split()).replace("’", "'")
    places = [
        words.find(f"{section['letter']} {section['title']}")
        for section in main_report(puma_findings).content["appendices"]
    ]
    assert -1 not in places
    assert places == sorted(places)
    for kind in ("Figure", "Table"):
        numbers = [int(number) for number in re.findall(rf"{kind} (\d+)\.", words)]
        assert numbers == list(range(1, len(numbers) + 1))
    assert all(f"(3.4-{number})" in words for number in range(24, 29))
    assert len(re.findall(rb"/Type\s*/Page\b", puma_pdf)) <= 8


def test_no_heading_stands_alone(puma_pdf: bytes, puma_findings: Findings, tmp_path: Path) -> None:
    """Below it, on its page, is the caption of a figure or a table, or an equation."""
    pages = [" ".join(page.split()) for page in read(puma_pdf, tmp_path).replace("’", "'").split("\f")]
    for section in main_report(puma_findings).content["appendices"]:
        heading = f"{section['letter']} {section['title']}"
        below = next(page.partition(heading)[2] for page in pages if heading in page)
        assert re.search(r"(Figure|Table) \d+\.|\(3\.4", below), heading


def test_user_text_comes_out_literally(tmp_path: Path) -> None:
    findings = made_findings(["revolute", "prismatic"], title=HOSTILE)
    joint = dataclasses.replace(findings.arm.joints[0], name="#panic() $a_")
    arm = dataclasses.replace(
        findings.arm, joints=(joint, findings.arm.joints[1]), sources=("#eval(x) <b>_",)
    )
    words = " ".join(read(pdf_of(main_report(dataclasses.replace(findings, arm=arm))), tmp_path).split())
    for said in (HOSTILE, "#panic() $a_", "#eval(x) <b>_"):
        assert said in words


@pytest.mark.parametrize("name", ["recorded", "measured_findings", "two_motions"])
def test_any_run_can_be_typeset(name: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    findings = request.getfixturevalue(name)
    report = main_report(findings)
    words = " ".join(read(pdf_of(report), tmp_path).split()).replace("’", "'")
    for section in report.content["appendices"]:
        assert section["title"] in words


@pytest.mark.parametrize("level", ["element", "term", "energy"])
def test_every_level_is_typeset(level: str, by_level: dict[str, Findings], tmp_path: Path) -> None:
    words = " ".join(read(pdf_of(main_report(by_level[level])), tmp_path).split()).replace("’", "'")
    assert ("By [FGL87]'s own method" in words) == (level != "element")
    assert ("follow from Lagrange" in words) == (level == "energy")


def test_typst_errors_are_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "broken.typ").write_text("#sys.inputs.nowhere")
    monkeypatch.setattr(pdf, "_TEMPLATES", tmp_path)
    with pytest.raises(GdAnalyzeError, match=r"broken\.typ[\s\S]*nowhere"):
        typeset("broken.typ", {}, {}, NOW)


def test_any_result_can_be_typeset(tmp_path: Path) -> None:
    table = Table("t", "Things", (Column("torque", [1.5, None], "N m"),), values={"y": [1, 2]})
    result = Result("Title", headline="Said.", parts=(table,), provenance={"created": NOW})
    words = read(pdf_of(result_document(result)), tmp_path)
    assert "Things" in words
    assert "1.5" in words
