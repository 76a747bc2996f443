"""What the PDF says of elements and single terms: rankings, and the founding text's verdicts beside ours."""

from __future__ import annotations

from typing import Any

from gd_analyze.formulas.languages import Typst
from gd_analyze.formulas.writing import term_formula
from gd_analyze.report.cells import formatted, in_fitting_units, share, torque
from gd_analyze.report.terms import ranked_rows
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import Row
from gd_analyze.results.words import SYMBOLS, told
from gd_analyze.text import figures, percent_cell, pretty

# Rows of the ranking of single terms.
_TERMS = 20
_TYPST = Typst()


def elements_ranked(findings: Findings, rows: list[Row]) -> list[Row]:
    """Elements by the torque they move; `rows` are those of `gd_analyze.results.rows.element_rows`."""
    fitting = in_fitting_units(in_fitting_units(rows, "unit", "peak"), "torque_unit", "torque_peak")
    written = formatted(
        fitting,
        "rank",
        "element",
        "torque_joint",
        "text_verdict",
        "unit",
        "torque_unit",
        peak=torque("peak"),
        change_without_translation=lambda row: _change(row["change_without_translation"]),
        change_without_rotation=lambda row: _change(row["change_without_rotation"]),
        torque_peak=torque("torque_peak"),
        torque_share=share("torque_share", findings, "torque_joint"),
    )
    for row, shown in zip(rows, written, strict=True):
        shown |= {
            "is_split": row["quantity"] != "gravity_loading",
            **{what: told(row, what) for what in ("dominant", "verdict", "kept")},
            "agrees": row["dominant"] == row["text_verdict"],
        }
    return written


def _change(share: float) -> str:
    """Percent without decimals; parts that cancel can change an element by far more than its peak."""
    value = 100 * share
    return "0" if value == 0 else "< 1" if value < 1 else f"{value:.0f}" if value < 1e4 else "> 9999"


def founding_text(findings: Findings) -> dict[str, Any] | None:
    """Compare with the founding text: how many verdicts agree, and what our numbers say of its remarks."""
    text = summary.text_comparison(findings)
    if text is None:
        return None
    remarks = [
        {
            "element": row["element"],
            "verdict": row["text_verdict"],
            "remark": remark,
            "translation": figures(row["part_peak_translation"]),
            "rotation": figures(row["part_peak_rotation"]),
            "unit": pretty(row["unit"]),
            "finding": finding,
        }
        for row, remark, finding in text["remarks"]
    ]
    return text | {"remarks": remarks}


def terms_ranked(findings: Findings) -> dict[str, Any]:
    """Describe the single terms that matter most, and how many lie within the parameters' uncertainty."""
    rows = ranked_rows(findings, _TERMS)
    written = formatted(
        in_fitting_units(rows, "alone_unit", "alone_torque"),
        "rank",
        "alone_joint",
        "alone_unit",
        "without_joint",
        alone_torque=torque("alone_torque"),
        alone_share=share("alone_share", findings, "alone_joint"),
        without_share=lambda row: percent_cell(row["without_share"]),
    )
    for row, shown in zip(rows, written, strict=True):
        formula = term_formula(row["term"], row["weight"])
        shown |= {
            "symbol": SYMBOLS[row["quantity"]],
            "row": _TYPST.symbol(formula.left),
            "math": _TYPST.body(formula.pieces[0]),
            "negative": row["weight"] < 0,
            "below_uncertainty": row["below_uncertainty"] == 1,
        }
    return {
        "written_out": findings.is_written_out,
        "total": findings.tables["terms"].attrs["total"],
        "not_worth_keeping": summary.not_worth_keeping(findings),
        "rows": written,
    }
