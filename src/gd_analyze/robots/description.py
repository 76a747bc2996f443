"""An arm as plain JSON values, and the fingerprint of the numbers that act on its dynamics."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import asdict
from typing import Any

import numpy as np

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, LinkUncertainty, Placement


def describe(arm: RobotArm) -> dict[str, Any]:
    """Everything that acts on the dynamics, how well it is known, names and limits, as plain JSON values."""
    return {
        "name": arm.name,
        "title": arm.title,
        "gravity": arm.gravity.tolist(),
        "joints": [_plain(joint) for joint in arm.joints],
        "links": [_plain(link) for link in arm.links],
        "drive_inertia": [drive.inertia for drive in arm.drives],
        "drive_inertia_uncertainty": [drive.inertia_uncertainty for drive in arm.drives],
    }


def describe_with_drives(arm: RobotArm) -> dict[str, Any]:
    """Everything `describe` gives, and all of the drives: what a budget may be a share of."""
    return {**describe(arm), "drives": [asdict(drive) for drive in arm.drives]}


def describe_in_full(arm: RobotArm) -> dict[str, Any]:
    """Everything there is to show: also table, sources, assumptions and doubts."""
    return {
        **describe_with_drives(arm),
        "dh_table": [asdict(row) for row in arm.dh_table],
        "convention": arm.convention,
        "sources": list(arm.sources),
        "assumptions": list(arm.assumptions),
        "doubts": list(arm.doubts),
    }


def arm_from_description(description: dict[str, Any]) -> RobotArm:
    """Rebuild an arm from what `describe` or `describe_in_full` gave.

    Descriptions written before uncertainties, or all of the drives, were part of them state none.

    Raises
    ------
    ArmError
        If a value is impossible, as on construction, or the drives are described in two ways that differ.
    KeyError, TypeError
        If the description lacks something or is of another shape.
    """
    inertias = description["drive_inertia"]
    uncertainties = description.get("drive_inertia_uncertainty", [None] * len(inertias))
    brief = list(zip(inertias, uncertainties, strict=True))
    drives = tuple(Drive(*pair) for pair in brief)
    if "drives" in description:
        drives = tuple(Drive(**{**d, "coulomb": tuple(d["coulomb"])}) for d in description["drives"])
        if [(drive.inertia, drive.inertia_uncertainty) for drive in drives] != brief:
            raise ArmError("the drives' inertias contradict each other", expected=str(inertias))
    return RobotArm(
        name=description["name"],
        title=description["title"],
        gravity=np.array(description["gravity"]),
        joints=tuple(
            Joint(**{**joint, "placement": Placement(**joint["placement"])})
            for joint in description["joints"]
        ),
        links=tuple(_link(link) for link in description["links"]),
        drives=drives,
        dh_table=tuple(DHRow(**row) for row in description.get("dh_table", [])),
        convention=description.get("convention", ""),
        sources=tuple(description.get("sources", [])),
        assumptions=tuple(description.get("assumptions", [])),
        doubts=tuple(description.get("doubts", [])),
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


def _link(value: dict[str, Any]) -> Link:
    stated = value.get("uncertainty")
    uncertainty = None if stated is None else LinkUncertainty(**stated)
    return Link(**{**value, "frame": Placement(**value["frame"]), "uncertainty": uncertainty})


def _plain(value: Any) -> Any:
    """A part as plain JSON values, by the fields that act: not where it is described, nor what was bare."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if not dataclasses.is_dataclass(value):
        return value
    names = (entry.name for entry in dataclasses.fields(value) if entry.name not in ("source", "bare"))
    return {name: _plain(getattr(value, name)) for name in names}
