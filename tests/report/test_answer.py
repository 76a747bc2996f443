"""The answer: shares of the matrix and the bars, lists, and equations by element, against the arrays."""

from __future__ import annotations

import dataclasses
import re
from collections import defaultdict

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.figures.figure import Area
from gd_analyze.figures.structure import cells, matrix_figure, shares_of_torque
from gd_analyze.formulas.formula import CircularFunction, Power
from gd_analyze.operations.program import program_inputs
from gd_analyze.report.budget import BudgetPath, summands
from gd_analyze.report.element_details import element_details
from gd_analyze.report.html import page_of
from gd_analyze.report.main_report import main_report
from gd_analyze.result import Fact
from gd_analyze.results.model_facts import FEEDFORWARD_ONLY, H_NOTE, headline, structure_note
from gd_analyze.results.run_facts import elements_by_verdict, notes, notices, stop_rows
from gd_analyze.simplification.torque_program import ROUGH, torque_program
from gd_analyze.text import percent
from gd_analyze.types import Findings
from page_reader import Page

EPS = np.finfo(float).eps


def test_areas_are_shares_of_peak_torque(puma_findings: Findings) -> None:
    figure, dataset = matrix_figure(puma_findings), puma_findings.decomposition
    peaks = np.abs(dataset.torque.values).max(axis=0)
    largest = np.abs(dataset.gravity_loading.values).max(axis=0) / peaks
    areas = {}
    for panel in figure.panels:
        # The first area is the cell itself.
        drawn = [item for item in panel.items if isinstance(item, Area)][1:]
        areas[panel.key] = sum(float(np.ptp(area.x) * (area.far - area.near)[0]) for area in drawn)
    ratio = areas["c2"] / areas["c3"]
    # Widths and heights are differences of numbers of the cell's size.
    assert ratio == pytest.approx(largest[1] / largest[2], rel=1e4 * EPS)


def test_diagonal_cells_hold_their_drives(puma_findings: Findings) -> None:
    of, dataset = cells(puma_findings), puma_findings.decomposition
    whole = np.abs(dataset.inertia.values.sum(axis=1)[:, 5, 5] * dataset.qdd.values[:, 5])
    whole = whole + np.abs(dataset.drive_torque.values[:, 5])
    peak = np.abs(dataset.torque.values[:, 5]).max()
    # D66 is constant, so that links and drive reach their peaks at one set point.
    assert of["D66"].share == pytest.approx(whole.max() / peak, rel=1e-12)
    for cell in of.values():
        assert sum(cell.parts.values()) == pytest.approx(1.0 if cell.parts else 0.0, abs=8 * EPS)
        assert ("drives" in cell.parts) == (cell.label in [f"D{k}{k}" for k in range(1, 7)])


def test_bars_are_shares_of_the_sum_of_rms(puma_findings: Findings) -> None:
    dataset, shares = puma_findings.decomposition, shares_of_torque(puma_findings)
    rms = {
        "gravity": dataset.gravity_loading.values,
        "drives": dataset.drive_torque.values,
    }
    for k, effect in enumerate(("translation", "rotation")):
        rms[effect] = (dataset.inertia.values[:, k] @ dataset.qdd.values[..., None])[..., 0]
        rms[f"h_{effect}"] = dataset.coriolis_centrifugal.values[:, k]
    sizes = {name: np.sqrt((values**2).mean(axis=0)) for name, values in rms.items()}
    total = sum(sizes.values())
    for name, size in sizes.items():
        # Sums of 31 squares and six parts.
        np.testing.assert_allclose(shares[name], size / total, rtol=0, atol=1e3 * EPS)


def test_every_element_is_in_one_list(puma_findings: Findings) -> None:
    facts = {part.key: part for part in elements_by_verdict(puma_findings).parts if isinstance(part, Fact)}
    # Elements of which only the drive counts are named in words.
    words = facts.pop("drives").written
    facts.pop("text")  # says how many of the text's verdicts agree
    listed = [label for fact in facts.values() for label in fact.value]
    listed += re.findall(r"D\d\d", words)
    assert sorted(listed) == sorted(puma_findings.dominance.element.values.tolist())
    assert [*element_details(puma_findings)][:7] == [
        *(f"D1{j}" for j in range(1, 7)),
        "D22",
    ]


