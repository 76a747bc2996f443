"""The small file that says how a log is to be read, so that the next one needs no flags."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import read_at_most, write_text
from gd_analyze.motions.choice import Choice, Use
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.reading import ROLES, Reading
from gd_analyze.motions.said import column_named
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.time_axis import SAMPLE, TimeColumns
from gd_analyze.motions.units import TIME_UNITS, units_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import TableLines
from gd_analyze.text import LARGEST, in_python

FORMAT = "gd-analyze log mapping 1"
LARGEST_FILE = 1_000_000


class MappedColumn(BaseModel):
    """A column: what it holds, of which joint of the arm, in which unit."""

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

    def text(self) -> str:
        """TOML of it."""
        lines = [f'format = "{FORMAT}"', f"measured = {'true' if self.measured else 'false'}"]
        if self.rate is not None:
            lines.append(f"rate = {self.rate!r} # samples per second, Hz")
        if self.topic is not None:
            lines.append(f"topic = {_quoted(self.topic)}")
        if self.names:
            lines.append(f"names = [{', '.join(map(_quoted, self.names))}]")
        for column in self.columns:
            lines += ["", "[[columns]]", f"column = {_quoted(column.column)}", f'role = "{column.role}"']
            lines += [f"joint = {_quoted(column.joint)}"] if column.joint else []
            lines.append(f"unit = {_quoted(column.unit)}")
        return "\n".join(lines) + "\n"


def mapping_of(
    choice: Choice, logged: Logged, table: LogTable, arm: RobotArm, reading: Reading, time_unit: str
) -> Mapping:
    """What a choice comes to, as it is written."""
    columns = [
        MappedColumn(column=_name(k, table), role="time", unit=unit)
        for k, unit in zip(
            choice.time.columns if choice.time else (),
            ("s", "ns") if choice.time and len(choice.time.columns) == 2 else (time_unit,),
            strict=False,
        )
    ]
    columns += [
        MappedColumn(
            column=_name(use.column, table),
            role=use.role,
            joint=arm.joints[use.joint].name,
            unit=use.unit,
        )
        for use in choice.uses
    ]
    names = list(reading.columns) if tuple(n or "-" for n in table.names) == tuple(reading.columns) else []
    return Mapping(
        format="gd-analyze log mapping 1",
        measured=logged.measured,
        rate=reading.rate,
        topic=reading.topic,
        names=names,
        columns=columns,
    )


def write_mapping(mapping: Mapping, path: str | Path) -> None:
    """Write a mapping file, atomically; raises OutputError."""
    write_text(path, mapping.text())


def read_mapping(path: str | Path) -> tuple[Mapping, TableLines]:
    """Read a mapping file, and where in it everything stands.

    Raises
    ------
    TrajectoryError
        If it cannot be read or does not fit; the message names the line.
    """
    path = Path(path)
    try:
        data = read_at_most(path, LARGEST_FILE)
        content = (data or b"").decode("utf-8")
        lines = TableLines(path, content)
        return Mapping.model_validate(tomllib.loads(content)), lines
    except OSError as error:
        raise _misfit(
            Location(path), error.strerror or str(error), "a mapping file that may be read"
        ) from None
    except UnicodeDecodeError:
        raise _misfit(Location(path), "no text", "TOML in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        where = Location(path, int(place[1]), int(place[2])) if place else Location(path)
        raise _misfit(where, re.sub(r" \(at .*\)$", "", str(error)), "TOML") from None
    except ValidationError as error:
        first = error.errors()[0]
        missing = first["type"] == "missing"
        expected = first["msg"].removeprefix("Input should be ")
        if missing:
            expected = f"a key {first['loc'][-1]}"
        raise _misfit(
            lines.locate(tuple(first["loc"])), "nothing" if missing else in_python(first["input"]), expected
        ) from None
    except (ValueError, RecursionError):
        raise _misfit(Location(path), "numbers or tables beyond any mapping", "a few columns") from None


def _misfit(where: Location, found: str, expected: str) -> TrajectoryError:
    return TrajectoryError(
        "the mapping file cannot be used",
        where=where,
        expected=expected,
        found=found,
        next_step="write one anew with --save-mapping",
    )


def choice_by(mapping: Mapping, lines: TableLines, table: LogTable, arm: RobotArm) -> Choice:
    """Columns as a mapping file says.

    Raises
    ------
    TrajectoryError
        If the log has no such columns, the arm no such joints, or a role misses joints.
    """
    names = [joint.name for joint in arm.joints]
    uses, times = [], []
    for k, of in enumerate(mapping.columns):
        where = lines.locate(("columns", k, "column"))
        column = column_named(of.column, table, str(where))
        if of.role == "time":
            if of.unit not in (*TIME_UNITS, SAMPLE):
                raise _misfit(lines.locate(("columns", k, "unit")), of.unit, ", ".join((*TIME_UNITS, SAMPLE)))
            times.append((column, of.unit))
            continue
        if of.joint not in names:
            near = difflib.get_close_matches(of.joint, names, n=1)
            expected = f"a joint of arm {arm.name}: {', '.join(names)}" + (f" ({near[0]}?)" if near else "")
            raise _misfit(lines.locate(("columns", k, "joint")), of.joint or "none", expected)
        joint = names.index(of.joint)
        units = units_of(of.role, arm.joints[joint].kind == "revolute")
        if of.unit not in units:
            raise _misfit(lines.locate(("columns", k, "unit")), of.unit, ", ".join(units))
        uses.append(Use(column, of.role, joint, of.unit, "mapping file"))
    _require_complete(uses, names, lines)
    used = {use.column for use in uses} | {column for column, _ in times}
    return Choice(
        uses=tuple(uses),
        time=_time(times, mapping, lines),
        unused={k: "not in the mapping file" for k in range(len(table.names)) if k not in used},
        measured=mapping.measured,
    )


def _require_complete(uses: Sequence[Use], names: Sequence[str], lines: TableLines) -> None:
    for role in ROLES:
        having = [use.joint for use in uses if use.role == role]
        if (having or role == "q") and sorted(having) != list(range(len(names))):
            missing = [names[j] for j in range(len(names)) if having.count(j) != 1]
            raise _misfit(
                Location(lines.path),
                f"{having.count(names.index(missing[0]))} columns for {role} of {missing[0]}",
                f"one column for {role} of every joint",
            )


def _time(times: Sequence[tuple[int, str]], mapping: Mapping, lines: TableLines) -> TimeColumns | None:
    units = [unit for _, unit in times]
    if units in (["s", "ns"], ["ns", "s"]):
        return TimeColumns(
            tuple(c for c, _ in sorted(times, key=lambda t: t[1] == "ns")), "s", "mapping file"
        )
    if len(times) > 1 or (not times and mapping.rate is None) or (SAMPLE in units and mapping.rate is None):
        raise _misfit(
            Location(lines.path),
            f"{len(times)} columns of time" + (", no rate" if mapping.rate is None else ""),
            "one column of time, a pair in s and ns, or samples and their rate",
        )
    return TimeColumns((times[0][0],), times[0][1], "mapping file") if times else None


def _name(column: int, table: LogTable) -> str:
    name = table.names[column]
    return name if name and table.names.count(name) == 1 and not name.startswith("#") else f"#{column + 1}"


def _quoted(text: str) -> str:
    """A basic string of TOML."""
    signs = {'"': '\\"', "\\": "\\\\"}
    return '"' + "".join(signs.get(s, s if s.isprintable() else f"\\U{ord(s):08x}") for s in text) + '"'
