"""What the PDF says, before it is typeset."""

from __future__ import annotations

import json
from pathlib import Path

from pdf_reader import read
from report_cases import made_findings

from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.formulas.languages import Typst
from gd_analyze.formulas.writing import part_symbol, term_formula
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.report.document import document
from gd_analyze.report.main_pdf import prepare_pdf
from gd_analyze.results.findings import Findings
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import JointKind
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import parts_of
from gd_analyze.studies.main_job import Settings, find

EIGHT: list[JointKind] = [*("prismatic",) * 5, *("revolute",) * 3]


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
    assert [row["budget"] for row in data["rows"] if row["asked"]] == [puma_findings.model.accuracy.budget]
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
    assert data["within"] == (certified <= puma_findings.model.accuracy.allowed).sum()
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
