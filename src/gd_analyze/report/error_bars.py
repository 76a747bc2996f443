"""Every joint's torque error as a share of the allowed one, as bars."""

from __future__ import annotations

from typing import Any

from gd_analyze.report.budget import used
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import margins, tube_bound
from gd_analyze.results.rows import joint_rows
from gd_analyze.text import amount, percent

# Largest share of the allowed error that a bar on paper shows; beyond it the other bars would vanish.
_LONGEST_BAR = 20.0


def error_bars(findings: Findings) -> dict[str, Any]:
    """Errors, sampled and proven, over allowed errors."""
    accuracy, bound = findings.model.accuracy, tube_bound(findings)
    sampled = used(accuracy.errors.largest, accuracy.allowed, findings.round_off)
    proven = [None] * len(sampled) if bound is None else used(bound, accuracy.allowed, findings.round_off)
    joints = []
    for row, share, bound_share in zip(
        joint_rows(findings, "simplified_model"), sampled, proven, strict=True
    ):
        unit = row["effort_unit"]
        joints.append(
            {
                "name": row["joint_name"],
                "used": share,
                "proven": bound_share,
                "words": f"{amount(row['largest_error'], unit)} of {amount(row['allowed_error'], unit)}",
                "share": percent(share),
            }
        )
    bounds = [share for share in proven if share is not None]
    return {
        "joints": joints,
        "longest": min(max([1.25, *sampled, *bounds]), _LONGEST_BAR),
        "is_proven": bound is not None,
        "exceeds": any(share > 1.0 for share in bounds),
        "proof": findings.proof,
        "near": "the motion" if bound is None else f"{margins(findings)} of the motion",
        "budget": accuracy.budget,
    }