def test_elements_that_the_model_drops_are_marked(puma_findings: Findings) -> None:
    facts = {part.key: part for part in elements_by_verdict(puma_findings).parts if isinstance(part, Fact)}
    written = {
        line.split(" = ")[0] for line in str(puma_findings.model.equations).splitlines() if line[0] in "Dhc"
    }
    listed = [label for key in ("translation", "rotation", "both", "gravity") for label in facts[key].value]
    dropped = [label for label in listed if label not in written]
    marked = [
        name.removesuffix("°") for fact in facts.values() for name in re.findall(r"\w+°", str(fact.text))
    ]
    assert sorted(marked) == sorted(dropped)
    assert dropped
    # Said once.
    assert [fact.note for fact in facts.values()].count("° not in the model") == 1


def value(power: Power, q: np.ndarray, qd: np.ndarray) -> float:
    """A factor of a term at a state."""
    base, exponent = power
    if isinstance(base, CircularFunction):
        angle = sum(weight * q[int(one.base.index) - 1] for weight, (one,) in base.argument)
        return {"cos": np.cos, "sin": np.sin}[base.name](angle) ** exponent
    if base.letter == "q":
        return qd[int(base.index) - 1] ** exponent
    angle = sum(q[int(digit) - 1] for digit in base.index)
    return {"C": np.cos, "S": np.sin}[base.letter](angle) ** exponent


def test_equations_by_element_are_the_model(puma_findings: Findings) -> None:
    path, model, rng = BudgetPath.of(puma_findings), puma_findings.model, np.random.default_rng(2)
    q, qd = rng.uniform(-3.0, 3.0, 6), rng.uniform(-1.0, 1.0, 6)
    found: dict[str, float] = defaultdict(float)
    for formula in path.formulas(puma_findings, path.asked):
        for factors, velocities, weight in summands(formula):
            powers = (value(power, q, qd) for power in (*factors, *velocities))
            found[f"{formula.left.letter}{formula.left.index}"] += weight * np.prod([*powers])
    inertia = np.zeros((6, 6))
    for i, j in zip(*np.triu_indices(6), strict=True):
        inertia[i, j] = found[f"D{i + 1}{j + 1}"] + (i == j) * found[f"J{i + 1}"]
    vectors = {
        "h": model.coriolis_centrifugal(q, qd),
        "c": model.gravity_loading(q),
    }
    # Sums of tens of terms up to the largest entry, in another order.
    near = 200 * EPS * np.abs(inertia).max()
    np.testing.assert_allclose(inertia, np.triu(model.inertia(q)), rtol=0, atol=near)
    for letter, values in vectors.items():
        own = [found[f"{letter}{k}"] for k in range(1, 7)]
        np.testing.assert_allclose(own, values, rtol=0, atol=200 * EPS * np.abs(values).max())


def test_two_notices_stand_before_the_answer(puma_findings: Findings) -> None:
    warned = dataclasses.replace(puma_findings, warnings=("one", "two", "three"))
    report = main_report(warned).content
    assert len(report["notices"]) == 2
    assert {"one", "two", "three"} <= {*report["notices"], *report["notes"]}


def test_every_notice_and_note_stands_in_the_report(puma_findings: Findings) -> None:
    """However few of them stand before the answer."""
    for warnings in ((), ("one",), ("one", "two", "three")):
        warned = dataclasses.replace(puma_findings, warnings=warnings)
        report = main_report(warned).content
        assert [*report["notices"], *report["notes"]] == [*warnings, *notices(warned), *notes(warned)]
        assert {*notes(warned)} <= {*report["notes"]}


