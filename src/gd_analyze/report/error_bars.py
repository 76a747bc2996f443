"""Every joint's torque error against the budget, as bars: logarithmic on the page, linear on paper."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.report.budget import place
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import margins, tube_bound
from gd_analyze.results.rows import joint_rows
from gd_analyze.text import amount, percent

# Largest share of the allowed error that a bar on paper shows; beyond it the other bars would vanish.
_LONGEST_BAR = 20.0


def error_bars(findings: Findings) -> dict[str, Any]:
    """Errors, sampled and proven, over allowed errors.

    On the page they have places, percent of its axis; on paper they are lengths in allowed errors.
    """
    accuracy, bound = findings.model.accuracy, tube_bound(findings)
    used = _used(findings, accuracy.errors.largest)
    proven = None if bound is None else _used(findings, bound)
    joints = []
    for i, row in enumerate(joint_rows(findings, "simplified_model")):
        allowed, error, unit = row["allowed_error"], row["largest_error"], row["effort_unit"]
        is_marked = bound is not None and allowed > 0
        joints.append(
            {
                "name": row["joint_name"],
                "place": place(error / allowed if allowed > 0 else float(error > 0)),
                "proven_place": place(float(bound[i]) / allowed) if bound is not None and is_marked else None,
                "used": used[i],
                "proven": None if proven is None else proven[i],
                "words": f"{amount(error, unit)} of {amount(allowed, unit)}",
                "share": percent(float(accuracy.shares[i])),
            }
        )
    return {
        "joints": joints,
        "budget_place": place(1.0),
        "longest": max([1.25, *used, *(proven or [])]),
        "shares_of": accuracy.asked.shares_of,
        "is_proven": bound is not None,
        "proof": findings.proof,
        "near": "the motion" if bound is None else f"{margins(findings)} of the motion",
        "budget": accuracy.budget,
    }


def _used(findings: Findings, errors: FloatArray) -> list[float]:
    """Errors over allowed errors; 0 where an error is round-off."""
    allowed = findings.model.accuracy.allowed
    counts = (errors > findings.round_off) & (allowed > 0.0)
    used = np.divide(errors, allowed, out=np.zeros_like(allowed), where=counts)
    return np.minimum(used, _LONGEST_BAR).tolist()
