"""What an arm's TOML file may hold, in which units, and what it must hold."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from gd_analyze.given_numbers import LARGEST
from gd_analyze.robots.inertia import of_point_mass, symmetric_tensor
from gd_analyze.robots.link_uncertainty import LinkUncertainty
from gd_analyze.robots.parts import DHRow, JointKind
from gd_analyze.vectors import FloatArray

UNIT_SUFFIXES = {"_deg": math.pi / 180, "_mm": 1e-3}
# NaN and infinity are refused by the tables.
_Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
_Nonnegative = Annotated[float, Field(ge=0, le=LARGEST)]
_Positive = Annotated[float, Field(gt=0, le=LARGEST)]
_LIMITS = ("range", "rate_limit", "acceleration_limit")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        """Suffix that each key may take, given the rest of its table."""
        return {}

    @model_validator(mode="before")
    @classmethod
    def _to_si(cls, data: Any) -> Any:
        """Fold keys with a unit suffix into their SI key."""
        if not isinstance(data, dict):
            return data
        converted = {f"{key}{suffix}": (key, suffix) for key, suffix in cls._unit_suffixes(data).items()}
        out: dict[str, Any] = {}
        for given, value in data.items():
            key, suffix = converted.get(given, (given, None))
            if key in out:
                raise ValueError(f"{key} is given twice, once with a unit suffix")
            out[key] = _scaled(value, UNIT_SUFFIXES[suffix]) if suffix else value
        return out


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_scaled(item, factor) for item in value]
    if not isinstance(value, int | float) or isinstance(value, bool):
        return value
    try:
        return value * factor
    except OverflowError:  # an integer that no float can hold: the schema says so
        return value


class _JointTable(_Table):
    name: str | None = None
    kind: JointKind = "revolute"
    theta: _Number = 0.0
    d: _Number = 0.0
    a: _Number = 0.0
    alpha: _Number = 0.0
    range: list[_Number] | None = Field(default=None, min_length=2, max_length=2)
    rate_limit: _Number | None = None
    acceleration_limit: _Number | None = None

    @property
    def row(self) -> DHRow:
        return DHRow(self.theta, self.d, self.a, self.alpha)

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        of_motion = "_mm" if data.get("kind") == "prismatic" else "_deg"
        lengths_and_angles = {"theta": "_deg", "alpha": "_deg", "a": "_mm", "d": "_mm"}
        return lengths_and_angles | dict.fromkeys(_LIMITS, of_motion)


class _InertiaTable(_Table):
    xx: _Number
    yy: _Number
    zz: _Number
    xy: _Number = 0.0
    xz: _Number = 0.0
    yz: _Number = 0.0

    def tensor(self) -> FloatArray:
        return symmetric_tensor(self.xx, self.yy, self.zz, self.xy, self.xz, self.yz)


class _InertiaUncertaintyTable(_InertiaTable):
    xx: _Nonnegative
    yy: _Nonnegative
    zz: _Nonnegative
    xy: _Nonnegative = 0.0
    xz: _Nonnegative = 0.0
    yz: _Nonnegative = 0.0


class _LinkTable(_Table):
    name: str | None = None
    mass: _Number
    com: list[_Number] = Field(min_length=3, max_length=3)
    inertia: _InertiaTable
    inertia_about: Literal["com", "origin"] = "com"
    as_measured: bool = False
    axial_only: bool = False
    mass_uncertainty: _Nonnegative | None = None
    com_uncertainty: list[_Nonnegative] | None = Field(default=None, min_length=3, max_length=3)
    inertia_uncertainty: _InertiaUncertaintyTable | None = None

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        return {"com": "_mm", "com_uncertainty": "_mm"}

    def uncertainty(self) -> LinkUncertainty | None:
        """What is stated; None where nothing is."""
        mass, com, inertia = self.mass_uncertainty, self.com_uncertainty, self.inertia_uncertainty
        if mass is None and com is None and inertia is None:
            return None
        return LinkUncertainty(
            mass,
            None if com is None else np.array(com),
            None if inertia is None else inertia.tensor(),
            self.inertia_about,
        )

    def inertia_com(self) -> FloatArray:
        """Inertia about the centre of mass, by the parallel-axis theorem where given elsewhere."""
        tensor = self.inertia.tensor()
        about_com = self.inertia_about == "com"
        return tensor if about_com else tensor - of_point_mass(self.mass, np.array(self.com))


class _DriveTable(_Table):
    inertia: _Nonnegative = 0.0
    inertia_uncertainty: _Nonnegative | None = None
    gear_ratio: _Number = 1.0
    viscous: _Nonnegative = 0.0
    coulomb: list[_Number] = Field(default=[0.0, 0.0], min_length=2, max_length=2)
    torque_limit: _Positive | None = None


class ArmFile(_Table):
    """The whole file; every table and key of it is described in docs/arms.md."""

    format: Literal["gd-analyze arm 1"]
    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    title: str = ""
    convention: Literal["standard", "modified"] = "standard"
    gravity: list[_Number] = Field(default=[0.0, 0.0, -9.8062], min_length=3, max_length=3)
    sources: list[str] = []
    assumptions: list[str] = []
    joints: list[_JointTable] = Field(min_length=1)
    links: list[_LinkTable] = Field(min_length=1)
    drives: list[_DriveTable] = []


def keys_beside(keys: tuple[str | int, ...]) -> list[str]:
    """Keys that the table may have in which a path such as ("links", 2, "mas") ends.

    Examples
    --------
    >>> keys_beside(("links", 1, "inertia", "zx"))
    ['xx', 'yy', 'zz', 'xy', 'xz', 'yz']
    """
    tables: dict[str, type[_Table]] = {
        "joints": _JointTable,
        "links": _LinkTable,
        "drives": _DriveTable,
        "inertia": _InertiaTable,
        "inertia_uncertainty": _InertiaUncertaintyTable,
    }
    names = [tables[key] for key in keys[:-1] if isinstance(key, str)]
    return list((names[-1] if names else ArmFile).model_fields)
