"""Reads an arm from a TOML file: schema, units, and the line of the file that is to blame.

Units are SI and radians unless a key says otherwise: `alpha_deg`, `theta_deg`, `a_mm`, `d_mm`, `com_mm`, and
for a joint's `range`, `velocity_limit` and `acceleration_limit` `_deg` where it turns, `_mm` where it slides.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, Location
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_schema import (
    UNIT_SUFFIXES,
    DHFile,
    DHJointTable,
    JointTable,
    LinkTable,
    keys_beside,
)
from gd_analyze.robots.frames import CONVENTIONS, placements_of
from gd_analyze.robots.parts import Drive, Joint, Link, Placement, require_name, require_sentences
from gd_analyze.robots.placement_schema import PlacedJointTable, PlacedLinkTable, PlacementFile
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.toml_lines import TableLines
from gd_analyze.text import in_python

_EXAMPLE = "`gd-analyze arms puma560 --to toml` prints a complete example"
_LONG_INTEGER = re.compile(r"\d[\d_]{4000}")

# A thousand joints with their links and drives.
LARGEST_FILE = 1_000_000

# What an arm by placements is called where a Denavit-Hartenberg table would be named.
PLACEMENTS = "placements"


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
        Of every number that looks like a slip of the unit, such as an angle in degrees or a mass in grams.
    """
    path = Path(path)
    content = _read(path)
    lines = TableLines(path, content)
    schema: type[DHFile | PlacementFile] = DHFile
    try:
        document = _document(path, content)
        if document.get("convention") == "placement":
            schema = PlacementFile
        parsed = schema.model_validate(document)
    except ValidationError as error:
        raise _misfit(error.errors(), lines, schema) from None
    except RecursionError:
        raise ArmError(
            "the arm file nests tables or lists beyond any arm", where=Location(path), next_step=_EXAMPLE
        ) from None
    arm = _build(parsed, lines)
    warn_of_implausible(arm, stacklevel=3)
    return arm


def _misfit(
    errors: Sequence[ErrorDetails], lines: TableLines, schema: type[DHFile | PlacementFile]
) -> ArmError:
    """Say what of a file does not fit the schema: of a key that is missing, the one that was meant for it."""
    first = errors[0]
    if first["type"] == "missing":
        table = first["loc"][:-1]
        strange = [error for error in errors if error["type"] == "extra_forbidden"]
        first = next((error for error in strange if error["loc"][:-1] == table), first)
    keys = first["loc"]
    expected, next_step = _expectation(first["msg"]), _EXAMPLE
    if first["type"] == "extra_forbidden":
        placed = (PlacedJointTable, PlacedLinkTable) if schema is PlacementFile else ()
        known = keys_beside(keys, *placed)
        expected = f"a key of the schema: {', '.join(known)}"
        near = _nearest(str(keys[-1]), known)
        next_step = f"did you mean {near}? {_EXAMPLE}" if near else _EXAMPLE
    return ArmError(
        f"the arm file does not fit the schema: {_dotted(keys) or 'top level'}",
        where=lines.locate(keys),
        expected=expected,
        found="nothing" if first["type"] == "missing" else in_python(first["input"]),
        next_step=next_step,
    )


def _nearest(key: str, known: Sequence[str]) -> str | None:
    """Key that is likely meant by a misspelt one; a suffix for its unit stays, unless it is what is wrong."""
    suffix = next((suffix for suffix in UNIT_SUFFIXES if key.endswith(suffix)), "")
    bare = key.removesuffix(suffix)
    near = difflib.get_close_matches(bare, known, n=1)
    return (bare if bare in known else near[0] + suffix) if near else None


def _read(path: Path) -> str:
    """Text of an arm file that may be TOML."""
    try:
        content = text_of_arm_file(path)
    except OSError as error:
        raise ArmError("cannot read the arm file", where=Location(path), found=error.strerror) from None
    except UnicodeDecodeError as error:
        raise ArmError(
            "the arm file is not text",
            where=Location(path),
            expected="a robot's URDF, MJCF or TOML file in UTF-8",
            found=f"byte 0x{error.object[error.start]:02x} at offset {error.start}",
            next_step="check that it is an arm's file",
        ) from None
    return content


