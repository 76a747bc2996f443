"""What an arm's TOML file may hold, in which units, and what it must hold."""

from __future__ import annotations

import math
from typing import Annotated, Any, Generic, Literal, TypeVar

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.parts import DHRow, JointKind, LinkUncertainty, of_point_mass, symmetric_tensor
from gd_analyze.text import LARGEST

UNIT_SUFFIXES = {"_deg": math.pi / 180, "_mm": 1e-3}
# NaN and infinity are refused by the tables.
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
_Nonnegative = Annotated[float, Field(ge=0, le=LARGEST)]
_Positive = Annotated[float, Field(gt=0, le=LARGEST)]
_LIMITS = ("range", "velocity_limit", "acceleration_limit")


def _ends(ends: list[float]) -> list[float]:
    """A range as it is, if its ends are numbers, or -inf and inf where they are unknown."""
    for end, unknown in zip(ends, (-math.inf, math.inf), strict=True):
        if end != unknown and not abs(end) <= LARGEST:
            raise ValueError(f"lower and upper end up to {LARGEST:g}, or -inf and inf where unknown")
    return ends


_End = Annotated[float, Field(allow_inf_nan=True)]
_Range = Annotated[list[_End], Field(min_length=2, max_length=2), AfterValidator(_ends)]


class Table(BaseModel):
    """Keys of one table of the file; an unknown one is refused."""

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


class JointTable(Table):
    """What every joint may state."""

    name: str | None = None
    kind: JointKind = "revolute"
    range: _Range | None = None
    velocity_limit: Number | None = None
    acceleration_limit: Number | None = None

    @property
    def ends(self) -> tuple[float | None, float | None]:
        """Lower and upper end of the range, None where unknown."""
        lower, upper = self.range or (-math.inf, math.inf)
        return (lower if math.isfinite(lower) else None), (upper if math.isfinite(upper) else None)

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        return dict.fromkeys(_LIMITS, "_mm" if data.get("kind") == "prismatic" else "_deg")


class DHJointTable(JointTable):
    """A joint by a row of a Denavit-Hartenberg table."""

    theta: Number = 0.0
    d: Number = 0.0
    a: Number = 0.0
    alpha: Number = 0.0

    @property
    def row(self) -> DHRow:
        """The row of the table."""
        return DHRow(self.theta, self.d, self.a, self.alpha)

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        return super()._unit_suffixes(data) | {"theta": "_deg", "alpha": "_deg", "a": "_mm", "d": "_mm"}


class _InertiaTable(Table):
    xx: Number
    yy: Number
    zz: Number
    xy: Number = 0.0
    xz: Number = 0.0
    yz: Number = 0.0

    def tensor(self) -> FloatArray:
        return symmetric_tensor(self.xx, self.yy, self.zz, self.xy, self.xz, self.yz)


class _InertiaUncertaintyTable(_InertiaTable):
    xx: _Nonnegative
    yy: _Nonnegative
    zz: _Nonnegative
    xy: _Nonnegative = 0.0
    xz: _Nonnegative = 0.0
    yz: _Nonnegative = 0.0


class LinkTable(Table):
    """What every link states."""

    name: str | None = None
    mass: Number
    com: list[Number] = Field(min_length=3, max_length=3)
    inertia: _InertiaTable
    inertia_about: Literal["com", "origin"] = "com"
    as_measured: bool = False
    axial_only: bool = False
    mass_uncertainty: _Nonnegative | None = None
    com_uncertainty: list[_Nonnegative] | None = Field(default=None, min_length=3, max_length=3)
    inertia_uncertainty: _InertiaUncertaintyTable | None = None
    inertia_uncertainty_about: Literal["com", "origin"] | None = None

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
            self.inertia_uncertainty_about or self.inertia_about,
        )

    def inertia_com(self) -> FloatArray:
        """Inertia about the centre of mass, by the parallel-axis theorem where given elsewhere."""
        tensor = self.inertia.tensor()
        about_com = self.inertia_about == "com"
        return tensor if about_com else tensor - of_point_mass(self.mass, np.array(self.com))


class DriveTable(Table):
    """What a drive states."""

    inertia: _Nonnegative = 0.0
    inertia_uncertainty: _Nonnegative | None = None
    gear_ratio: Number = 1.0
    viscous: _Nonnegative = 0.0
    coulomb: list[Number] = Field(default=[0.0, 0.0], min_length=2, max_length=2)
    torque_limit: _Positive | None = None


_JointT = TypeVar("_JointT", bound=JointTable)
_LinkT = TypeVar("_LinkT", bound=LinkTable)


class ArmTables(Table, Generic[_JointT, _LinkT]):
    """The whole file; every table and key of it is described in docs/arms.md."""

    format: Literal["gd-analyze arm 1"]
    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    title: str = ""
    convention: Literal["standard", "modified", "placement"] = "standard"
    gravity: list[Number] = Field(default=[0.0, 0.0, -9.8062], min_length=3, max_length=3)
    sources: list[str] = []
    assumptions: list[str] = []
    doubts: list[str] = []
    joints: list[_JointT] = Field(min_length=1)
    links: list[_LinkT] = Field(min_length=1)
    drives: list[DriveTable] = []


class DHFile(ArmTables[DHJointTable, LinkTable]):
    """A file of an arm by its Denavit-Hartenberg table."""


def keys_beside(
    keys: tuple[str | int, ...], joint: type[JointTable] = DHJointTable, link: type[LinkTable] = LinkTable
) -> list[str]:
    """Keys that the table may have in which a path such as ("links", 2, "mas") ends.

    Examples
    --------
    >>> keys_beside(("links", 1, "inertia", "zx"))
    ['xx', 'yy', 'zz', 'xy', 'xz', 'yz']
    """
    tables: dict[str, type[Table]] = {
        "joints": joint,
        "links": link,
        "drives": DriveTable,
        "inertia": _InertiaTable,
        "inertia_uncertainty": _InertiaUncertaintyTable,
    }
    names = [tables[key] for key in keys[:-1] if isinstance(key, str)]
    return list((names[-1] if names else DHFile).model_fields)
