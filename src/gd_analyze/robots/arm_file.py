"""Reads an arm from a TOML file: keys, units and what each must hold, and the line that an error is about.

Units are SI and radians unless a key has a suffix, such as `alpha_deg` and `a_mm`; docs/arms.md has all keys.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Generic, Literal, TypeVar

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import CONVENTIONS, roll_pitch_yaw
from gd_analyze.robots.parts import (
    ORTHONORMAL_TOLERANCE,
    DHRow,
    Drive,
    Joint,
    JointKind,
    Link,
    LinkUncertainty,
    Placement,
    is_name,
    is_rotation,
    is_sentence,
    of_point_mass,
    symmetric_tensor,
)
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.text_file import UNIT_SUFFIXES, TableLines, parsed_toml, text_of
from gd_analyze.text import LARGEST, in_python

# A thousand joints with their links and drives.
_LARGEST_FILE = 1_000_000
# Convention of an arm without a Denavit-Hartenberg table.
_PLACEMENTS = "placements"


def _that(holds: Callable[[Any], bool], expected: str) -> AfterValidator:
    def checked(value: Any) -> Any:
        if not holds(value):
            raise ValueError(expected)
        return value

    return AfterValidator(checked)


def _are_ends(ends: list[float]) -> bool:
    return all(
        abs(end) <= LARGEST or end == none for end, none in zip(ends, (-math.inf, math.inf), strict=True)
    )


# NaN and infinity are refused by the tables.
_Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
_Nonnegative = Annotated[float, Field(ge=0, le=LARGEST)]
_Vector = Annotated[list[_Number], Field(min_length=3, max_length=3)]
_Ends = Annotated[list[Annotated[float, Field(allow_inf_nan=True)]], Field(min_length=2, max_length=2)]
_Range = Annotated[
    _Ends, _that(_are_ends, f"lower and upper end up to {LARGEST:g}, or -inf and inf where unknown")
]
_Rows = Annotated[list[_Vector], Field(min_length=3, max_length=3)]
_Rotation = Annotated[_Rows, _that(is_rotation, "a rotation: three orthonormal rows, right-handed")]
_Direction = Annotated[
    _Vector, _that(lambda axis: abs(math.hypot(*axis) - 1) <= ORTHONORMAL_TOLERANCE, "a unit vector")
]
_Name = Annotated[str, _that(is_name, "one short line of printable text")]
_Sentences = list[Annotated[str, _that(is_sentence, "text without control characters")]]
_About = Literal["com", "origin"]


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
        of_kind = "_mm" if data.get("kind") == "prismatic" else "_deg"
        bare = {f"{key}{suffix or of_kind}": key for key, suffix in cls.SUFFIXES.items()}
        out: dict[str, Any] = {}
        for given, value in data.items():
            key = str(bare.get(given, given))
            if key in out:
                raise ValueError(f"{key} is given twice, once with a unit suffix")
            out[key] = value if key == given else _scaled(value, UNIT_SUFFIXES[given[len(key) :]])
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

    name: _Name | None = None
    kind: JointKind = "revolute"
    range: _Range | None = None
    velocity_limit: _Number | None = None
    acceleration_limit: _Number | None = None


class DHJointTable(JointTable):
    """A joint by a row of a Denavit-Hartenberg table."""

    SUFFIXES = JointTable.SUFFIXES | {"theta": "_deg", "alpha": "_deg", "a": "_mm", "d": "_mm"}

    theta: _Number = 0.0
    d: _Number = 0.0
    a: _Number = 0.0
    alpha: _Number = 0.0


class PlacedJointTable(JointTable):
    """A joint by its frame in the frame of the link before, and its axis in its own."""

    SUFFIXES = JointTable.SUFFIXES | {"xyz": "_mm", "rpy": "_deg"}

    xyz: _Vector = [0.0, 0.0, 0.0]
    rpy: _Vector | None = None
    rotation: _Rotation | None = None
    axis: _Direction = [0.0, 0.0, 1.0]


class InertiaTable(Table):
    """Entries of an inertia tensor."""

    xx: _Number
    yy: _Number
    zz: _Number
    xy: _Number = 0.0
    xz: _Number = 0.0
    yz: _Number = 0.0


_InertiaUncertainty = Annotated[
    InertiaTable, _that(lambda table: min(dict(table).values()) >= 0, "entries of 0 or more")
]


class LinkTable(Table):
    """What every link states."""

    SUFFIXES = {"com": "_mm", "com_uncertainty": "_mm"}

    name: _Name | None = None
    mass: _Number
    com: _Vector
    inertia: InertiaTable
    inertia_about: _About = "com"
    as_measured: bool = False
    axial_only: bool = False
    mass_uncertainty: _Nonnegative | None = None
    com_uncertainty: list[_Nonnegative] | None = Field(default=None, min_length=3, max_length=3)
    inertia_uncertainty: _InertiaUncertainty | None = None
    inertia_uncertainty_about: _About | None = None

    def uncertainty(self) -> LinkUncertainty | None:
        """Stated uncertainties; None where nothing is stated."""
        mass, com, inertia = self.mass_uncertainty, self.com_uncertainty, self.inertia_uncertainty
        if mass is None and com is None and inertia is None:
            return None
        return LinkUncertainty(
            mass,
            None if com is None else np.array(com),
            None if inertia is None else symmetric_tensor(**dict(inertia)),
            self.inertia_uncertainty_about or self.inertia_about,
        )

    def inertia_com(self) -> FloatArray:
        """Inertia about the centre of mass, by the parallel-axis theorem where given elsewhere."""
        tensor = symmetric_tensor(**dict(self.inertia))
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
    gear_ratio: _Number = 1.0
    viscous: _Nonnegative = 0.0
    coulomb: list[_Number] = Field(default=[0.0, 0.0], min_length=2, max_length=2)
    torque_limit: Annotated[float, Field(gt=0, le=LARGEST)] | None = None


_Joints = TypeVar("_Joints", bound=JointTable)
_Links = TypeVar("_Links", bound=LinkTable)


class ArmTables(Table, Generic[_Joints, _Links]):
    """What every file states."""

    format: Literal["gd-analyze arm 1"]
    name: _Name = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    title: _Name = ""
    convention: Literal["standard", "modified", "placement"] = "standard"
    gravity: _Vector = [0.0, 0.0, -9.8062]
    sources: _Sentences = []
    assumptions: _Sentences = []
    doubts: _Sentences = []
    joints: Annotated[list[_Joints], Field(min_length=1)]
    links: Annotated[list[_Links], Field(min_length=1)]
    drives: list[DriveTable] = []


DHFile = ArmTables[DHJointTable, LinkTable]
PlacementFile = ArmTables[PlacedJointTable, PlacedLinkTable]


def read_arm(path: str | Path) -> RobotArm:
    """Read an arm from a TOML file; warns of implausible numbers, ArmError with the line of what is wrong."""
    path = Path(path)
    content = text_of_arm_file(path)
    document = parsed_toml(path, content, "arm file")
    schema: type[ArmTables[Any, Any]] = PlacementFile if document.get("convention") == "placement" else DHFile
    lines = TableLines(path, content)
    try:
        parsed = schema.model_validate(document)
    except ValidationError as error:
        raise _misfit(error.errors(), lines) from None
    arm = _build(parsed, lines)
    warn_of_implausible(arm, stacklevel=3)
    return arm


def text_of_arm_file(path: Path) -> str:
    """Text of an arm file; ArmError if it cannot be read, is not text, or is longer than any arm's."""
    return text_of(path, "arm file", _LARGEST_FILE)


