"""Reads an arm from a TOML file: its schema, its units, and the line of the file that an error is about.

Units are SI and radians unless a key says otherwise: `alpha_deg`, `theta_deg`, `a_mm`, `d_mm`, `com_mm`; a
joint's `range`, `velocity_limit` and `acceleration_limit` take `_deg` (revolute) or `_mm` (prismatic).
"""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from gd_analyze.errors import ArmError, Location
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_schema import (
    UNIT_SUFFIXES,
    ArmTables,
    DHFile,
    DHJointTable,
    DriveTable,
    InertiaTable,
    InertiaUncertaintyTable,
    LinkTable,
    PlacedJointTable,
    PlacedLinkTable,
    PlacementFile,
    Table,
)
from gd_analyze.robots.frames import CONVENTIONS, roll_pitch_yaw
from gd_analyze.robots.limits import invalid_toml
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement, is_sentence, require_name
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.text import in_python

# A thousand joints with their links and drives.
LARGEST_FILE = 1_000_000
# Convention of an arm without a Denavit-Hartenberg table.
PLACEMENTS = "placements"
_EXAMPLE = "`gd-analyze arms puma560 --to toml` prints a complete example"


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

    Warns
    -----
    GdAnalyzeWarning
        Of every implausible number, such as an angle in degrees or a mass in grams.
    """
    path = Path(path)
    content = text_of_arm_file(path)
    lines = TableLines(path, content)
    schema: type[ArmTables] = DHFile
    try:
        document = _document(path, content)
        if document.get("convention") == "placement":
            schema = PlacementFile
        arm = _build(schema.model_validate(document), lines)
    except ValidationError as error:
        raise _misfit(error.errors(), lines, schema) from None
    except RecursionError:
        what = "the arm file nests tables or lists beyond any arm"
        raise ArmError(what, where=Location(path), next_step=_EXAMPLE) from None
    warn_of_implausible(arm, stacklevel=3)
    return arm


def text_of_arm_file(path: Path) -> str:
    """Text of an arm file.

    Raises
    ------
    ArmError
        If it cannot be read, is not text, or is longer than any arm's.
    """
    where = Location(path)
    try:
        data = read_at_most(path, LARGEST_FILE)
        if data is not None:
            return data.decode("utf-8")
    except OSError as error:
        raise ArmError("cannot read the arm file", where=where, found=error.strerror) from None
    except UnicodeDecodeError as error:
        found = f"byte 0x{error.object[error.start]:02x} at offset {error.start}"
        expected = "a robot's URDF, MJCF or TOML file in UTF-8"
        raise ArmError("the arm file is not text", where=where, expected=expected, found=found) from None
    expected = f"up to {megabytes(LARGEST_FILE)}; a joint with its link takes less than 1 kB"
    raise ArmError("the arm file is too large", where=where, expected=expected, found="more")


def _document(path: Path, content: str) -> dict[str, Any]:
    try:
        return tomllib.loads(content)
    except tomllib.TOMLDecodeError as error:
        raise invalid_toml("the arm file", path, content, error) from None
    except ValueError:  # Python reads no integers of thousands of digits
        lines = enumerate(content.splitlines(), start=1)
        line = next((number for number, text in lines if re.search(r"\d[\d_]{4000}", text)), None)
        what = "the arm file holds a number of thousands of digits"
        raise ArmError(what, where=Location(path, line), next_step=_EXAMPLE) from None


class TableLines:
    """Line numbers of tables and keys, which `tomllib` does not keep."""

    def __init__(self, path: Path, content: str) -> None:
        self.path = path
        self._lines: dict[tuple[str | int, ...], int] = {}
        counts: dict[str, int] = {}
        table: tuple[str | int, ...] = ()
        for number, line in enumerate(content.splitlines(), start=1):
            if header := re.match(r"\s*\[\[\s*([\w.-]+)\s*\]\]", line):
                index = counts[header[1]] = counts.get(header[1], -1) + 1
                table = (header[1], index)
                self._lines[table] = number
            elif key := re.match(r"\s*([\w-]+)\s*=", line):
                self._lines[(*table, key[1])] = number

    def locate(self, keys: tuple[str | int, ...]) -> Location:
        """Line of the innermost known key of a path such as ("links", 2, "mass")."""
        for end in range(len(keys), 0, -1):
            for suffix in ("", *UNIT_SUFFIXES):
                candidate = (*keys[: end - 1], f"{keys[end - 1]}{suffix}") if suffix else keys[:end]
                if candidate in self._lines:
                    return Location(self.path, self._lines[candidate])
        return Location(self.path)


def _misfit(errors: Sequence[ErrorDetails], lines: TableLines, schema: type[ArmTables]) -> ArmError:
    """Refusal of what does not fit the schema; in the place of a missing key, a misspelt one beside it."""
    first = errors[0]
    if first["type"] == "missing":
        unknown = (error for error in errors if error["type"] == "extra_forbidden")
        first = next((error for error in unknown if error["loc"][:-1] == first["loc"][:-1]), first)
    keys = first["loc"]
    expected = first["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    next_step = _EXAMPLE
    if first["type"] == "extra_forbidden":
        known = _keys_beside(keys, schema)
        expected = f"a key of the schema: {', '.join(known)}"
        if near := _nearest(str(keys[-1]), known):
            next_step = f"did you mean {near}? {_EXAMPLE}"
    dotted = "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in keys).lstrip(".")
    return ArmError(
        f"the arm file does not fit the schema: {dotted or 'top level'}",
        where=lines.locate(keys),
        expected=expected,
        found="nothing" if first["type"] == "missing" else in_python(first["input"]),
        next_step=next_step,
    )


def _keys_beside(keys: tuple[str | int, ...], schema: type[ArmTables]) -> list[str]:
    """Keys of the table in which a path such as ("links", 2, "mas") ends."""
    placed = schema is PlacementFile
    tables: dict[str, type[Table]] = {
        "joints": PlacedJointTable if placed else DHJointTable,
        "links": PlacedLinkTable if placed else LinkTable,
        "drives": DriveTable,
        "inertia": InertiaTable,
        "inertia_uncertainty": InertiaUncertaintyTable,
    }
    names = [key for key in keys[:-1] if isinstance(key, str)]
    return list((tables[names[-1]] if names else schema).model_fields)


def _nearest(key: str, known: Sequence[str]) -> str | None:
    """Key that a misspelt one likely stands for; its unit suffix stays, unless that is what is wrong."""
    suffix = next((suffix for suffix in UNIT_SUFFIXES if key.endswith(suffix)), "")
    bare = key.removesuffix(suffix)
    near = difflib.get_close_matches(bare, known, n=1)
    return (bare if bare in known else near[0] + suffix) if near else None


def _build(parsed: ArmTables, lines: TableLines) -> RobotArm:
    for key in ("name", "title"):
        require_name(getattr(parsed, key), f"an arm's {key}", lines.locate((key,)))
    for key in ("sources", "assumptions", "doubts"):
        if not all(map(is_sentence, getattr(parsed, key))):
            raise ArmError(f"one of the {key} is not printable", where=lines.locate((key,)), expected="text")
    n = len(parsed.joints)
    for what, count in (("links", len(parsed.links)), ("drives", len(parsed.drives))):
        if count != n and (count or what == "links"):
            raise ArmError(
                f"the arm file needs one [[{what}]] table per joint",
                where=lines.locate((what, max(0, count - 1))),
                expected=f"{n} [[{what}]] tables",
                found=str(count),
            )
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
        joints.append(
            Joint(
                joint.name or str(i + 1),
                joint.kind,
                before,
                np.array(axis),
                lower,
                upper,
                joint.velocity_limit,
                joint.acceleration_limit,
                lines.locate(("joints", i)),
            )
        )
        links.append(
            Link(
                link.name or str(i + 1),
                link.mass,
                np.array(link.com),
                link.inertia_com(),
                behind,
                link.as_measured,
                link.axial_only,
                link.uncertainty(),
                lines.locate(("links", i)),
            )
        )
    drives = (Drive(**{**dict(drive), "coulomb": tuple(drive.coulomb)}) for drive in parsed.drives)
    return RobotArm(
        name=parsed.name,
        title=parsed.title or parsed.name,
        gravity=np.array(parsed.gravity),
        joints=tuple(joints),
        links=tuple(links),
        drives=tuple(drives),
        dh_table=tuple(rows),
        convention=CONVENTIONS[parsed.convention][0] if rows else PLACEMENTS,
        sources=tuple(parsed.sources),
        assumptions=tuple(parsed.assumptions),
        doubts=tuple(parsed.doubts),
    )


def _placement(xyz: list[float], rpy: list[float] | None, rotation: list[list[float]] | None) -> Placement:
    turned = np.eye(3) if rpy is None else roll_pitch_yaw(*rpy)
    return Placement(turned if rotation is None else np.array(rotation), np.array(xyz))
