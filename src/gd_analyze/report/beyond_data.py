"""What lies beyond the report's own model and trajectory, as JSON values: other budgets and other states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gd_analyze.findings import Findings
from gd_analyze.harmonics.torque_rendering import torque_term_text
from gd_analyze.harmonics.torque_typst import to_typst
from gd_analyze.report.context import Context, percent
from gd_analyze.formatting import aligned, figures, hundredths, pretty

# Rows of the ranking of single terms.
_TERMS = 20

# A budget given joint by joint is too long for a table.
_LONGEST_BUDGET = 12


def trade_off_data(findings: Findings, context: Context) -> dict[str, Any]:
    """Describe operations and error of every kind of model, by budget."""
    factors = sorted({point.factor for point in findings.trade_off})
    return {
        "kinds": [{"level": level, "refit": refit} for level, refit in context.trade_off_kinds],
        "rows": [
            {
                "budget": _budget(row.budget, factor),
                "asked": row.is_asked,
                "operations": [str(operations) for operations in row.operations],
                "errors": [hundredths(share) for share in row.error_shares],
            }
            for row, factor in zip(context.trade_off, factors, strict=True)
        ],
        "operations": sum(context.operations[:2]),
        "error": percent(float(findings.model.promise.errors.largest_share.max(initial=0.0))),
        "exact": sum(context.operations_full[:2]),
        "exact_elements": sum(context.element_operations_full[:2]),
    }


def _budget(stated: str, factor: float) -> str:
    return pretty(stated) if len(stated) <= _LONGEST_BUDGET else f"budget × {factor:g}"


def term_data(findings: Findings, context: Context, noise: float) -> dict[str, Any]:
    """Describe the single terms that matter most, and how many lie within the parameters' uncertainty."""
    rows = context.terms[:_TERMS]
    torques = aligned(figures(row.alone_torque) for row in rows)
    peaks = findings.model.promise.errors.peak_torque
    shares = aligned(
        hundredths(row.alone_share) if peaks[row.alone_joint - 1] > noise else "–" for row in rows
    )
    without = aligned(hundredths(row.without_share) for row in rows)
    symbols = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c"}
    return {
        "total": context.terms_total,
        "not_worth_keeping": context.terms_not_worth_keeping,
        "rows": [
            {
                "rank": row.rank,
                "symbol": symbols[row.term.quantity],
                "row": to_typst(f"tau{row.term.row + 1}"),
                "math": to_typst(torque_term_text(row.term, abs(row.weight))),
                "negative": row.weight < 0,
                "torque": torques[k],
                "unit": pretty(findings.arm.joints[row.alone_joint - 1].effort_unit),
                "joint": row.alone_joint,
                "share": shares[k],
                "without": without[k],
                "without_joint": row.without_joint,
                "below_uncertainty": bool(row.below_uncertainty),
            }
            for k, row in enumerate(rows)
        ],
    }


def beyond_data(findings: Findings, context: Context, noise: float) -> dict[str, Any]:
    """Describe what the model does away from the set points, joint by joint."""
    rows, errors = context.beyond, context.joint_errors
    certified = [row.certified for row in rows]
    columns = {
        "allowed": _column([row.allowed for row in errors]),
        "sampled": _column([row.largest for row in errors], noise),
        "certified": _column(certified, noise),
        "certified_share": aligned(
            "–" if (s := row.certified_share) is None else hundredths(s) for row in rows
        ),
        "found": _column([row.worst_found for row in rows], noise),
        "drawn": _column([row.within_limits for row in rows]),
        "drawn_share": aligned(
            "–" if (s := row.within_limits_share) is None else hundredths(s) for row in rows
        ),
        "per_kg": _column([row.torque_per_kg for row in rows]),
        "mass": aligned(_mass(row.mass_within_budget) for row in rows),
        "uncertainty": _column([row.uncertainty for row in rows]),
    }
    proven = [row for row in certified if row is not None]
    payload = findings.beyond.payload
    return {
        "rows": [
            {
                "joint": row.joint,
                "name": row.name,
                "unit": pretty(row.unit),
                **{key: column[k] for key, column in columns.items()},
            }
            for k, row in enumerate(rows)
        ],
        "certified": bool(proven),
        "within": sum(bound <= row.allowed for bound, row in zip(proven, errors, strict=False)),
        "ratio": _ratio(findings, noise),
        "drawn": context.drawn,
        "uncertain": any(row.uncertainty is not None for row in rows),
        "largest_mass": _mass(payload.largest_mass),
        "limiting_joint": payload.limiting_joint,
    }


def _column(values: Sequence[float | None], noise: float = 0.0) -> list[dict[str, str]]:
    """Three digits each; a dash where nothing can be said, and whether it is nothing but round-off."""
    return aligned(
        "–" if value is None else "≈ 0" if 0.0 < value <= noise else figures(value) for value in values
    )


def _mass(mass: float) -> str:
    return "any" if np.isinf(mass) else figures(mass)


def _ratio(findings: Findings, noise: float) -> str:
    """Largest ratio of certified to worst found, of joints whose error is more than round-off."""
    certificate = findings.beyond.certificate
    if certificate is None:
        return ""
    ratios = certificate.ratio[certificate.worst_found > noise]
    return f"{ratios.max():.2f}" if len(ratios) else ""
