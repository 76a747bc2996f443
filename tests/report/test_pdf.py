from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from pdf_reader import read
from report_cases import HOSTILE, made_findings, resting_findings

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.figures.torques import CONTRIBUTIONS, Contributions
from gd_analyze.report.compiled_templates import TEMPLATES
from gd_analyze.report.document import document
from gd_analyze.report.main_pdf import prepare_pdf, report_figures, typeset
from gd_analyze.report.old_numbering import numbering
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import JointKind
from gd_analyze.text import amount, pretty, rounded_up

EIGHT: list[JointKind] = [*("prismatic",) * 5, *("revolute",) * 3]
NOW = "2024-05-01T00:00:00+00:00"


@pytest.fixture(scope="module")
def puma_pdf(puma_findings: Findings) -> bytes:
    return prepare_pdf(puma_findings)()


def test_first_page_answers_the_question(puma_pdf: bytes, puma_findings: Findings, tmp_path: Path) -> None:
    text = read(puma_pdf, tmp_path, "-l", "1")
    words = " ".join(text.split())
    assert summary.title(puma_findings) in words
    assert summary.headline(puma_findings) in words
    for value, caption in summary.facts(puma_findings):
        assert pretty(value) in words
        assert caption in words
    for warning in puma_findings.warnings:
        assert warning in words
    bounds = puma_findings.tables["tube"].tube_certified.values
    errors = puma_findings.model.accuracy.errors.largest
    for joint, error, bound in zip(puma_findings.arm.joints, errors, bounds, strict=True):
        assert joint.name in words
        assert pretty(amount(error, "N m")) in words
        assert pretty(amount(rounded_up(float(bound)), "N m")) in words
    # What is proven is proven for whom, and what the torque is made of is named.
    assert summary.margins_told(puma_findings) in words
    for name in Contributions.of(puma_findings).parts:
        assert CONTRIBUTIONS[name] in words


def test_every_part_of_the_report_is_there(puma_pdf: bytes, puma_findings: Findings, tmp_path: Path) -> None:
    words = " ".join(read(puma_pdf, tmp_path).split())
    numbers = numbering(puma_findings)
    for heading in (
        "The simplified model",
        "Fewer operations, or less error",
        *(f"{letter} {numbers['titles'][name]}" for name, letter in numbers["appendices"].items()),
        "Beside the founding text",
        "What was dropped, and why",
        "Sources",
        "Assumptions",
        "Provenance",
    ):
        assert heading.replace("'", "’") in words.replace("'", "’"), heading
    for number in range(24, 29):
        assert f"(3.4-{number})" in words


def test_what_is_numbered_is_there_once_and_in_order(
    puma_pdf: bytes, puma_findings: Findings, tmp_path: Path
) -> None:
    words = " ".join(read(puma_pdf, tmp_path).split())
    numbers = numbering(puma_findings)
    for kind, missing in (("figures", {"beyond"}), ("tables", set())):
        captions = [f"{text}." for name, text in numbers[kind].items() if name not in missing]
        places = [words.find(caption) for caption in captions]
        assert -1 not in places, dict(zip(captions, places, strict=True))
        assert places == sorted(places)
        assert all(words.count(caption) == 1 for caption in captions)


def test_two_pages_answer_and_appendices_follow(puma_pdf: bytes, tmp_path: Path) -> None:
    first, second, third, *_ = read(puma_pdf, tmp_path).split("\f")
    assert "Figure 1." in first
    assert "Figure 2." in first
    assert "Table 1." in first
    assert "The simplified model" in second
    assert "Figure 3." in second
    assert " ".join(third.split()).startswith("Unimation PUMA 560")
    assert "A Motion, torque and error over time" in " ".join(third.split())


def test_is_a_pdf_of_a_sane_length_that_says_who_made_it(puma_pdf: bytes) -> None:
    assert puma_pdf.startswith(b"%PDF-")
    assert 9 <= len(re.findall(rb"/Type\s*/Page\b", puma_pdf)) <= 13
    assert b"gd-analyze" in puma_pdf


def test_same_findings_give_the_same_bytes(swing_findings: Findings) -> None:
    assert prepare_pdf(swing_findings)() == prepare_pdf(swing_findings)()


def test_user_text_comes_out_literally(tmp_path: Path) -> None:
    findings = made_findings(["revolute", "prismatic"], title=HOSTILE)
    hostile_link = dataclasses.replace(findings.arm.joints[0], name="#panic() $a_")
    arm = dataclasses.replace(
        findings.arm, joints=(hostile_link, findings.arm.joints[1]), sources=("#eval(x) <b>_",)
    )
    text = " ".join(read(prepare_pdf(dataclasses.replace(findings, arm=arm))(), tmp_path).split())
    assert HOSTILE in text
    assert "#panic() $a_" in text
    assert "#eval(x) <b>_" in text


@pytest.mark.parametrize(
    "made",
    [
        pytest.param(lambda: made_findings(["revolute"]), id="one joint"),
        pytest.param(lambda: made_findings(["prismatic"]), id="one sliding joint"),
        pytest.param(lambda: made_findings(EIGHT), id="eight joints"),
        pytest.param(lambda: made_findings(["prismatic"] * 10), id="ten joints"),
        pytest.param(lambda: made_findings(["revolute"] * 3, set_points=1), id="one set point"),
        pytest.param(lambda: made_findings(["revolute"] * 2, set_points=5000), id="long"),
    ],
)
def test_any_serial_arm_can_be_typeset(made: Callable[[], Findings]) -> None:
    assert prepare_pdf(made())().startswith(b"%PDF-")


def test_an_arm_without_torque_can_be_typeset(puma: RobotArm) -> None:
    findings = resting_findings(puma)
    data = document(findings)
    assert {row["peak_torque"]["text"] for row in data["joints"]} == {"0"}
    assert not any(row["over"] for row in data["joints"])
    assert prepare_pdf(findings)().startswith(b"%PDF-")


def test_no_font_of_the_machine_is_needed(puma_findings: Findings) -> None:
    import typst

    inputs = {"data": json.dumps(document(puma_findings)), **report_figures(puma_findings)}
    _, warnings = typst.compile_with_warnings(
        TEMPLATES / "report.typ", root=TEMPLATES, ignore_system_fonts=True, sys_inputs=inputs
    )
    assert warnings == []


def test_typst_errors_are_passed_on(tmp_path: Path) -> None:
    template = tmp_path / "broken.typ"
    template.write_text("#sys.inputs.nowhere")
    with pytest.raises(GdAnalyzeError, match=r"cannot be typeset[\s\S]*nowhere"):
        typeset(template, {}, {}, NOW)


@pytest.mark.parametrize("level", ["element", "term", "energy"])
def test_every_level_is_typeset_with_its_own_equations(
    level: str, by_level: dict[str, Findings], tmp_path: Path
) -> None:
    findings = by_level[level]
    words = " ".join(read(prepare_pdf(findings)(), tmp_path).split())
    assert ("G By the founding text's own method" in words) == (level != "element")
    assert ("follow by Lagrange" in words) == (level == "energy")
    assert ("refitted to absorb" in words) == findings.model.refitted
    assert summary.margins_told(findings) in words
    assert summary.headline(findings) in words
