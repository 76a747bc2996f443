"""An arm as plain JSON values under the keys of arm files, and the fingerprint of the numbers that act."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import FILE, FORMAT, Key, keys_of
from gd_analyze.robots.frames import CONVENTIONS
from gd_analyze.robots.parts import DHRow, Joint, Link, LinkUncertainty, Placement, entries_of


def describe(arm: RobotArm) -> dict[str, Any]:
    """All that an arm file states, in SI and to the last bit, without what is unknown.

    An arm given by a Denavit-Hartenberg table keeps it; any other has placements, by rotation matrices.
    """
    convention = table_convention(arm)
    keys = keys_of(convention)
    rows = arm.dh_table if convention in CONVENTIONS else [None] * arm.n_joints
    values = vars(arm) | {
        "format": FORMAT,
        "title": arm.title or arm.name,
        "convention": convention,
        "gravity": arm.gravity_vector,
        "joints": [_stated(_joint(*pair), keys["joints"]) for pair in zip(arm.joints, rows, strict=True)],
        "links": [_stated(_link(link), keys["links"]) for link in arm.links],
        "drives": [
            _stated(vars(drive) | {"torque_limit": drive.torque_limit or None}, keys["drives"])
            for drive in arm.drives
        ],
        "spread": None if arm.spread is None else arm.spread.reshape(-1, 11 * arm.n_joints),
    }
    return _stated(values, FILE)


def _stated(values: Mapping[str, Any], keys: Mapping[str, Key]) -> dict[str, Any]:
    """Values of the keys as JSON has them, without None."""
    return {key: _plain(values[key]) for key in keys if values.get(key) is not None}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def _joint(joint: Joint, row: DHRow | None) -> dict[str, Any]:
    ends = [joint.lower, joint.upper]
    placement = _placement(joint.placement, "") if row is None else vars(row)
    return vars(joint) | {"range": None if ends == [None, None] else ends} | placement


def _link(link: Link) -> dict[str, Any]:
    stated, bare = link.uncertainty or LinkUncertainty(), link.bare
    values = vars(link) | _placement(link.frame, "frame_")
    values |= {"inertia": entries_of(link.inertia_com), "inertia_about": "com"}
    values |= {"mass_uncertainty": stated.mass, "com_uncertainty": stated.com}
    if stated.inertia is not None:
        values["inertia_uncertainty"] = entries_of(stated.inertia)
    if stated.inertia_about != "com":
        values["inertia_uncertainty_about"] = stated.inertia_about
    if bare is not None:
        inertia = entries_of(bare.inertia_com)
        values["without_payload"] = {"mass": bare.mass, "com": bare.com.tolist(), "inertia": inertia}
    return values


def _placement(placement: Placement, prefix: str) -> dict[str, FloatArray]:
    return {f"{prefix}xyz": placement.translation, f"{prefix}rotation": placement.rotation}


def table_convention(arm: RobotArm) -> str:
    """The convention of the arm's table, or "placement" if no table gives the same arm."""
    if not arm.dh_table or arm.convention not in CONVENTIONS:
        return "placement"
    pairs = [(joint.axis, np.array([0.0, 0.0, 1.0])) for joint in arm.joints]
    for joint, link, row in zip(arm.joints, arm.links, arm.dh_table, strict=True):
        of_row = CONVENTIONS[arm.convention](joint.kind, row)
        for given, made in zip((joint.placement, link.frame), of_row, strict=True):
            pairs += [(given.rotation, made.rotation), (given.translation, made.translation)]
    return arm.convention if all(are_same(*pair) for pair in pairs) else "placement"


def are_same(a: FloatArray, b: FloatArray) -> bool:
    """Whether arrays are equal bit by bit: the sign of a zero is part of a fingerprint."""
    return a.tobytes() == b.tobytes()


def fingerprint(arm: RobotArm, drives: bool = False) -> str:
    """SHA-256 of the numbers that determine torque at a state; drives on request.

    It excludes names, limits and uncertainties, so that better knowledge of an arm keeps its results valid,
    and is the same for a Denavit-Hartenberg table and the placements that it gives.
    """
    acting = {
        "gravity": arm.gravity_vector.tolist(),
        "joints": [[joint.kind, _frame(joint.placement), joint.axis.tolist()] for joint in arm.joints],
        "links": [
            [link.mass, link.com.tolist(), link.inertia_com.tolist(), _frame(link.frame)]
            for link in arm.links
        ],
    }
    if drives:
        acting["drive_inertia"] = [drive.inertia for drive in arm.drives]
    return hashlib.sha256(json.dumps(acting, sort_keys=True).encode()).hexdigest()


def _frame(placement: Placement) -> dict[str, Any]:
    return {key: values.tolist() for key, values in vars(placement).items()}
