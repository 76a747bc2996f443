"""The arm's own numbers as text: joints, Denavit-Hartenberg table, links, sources."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.plausibility import inconsistent_inertias
from gd_analyze.text import given


def arm_data(arm: RobotArm) -> dict[str, Any]:
    """Describe an arm as given, six digits at most, for display only."""
    return {
        "name": arm.name,
        "convention": arm.convention,
        "gravity": [given(g) for g in arm.gravity],
        "joints": [
            {
                "name": joint.name,
                "kind": "turns" if joint.kind == "revolute" else "slides",
                "range": _range(joint.lower, joint.upper, joint.kind == "revolute"),
                "velocity_limit": given(joint.velocity_limit),
                "acceleration_limit": given(joint.acceleration_limit),
                "unit": joint.unit,
            }
            for joint in arm.joints
        ],
        "dh": [
            [given(np.degrees(r.theta)), given(r.d), given(r.a), given(np.degrees(r.alpha))]
            for r in arm.dh_table
        ],
        "links": [
            {
                "name": link.name,
                "mass": given(link.mass),
                "com": [given(x) for x in link.com],
                "inertia": [given(link.inertia_com[k, k]) for k in range(3)],
                "products": [given(link.inertia_com[a, b]) for a, b in ((0, 1), (0, 2), (1, 2))],
                "axial_only": link.axial_only,
            }
            for link in arm.links
        ],
        "has_products": any(
            np.any(link.inertia_com != np.diag(np.diag(link.inertia_com))) for link in arm.links
        ),
        "drive_inertia": [given(drive.inertia) for drive in arm.drives],
        "sources": list(arm.sources),
        "assumptions": list(arm.assumptions),
        "doubts": [*arm.doubts, *inconsistent_inertias(arm)],
    }


def _range(lower: float | None, upper: float | None, turning: bool) -> str:
    if lower is None and upper is None:
        return "unlimited"
    ends = [None if x is None else np.degrees(x) if turning else x for x in (lower, upper)]
    return f"{given(ends[0])} to {given(ends[1])} {'deg' if turning else 'm'}"
