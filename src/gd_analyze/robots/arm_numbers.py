"""Numbers of an arm, named by their keys in arm files, and the arm with some of them replaced."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import (
    DH_JOINT,
    DRIVE,
    FILE,
    JOINT,
    LINK,
    PLACED_JOINT,
    PLACED_LINK,
    arm_in,
    keys_of,
)
from gd_analyze.robots.description import describe
from gd_analyze.robots.frames import CONVENTIONS, angles_of
from gd_analyze.robots.plausibility import inertia_physically_inconsistent, warn_of_implausible
from gd_analyze.units import KINDS, UNITS, Quantity

EXAMPLES = "link3.mass, link3.com.x, link3.inertia.xx, joint2.a (or a_mm), drive1.inertia, gravity.z"
_NAME = re.compile(r"(?:(joint|link|drive)([1-9][0-9]*)\.)?([a-z_]+?)(_mm|_deg)?(?:\.([a-z]+))?")
_KEYS = {
    "joint": JOINT | DH_JOINT | PLACED_JOINT,
    "link": LINK | PLACED_LINK,
    "drive": DRIVE,
    "": FILE,
}


@dataclass(frozen=True)
class ArmNumber:
    """One number of an arm."""

    name: str  # "joint2.a_mm", "link3.com.x", "drive1.inertia", "gravity.z"
    part: str  # "joint", "link" or "drive", or "" for the arm as a whole
    index: int  # of the part, from 0
    key: str
    component: str  # "x" of a vector, "xy" of a tensor, "upper" of a range, or ""
    unit: str  # "mm" of "joint2.a_mm"

    @classmethod
    def named(cls, name: str) -> ArmNumber | None:
        """The number of this name; None if no arm has one."""
        match = _NAME.fullmatch(name)
        if match is None:
            return None
        part, number, key, suffix, component = (word or "" for word in match.groups())
        entry = _KEYS[part].get(key)
        if entry is None or not entry.unit or component not in (entry.components or ("",)):
            return None
        if suffix not in ("", entry.suffix()):
            return None
        return cls(name, part, int(number or 1) - 1, key, component, suffix.removeprefix("_") or entry.unit)

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
    description, stated, seen = describe(arm), arm, dict[tuple[Any, ...], str]()
    for name, value in given.items():
        number = ArmNumber.named(name)
        if number is None:
            raise UsageError("no arm has such a number", where=name, expected=EXAMPLES, found=name)
        other = seen.setdefault((number.part, number.index, number.key, number.component), name)
        if other != name:
            raise UsageError("the number is given twice", where=name, found=[other, name])
        read = number.read(value)
        _put(number, _table_with(number, description), read * number.factor)
        try:
            stated = arm_in(description)
        except ArmError as error:
            message = f"{name} = {read:g} {number.unit} gives no valid arm: {error.what}"
            raise ArmError(message, where=name, found=str(value)) from None
    # What files do not state is kept, too: where a part is described, what it carries, the arm's tip.
    changed = replace(
        arm,
        gravity_vector=stated.gravity_vector,
        joints=tuple(replace(new, source=x.source) for new, x in zip(stated.joints, arm.joints, strict=True)),
        links=tuple(
            replace(new, source=x.source, bare=x.bare) for new, x in zip(stated.links, arm.links, strict=True)
        ),
        drives=stated.drives,
        dh_table=stated.dh_table,
    )
    listed = ", ".join(f"{name} = {value}" for name, value in given.items())
    known_faults = [fault for _, fault in inertia_physically_inconsistent(arm)]
    for _, fault in inertia_physically_inconsistent(changed):
        if fault not in known_faults:
            raise ArmError(f"{listed} gives no valid arm", where=", ".join(given), found=fault)
    changed = replace(changed, assumptions=(*arm.assumptions, f"In place of the arm's numbers: {listed}."))
    warn_of_implausible(changed)
    return changed


def _table_with(number: ArmNumber, description: dict[str, Any]) -> dict[str, Any]:
    """The table that states a number in an arm's description; UsageError if the arm has no such number."""
    tables = description[f"{number.part}s"] if number.part else [description]
    if number.index >= len(tables):
        message = f"the arm has no {number.part} {number.index + 1}"
        expected = f"{number.part}s 1 to {len(tables)}"
        if not tables:
            expected = "an arm with drives, in its file or by drive_inertia"
        raise UsageError(message, where=number.name, expected=expected)
    convention = description["convention"]
    keys = keys_of(convention).get(f"{number.part}s", FILE)
    if number.key not in keys:
        given_by = f"a {convention} Denavit-Hartenberg table" if convention in CONVENTIONS else "placements"
        message, known = f"the arm's frames are given by {given_by}", [key for key in keys if keys[key].unit]
        raise UsageError(message, where=number.name, expected=", ".join(known), found=number.name)
    return tables[number.index]


def _put(number: ArmNumber, table: dict[str, Any], value: float) -> None:
    """Replace a number in its table by a value in SI; UsageError for one of several that are not stated."""
    key, component = number.key, number.component
    if key.endswith("rpy") and key not in table:
        rotation = table.pop(key.replace("rpy", "rotation"))
        table[key] = list(angles_of(np.array(rotation)))
    if not component:
        table[key] = value
    elif key not in table:
        message, hint = f"the arm does not state its {key}", "state it in its file"
        raise UsageError(message, where=number.name, next_step=hint)
    elif isinstance(table[key], dict):
        table[key][component] = value
    else:
        table[key][_KEYS[number.part][key].components.index(component)] = value
