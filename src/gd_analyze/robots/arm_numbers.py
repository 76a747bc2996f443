"""Numbers of an arm, named by their keys in arm files, and the arm with some of them replaced."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_toml import table_convention
from gd_analyze.robots.frames import CONVENTIONS, angles_of, roll_pitch_yaw
from gd_analyze.robots.parts import Link, Placement
from gd_analyze.robots.plausibility import inertia_physically_inconsistent, warn_of_implausible
from gd_analyze.units import KINDS, UNITS, Quantity

EXAMPLES = "link3.mass, link3.com.x, link3.inertia.xx, joint2.a (or a_mm), drive1.inertia, gravity.z"
_NAME = re.compile(r"(?:(joint|link|drive)([1-9][0-9]*)\.)?([a-z_]+?)(_mm|_deg)?(?:\.([xyz]{1,2}))?")
_VECTOR = ("x", "y", "z")
_TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")
# SI unit and components of the numbers of each part, by key.
_KEYS: Mapping[str, Mapping[str, tuple[str, tuple[str, ...]]]] = {
    "joint": {
        "theta": ("rad", ()),
        "d": ("m", ()),
        "a": ("m", ()),
        "alpha": ("rad", ()),
        "xyz": ("m", _VECTOR),
        "rpy": ("rad", _VECTOR),
    },
    "link": {
        "mass": ("kg", ()),
        "com": ("m", _VECTOR),
        "inertia": ("kg m^2", _TENSOR),
        "frame_xyz": ("m", _VECTOR),
        "frame_rpy": ("rad", _VECTOR),
    },
    "drive": {"inertia": ("kg m^2 or kg", ())},
    "": {"gravity": ("m/s^2", _VECTOR)},
}
_OF_TABLES = ("theta", "d", "a", "alpha")
_OF_PLACEMENTS = ("xyz", "rpy", "frame_xyz", "frame_rpy")


@dataclass(frozen=True)
class ArmNumber:
    """One number of an arm."""

    name: str  # "joint2.a_mm", "link3.com.x", "drive1.inertia", "gravity.z"
    part: str  # "joint", "link" or "drive", or "" for the arm as a whole
    index: int  # of the part, from 0
    key: str
    component: str  # "x" of a vector, "xy" of a tensor, or ""
    unit: str  # "mm" of "joint2.a_mm"

    @classmethod
    def named(cls, name: str) -> ArmNumber | None:
        """The number of this name; None if no arm has one."""
        match = _NAME.fullmatch(name)
        if match is None:
            return None
        part, number, key, suffix, component = (word or "" for word in match.groups())
        unit, components = _KEYS[part].get(key, ("", ()))
        if not unit or (component not in components if components else component):
            return None
        if suffix and unit != {"_mm": "m", "_deg": "rad"}[suffix]:
            return None
        return cls(name, part, int(number or 1) - 1, key, component, suffix.removeprefix("_") or unit)

    @property
    def factor(self) -> float:
        """Its unit in SI."""
        return UNITS[KINDS[self.unit]][self.unit] if self.unit in KINDS else 1.0

    def read(self, given: object) -> float:
        """Value in its unit; UsageError unless it is a number, alone or with a unit of the same kind."""
        quantity = Quantity.parse(str(given))
        if quantity is None or quantity.kind not in ("", KINDS.get(self.unit, "")):
            expected = f"a number in {self.unit}"
            if self.unit in KINDS:
                expected += f", or with one of {', '.join(UNITS[KINDS[self.unit]])}"
            raise UsageError(
                "the number cannot be read", where=self.name, expected=expected, found=str(given)
            )
        return quantity.si / self.factor if quantity.kind else quantity.si


def with_numbers(arm: RobotArm, given: Mapping[str, object]) -> RobotArm:
    """Replace numbers of an arm, named as in its file: {"link3.mass": 2.5, "joint2.a": "350 mm"}.

    Everything else is kept. A longer link keeps its mass, its inertia about the centre of mass, and its
    centre of mass in the link frame, which in standard Denavit-Hartenberg frames is at the link's far end.

    Raises
    ------
    UsageError
        If the arm has no such number, it is given twice or cannot be read.
    ArmError
        If a value makes the arm invalid, or an inertia physically inconsistent that was not.

    Warns
    -----
    GdAnalyzeWarning
        If numbers of the new arm are implausible.
    """
    changed, seen = arm, dict[tuple[Any, ...], str]()
    for name, value in given.items():
        number = ArmNumber.named(name)
        if number is None:
            raise UsageError("no arm has such a number", where=name, expected=EXAMPLES, found=name)
        other = seen.setdefault((number.part, number.index, number.key, number.component), name)
        if other != name:
            raise UsageError("the number is given twice", where=name, found=[other, name])
        _require_of(arm, number)
        read = number.read(value)
        try:
            changed = _replaced(changed, number, read * number.factor)
        except ArmError as error:
            message = f"{name} = {read:g} {number.unit} gives no valid arm: {error.what}"
            raise ArmError(message, where=name, found=str(value)) from None
    listed = ", ".join(f"{name} = {value}" for name, value in given.items())
    known_faults = [fault for _, fault in inertia_physically_inconsistent(arm)]
    for _, fault in inertia_physically_inconsistent(changed):
        if fault not in known_faults:
            raise ArmError(f"{listed} gives no valid arm", where=", ".join(given), found=fault)
    changed = replace(changed, assumptions=(*arm.assumptions, f"In place of the arm's numbers: {listed}."))
    warn_of_implausible(changed, stacklevel=2)
    return changed


def _require_of(arm: RobotArm, number: ArmNumber) -> None:
    """Raise a UsageError unless the arm has this number."""
    count = {"joint": arm.n_joints, "link": arm.n_joints, "drive": len(arm.drives), "": 1}[number.part]
    if number.index >= count:
        message, expected = f"the arm has no {number.part} {number.index + 1}", f"{number.part}s 1 to {count}"
        if not count:
            expected = "an arm with drives, in its file or by drive_inertia"
        raise UsageError(message, where=number.name, expected=expected)
    placed = table_convention(arm) not in CONVENTIONS
    if number.key in (_OF_TABLES if placed else _OF_PLACEMENTS):
        given_by = "by placements" if placed else "in a Denavit-Hartenberg table"
        keys = "joint2.xyz.x, joint2.rpy.z, link2.frame_xyz.x" if placed else "joint2.theta, .d, .a, .alpha"
        message = f"the arm's frames are given {given_by}"
        raise UsageError(message, where=number.name, expected=keys, found=number.name)


def _replaced(arm: RobotArm, number: ArmNumber, value: float) -> RobotArm:
    """Replace one number by a value in SI."""
    i, key = number.index, number.key
    joints, links, drives = list(arm.joints), list(arm.links), list(arm.drives)
    if number.part == "drive":
        drives[i] = replace(drives[i], inertia=value)
        return replace(arm, drives=tuple(drives))
    if key == "gravity":
        return replace(arm, gravity=_with_component(arm.gravity, number, value))
    if key in _OF_TABLES:
        rows = list(arm.dh_table)
        rows[i] = replace(rows[i], **{key: value})
        before, behind = CONVENTIONS[table_convention(arm)][1](joints[i].kind, rows[i])
        joints[i], links[i] = replace(joints[i], placement=before), replace(links[i], frame=behind)
        return replace(arm, joints=tuple(joints), links=tuple(links), dh_table=tuple(rows))
    if number.part == "joint":
        joints[i] = replace(joints[i], placement=_placed(joints[i].placement, number, value))
    else:
        links[i] = _changed_link(links[i], number, value)
    return replace(arm, joints=tuple(joints), links=tuple(links))


def _changed_link(link: Link, number: ArmNumber, value: float) -> Link:
    if number.key == "mass":
        return replace(link, mass=value)
    if number.key == "com":
        return replace(link, com=_with_component(link.com, number, value))
    if number.key == "inertia":
        inertia = link.inertia_com.copy()
        row, column = (_VECTOR.index(axis) for axis in number.component)
        inertia[row, column] = inertia[column, row] = value
        return replace(link, inertia_com=inertia)
    return replace(link, frame=_placed(link.frame, number, value))


def _placed(placement: Placement, number: ArmNumber, value: float) -> Placement:
    if number.key.endswith("xyz"):
        return replace(placement, translation=_with_component(placement.translation, number, value))
    angles = _with_component(np.array(angles_of(placement.rotation)), number, value)
    return replace(placement, rotation=roll_pitch_yaw(*angles.tolist()))


def _with_component(vector: FloatArray, number: ArmNumber, value: float) -> FloatArray:
    changed = vector.copy()
    changed[_VECTOR.index(number.component)] = value
    return changed
