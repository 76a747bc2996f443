"""Words and letters for what tables name in full; terminal, HTML and PDF use the same."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gd_analyze.robots.arm import RobotArm

# Of quantities, in formulas.
SYMBOLS = {
    "inertia": "D",
    "coriolis_centrifugal": "h",
    "gravity_loading": "c",
    "torque": "τ",
    "kinetic": "T",
    "potential": "U",
}

# Verdicts in the order they are told, and what they are called.
VERDICTS = {
    "translation": "translation",
    "rotation": "rotation",
    "both": "both",
    "gravity": "gravity",
    "negligible": "negligible",
    "neither": "zero",
}


def drives_told(arm: RobotArm, drives: bool) -> str:
    """Say whether the drives' inertia is part of the torque; "" of an arm that has none."""
    return ("drives included" if drives else "links alone") if arm.counts_drives() else ""


def told(row: Mapping[str, Any], what: str = "verdict") -> str:
    """Effect that is dominant or kept, or a verdict, as it is told: gravity has no effects to tell apart.

    Parameters
    ----------
    row
        Of `gd_analyze.results.rows.element_rows`.
    what
        "verdict", "dominant" or "kept".
    """
    effect: str = row[what]
    has_none = row["quantity"] == "gravity_loading" and effect not in ("negligible", "neither")
    return "gravity" if has_none else effect
