"""Numbers of an arm that a design may change, named as in arm files, and the changed arm."""

from __future__ import annotations

import copy
import difflib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.arm_toml import toml_of
from gd_analyze.robots.text_file import UNIT_SUFFIXES

# Speed of the motion as a multiple of the planned one; not a number of the arm.
SPEED = "speed"
_NAME = re.compile(r"(?:(joint|link|drive)(\d+)\.)?([a-z_]+?)(_mm|_deg)?(?:\.([xyz]{1,2}))?")
_VECTOR = ("x", "y", "z")
_TENSOR = ("xx", "yy", "zz", "xy", "xz", "yz")
# Units by the suffix of a key.
_SUFFIXED = {"_mm": ("m", "mm"), "_deg": ("rad", "deg")}
# Largest physical inconsistency, as a share, of numbers rounded to three digits.
_ROUNDING_TOLERANCE = 1e-3
# The same of published measurements.
_MEASUREMENT_TOLERANCE = 0.1


@dataclass(frozen=True)
class Parameter:
    """One number of an arm."""

    name: str  # as asked for: "joint2.a_mm", "link3.com.x", "drive1.inertia", "gravity.z", "speed"
    part: str = ""  # "joint", "link", "drive", or "" for the arm as a whole
    number: int = 0  # of the part, from 0
    key: str = ""
    suffix: str = ""  # of its unit: "_mm", "_deg" or ""
    component: str = ""  # "x" of a vector, "xy" of a tensor
    unit: str = ""

    @property
    def is_inertial(self) -> bool:
        """Whether only mass, centre of mass, inertia or drive inertia change: torque is linear in these."""
        return self.key in ("mass", "com", "inertia")


@dataclass(frozen=True, eq=False)
class VariedArm:
    """An arm whose numbers can be changed; all others are kept, to the last bit.

    A longer link keeps its mass, its inertia, and its centre of mass in the link frame, which is at the far
    end of the link in standard Denavit-Hartenberg frames. Uncertainties are dropped.
    """

    arm: RobotArm

    @cached_property
    def document(self) -> dict[str, Any]:
        """The arm's file."""
        links = tuple(replace(link, uncertainty=None) for link in self.arm.links)
        return tomllib.loads(toml_of(replace(self.arm, links=links, spread=None)))

    @cached_property
    def parameters(self) -> dict[str, str]:
        """Unit of every number that torque depends on, by its name without a unit suffix."""
        arm, placed = self.arm, self.document["convention"] == "placement"
        m, rad, tensor = "m", "rad", "kg m^2"
        vectors = {"xyz": m, "rpy": rad} if placed else {}
        joint_units = {} if placed else {"theta": rad, "d": m, "a": m, "alpha": rad}
        joint_units |= {f"{key}.{x}": unit for key, unit in vectors.items() for x in _VECTOR}
        link_units = (
            {"mass": "kg"} | {f"com.{x}": m for x in _VECTOR} | {f"inertia.{x}": tensor for x in _TENSOR}
        )
        link_units |= {f"frame_{key}.{x}": unit for key, unit in vectors.items() for x in _VECTOR}
        out = {SPEED: ""} | {f"gravity.{x}": "m/s^2" for x in _VECTOR}
        for i in range(1, arm.n_joints + 1):
            out |= {f"joint{i}.{key}": unit for key, unit in joint_units.items()}
            out |= {f"link{i}.{key}": unit for key, unit in link_units.items()}
            if arm.drives:
                out[f"drive{i}.inertia"] = tensor if arm.is_revolute[i - 1] else "kg"
        return out

    def parameter(self, name: str) -> Parameter:
        """Find a number by name; UsageError if the arm has no such number."""
        match = _NAME.fullmatch(name)
        if match is not None:
            part, number, key, suffix, component = (word or "" for word in match.groups())
            before, behind = f"{part}{number}." if part else "", f".{component}" if component else ""
            bare = before + key + behind
            unit = self.parameters.get(bare)
            scaled = dict([_SUFFIXED[suffix]]).get(unit or "") if suffix else unit
            if scaled is not None:
                return Parameter(name, part, int(number or 1) - 1, key, suffix, component, scaled)
        near = difflib.get_close_matches(name, self.parameters, n=3, cutoff=0.5)
        raise UsageError(
            "the arm has no such number",
            where=f"--vary {name}",
            expected="a key of an arm file, such as link3.mass, link3.com.x, joint2.a (or a_mm); or speed",
            found=name,
            next_step=f"did you mean {' or '.join(near)}?" if near else None,
        )

    def value(self, parameter: Parameter) -> float:
        """Value of a number in the arm as given, in its unit."""
        return 1.0 if parameter.key == SPEED else float(_located(self.document, parameter)[2])

    def at(self, values: Mapping[Parameter, float]) -> RobotArm:
        """Change some numbers; an ArmError names the value that makes the arm invalid."""
        changed = copy.deepcopy(self.document)
        changes = {parameter: value for parameter, value in values.items() if parameter.key != SPEED}
        for parameter, value in changes.items():
            _change(changed, parameter, value)
        try:
            arm = arm_in(changed, self.arm.name)
        except ArmError as error:
            listed = ", ".join(f"{parameter.name} = {value:g}" for parameter, value in changes.items())
            raise ArmError(f"{listed} gives no valid arm: {error.what}", where=f"--vary {listed}") from None
        identity = {key: getattr(self.arm, key) for key in ("name", "title", "tip", "tip_frame")}
        return replace(arm, **identity)

    def bodies(self, points: Mapping[Parameter, FloatArray], count: int) -> Bodies:
        """Bodies of `count` arms in which inertial numbers are changed, values (count,) each.

        An ArmError names the value that makes a mass or drive inertia negative, or an inertia physically
        inconsistent that was not.
        """
        arm = self.arm
        nominal = (arm.mass, arm.com, arm.inertia_com, arm.drive_inertia if arm.drives else np.zeros(0))
        mass, com, inertia, drive = (np.tile(x, (count,) + (1,) * x.ndim) for x in nominal)
        for parameter, samples in points.items():
            values, k = samples * UNIT_SUFFIXES.get(parameter.suffix, 1.0), parameter.number
            if parameter.part == "drive":
                drive[:, k] = values
            elif parameter.key == "mass":
                mass[:, k] = values
            elif parameter.key == "com":
                com[:, k, _VECTOR.index(parameter.component)] = values
            else:
                a, b = (_VECTOR.index(x) for x in parameter.component)
                inertia[:, k, a, b] = inertia[:, k, b, a] = values
        for parameter, samples in points.items():
            if parameter.part == "drive" or parameter.key == "mass":
                is_wrong = samples < 0.0
                message = f"{parameter.part} {parameter.number + 1} cannot have a negative {parameter.key}"
            else:
                link = arm.links[parameter.number]
                tolerance = [
                    _ROUNDING_TOLERANCE,
                    _MEASUREMENT_TOLERANCE if link.as_measured else _ROUNDING_TOLERANCE,
                ]
                most = np.maximum(tolerance, _inconsistency(link.inertia_com)) * (1.0 + 1e-9)
                is_wrong = np.asarray((_inconsistency(inertia[:, parameter.number]) > most).any(axis=-1))
                message = f"the inertia of link {link.name} becomes physically inconsistent"
            if parameter.key != "com" and is_wrong.any():
                value_text = f"{samples[is_wrong][0]:g} {parameter.unit}"
                raise ArmError(
                    message, where=f"--vary {parameter.name}", found=value_text, next_step="narrow the range"
                )
        return Bodies(mass, com, inertia, drive)


