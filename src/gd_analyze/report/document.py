"""The PDF's words and numbers as JSON values, formatted and ordered; the template only lays them out."""

from __future__ import annotations

import datetime
from typing import Any

import numpy as np

from gd_analyze.dominance import text_verdicts
from gd_analyze.findings import Findings
from gd_analyze.formulas.parts import part_symbol, parts_formulas
from gd_analyze.formulas.typst import Typst
from gd_analyze.models.element_level import Part, parts_of
from gd_analyze.report.arm_data import arm_data
from gd_analyze.report.beyond_data import beyond_data, term_data, trade_off_data
from gd_analyze.report.context import Context, DominanceRow, build_context, percent
from gd_analyze.report.harmonic_data import equation_data, harmonic_data
from gd_analyze.report.panel import MOST_POINTS
from gd_analyze.formatting import aligned, figures, hundredths, pretty

TYPST = Typst()
_SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c"}


def document(findings: Findings) -> dict[str, Any]:
    """Everything the template shows but the figures."""
    context = build_context(findings)
    arm, model = findings.arm, findings.model
    count = findings.trajectory.n_set_points
    noise = round_off(findings)
    return {
        "title": context.title,
        "subtitle": context.subtitle,
        "headline": context.headline,
        "date": _date(findings),
        "facts": [{"value": pretty(value), "caption": caption} for value, caption in context.facts],
        "budget": context.budget,
        "n_joints": arm.n_joints,
        "n_set_points": count,
        "thinned_to": MOST_POINTS if count > MOST_POINTS else 0,
        "all_turning": all(arm.is_revolute),
        "errors": _errors(context, noise),
        "round_off": figures(noise),
        "kept": {
            "inertia": context.inertia_kept,
            "coriolis": context.coriolis_kept,
            "gravity": context.gravity_kept,
        },
        "level": context.level,
        "refitted": context.refitted,
        "kept_terms": context.kept_terms,
        "search": context.search,
        "operations": _operations(context.operations_full, context.operations),
        "harmonic": harmonic_data(findings),
        "trade_off": trade_off_data(findings, context),
        "terms": term_data(findings, context, noise),
        "beyond": beyond_data(findings, context, noise),
        "warnings": list(context.warnings),
        "dominance": _dominance(findings, context.dominance),
        "threshold": percent(float(findings.dominance.attrs["threshold"])),
        "verdict_counts": context.verdict_counts,
        "text": _text(findings, context),
        "elements": {
            "equations": _equations(findings, context),
            "budget": findings.element_model.budget_stated,
            "operations": _operations(context.element_operations_full, context.element_operations),
            **_dropped(findings, context),
        },
        "drives": model.drives,
        "residuals": [
            {
                "symbol": {"torque": "τ"}.get(quantity, _SYMBOLS.get(quantity, "")),
                "quantity": quantity.replace("_", " "),
                "largest": figures(largest),
                "bound": figures(bound),
                "unit": pretty(unit),
            }
            for quantity, largest, bound, unit in context.residuals
        ],
        "arm": arm_data(arm),
        "provenance": [[label.replace("_", " "), value] for label, value in context.provenance],
    }


def round_off(findings: Findings) -> float:
    """Torque that round-off alone may explain, N m: the bound of the cross-check."""
    return next(residual.bound for residual in findings.residuals if residual.quantity == "torque")


def _date(findings: Findings) -> list[int]:
    """Year, month and day the findings were made."""
    created = datetime.datetime.fromisoformat(findings.provenance["created"])
    return [created.year, created.month, created.day]


def _errors(context: Context, noise: float) -> list[dict[str, Any]]:
    rows = context.joint_errors
    columns = {
        key: aligned(_above(getattr(row, key), noise) for row in rows)
        for key in ("peak_torque", "allowed", "largest", "rms")
    }
    shares = aligned(hundredths(row.largest_share) if row.peak_torque > noise else "–" for row in rows)
    return [
        {
            "joint": row.joint,
            "name": row.name,
            "unit": pretty(row.unit),
            **{key: column[k] for key, column in columns.items()},
            "share": shares[k],
            "used": _used(row.largest, row.allowed) if row.largest > noise else 0.0,
            "over": row.largest > max(row.allowed, noise),
        }
        for k, row in enumerate(rows)
    ]


def _above(value: float, noise: float) -> str:
    """Three digits, or that the value is nothing but round-off."""
    return figures(value) if value > noise or value == 0 else "≈ 0"


def _used(largest: float, allowed: float) -> float:
    """Return the used share of the allowance, at most 1, as a bar's length."""
    return min(largest / allowed, 1.0) if allowed > 0 else float(largest > 0)


