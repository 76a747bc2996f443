from __future__ import annotations

import dataclasses
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_cases import HOSTILE, made_findings, resting_findings

from gd_analyze.dominance import text_verdicts
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.formatting import (
    aligned,
    amount,
    figures,
    fitting,
    percent_cell,
    prefixed,
    pretty,
    rounded_up,
)
from gd_analyze.formulas.parts import part_symbol
from gd_analyze.formulas.typst import Typst
from gd_analyze.formulas.writing import term_formula
from gd_analyze.levels import Budget
from gd_analyze.levels.parts import parts_of
from gd_analyze.main_job import Settings, find
from gd_analyze.report.colours import TEMPLATES
from gd_analyze.report.document import document
from gd_analyze.report.numbering import numbering
from gd_analyze.report.pdf import prepare_pdf, report_figures, typeset
from gd_analyze.results import Findings, summary
from gd_analyze.results.contributions import Contributions
from gd_analyze.results.words import CONTRIBUTIONS
from gd_analyze.robots import RobotArm
from gd_analyze.robots.parts import JointKind
from gd_analyze.trajectories import Trajectory

EIGHT: list[JointKind] = [*("prismatic",) * 5, *("revolute",) * 3]
NOW = "2024-05-01T00:00:00+00:00"


def read(pdf: bytes, folder: Path, *options: str) -> str:
    """What a reader can select and copy, without line ends."""
    program = shutil.which("pdftotext")
    if program is None:
        pytest.skip("pdftotext (poppler-utils) is not installed")
    path = folder / "report.pdf"
    path.write_bytes(pdf)
    done = subprocess.run([program, *options, str(path), "-"], capture_output=True, check=True, text=True)
    return " ".join(done.stdout.replace("\f", " \f ").split(" ")).replace("\n", " ")


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
    errors = puma_findings.model.promise.errors.largest
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


@pytest.fixture(scope="module")
def by_level(puma: RobotArm, pick_and_place: Trajectory) -> dict[str, Findings]:
    return {
        "element": find(puma, pick_and_place, Settings(level="element", drives=True)),
        "energy": find(puma, pick_and_place, Settings(level="energy", refit=True)),
        "term": find(puma, pick_and_place, Settings(operations=90)),
    }


def test_document_is_plain_json_and_names_every_kept_part(puma_findings: Findings) -> None:
    data = json.loads(json.dumps(document(puma_findings), allow_nan=False))["elements"]
    written = {
        piece["math"].removeprefix("paren.l ").partition(" ")[0]
        for row in data["equations"]
        for group in row["groups"]
        for piece in group
    }
    model = puma_findings.element_model
    for part in model.terms:
        element, *effect = part.label.split()
        symbols = {Typst().symbol(part_symbol(element, *effect)), Typst().symbol(part_symbol(element))}
        assert symbols & written, part.label
    gone = {*(row["math"] for row in data["costing"]), *data["zero"], *data["idle"]}
    assert len(gone) == len(parts_of(model.arm.n_joints)) - len(model.terms)
    assert not gone & written


def test_drives_stand_on_the_diagonal(by_level: dict[str, Findings]) -> None:
    equations = document(by_level["element"])["elements"]["equations"]
    for i, row in enumerate(equations):
        (drive,) = [piece["math"] for group in row["groups"] for piece in group if "J" in piece["math"]]
        joint = i + 1
        assert drive.replace("paren.r ", "") == f"J_({joint}) thin dot.double(q)_({joint})"


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


def test_harmonic_equations_hold_every_kept_term(by_level: dict[str, Findings]) -> None:
    term, energy = by_level["term"].model, by_level["energy"].model
    for model, findings, kept in (
        (term, by_level["term"], len(term.torques)),
        (energy, by_level["energy"], len(energy.terms)),
    ):
        data = document(findings)["harmonic"]
        pieces = [piece for row in data["equations"] for group in row["groups"] for piece in group]
        carried = sum(piece["math"].startswith("tau") for piece in pieces)
        nothing = sum(piece["math"] == "0" for piece in pieces)
        assert len(pieces) - carried - nothing == kept, model.level
        counted = [entry for row in data["kept"] for entry in row if entry]
        assert sum(entry["kept"] for entry in counted) == kept
    exact = [entry for row in document(by_level["term"])["harmonic"]["kept"] for entry in row]
    assert sum(entry["of"] for entry in exact) == by_level["term"].tables["terms"].attrs["total"]


def test_element_level_has_no_harmonic_equations(by_level: dict[str, Findings]) -> None:
    assert document(by_level["element"])["harmonic"] is None


def test_trade_off_marks_the_budget_asked_for(puma_findings: Findings) -> None:
    data = document(puma_findings)["trade_off"]
    assert [row["budget"] for row in data["rows"] if row["asked"]] == [puma_findings.model.promise.budget]
    assert data["operations"] == puma_findings.model.operations.total
    for row in data["rows"]:
        assert len(row["operations"]) == len(row["errors"]) == len(data["kinds"])


def test_a_budget_by_joint_does_not_widen_the_table(puma: RobotArm, pick_and_place: Trajectory) -> None:
    findings = find(puma, pick_and_place, Settings(budget=Budget.parse("1%,2%,1%,2%,1%,2%"), level="element"))
    assert {row["budget"] for row in document(findings)["trade_off"]["rows"]} >= {"budget × 1", "budget × 5"}