@dataclass(frozen=True, eq=False)
class Bodies:
    """Bodies of S arms with the same geometry."""

    mass: FloatArray  # kg, (S, n)
    com: FloatArray  # in the link frames, m, (S, n, 3)
    inertia_com: FloatArray  # about the centres of mass, kg m^2, (S, n, 3, 3)
    drive_inertia: FloatArray  # at the joints, kg m^2 (kg), (S, n), or (S, 0) without drives

    def at(self, arms: Any) -> Bodies:
        """Take some of the arms."""
        return Bodies(*(getattr(self, column.name)[arms] for column in fields(self)))


def _inconsistency(inertia_com: FloatArray) -> FloatArray:
    """Physical inconsistency of inertias (..., 3, 3), as shares of their largest moment, (..., 2).

    Magnitude of a negative smallest principal moment, and excess of the largest over the sum of the others.
    """
    least, middle, most = np.moveaxis(np.linalg.eigvalsh(inertia_com), -1, 0)
    largest = np.maximum(np.maximum(np.abs(least), np.abs(most)), np.finfo(float).tiny)
    return np.stack([-least, most - least - middle], axis=-1) / largest[..., None]


def _located(document: dict[str, Any], parameter: Parameter) -> tuple[dict[str, Any], str, Any, Any]:
    """Table of a number, its key there, its value in its own unit, and the whole vector."""
    table = document[f"{parameter.part}s"][parameter.number] if parameter.part else document
    stated = next(
        (parameter.key + s for s in ("", *UNIT_SUFFIXES) if parameter.key + s in table), parameter.key
    )
    value = table.get(stated, [0.0, 0.0, 0.0] if parameter.component else 0.0)
    if isinstance(value, dict):
        return table, stated, value.get(parameter.component, 0.0), value
    has, wants = (
        UNIT_SUFFIXES.get(key, 1.0) for key in (stated.removeprefix(parameter.key), parameter.suffix)
    )
    whole = np.array(value) * (has / wants)
    return table, stated, whole[_VECTOR.index(parameter.component)] if parameter.component else whole, whole


def _change(document: dict[str, Any], parameter: Parameter, value: float) -> None:
    """Put a number into an arm's file, in its own unit."""
    table, stated, _, whole = _located(document, parameter)
    table.pop(stated, None)
    if isinstance(whole, dict):
        table[parameter.key] = whole | {parameter.component: value}
    elif parameter.component:
        whole[_VECTOR.index(parameter.component)] = value
        table[parameter.key + parameter.suffix] = whole.tolist()
    else:
        table[parameter.key + parameter.suffix] = value
