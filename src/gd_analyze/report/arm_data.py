"""The arm's own numbers as text: joints, Denavit-Hartenberg table, links, sources."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.formatting import pretty
from gd_analyze.robots import RobotArm


def arm_data(arm: RobotArm) -> dict[str, Any]:
    """Describe an arm as given, six digits at most, for display only."""
    return {
        "name": arm.name,
        "convention": arm.convention,
        "gravity": [_plain(g) for g in arm.gravity],
        "joints": [
            {
                "name": joint.name,
                "kind": "turns" if joint.kind == "revolute" else "slides",
                "range": _range(joint.lower, joint.upper, joint.kind == "revolute"),
                "rate_limit": _plain(joint.rate_limit),
                "acceleration_limit": _plain(joint.acceleration_limit),
                "unit": joint.unit,
            }
            for joint in arm.joints
        ],
        "dh": [
            [_plain(np.degrees(r.theta)), _plain(r.d), _plain(r.a), _plain(np.degrees(r.alpha))]
            for r in arm.dh_table
        ],
        "links": [
            {
                "name": link.name,
                "mass": _plain(link.mass),
                "com": [_plain(x) for x in link.com],
                "inertia": [_plain(link.inertia_com[k, k]) for k in range(3)],
                "products": [_plain(link.inertia_com[a, b]) for a, b in ((0, 1), (0, 2), (1, 2))],
                "axial_only": link.axial_only,
            }
            for link in arm.links
        ],
        "has_products": any(
            np.any(link.inertia_com != np.diag(np.diag(link.inertia_com))) for link in arm.links
        ),
        "drive_inertia": [_plain(drive.inertia) for drive in arm.drives],
        "sources": list(arm.sources),
        "assumptions": list(arm.assumptions),
    }


def _range(lower: float | None, upper: float | None, turning: bool) -> str:
    if lower is None and upper is None:
        return "unlimited"
    ends = [None if x is None else np.degrees(x) if turning else x for x in (lower, upper)]
    return f"{_plain(ends[0])} to {_plain(ends[1])} {'deg' if turning else 'm'}"


def _plain(value: float | None) -> str:
    """Data as given: up to six digits, no trailing zeros; a dash where unknown."""
    if value is None:
        return "–"
    return pretty(f"{value + 0.0:.6g}").replace("-", "−") if np.isfinite(value) else "∞"