def _operations(full: tuple[int, int, int], model: tuple[int, int, int]) -> list[dict[str, str]]:
    rows = [
        *zip(
            ("multiplications", "additions", "sines and cosines"), zip(full, model, strict=True), strict=True
        )
    ]
    rows.insert(2, ("both", (sum(full[:2]), sum(model[:2]))))
    return [
        {
            "what": what,
            "full": str(before),
            "model": str(after),
            "saved": f"{100 * (1 - after / before):.1f}" if before else "0.0",
        }
        for what, (before, after) in rows
    ]


def _dominance(findings: Findings, rows: tuple[DominanceRow, ...]) -> list[dict[str, Any]]:
    arm = findings.arm
    torques = aligned(figures(row.torque_peak) for row in rows)
    peaks = aligned(figures(row.peak) for row in rows)
    shares = aligned(_share(findings, row.torque_share, row.torque_joint) for row in rows)
    without = [
        aligned(_change(getattr(row, key)) for row in rows)
        for key in ("without_translation", "without_rotation")
    ]
    return [
        {
            "rank": row.rank,
            "symbol": row.element[0],
            "index": row.element[1:],
            "peak": peaks[k],
            "unit": pretty(row.unit),
            "without_translation": without[0][k],
            "without_rotation": without[1][k],
            "split": not row.element.startswith("c"),
            "torque": torques[k],
            "torque_joint": row.torque_joint,
            "torque_unit": pretty(arm.joints[row.torque_joint - 1].effort_unit),
            "share": shares[k],
            "dominant": row.dominant,
            "negligible": row.verdict == "negligible",
            "kept": row.kept,
            "text": row.text_verdict,
            "agrees": row.dominant == row.text_verdict,
        }
        for k, row in enumerate(rows)
    ]


def _change(share: float) -> str:
    """Percent without decimals; parts that cancel can change an element by far more than its peak."""
    if not np.isfinite(share):
        return "∞"
    value = 100 * share
    return "0" if value == 0 else "< 1" if value < 1 else f"{value:.0f}" if value < 1e4 else "> 9999"


def _text(findings: Findings, context: Context) -> dict[str, Any] | None:
    """Compare with the text: how many verdicts agree, and what our numbers say of its remarks."""
    reference = text_verdicts(findings.arm.name)
    if reference is None:
        return None
    by_element = {row.element: row for row in context.dominance}
    remarks = []
    for element, remark in reference.remarks.items():
        row = by_element[element]
        remarks.append(
            {
                "symbol": element[0],
                "index": element[1:],
                "verdict": row.text_verdict,
                "remark": remark,
                "translation": figures(row.translation_peak),
                "rotation": figures(row.rotation_peak),
                "unit": pretty(row.unit),
                "finding": _supported(row),
            }
        )
    agreed, given = context.text_agreement
    return {"source": reference.source, "agreed": agreed, "given": given, "remarks": remarks}


def _supported(row: DominanceRow) -> str:
    if row.dominant == row.text_verdict:
        return "our numbers support the verdict, not the remark"
    if row.dominant == "rotation":
        return "our numbers support the remark, not the verdict"
    if row.dominant == "neither":
        return "here the element is zero to round-off, so neither statement is borne out"
    return "here both effects count, so neither statement is borne out"


def _equations(findings: Findings, context: Context) -> list[dict[str, Any]]:
    """Every joint's torque in the model that keeps parts of elements."""
    kept = {row.element: row.kept for row in context.dominance}
    formulas = parts_formulas(kept, findings.arm.n_joints, findings.model.drives)
    return [*map(equation_data, formulas)]


def _dropped(findings: Findings, context: Context) -> dict[str, Any]:
    """Dropped parts with what they cost, and apart from them those that are zero anyway."""
    arm = findings.arm
    parts = {part.label: part for part in parts_of(arm.n_joints)}
    noise = round_off(findings)
    costly = [row for row in context.dropped if row.torque_peak > noise]
    torques = aligned(figures(row.torque_peak) for row in costly)
    shares = aligned(_share(findings, row.torque_share, row.torque_joint) for row in costly)
    rows = []
    for row, torque, share in zip(costly, torques, shares, strict=True):
        joint = row.torque_joint - 1
        within = row.torque_peak <= findings.element_model.budget[joint]
        rows.append(
            {
                "math": _symbol(parts[row.part]),
                "torque": torque,
                "unit": pretty(arm.joints[joint].effort_unit),
                "joint": row.torque_joint,
                "share": share,
                "why": "within the allowance by itself" if within else "cancels against other dropped parts",
            }
        )
    zeros = [_symbol(parts[row.part]) for row in context.dropped if row.torque_peak <= noise]
    return {"dropped": rows, "zeros": zeros}


def _share(findings: Findings, share: float, joint: int) -> str:
    """Percent of a joint's peak torque; a dash where that torque is round-off (joints count from 1)."""
    peak = float(findings.model.promise.peak_torque[joint - 1])
    return hundredths(share) if share == 0 or peak > round_off(findings) else "–"


def _symbol(part: Part) -> str:
    return TYPST.symbol(part_symbol(part.element.label, part.effect))