def test_single_terms_come_as_ranked(puma_findings: Findings) -> None:
    data = document(puma_findings)["terms"]
    ranked = puma_findings.ranked_terms
    assert data["total"] == len(ranked)
    assert [row["rank"] for row in data["rows"]] == [*range(1, len(data["rows"]) + 1)]
    for row, (term, weight) in zip(data["rows"], ranked.items(), strict=False):
        formula = term_formula(term, weight)
        assert ("-" if row["negative"] else "") + row["math"] == Typst().right(formula)
        assert row["negative"] == (weight < 0)


def test_beyond_says_what_is_proven_and_what_is_not(puma_findings: Findings) -> None:
    shown, certified = document(puma_findings), puma_findings.tables["beyond"].certified.values
    data = shown["beyond"]
    assert data["within"] == (certified <= puma_findings.model.promise.allowed).sum()
    for row, bound in zip(shown["joints"], certified, strict=True):
        # Never less than the bound, and by less than one in the last of three digits more.
        factor = 1e-3 if row["effort_unit"] == "mN m" else 1.0
        assert bound <= float(row["certified"]["text"]) * factor * (1 + 1e-12)
        assert float(row["certified"]["text"]) * factor < 1.011 * bound
    assert data["drawn"] == puma_findings.tables["beyond"].attrs["states_drawn"] > 0


def test_an_arm_without_limits_has_a_certificate_but_nothing_drawn(tmp_path: Path) -> None:
    findings = made_findings(["revolute", "prismatic"])
    data = document(findings)["beyond"]
    assert data["certified"]
    assert data["drawn"] == 0
    words = " ".join(read(prepare_pdf(findings)(), tmp_path).split())
    assert "nothing is said: the arm does not state all of them" in words


def test_units_follow_the_kind_of_joint() -> None:
    rows = document(made_findings(["revolute", "prismatic"]))["dominance"]
    units = {row["element"]: row["unit"] for row in rows}
    assert units["D11"] == "kg m²"
    assert units["D12"] == "kg m"
    assert units["D22"] == "kg"
    assert (units["h1"], units["h2"]) == ("N m", "N")


def test_other_arms_have_no_verdicts_of_the_text(swing_findings: Findings, tmp_path: Path) -> None:
    assert document(swing_findings)["text"] is None
    assert "Beside the founding text" not in read(prepare_pdf(swing_findings)(), tmp_path)


def test_text_remarks_are_weighed_with_our_numbers(puma_findings: Findings) -> None:
    text = document(puma_findings)["text"]
    dominance, stated = puma_findings.dominance, text_verdicts("puma560").verdicts
    ours = dict(zip(dominance.element.values, dominance.dominant.values, strict=True))
    assert text["agreed"] == sum(ours[element] == verdict for element, verdict in stated.items())
    assert text["given"] == len(stated)
    assert {remark["element"] for remark in text["remarks"]} == {"D45", "D56"}


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (41.0, "41.0"),
        (0.0012, "0.00120"),
        (123.4, "123"),
        (2.1e-14, "2.10 × 10⁻¹⁴"),
        (np.inf, "∞"),
    ],
)
def test_figures(value: float, shown: str) -> None:
    assert figures(value) == shown


def test_percent_has_no_more_digits_than_it_means() -> None:
    shares = (0.0, 1e-6, 0.01234, 1.1502, np.inf)
    assert [*map(percent_cell, shares)] == ["0", "< 0.01", "1.2", "115", "∞"]


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (6.56e-5, "N m", "65.6 µN m"),
        (0.0971, "N m", "97.1 mN m"),
        (41.0, "N m", "41 N m"),
        (12_300.0, "N", "12.3 kN"),
        (4e-5, "kg m^2", "40 mg m^2"),
        (0.02, "kg m", "20 g m"),
        (2.1e-14, "N m", "2.10e-14 N m"),  # round-off is no quantity of the arm
        (0.0, "N m", "0 N m"),
        (1e-5, "kg m^2 or kg m", "1.00e-05 kg m^2 or kg m"),
        (0.01, "deg", "0.01 deg"),
    ],
)
def test_prefixes_stand_in_place_of_powers_of_ten(value: float, unit: str, shown: str) -> None:
    assert amount(value, unit) == shown


@given(st.floats(1e-9, 9.9e6), st.sampled_from(["N m", "N"]))
def test_a_prefix_leaves_one_to_four_digits_before_the_point(value: float, unit: str) -> None:
    factor, shown = prefixed(value, unit)
    assert shown.endswith(unit)
    # Units without a prefix go from a tenth to ten thousand; the factor is a power of ten, rounded once.
    assert value / factor * (1 + 1e-12) >= 0.1
    assert value / factor < 1e4


@given(st.lists(st.floats(1e-6, 1e3), min_size=1, max_size=6))
def test_a_row_in_one_unit_needs_no_powers_of_ten_within_seven_decades(values: list[float]) -> None:
    factor, _ = fitting(values, "N m")
    written = [figures(value / factor) for value in values]
    near = [text for text, value in zip(written, values, strict=True) if value > 1.01e-5 * max(values)]
    assert not any("10" in text and "×" in text for text in near)


def test_aligned_numbers_have_the_same_number_of_decimals() -> None:
    column = aligned(["12", "0.5", "1.25"])
    filled = [(entry["text"] + entry["pad"]).partition(".")[2] for entry in column]
    assert {len(decimals) for decimals in filled} == {2}
