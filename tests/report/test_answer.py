"""The answer: shares of the matrix and the bars, lists, and equations by element, against the arrays."""

from __future__ import annotations

import dataclasses
from collections import defaultdict

import numpy as np
import pytest
import xarray as xr
from page_reader import Page

from gd_analyze.figures.figure import Area
from gd_analyze.figures.structure import cells, matrix_figure, shares_of_torque
from gd_analyze.formulas.formula import Function, Power
from gd_analyze.report.answer import element_details, verdict_lists
from gd_analyze.report.budget import BudgetPath, summands
from gd_analyze.report.main_page import render_html
from gd_analyze.report.main_report import main_report
from gd_analyze.results.findings import Findings

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
        "velocity": dataset.coriolis_centrifugal.values.sum(axis=1),
        "drives": dataset.drive_torque.values,
    }
    for k, effect in enumerate(("translation", "rotation")):
        rms[effect] = (dataset.inertia.values[:, k] @ dataset.qdd.values[..., None])[..., 0]
    sizes = {name: np.sqrt((values**2).mean(axis=0)) for name, values in rms.items()}
    total = sum(sizes.values())
    for name, size in sizes.items():
        # Sums of 31 squares and five parts.
        np.testing.assert_allclose(shares[name], size / total, rtol=0, atol=1e3 * EPS)


def test_every_element_is_in_one_list(puma_findings: Findings) -> None:
    listed = [label for group in verdict_lists(puma_findings) for label in group.elements]
    assert sorted(listed) == sorted(puma_findings.dominance.element.values.tolist())
    assert [one["label"] for one in element_details(puma_findings)][:7] == [
        *(f"D1{j}" for j in range(1, 7)),
        "D22",
    ]


def value(power: Power, q: np.ndarray, qd: np.ndarray) -> float:
    """A factor of a term at a state."""
    base, exponent = power
    if isinstance(base, Function):
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
    report = main_report(warned)
    assert len(report.opening.notices) == 2
    assert {"one", "two", "three"} <= {*report.opening.notices, *report.notes}


def test_named_budgets_are_stops_of_the_slider(puma_findings: Findings) -> None:
    stops = xr.Dataset(
        {
            "budget": ("stop", ["1%", "1% or 10% friction"]),
            "terms": ("stop", [34, 15]),
            "operations": ("stop", [78, 30]),
            "proven_share": ("stop", [0.0095, 0.04]),
            "position": ("stop", [10, -1]),
        }
    )
    unnamed = Page(render_html(puma_findings))
    assert not [button for button in unnamed.all("button") if "data-stop" in button]
    shown = dataclasses.replace(puma_findings, tables={**puma_findings.tables, "stops": stops})
    page = Page(render_html(shown))
    buttons = [button for button in page.all("button") if "data-stop" in button]
    assert [button["data-stop"] for button in buttons] == ["10", "-1"]
    assert ["disabled" in button for button in buttons] == [False, True]
    assert "15 terms, 30 operations" in " ".join(page.text.split())
