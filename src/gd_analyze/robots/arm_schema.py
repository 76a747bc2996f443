"""Schema of an arm's TOML file: keys, units and what each must hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.parts import (
    ORTHONORMAL_TOLERANCE,
    JointKind,
    LinkUncertainty,
    Placement,
    of_point_mass,
    symmetric_tensor,
)
from gd_analyze.text import LARGEST

UNIT_SUFFIXES = {"_deg": math.pi / 180, "_mm": 1e-3}

# NaN and infinity are refused by the tables.
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
_Nonnegative = Annotated[float, Field(ge=0, le=LARGEST)]
_Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
_About = Literal["com", "origin"]


def _ends(ends: list[float]) -> list[float]:
    for end, unknown in zip(ends, (-math.inf, math.inf), strict=True):
        if end != unknown and not abs(end) <= LARGEST:
            raise ValueError(f"lower and upper end up to {LARGEST:g}, or -inf and inf where unknown")
    return ends


def _rotation(rows: list[list[float]]) -> list[list[float]]:
    try:
        Placement(np.array(rows))
    except ArmError:
        raise ValueError("a rotation: three orthonormal rows, right-handed") from None
    return rows


def _direction(axis: list[float]) -> list[float]:
    length = float(np.linalg.norm(axis))
    if abs(length - 1) > ORTHONORMAL_TOLERANCE:
        raise ValueError(f"a unit vector, of length 1 instead of {length:g}")
    return axis


_End = Annotated[float, Field(allow_inf_nan=True)]
_Range = Annotated[list[_End], Field(min_length=2, max_length=2), AfterValidator(_ends)]
_Rotation = Annotated[list[_Vector], Field(min_length=3, max_length=3), AfterValidator(_rotation)]
_Direction = Annotated[_Vector, AfterValidator(_direction)]


class Table(BaseModel):
    """Keys of one table of the file; an unknown one is refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    # Unit suffix that each key may take; "" where it depends on the kind of joint.
    SUFFIXES: ClassVar[dict[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _to_si(cls, data: Any) -> Any:
        """Fold keys with a unit suffix into their SI key."""
        if not isinstance(data, dict):
            return data
        by_kind = "_mm" if data.get("kind") == "prismatic" else "_deg"
        suffixes = {key: suffix or by_kind for key, suffix in cls.SUFFIXES.items()}
        converted = {f"{key}{suffix}": (key, suffix) for key, suffix in suffixes.items()}
        out: dict[str, Any] = {}
        for given, value in data.items():
            key, suffix = converted.get(given, (given, ""))
            if key in out:
                raise ValueError(f"{key} is given twice, once with a unit suffix")
            out[key] = _scaled(value, UNIT_SUFFIXES[suffix]) if suffix else value
        return out

    @model_validator(mode="after")
    def _one_rotation(self) -> Table:
        for prefix in ("", "frame_"):
            if getattr(self, f"{prefix}rpy", None) and getattr(self, f"{prefix}rotation", None):
                raise ValueError(f"either {prefix}rpy or {prefix}rotation, which say the same")
        return self


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_scaled(item, factor) for item in value]
    if not isinstance(value, int | float) or isinstance(value, bool):
        return value
    try:
        return value * factor
    except OverflowError:  # an integer that no float can hold: the schema refuses it
        return value


class JointTable(Table):
    """What every joint may state."""

    SUFFIXES = dict.fromkeys(("range", "velocity_limit", "acceleration_limit"), "")

    name: str | None = None
    kind: JointKind = "revolute"
    range: _Range | None = None
    velocity_limit: Number | None = None
    acceleration_limit: Number | None = None


class DHJointTable(JointTable):
    """A joint by a row of a Denavit-Hartenberg table."""

    SUFFIXES = JointTable.SUFFIXES | {"theta": "_deg", "alpha": "_deg", "a": "_mm", "d": "_mm"}

    theta: Number = 0.0
    d: Number = 0.0
    a: Number = 0.0
    alpha: Number = 0.0


class PlacedJointTable(JointTable):
    """A joint by its frame in the frame of the link before, and its axis in its own."""

    SUFFIXES = JointTable.SUFFIXES | {"xyz": "_mm", "rpy": "_deg"}

    xyz: _Vector = [0.0, 0.0, 0.0]
    rpy: _Vector | None = None
    rotation: _Rotation | None = None
    axis: _Direction = [0.0, 0.0, 1.0]


class InertiaTable(Table):
    """Entries of an inertia tensor."""

    xx: Number
    yy: Number
    zz: Number
    xy: Number = 0.0
    xz: Number = 0.0
    yz: Number = 0.0

    def tensor(self) -> FloatArray:
        """Matrix, shape (3, 3)."""
        return symmetric_tensor(self.xx, self.yy, self.zz, self.xy, self.xz, self.yz)


class InertiaUncertaintyTable(InertiaTable):
    """Standard uncertainties of the entries of an inertia tensor."""

    xx: _Nonnegative
    yy: _Nonnegative
    zz: _Nonnegative
    xy: _Nonnegative = 0.0
    xz: _Nonnegative = 0.0
    yz: _Nonnegative = 0.0


class LinkTable(Table):
    """What every link states."""

    SUFFIXES = {"com": "_mm", "com_uncertainty": "_mm"}

    name: str | None = None
    mass: Number
    com: _Vector
    inertia: InertiaTable
    inertia_about: _About = "com"
    as_measured: bool = False
    axial_only: bool = False
    mass_uncertainty: _Nonnegative | None = None
    com_uncertainty: list[_Nonnegative] | None = Field(default=None, min_length=3, max_length=3)
    inertia_uncertainty: InertiaUncertaintyTable | None = None
    inertia_uncertainty_about: _About | None = None

    def uncertainty(self) -> LinkUncertainty | None:
        """Stated uncertainties; None where nothing is stated."""
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


class PlacedLinkTable(LinkTable):
    """A link, and its frame in the frame of its joint."""

    SUFFIXES = LinkTable.SUFFIXES | {"frame_xyz": "_mm", "frame_rpy": "_deg"}

    frame_xyz: _Vector = [0.0, 0.0, 0.0]
    frame_rpy: _Vector | None = None
    frame_rotation: _Rotation | None = None


class DriveTable(Table):
    """What a drive states."""

    inertia: _Nonnegative = 0.0
    inertia_uncertainty: _Nonnegative | None = None
    gear_ratio: Number = 1.0
    viscous: _Nonnegative = 0.0
    coulomb: list[Number] = Field(default=[0.0, 0.0], min_length=2, max_length=2)
    torque_limit: Annotated[float, Field(gt=0, le=LARGEST)] | None = None


class ArmTables(Table):
    """The whole file; every table and key is described in docs/arms.md."""

    format: Literal["gd-analyze arm 1"]
    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    title: str = ""
    convention: Literal["standard", "modified", "placement"] = "standard"
    gravity: _Vector = [0.0, 0.0, -9.8062]
    sources: list[str] = []
    assumptions: list[str] = []
    doubts: list[str] = []
    joints: Sequence[JointTable]
    links: Sequence[LinkTable]
    drives: list[DriveTable] = []


class DHFile(ArmTables):
    """A file of an arm by its Denavit-Hartenberg table."""

    joints: Annotated[Sequence[DHJointTable], Field(min_length=1)]
    links: Annotated[Sequence[LinkTable], Field(min_length=1)]


class PlacementFile(ArmTables):
    """A file of an arm by placements."""

    joints: Annotated[Sequence[PlacedJointTable], Field(min_length=1)]
    links: Annotated[Sequence[PlacedLinkTable], Field(min_length=1)]