def test_named_budgets_are_stops_of_the_slider(puma_findings: Findings) -> None:
    stops, budgets = puma_findings.tables["stops"], puma_findings.tables["budgets"]
    page = Page(page_of(main_report(puma_findings)))
    buttons = [button for button in page.all("button") if "data-stop" in button]
    assert [int(button["data-stop"]) for button in buttons] == stops.position.values.tolist()
    assert [button["aria-pressed"] for button in buttons].count("true") == 1
    words = " ".join(page.text.split())
    for row in stops.to_dataframe().itertuples():
        apart = f"D, h, c {row.operations_apart}/{row.sines_cosines_apart}"
        torque = f"torque {row.operations}/{row.sines_cosines}"
        assert f"{row.terms} terms; {apart}, {torque};" in words
        # The position is that of the named budget's own model.
        kept = budgets.isel(position=row.position)
        assert int(kept.kept.sum()) == row.terms
        for name in ("operations", "operations_apart", "sines_cosines", "sines_cosines_apart"):
            assert int(kept[name]) == getattr(row, name)
        assert row.budget == str(kept.budget.values)
        assert 0.0 < row.proven_share <= 1.0


def test_a_budget_that_was_not_searched_says_why(puma_findings: Findings) -> None:
    stops = puma_findings.tables["stops"].copy(deep=True)
    stops.terms[1:], stops.position[1:], stops.proven_share[1:] = -1, -1, np.nan
    stops.terms_beyond[1], stops.terms_beyond[2] = 481, -1
    stops["unsearched"] = ("stop", ["", "terms", "terms"])
    shown = dataclasses.replace(puma_findings, tables={**puma_findings.tables, "stops": stops})
    page = Page(page_of(main_report(shown)))
    buttons = [button for button in page.all("button") if "data-stop" in button]
    assert ["disabled" in button for button in buttons] == [False, True, True]
    words = " ".join(page.text.split())
    assert "481 terms" in words
    assert "-1 terms" not in words
    for reason, told in (("log", "as the log contradicts the file"), ("time", "as the time is over")):
        stops["unsearched"] = ("stop", ["", reason, "terms"])
        assert told in stop_rows(shown)[1]["words"]
    assert stop_rows(shown)[2]["words"] == "too many terms matter"


def test_the_budget_of_a_model_with_errors_above_its_bound_is_not_called_proven(
    puma_findings: Findings,
) -> None:
    stops = puma_findings.tables["stops"].copy(deep=True)
    stops.proven_share[1] = 1.16
    shown = dataclasses.replace(puma_findings, tables={**puma_findings.tables, "stops": stops})
    said = {row["budget"]: row["words"] for row in stop_rows(shown)}
    assert said[str(stops.budget.values[1])].endswith("not proven")
    assert said[str(stops.budget.values[2])].endswith("(proven)")
    assert "not proven" in BudgetPath.of(shown).proofs(shown)[int(stops.position[1])]


def test_h_and_gamma_are_explained_before_the_equations(puma_findings: Findings) -> None:
    model = puma_findings.model
    gamma = model.accuracy.gamma
    assert gamma is not None
    assert gamma < 1.0
    words = " ".join(Page(page_of(main_report(puma_findings))).text.split())
    places = [
        words.index(said)
        for said in (
            H_NOTE.replace("`", ""),
            f"Mass matrix within {percent(gamma)} of",
            "those not listed are zero",
        )
    ]
    assert places == sorted(places)
    unfit = dataclasses.replace(model, accuracy=dataclasses.replace(model.accuracy, gamma=1.5))
    assert FEEDFORWARD_ONLY in structure_note(unfit)
    assert FEEDFORWARD_ONLY.capitalize() in headline(unfit)
    assert FEEDFORWARD_ONLY not in structure_note(model) + headline(model)


def test_every_position_errs_as_the_table_says(puma_findings: Findings) -> None:
    """The terms shown at a position, mirror terms of D included, have the errors of its row."""
    path, model, dataset = BudgetPath.of(puma_findings), puma_findings.model, puma_findings.decomposition
    states = [dataset[name].values for name in ("q", "qd", "qdd")]
    exact = dataset.torque.values
    for k, row in enumerate(path.rows):
        torques = path.torques(puma_findings, k)
        program = torque_program(model.form.velocities, torques, ROUGH)
        made = program.run(program_inputs(gd.types.States(*states))).T
        error = np.abs(made - exact).max(axis=0)
        # Torques are sums of up to some hundred products, in another order than the table's program.
        near = 1000 * EPS * np.abs(exact).max()
        np.testing.assert_allclose(error, row["largest_error"], rtol=0, atol=near)
