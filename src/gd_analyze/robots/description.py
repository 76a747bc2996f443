"""An arm as plain JSON values, and the fingerprint of the numbers that act on its dynamics."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from typing import Any

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.link_uncertainty import LinkUncertainty
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement


def describe(arm: RobotArm) -> dict[str, Any]:
    """Everything that acts on the dynamics, how well it is known, names and limits, as plain JSON values."""
    return {
        "name": arm.name,
        "title": arm.title,
        "gravity": arm.gravity.tolist(),
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "placement": _placement(joint.placement),
                "axis": joint.axis.tolist(),
                "lower": joint.lower,
                "upper": joint.upper,
                "rate_limit": joint.rate_limit,
                "acceleration_limit": joint.acceleration_limit,
            }
            for joint in arm.joints
        ],
        "links": [
            {
                "name": link.name,
                "mass": link.mass,
                "com": link.com.tolist(),
                "inertia_com": link.inertia_com.tolist(),
                "frame": _placement(link.frame),
                "as_measured": link.as_measured,
                "axial_only": link.axial_only,
                "uncertainty": None if link.uncertainty is None else link.uncertainty.describe(),
            }
            for link in arm.links
        ],
        "drive_inertia": [drive.inertia for drive in arm.drives],
        "drive_inertia_uncertainty": [drive.inertia_uncertainty for drive in arm.drives],
    }


def describe_in_full(arm: RobotArm) -> dict[str, Any]:
    """Everything `describe` gives, and what else there is to show: friction, table, sources, assumptions."""
    return {
        **describe(arm),
        "drives": [asdict(drive) for drive in arm.drives],
        "dh_table": [asdict(row) for row in arm.dh_table],
        "convention": arm.convention,
        "sources": list(arm.sources),
        "assumptions": list(arm.assumptions),
    }


def arm_from_description(description: dict[str, Any]) -> RobotArm:
    """Rebuild an arm from what `describe` or `describe_in_full` gave.

    Descriptions written before uncertainties were part of them state none.

    Raises
    ------
    ArmError
        If a value is impossible, as on construction.
    KeyError, TypeError
        If the description lacks something or is of another shape.
    """
    inertias = description["drive_inertia"]
    uncertainties = description.get("drive_inertia_uncertainty", [None] * len(inertias))
    return RobotArm(
        name=description["name"],
        title=description["title"],
        gravity=np.array(description["gravity"]),
        joints=tuple(
            Joint(**{**joint, "placement": _placed(joint["placement"]), "axis": np.array(joint["axis"])})
            for joint in description["joints"]
        ),
        links=tuple(
            Link(
                name=link["name"],
                mass=link["mass"],
                com=np.array(link["com"]),
                inertia_com=np.array(link["inertia_com"]),
                frame=_placed(link["frame"]),
                as_measured=link["as_measured"],
                axial_only=link["axial_only"],
                uncertainty=_uncertain(link.get("uncertainty")),
            )
            for link in description["links"]
        ),
        drives=(
            tuple(Drive(**{**drive, "coulomb": tuple(drive["coulomb"])}) for drive in description["drives"])
            if "drives" in description
            else tuple(Drive(*pair) for pair in zip(inertias, uncertainties, strict=True))
        ),
        dh_table=tuple(DHRow(**row) for row in description.get("dh_table", [])),
        convention=description.get("convention", ""),
        sources=tuple(description.get("sources", [])),
        assumptions=tuple(description.get("assumptions", [])),
    )


def fingerprint(arm: RobotArm, drives: bool = False) -> str:
    """SHA-256 of the numbers that act on torque at a state; drives on request, never names or limits.

    Nor uncertainties: an arm whose numbers are known better has the same torques, and results made for it
    remain those of the same arm.
    """
    description = describe(arm)
    acting = {
        "gravity": description["gravity"],
        "joints": [[joint[key] for key in ("kind", "placement", "axis")] for joint in description["joints"]],
        "links": [
            [link[key] for key in ("mass", "com", "inertia_com", "frame")] for link in description["links"]
        ],
    }
    if drives:
        acting["drive_inertia"] = description["drive_inertia"]
    return hashlib.sha256(json.dumps(acting, sort_keys=True).encode()).hexdigest()


def _uncertain(value: dict[str, Any] | None) -> LinkUncertainty | None:
    return None if value is None else LinkUncertainty.from_description(value)


def _placement(value: Placement) -> dict[str, Any]:
    return {"rotation": value.rotation.tolist(), "translation": value.translation.tolist()}


def _placed(value: dict[str, Any]) -> Placement:
    return Placement(np.array(value["rotation"]), np.array(value["translation"]))
