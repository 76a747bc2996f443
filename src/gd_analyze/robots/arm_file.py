"""Reads an arm from a TOML file: schema, units, and the line of the file that is to blame.

Units are SI and radians unless a key says otherwise: `alpha_deg`, `theta_deg`, `a_mm`, `d_mm`, `com_mm`, and
for a joint's `range`, `rate_limit` and `acceleration_limit` `_deg` where it turns, `_mm` where it slides.
"""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.denavit_hartenberg import modified_placements, standard_placements
from gd_analyze.robots.parts import DHRow, Drive, Joint, JointKind, Link
from gd_analyze.vectors import FloatArray

FORMAT = "gd-analyze arm 1"

_UNIT_SUFFIXES = {"_deg": math.pi / 180, "_mm": 1e-3}
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
            out[key] = _scaled(value, _UNIT_SUFFIXES[suffix]) if suffix else value
        return out


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_scaled(item, factor) for item in value]
    return value * factor if isinstance(value, int | float) and not isinstance(value, bool) else value


class _JointTable(_Table):
    name: str | None = None
    kind: JointKind = "revolute"
    theta: float = 0.0
    d: float = 0.0
    a: float = 0.0
    alpha: float = 0.0
    range: list[float] | None = Field(default=None, min_length=2, max_length=2)
    rate_limit: float | None = None
    acceleration_limit: float | None = None

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        of_motion = "_mm" if data.get("kind") == "prismatic" else "_deg"
        lengths_and_angles = {"theta": "_deg", "alpha": "_deg", "a": "_mm", "d": "_mm"}
        return lengths_and_angles | dict.fromkeys(_LIMITS, of_motion)


