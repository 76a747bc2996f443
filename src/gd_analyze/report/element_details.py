"""Every element by itself, for the page that opens it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gd_analyze.arrays import evenly
from gd_analyze.dynamics.dominance import elements
from gd_analyze.dynamics.dominance_over_time import verdicts
from gd_analyze.figures.elements import subscripted
from gd_analyze.figures.structure import Cell, cells
from gd_analyze.formulas.formula import Formula, Product
from gd_analyze.formulas.languages import Plain
from gd_analyze.report.budget import summands
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import changes_text, element_rows
from gd_analyze.text import amount, percent, pretty

# Most terms of an exact equation that the page writes out.
_MOST_TERMS = 16
# Most columns of dominance over time.
_MOST_COLUMNS = 120
# Digits of verdicts in the strip of an element.
_MARKS = ("zero", "negligible", "translation", "rotation", "both", "drive")


def element_details(findings: Findings) -> dict[str, dict[str, str]]:
    """Every element by its label: words, dominance over time, exact and kept equation.

    "cell" is what its cell of the matrix says when pointed at, and to screen readers.
    """
    cells_by_label, rows = cells(findings), {row["element"]: row for row in element_rows(findings)}
    over_time = findings.tables["dominance_over_time"]
    over_time = over_time.isel(time=evenly(over_time.sizes["time"], _MOST_COLUMNS))
    marks = np.argmax(verdicts(over_time).values[..., None] == np.array(_MARKS), axis=-1)
    at = dict(zip(over_time.element.values.tolist(), marks.T.tolist(), strict=True))
    # An arm of too many terms has none that are ranked, and some levels have no terms.
    model, ranked = findings.model, findings.ranked_terms
    exact = dict(_plain(model.by_element(ranked).formulas)) if ranked else None
    simplified = dict(_plain(model.equations.formulas)) if model.has_terms else None
    out = {}
    for element in elements(findings.arm.n_joints):
        label = element.label
        row, cell = rows[label], cells_by_label[label]
        share = f"{percent(cell.share)} of peak torque of joint {cell.joint}"
        out[label] = {
            "cell": f"{label}, {cell.verdict}, {share}{', with its drive' if 'drives' in cell.parts else ''}",
            "name": subscripted(label),
            "words": _words(row, cell),
            "changes": changes_text(row),
            "over_time": "" if label[0] == "c" else "".join(map(str, at[label])),
        }
        if exact is not None:
            out[label]["exact"] = exact.get(label, "0")
        if simplified is not None:
            out[label]["simplified"] = simplified.get(label, "0")
    return out


def _words(row: dict[str, Any], cell: Cell) -> str:
    """Parts and torque of an element in two sentences."""
    verdict = {"drive": "its drive counts, its links are negligible", "both": "both effects count"}
    finding = verdict.get(cell.verdict, cell.verdict)
    if cell.verdict in ("translation", "rotation"):
        finding = f"{cell.verdict} dominates"
    parts = [pretty(amount(row[f"part_peak_{name}"], row["unit"])) for name in ("translation", "rotation")]
    if row["quantity"] == "gravity_loading":
        split = f"up to {parts[0]}"
    else:
        split = f"translation up to {parts[0]}, rotation up to {parts[1]}"
    torque = pretty(amount(row["torque_peak"], row["torque_unit"]))
    words = f"{finding[:1].upper()}{finding[1:]}: {split} at the set points."
    words += f" Torque up to {torque} at joint {row['torque_joint']}"
    words += f", {percent(row['torque_share'])} of its peak torque."
    if "drives" in cell.parts:
        drive = pretty(amount(row["drive"], row["unit"]))
        words += f" Its drive has {drive}; with it the torque reaches {percent(cell.share)}."
    return words


def _plain(formulas: tuple[Formula, ...]) -> Iterator[tuple[str, str]]:
    """Labels and right-hand sides of elements in plain characters, the largest terms first."""
    plain = Plain()
    for formula in formulas:
        terms = sorted(summands(formula), key=lambda summand: -abs(summand.weight))
        out = ""
        for factors, velocities, weight in terms[:_MOST_TERMS]:
            sign = "−" if weight < 0.0 else "+" if out else ""
            space = " " if out else ""
            out += f"{space}{sign}{space}{plain.product(Product(abs(weight), factors + velocities))}"
        if len(terms) > _MOST_TERMS:
            out += f" + {len(terms) - _MOST_TERMS} smaller terms"
        yield f"{formula.left.letter}{formula.left.index}", pretty(out)
