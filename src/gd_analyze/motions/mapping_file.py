"""A small TOML file that says how to read a log, so that similar logs need no options."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import read_at_most, write_text
from gd_analyze.motions.families import SAMPLE, TimeColumns
from gd_analyze.motions.logged import ColumnUse
from gd_analyze.motions.mapping import Choice, column_named
from gd_analyze.motions.reading import ROLES, Reading, refusal
from gd_analyze.motions.roles import units_of
from gd_analyze.motions.table import LogTable
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.text_file import TableLines
from gd_analyze.text import LARGEST, field_fault
from gd_analyze.units import TIME_UNITS

_FORMAT: Literal["gd-analyze log mapping 1"] = "gd-analyze log mapping 1"
_LARGEST_FILE = 1_000_000


class MappedColumn(BaseModel):
    """A column: role, joint of the arm, and unit."""

    model_config = ConfigDict(extra="forbid", strict=True)

    column: str
    role: Literal["time", "q", "qd", "qdd", "torque"]
    joint: str = ""
    unit: str


class Mapping(BaseModel):
    """The file's contents."""

    model_config = ConfigDict(extra="forbid", strict=True)

    format: Literal["gd-analyze log mapping 1"]
    measured: bool
    rate: float | None = Field(default=None, gt=0.0, le=LARGEST)
    topic: str | None = None
    names: list[str] = []
    columns: list[MappedColumn]


def write_mapping(choice: Choice, table: LogTable, reading: Reading, time_unit: str) -> None:
    """Write the columns' roles to `reading.save_mapping`, atomically; raises OutputError."""
    times = choice.time.columns if choice.time else ()
    columns = [(k, "time", "", unit) for k, unit in zip(times, (time_unit, "ns"), strict=False)]
    columns += [(k, use.role, use.joint, use.unit) for k, use in choice.uses]
    lines = [f'format = "{_FORMAT}"', f"measured = {'true' if choice.measured else 'false'}"]
    if reading.rate is not None:
        lines.append(f"rate = {reading.rate!r} # samples per second, Hz")
    if reading.topic is not None:
        lines.append(f"topic = {_quoted(reading.topic)}")
    if tuple(name or "-" for name in table.names) == reading.columns:
        lines.append(f"names = [{', '.join(map(_quoted, reading.columns))}]")
    for k, role, joint, unit in columns:
        name = table.names[k]
        unique = name and table.names.count(name) == 1 and not name.startswith("#")
        lines += ["", "[[columns]]", f"column = {_quoted(name if unique else f'#{k + 1}')}"]
        lines += [f'role = "{role}"', *([f"joint = {_quoted(joint)}"] if joint else [])]
        lines += [f"unit = {_quoted(unit)}"]
    write_text(reading.save_mapping or "", "\n".join(lines) + "\n")


def _quoted(text: str) -> str:
    """A basic string of TOML."""
    signs = {'"': '\\"', "\\": "\\\\"}
    return '"' + "".join(signs.get(s, s if s.isprintable() else f"\\U{ord(s):08x}") for s in text) + '"'


def read_mapping(path: str | Path) -> tuple[Mapping, TableLines]:
    """Read a mapping file and the places of its keys; a TrajectoryError names the faulty line."""
    path = Path(path)
    try:
        content = (read_at_most(path, _LARGEST_FILE) or b"").decode("utf-8")
        lines = TableLines(path, content)
        return Mapping.model_validate(tomllib.loads(content)), lines
    except OSError as error:
        fault = error.strerror or str(error)
        raise _misfit(Location(path), fault, "a readable mapping file") from None
    except UnicodeDecodeError:
        raise _misfit(Location(path), "not text", "TOML in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        where = Location(path, int(place[1]), int(place[2])) if place else Location(path)
        raise _misfit(where, re.sub(r" \(at .*\)$", "", str(error)), "TOML") from None
    except ValidationError as error:
        first = error.errors()[0]
        expected, fault = field_fault(first)
        raise _misfit(lines.locate(tuple(first["loc"])), fault, expected) from None
    except (ValueError, RecursionError):
        raise _misfit(Location(path), "numbers or tables too large for a mapping", "a few columns") from None


def _misfit(where: Location, content: str, expected: str) -> TrajectoryError:
    step = "write a new one with --save-mapping"
    return refusal("the mapping file cannot be used", where, expected, content, step)


def choice_by(mapping: Mapping, lines: TableLines, table: LogTable, arm: RobotArm) -> Choice:
    """Columns by a mapping file; TrajectoryError if log or arm lack them, or a role lacks joints."""
    joints = {joint.name: joint for joint in arm.joints}
    uses: list[tuple[int, ColumnUse]] = []
    times: dict[str, int] = {}
    for k, entry in enumerate(mapping.columns):
        column = column_named(entry.column, table, str(lines.locate(("columns", k, "column"))))
        units = [*TIME_UNITS, SAMPLE]
        if entry.role != "time" and entry.joint not in joints:
            expected = f"a joint of arm {arm.name}: {', '.join(joints)}"
            raise _misfit(lines.locate(("columns", k, "joint")), entry.joint or "none", expected)
        if entry.role != "time":
            units = list(units_of(entry.role, joints[entry.joint].kind == "revolute"))
            use = ColumnUse(table.shown(column), entry.role, entry.joint, entry.unit, "mapping file")
            uses.append((column, use))
        elif entry.unit in times:
            raise _misfit(lines.locate(("columns", k, "column")), f"another time in {entry.unit}", "one")
        else:
            times[entry.unit] = column
        if entry.unit not in units:
            raise _misfit(lines.locate(("columns", k, "unit")), entry.unit, ", ".join(units))
    for role in ROLES:
        joint_names = [use.joint for _, use in uses if use.role == role]
        faulty_joint = next((name for name in joints if joint_names.count(name) != 1), None)
        if (joint_names or role == "q") and faulty_joint is not None:
            content = f"{joint_names.count(faulty_joint)} columns for {role} of {faulty_joint}"
            raise _misfit(Location(lines.path), content, f"one column for {role} of every joint")
    uses.sort(key=lambda pair: [*joints].index(pair[1].joint))
    time = None
    if set(times) == {"s", "ns"}:
        time = TimeColumns((times["s"], times["ns"]), "s", "mapping file")
    elif len(times) > 1 or (mapping.rate is None and (not times or SAMPLE in times)):
        content = f"{len(times)} columns of time" + (", no rate" if mapping.rate is None else "")
        expected = "one column of time, a pair in s and ns, or samples and their rate"
        raise _misfit(Location(lines.path), content, expected)
    elif times:
        ((unit, column),) = times.items()
        time = TimeColumns((column,), unit, "mapping file")
    used = {column for column, _ in uses} | set(times.values())
    unused = {k: "not in the mapping file" for k in range(len(table.names)) if k not in used}
    return Choice(tuple(uses), time, unused, mapping.measured)
