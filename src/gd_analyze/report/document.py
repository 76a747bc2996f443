"""The PDF's words and numbers as JSON values, formatted and ordered; the template only lays them out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gd_analyze.formatting import aligned, figures, hundredths, percent, pretty
from gd_analyze.formulas.parts import part_symbol
from gd_analyze.formulas.typst import Typst
from gd_analyze.formulas.writing import term_formula
from gd_analyze.labels import inertia_label, joined
from gd_analyze.operations import OperationCount
from gd_analyze.report.arm_data import arm_data
from gd_analyze.report.harmonic_data import equation_data, harmonic_data
from gd_analyze.report.panel import MOST_POINTS
from gd_analyze.report.terms import ranked_rows
from gd_analyze.results import Findings, rows_of, summary
from gd_analyze.results.rows import Row, dropped_parts, element_rows, joint_rows, trade_off_rows
from gd_analyze.results.words import LETTERS, SYMBOLS, VERDICTS, kind_name, told

# Rows of the ranking of single terms, and the longest budget that a table has room for.
_TERMS, _LONGEST_BUDGET = 20, 12
_TYPST = Typst()


def document(findings: Findings) -> dict[str, Any]:
    """Everything the template shows but the figures."""
    arm, model, tables = findings.arm, findings.model, findings.tables
    count = findings.trajectory.n_set_points
    ranked = element_rows(findings)
    return {
        **summary.opening(findings),
        "letters": LETTERS,
        "n_joints": arm.n_joints,
        "n_set_points": count,
        "thinned_to": MOST_POINTS if count > MOST_POINTS else 0,
        "all_turning": all(arm.is_revolute),
        "warnings": list(findings.warnings),
        "budget": model.promise.budget,
        "is_mechanical": model.level.is_mechanical,
        "refitted": model.refitted,
        "drives": model.drives,
        "search": model.promise.search,
        "operations": _operations(model.operations_full, model.operations),
        "joints": _joints(findings),
        "harmonic": harmonic_data(model),
        "elements": _elements(findings),
        "kept": _kept_matrix({row["element"]: told(row, "kept") for row in ranked}, arm.n_joints),
        "dominance": _dominance(findings, ranked),
        "threshold": percent(float(findings.dominance.attrs["threshold"])),
        "verdicts": [
            f"{number} {VERDICTS[verdict]}"
            for verdict in VERDICTS
            if (number := summary.verdict_counts(findings).get(verdict))
        ],
        "text": _text(findings),
        "trade_off": _trade_off(findings),
        "terms": _terms(findings),
        "beyond": _beyond(findings),
        "cross_check": [
            {
                "symbol": SYMBOLS[row["quantity"]],
                "quantity": row["quantity"].replace("_", " "),
                "largest_difference": figures(row["largest_difference"]),
                "round_off_bound": figures(row["round_off_bound"]),
                "unit": pretty(row["unit"]),
            }
            for row in rows_of(tables["cross_check"], "comparison")
        ],
        "arm": arm_data(arm),
        "run": findings.provenance.get("run", ""),
        "provenance": [
            [label.replace("_", " "), value] for label, value in summary.provenance_lines(findings)
        ],
    }


def _formatted(rows: list[Row], *same: str, **formats: Callable[[Row], str]) -> list[Row]:
    """Rows as the template lays them out: some values as they are, others written so that points align."""
    columns = {name: aligned(map(write, rows)) for name, write in formats.items()}
    return [
        {name: row[name] for name in same} | {name: column[k] for name, column in columns.items()}
        for k, row in enumerate(rows)
    ]


def _torque(name: str, noise: float = 0.0) -> Callable[[Row], str]:
    """Write three digits; a dash where nothing can be said, and whether it is nothing but round-off."""

    def write(row: Row) -> str:
        value = row[name]
        return "–" if value is None else "≈ 0" if 0.0 < value <= noise else figures(value)

    return write


def _share(name: str, findings: Findings, joint: str = "joint") -> Callable[[Row], str]:
    """Write percent of a joint's peak torque; a dash where nothing is known or that torque is round-off."""
    peaks = findings.model.promise.errors.peak_torque

    def write(row: Row) -> str:
        share = row[name]
        known = share is not None and (share == 0 or peaks[row[joint] - 1] > findings.round_off)
        return hundredths(share) if known else "–"

    return write


def _joints(findings: Findings) -> list[Row]:
    noise = findings.round_off
    rows = joint_rows(findings, "simplified_model", "beyond")
    errors = ("peak_torque", "allowed_error", "largest_error", "rms_error", "certified", "worst_found")
    elsewhere = ("within_limits", "torque_per_kg", "uncertainty")
    shares = ("largest_share", "certified_share", "within_limits_share")
    written = _formatted(
        rows,
        "joint",
        "joint_name",
        **{name: _torque(name, noise) for name in errors},
        **{name: _torque(name) for name in elsewhere},
        mass_within_budget=lambda row: _any_or(row["mass_within_budget"]),
        **{name: _share(name, findings) for name in shares},
    )
    for row, shown in zip(rows, written, strict=True):
        largest, allowed = row["largest_error"], row["allowed_error"]
        shown["effort_unit"] = pretty(row["effort_unit"])
        shown["used"] = min(largest / allowed, 1.0) if largest > noise else 0.0
        shown["over"] = largest > max(allowed, noise)
    return written


def _any_or(mass: float) -> str:
    return figures(mass) if mass < float("inf") else "any"