def _document(path: Path, content: str) -> dict[str, Any]:
    """Tables and keys as TOML has them."""
    try:
        return tomllib.loads(content)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(place[1]), int(place[2])) if place else (content.count("\n") + 1, None)
        raise ArmError(
            "the arm file is not valid TOML",
            where=Location(path, line, column),
            found=re.sub(r" \(at .*\)$", "", str(error)),
            next_step=f"mend the syntax there; {_EXAMPLE}",
        ) from None
    except ValueError:
        # Python reads no integers of thousands of digits; nothing else beside the syntax makes it refuse.
        texts = enumerate(content.splitlines(), start=1)
        longest = next((number for number, text in texts if _LONG_INTEGER.search(text)), None)
        raise ArmError(
            "the arm file holds a number of thousands of digits",
            where=Location(path, longest),
            expected="a number that a measurement or a drawing can give",
            next_step=_EXAMPLE,
        ) from None


def text_of_arm_file(path: Path) -> str:
    """Read the text of an arm file, which is short.

    Raises
    ------
    ArmError
        If the file is longer than any arm's.
    OSError, UnicodeDecodeError
        If it cannot be read or is not text.
    """
    data = read_at_most(path, LARGEST_FILE)
    if data is None:
        raise ArmError(
            "the arm file is too large",
            where=Location(path),
            expected=f"up to {megabytes(LARGEST_FILE)}",
            found="more",
            next_step="check that it is an arm's file; a joint with its link takes less than 1 kB",
        )
    return data.decode("utf-8")


def _build(parsed: DHFile | PlacementFile, lines: TableLines) -> RobotArm:
    for key in ("name", "title"):
        require_name(getattr(parsed, key), f"an arm's {key}", lines.locate((key,)))
    for key in ("sources", "assumptions", "doubts"):
        require_sentences(getattr(parsed, key), f"one of the {key}", lines.locate((key,)))
    for what in ("links", "drives"):
        count = len(getattr(parsed, what))
        if count != len(parsed.joints) and (count or what == "links"):
            raise ArmError(
                f"the arm file needs one [[{what}]] table per joint",
                where=lines.locate((what, max(0, count - 1))),
                expected=f"{len(parsed.joints)} [[{what}]] tables",
                found=str(count),
            )
    joints, links = _joints_and_links(parsed, lines)
    return RobotArm(
        name=parsed.name,
        title=parsed.title or parsed.name,
        gravity=np.array(parsed.gravity),
        joints=joints,
        links=links,
        drives=tuple(
            Drive(**{**dict(drive), "coulomb": (drive.coulomb[0], drive.coulomb[1])})
            for drive in parsed.drives
        ),
        dh_table=tuple(joint.row for joint in parsed.joints if isinstance(joint, DHJointTable)),
        convention=CONVENTIONS.get(parsed.convention, PLACEMENTS),
        sources=tuple(parsed.sources),
        assumptions=tuple(parsed.assumptions),
        doubts=tuple(parsed.doubts),
    )


def _joints_and_links(
    parsed: DHFile | PlacementFile, lines: TableLines
) -> tuple[tuple[Joint, ...], tuple[Link, ...]]:
    joints, links = [], []
    for i, (joint, link) in enumerate(zip(parsed.joints, parsed.links, strict=True)):
        before, axis, behind = _placed(joint, link, parsed.convention)
        lower, upper = joint.ends
        joints.append(
            Joint(
                name=joint.name or str(i + 1),
                kind=joint.kind,
                placement=before,
                axis=axis,
                lower=lower,
                upper=upper,
                velocity_limit=joint.velocity_limit,
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
                uncertainty=link.uncertainty(),
                source=lines.locate(("links", i)),
            )
        )
    return tuple(joints), tuple(links)


def _placed(joint: JointTable, link: LinkTable, convention: str) -> tuple[Placement, FloatArray, Placement]:
    """Joint frame, axis and link frame."""
    if isinstance(joint, PlacedJointTable) and isinstance(link, PlacedLinkTable):
        return joint.placement, np.array(joint.axis), link.frame
    assert isinstance(joint, DHJointTable)  # as the schema of the file says
    before, behind = placements_of(convention, joint.kind, joint.row)
    return before, np.array([0.0, 0.0, 1.0]), behind


def _dotted(keys: tuple[str | int, ...]) -> str:
    return "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in keys).lstrip(".")


def _expectation(message: str) -> str:
    """Reword the validator's message as an expectation."""
    return message.removeprefix("Value error, ").removeprefix("Input should be ")