class _InertiaTable(_Table):
    xx: float
    yy: float
    zz: float
    xy: float = 0.0
    xz: float = 0.0
    yz: float = 0.0

    def tensor(self) -> FloatArray:
        return np.array(
            [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
        )


class _LinkTable(_Table):
    name: str | None = None
    mass: float
    com: list[float] = Field(min_length=3, max_length=3)
    inertia: _InertiaTable
    inertia_about: Literal["com", "origin"] = "com"
    as_measured: bool = False
    axial_only: bool = False

    @classmethod
    def _unit_suffixes(cls, data: dict[str, Any]) -> dict[str, str]:
        return {"com": "_mm"}

    def inertia_com(self) -> FloatArray:
        """Inertia about the centre of mass, by the parallel-axis theorem where given elsewhere."""
        tensor = self.inertia.tensor()
        if self.inertia_about == "com":
            return tensor
        com = np.array(self.com)
        shifted: FloatArray = tensor - self.mass * ((com @ com) * np.eye(3) - np.outer(com, com))
        return shifted


class _DriveTable(_Table):
    inertia: float = Field(default=0.0, ge=0)
    inertia_uncertainty: float | None = Field(default=None, ge=0)
    gear_ratio: float = 1.0
    viscous: float = Field(default=0.0, ge=0)
    coulomb: list[float] = Field(default=[0.0, 0.0], min_length=2, max_length=2)
    torque_limit: float | None = Field(default=None, gt=0)


class _ArmFile(_Table):
    format: Literal["gd-analyze arm 1"]
    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    title: str = ""
    convention: Literal["standard", "modified"] = "standard"
    gravity: list[float] = Field(default=[0.0, 0.0, -9.8062], min_length=3, max_length=3)
    sources: list[str] = []
    assumptions: list[str] = []
    joints: list[_JointTable] = Field(min_length=1)
    links: list[_LinkTable] = Field(min_length=1)
    drives: list[_DriveTable] = []


def read_arm(path: str | Path) -> RobotArm:
    """Read an arm from a TOML file.

    Parameters
    ----------
    path
        The file; docs/arms.md describes its keys.

    Returns
    -------
    RobotArm
        A valid arm.

    Raises
    ------
    ArmError
        If the file cannot be read, is not TOML, does not fit the schema or describes an impossible arm;
        the message names the line.
    """
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        raise ArmError("cannot read the arm file", where=Location(path), found=error.strerror) from None
    except UnicodeDecodeError as error:
        raise ArmError(
            "the arm file is not text",
            where=Location(path),
            expected="a TOML file in UTF-8",
            found=f"byte 0x{error.object[error.start]:02x} at offset {error.start}",
        ) from None
    if text.lstrip("\ufeff \t\r\n").startswith("<"):
        raise ArmError(
            "the arm file is XML, such as URDF or MJCF, which is not read",
            where=Location(path),
            expected="a TOML file with a Denavit-Hartenberg table, masses, centres of mass and inertias",
            found=text.lstrip("\ufeff \t\r\n").split("\n", 1)[0][:60],
            next_step="`gd-analyze arms puma560 --toml` prints a complete example; docs/arms.md has the keys",
        )
    lines = _TableLines(path, text)
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
        raise ArmError(
            "the arm file is not valid TOML",
            where=Location(path, line, column),
            found=re.sub(r" \(at .*\)$", "", str(error)),
            next_step="mend the syntax there; `gd-analyze arms puma560 --toml` prints a complete example",
        ) from None
    try:
        parsed = _ArmFile.model_validate(document)
    except ValidationError as error:
        first = error.errors()[0]
        keys = first["loc"]
        raise ArmError(
            f"the arm file does not fit the schema: {_dotted(keys) or 'top level'}",
            where=lines.locate(keys),
            expected=_expectation(first["msg"]),
            found="nothing" if first["type"] == "missing" else repr(first["input"])[:120],
            next_step="`gd-analyze arms puma560 --toml` prints a complete example",
        ) from None
    return _build(parsed, lines)


def _build(parsed: _ArmFile, lines: _TableLines) -> RobotArm:
    for what in ("links", "drives"):
        count = len(getattr(parsed, what))
        if count != len(parsed.joints) and (count or what == "links"):
            raise ArmError(
                f"the arm file needs one [[{what}]] table per joint",
                where=lines.locate((what, max(0, count - 1))),
                expected=f"{len(parsed.joints)} [[{what}]] tables",
                found=str(count),
            )
    placements = standard_placements if parsed.convention == "standard" else modified_placements
    joints, links, rows = [], [], []
    for i, (joint, link) in enumerate(zip(parsed.joints, parsed.links, strict=True)):
        row = DHRow(joint.theta, joint.d, joint.a, joint.alpha)
        before, behind = placements(joint.kind, row)
        lower, upper = joint.range or (None, None)
        rows.append(row)
        joints.append(
            Joint(
                name=joint.name or str(i + 1),
                kind=joint.kind,
                placement=before,
                lower=lower,
                upper=upper,
                rate_limit=joint.rate_limit,
                acceleration_limit=joint.acceleration_limit,
                source=lines.locate(("joints", i)),
            )
        )
        links.append(
            Link(
                name=link.name or str(i + 1),
                mass=link.mass,
                com=np.array(link.com),
                inertia_com=link.inertia_com(),
                frame=behind,
                as_measured=link.as_measured,
                axial_only=link.axial_only,
                source=lines.locate(("links", i)),
            )
        )
    return RobotArm(
        name=parsed.name,
        title=parsed.title or parsed.name,
        gravity=np.array(parsed.gravity),
        joints=tuple(joints),
        links=tuple(links),
        drives=tuple(
            Drive(
                drive.inertia,
                drive.inertia_uncertainty,
                drive.gear_ratio,
                drive.viscous,
                (drive.coulomb[0], drive.coulomb[1]),
                drive.torque_limit,
            )
            for drive in parsed.drives
        ),
        dh_table=tuple(rows),
        convention=f"{parsed.convention} Denavit-Hartenberg",
        sources=tuple(parsed.sources),
        assumptions=tuple(parsed.assumptions),
    )


def _dotted(keys: tuple[str | int, ...]) -> str:
    return "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in keys).lstrip(".")


def _expectation(message: str) -> str:
    """Reword the validator's message as an expectation."""
    if message.startswith("Extra inputs"):
        return "a key of the schema (check the spelling)"
    return message.removeprefix("Value error, ").removeprefix("Input should be ")


class _TableLines:
    """Line numbers of tables and keys; the TOML parser of the standard library keeps none."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self._lines: dict[tuple[str | int, ...], int] = {}
        counts: dict[str, int] = {}
        table: tuple[str | int, ...] = ()
        for number, line in enumerate(text.splitlines(), start=1):
            if header := re.match(r"\s*\[\[\s*([\w.-]+)\s*\]\]", line):
                index = counts[header[1]] = counts.get(header[1], -1) + 1
                table = (header[1], index)
                self._lines[table] = number
            elif key := re.match(r"\s*([\w-]+)\s*=", line):
                self._lines[(*table, key[1])] = number

    def locate(self, keys: tuple[str | int, ...]) -> Location:
        """Line of the innermost known key of a path such as ("links", 2, "mass")."""
        for end in range(len(keys), 0, -1):
            for suffix in ("", *_UNIT_SUFFIXES):
                candidate = (*keys[: end - 1], f"{keys[end - 1]}{suffix}") if suffix else keys[:end]
                if candidate in self._lines:
                    return Location(self.path, self._lines[candidate])
        return Location(self.path)