def _kept_matrix(kept: dict[str, str], n_joints: int) -> list[list[str]]:
    """What is kept of D, h and c in the row of every joint."""
    every = range(n_joints)
    return [
        [kept[inertia_label(i, j)] for j in every] + [kept[f"{vector}{joined((i,))}"] for vector in "hc"]
        for i in every
    ]


def _operations(full: OperationCount, left: OperationCount) -> list[dict[str, str]]:
    return [
        {
            "what": what,
            "full": str(before),
            "model": str(after),
            "saved": f"{100 * (1 - after / before):.1f}" if before else "0.0",
        }
        for what, before, after in (
            ("multiplications", full.multiplications, left.multiplications),
            ("additions", full.additions, left.additions),
            ("both", full.total, left.total),
            ("sines and cosines", full.sines_cosines, left.sines_cosines),
        )
    ]


def _dominance(findings: Findings, rows: list[Row]) -> list[Row]:
    written = _formatted(
        rows,
        "rank",
        "element",
        "torque_joint",
        "text_verdict",
        peak=_torque("peak"),
        change_without_translation=lambda row: _change(row["change_without_translation"]),
        change_without_rotation=lambda row: _change(row["change_without_rotation"]),
        torque_peak=_torque("torque_peak"),
        torque_share=_share("torque_share", findings, "torque_joint"),
    )
    for row, shown in zip(rows, written, strict=True):
        shown |= {
            "unit": pretty(row["unit"]),
            "torque_unit": row["torque_unit"],
            "is_split": row["quantity"] != "gravity_loading",
            **{what: told(row, what) for what in ("dominant", "verdict", "kept")},
            "agrees": row["dominant"] == row["text_verdict"],
        }
    return written


def _change(share: float) -> str:
    """Percent without decimals; parts that cancel can change an element by far more than its peak."""
    value = 100 * share
    return "0" if value == 0 else "< 1" if value < 1 else f"{value:.0f}" if value < 1e4 else "> 9999"


def _text(findings: Findings) -> dict[str, Any] | None:
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


def _elements(findings: Findings) -> dict[str, Any]:
    """The model by the founding text's own method, and what it leaves out by reason."""
    model, dropped = findings.element_model, dropped_parts(findings)
    costing = _formatted(
        dropped.costing,
        "torque_joint",
        "torque_unit",
        torque_peak=_torque("torque_peak"),
        torque_share=_share("torque_share", findings, "torque_joint"),
    )
    for row, shown in zip(dropped.costing, costing, strict=True):
        within = row["torque_peak"] <= model.promise.allowed[row["torque_joint"] - 1]
        shown["math"] = _part(row)
        shown["why"] = "within the allowance by itself" if within else "cancels against other dropped parts"
    return {
        "equations": [equation_data(formula) for formula in model.formulas],
        "budget": model.promise.budget,
        "operations": _operations(model.operations_full, model.operations),
        "saves": model.saves,
        "count": model.operations.total,
        "exact": model.operations_full.total,
        "costing": costing,
        "zero": [*map(_part, dropped.zero)],
        "idle": [*map(_part, dropped.idle)],
    }


def _part(row: Row) -> str:
    return _TYPST.symbol(part_symbol(*row["part"].split()))


def _trade_off(findings: Findings) -> dict[str, Any]:
    """Describe operations and error of every kind of model, by budget."""
    model, kinds = findings.model, rows_of(findings.tables["trade_off"], "kind")
    return {
        "kinds": [kind_name(kind["level"], kind["refit"]) for kind in kinds],
        "rows": [
            {
                "budget": pretty(row["budget"])
                if len(row["budget"]) <= _LONGEST_BUDGET
                else f"budget × {row['factor']:g}",
                "asked": row["asked"],
                "operations": [*map(str, row["operations"])],
                "errors": [*map(hundredths, row["largest_share"])],
            }
            for row in trade_off_rows(findings)
        ],
        "operations": model.operations.total,
        "error": percent(float(model.promise.errors.largest_share.max(initial=0.0))),
    }


def _terms(findings: Findings) -> dict[str, Any]:
    """Describe the single terms that matter most, and how many lie within the parameters' uncertainty."""
    rows = ranked_rows(findings, _TERMS)
    written = _formatted(
        rows,
        "rank",
        "alone_joint",
        "alone_unit",
        "without_joint",
        alone_torque=_torque("alone_torque"),
        alone_share=_share("alone_share", findings, "alone_joint"),
        without_share=lambda row: hundredths(row["without_share"]),
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


def _beyond(findings: Findings) -> dict[str, Any]:
    """Describe what the model does away from the set points; the joints' own numbers are among theirs."""
    rows = joint_rows(findings, "simplified_model", "beyond")
    ratio = summary.bound_ratio(findings)
    payload = min(rows, key=lambda row: row["mass_within_budget"])
    limited = payload["mass_within_budget"] != float("inf")
    certified = [row for row in rows if row["certified"] is not None]
    return {
        "certified": bool(certified),
        "within": sum(row["certified"] <= row["allowed_error"] for row in certified),
        "ratio": "" if ratio is None else f"{ratio:.2f}",
        "drawn": findings.tables["beyond"].attrs["states_drawn"],
        "uncertain": rows[0]["uncertainty"] is not None,
        "largest_mass": _any_or(payload["mass_within_budget"]),
        "limiting_joint": payload["joint"] if limited else None,
    }