def _misfit(errors: Sequence[ErrorDetails], lines: TableLines) -> ArmError:
    """Refusal of what does not fit the schema; in the place of a missing key, a misspelt one beside it."""
    unknown = [error for error in errors if error["type"] == "extra_forbidden"]
    misspelt = (error for error in unknown if error["loc"][:-1] == errors[0]["loc"][:-1])
    first = next(misspelt, errors[0]) if errors[0]["type"] == "missing" else errors[0]
    keys = first["loc"]
    likely = _likely(str(keys[-1])) if first in unknown else ""
    dotted = "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in keys).lstrip(".")
    return ArmError(
        f"the arm file does not fit the schema: {dotted or 'top level'}",
        where=lines.locate(keys),
        expected=first["msg"].removeprefix("Value error, ").removeprefix("Input should be "),
        found="nothing" if first["type"] == "missing" else in_python(first["input"]),
        next_step=(f"did you mean {likely}? " if likely else "")
        + "`gd-analyze arms puma560 --to toml` prints a complete example",
    )


def _likely(key: str) -> str:
    """Key that a misspelt one likely stands for; its unit suffix stays, unless that is what is wrong."""
    tables: tuple[type[Table], ...] = (
        PlacementFile,
        DHJointTable,
        PlacedJointTable,
        PlacedLinkTable,
        InertiaTable,
        DriveTable,
    )
    known = {name for table in tables for name in table.model_fields}
    suffix = next((suffix for suffix in UNIT_SUFFIXES if key.endswith(suffix)), "")
    bare = key.removesuffix(suffix)
    near = difflib.get_close_matches(bare, sorted(known), n=1)
    return "" if not near else bare if bare in known else near[0] + suffix


