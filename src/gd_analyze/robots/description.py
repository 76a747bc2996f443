"""An arm as plain JSON values, and the fingerprint of the numbers that determine its dynamics."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from typing import Any

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, LinkUncertainty, Placement

_ACTING_OF_JOINTS = ("kind", "placement", "axis")
_ACTING_OF_LINKS = ("mass", "com", "inertia_com", "frame")
_TEXTS = ("sources", "assumptions", "doubts")


def describe(arm: RobotArm) -> dict[str, Any]:
    """All dynamic parameters with uncertainties, names and limits, as plain JSON values."""
    keys = ("name", "title", "gravity", "joints", "links", "drives")
    spread = {} if arm.spread is None else {"spread": arm.spread.tolist()}
    return {key: _plain(getattr(arm, key)) for key in keys} | spread


def describe_in_full(arm: RobotArm) -> dict[str, Any]:
    """The same with Denavit-Hartenberg table, sources, assumptions and doubts."""
    return describe(arm) | {key: _plain(getattr(arm, key)) for key in ("dh_table", "convention", *_TEXTS)}


def arm_from_description(description: dict[str, Any]) -> RobotArm:
    """Arm from the result of `describe` or `describe_in_full`; else ArmError, KeyError or TypeError."""
    texts: dict[str, Any] = {key: tuple(description.get(key, [])) for key in _TEXTS}
    placed = [{**joint, "placement": Placement(**joint["placement"])} for joint in description["joints"]]
    return RobotArm(
        name=description["name"],
        title=description["title"],
        gravity=np.array(description["gravity"]),
        joints=tuple(Joint(**joint) for joint in placed),
        links=tuple(_link(link) for link in description["links"]),
        drives=tuple(Drive(**drive) for drive in description["drives"]),
        dh_table=tuple(DHRow(**row) for row in description.get("dh_table", [])),
        convention=description.get("convention", ""),
        spread=np.array(description["spread"]) if "spread" in description else None,
        **texts,
    )


def fingerprint(arm: RobotArm, drives: bool = False) -> str:
    """SHA-256 of the numbers that determine torque at a state; drives on request.

    It excludes names, limits and uncertainties, so that better knowledge of an arm keeps its results valid.
    """
    description = describe(arm)
    acting = {
        "gravity": description["gravity"],
        "joints": [[joint[key] for key in _ACTING_OF_JOINTS] for joint in description["joints"]],
        "links": [[link[key] for key in _ACTING_OF_LINKS] for link in description["links"]],
    }
    if drives:
        acting["drive_inertia"] = [drive.inertia for drive in arm.drives]
    return hashlib.sha256(json.dumps(acting, sort_keys=True).encode()).hexdigest()


def _link(value: dict[str, Any]) -> Link:
    stated = value["uncertainty"]
    uncertainty = None if stated is None else LinkUncertainty(**stated)
    return Link(**{**value, "frame": Placement(**value["frame"]), "uncertainty": uncertainty})


def _plain(value: Any) -> Any:
    """A part as plain JSON values, without its place in a file and the link without payload."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    if not dataclasses.is_dataclass(value):
        return value
    names = (entry.name for entry in dataclasses.fields(value) if entry.name not in ("source", "bare"))
    return {name: _plain(getattr(value, name)) for name in names}