def _build(parsed: ArmTables[Any, Any], lines: TableLines) -> RobotArm:
    n = len(parsed.joints)
    for what, count in (("links", len(parsed.links)), ("drives", len(parsed.drives))):
        if count != n and (count or what == "links"):
            problem, where = (
                f"the arm file needs one [[{what}]] table per joint",
                lines.locate((what, count - 1)),
            )
            raise ArmError(problem, where=where, expected=f"{n} [[{what}]] tables", found=str(count))
    joints, links, rows = [], [], []
    for i, (joint, link) in enumerate(zip(parsed.joints, parsed.links, strict=True)):
        axis = [0.0, 0.0, 1.0]
        if isinstance(joint, PlacedJointTable) and isinstance(link, PlacedLinkTable):
            before, axis = _placement(joint.xyz, joint.rpy, joint.rotation), joint.axis
            behind = _placement(link.frame_xyz, link.frame_rpy, link.frame_rotation)
        elif isinstance(joint, DHJointTable):
            rows.append(DHRow(joint.theta, joint.d, joint.a, joint.alpha))
            before, behind = CONVENTIONS[parsed.convention][1](joint.kind, rows[-1])
        lower, upper = (end if math.isfinite(end) else None for end in joint.range or (-math.inf, math.inf))
        limits = (lower, upper, joint.velocity_limit, joint.acceleration_limit)
        name, where = joint.name or str(i + 1), lines.locate(("joints", i))
        joints.append(Joint(name, joint.kind, before, np.array(axis), *limits, where))
        known = (link.as_measured, link.axial_only, link.uncertainty(), lines.locate(("links", i)))
        name, com = link.name or str(i + 1), np.array(link.com)
        links.append(Link(name, link.mass, com, link.inertia_com(), behind, *known))
    drives = (Drive(**{**dict(drive), "coulomb": tuple(drive.coulomb)}) for drive in parsed.drives)
    return RobotArm(
        name=parsed.name,
        title=parsed.title or parsed.name,
        gravity=np.array(parsed.gravity),
        joints=tuple(joints),
        links=tuple(links),
        drives=tuple(drives),
        dh_table=tuple(rows),
        convention=CONVENTIONS[parsed.convention][0] if rows else _PLACEMENTS,
        **{key: tuple(getattr(parsed, key)) for key in ("sources", "assumptions", "doubts")},
    )


def _placement(xyz: list[float], rpy: list[float] | None, rotation: list[list[float]] | None) -> Placement:
    turned = np.eye(3) if rpy is None else roll_pitch_yaw(*rpy)
    return Placement(turned if rotation is None else np.array(rotation), np.array(xyz))
