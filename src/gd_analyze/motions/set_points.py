"""Reads a file of set points; the contract of these is in docs/trajectories.md."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray, are_possible
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.csv_columns import KINDS, Columns, header_for, read_columns
from gd_analyze.motions.csv_lines import Lines
from gd_analyze.motions.csv_rows import Rows
from gd_analyze.motions.csv_writing import GAP, recorded_command
from gd_analyze.motions.derived_rates import FEWEST_SET_POINTS, complete_rates
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, visible


def set_points_in(
    path: str | Path, name: str, source: str, data: bytes, arm: RobotArm
) -> tuple[Trajectory, FloatArray | None]:
    """Read a file of set points, and its angles that are said to be in degrees as they stand there."""
    _require_text(data, path)
    lines = Lines(data)
    numbers = [i for i, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not numbers:
        raise TrajectoryError(
            "the trajectory file is empty",
            where=Location(path),
            expected=f"the header {header_for(arm.n_joints, ('q',))} and one line per set point",
            found="no data" if data.strip() else "0 bytes",
            next_step="`gd-analyze plan --help` shows how to make a trajectory",
        )
    rows = Rows(path, lines.at(np.array(numbers) - 1), numbers)
    columns = read_columns(rows.cells(0), arm, rows.place(0))
    if len(numbers) == 1:
        raise TrajectoryError(
            "the trajectory file holds a header only",
            where=rows.place(0),
            expected="one line per set point",
            found="none",
            next_step="add the set points",
        )
    table = rows.numbers(columns.names, columns.time)
    # From here on they are shown, on pages too, and no path any more.
    name, origin = visible(name), visible(_origin(source, lines))
    gaps = _gaps(lines, numbers)
    trajectory = _build(table, columns, arm, name, origin, rows.place(-1), gaps)
    angles = [c for c in columns.by_kind["q"] if c in columns.degrees]
    return trajectory, table[:, angles] if angles else None


def _require_text(data: bytes, path: str | Path) -> None:
    next_step = "save it as CSV in UTF-8"
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in data:
        raise TrajectoryError(
            "the trajectory file is not CSV text",
            where=Location(path),
            expected="CSV in UTF-8",
            found="UTF-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "a binary file (zero bytes)",
            next_step=next_step,
        )
    try:
        data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise TrajectoryError(
            "the trajectory file is not UTF-8",
            where=Location(path, line),
            expected="CSV in UTF-8",
            found=f"byte 0x{data[error.start]:02x}",
            next_step=next_step,
        ) from None


def _origin(source: str, lines: Sequence[str]) -> str:
    # The command stands before the header; looking further would search every row of long files.
    command = recorded_command("\n".join(lines[:20]))
    return source + (f"; made by: {command}" if command else "")


def _gaps(lines: Sequence[str], numbers: Sequence[int]) -> tuple[int, ...]:
    """Set points before which a line says that there is a gap; of the first there is nothing before."""
    said = [i for i, line in enumerate(lines, 1) if line.startswith(GAP) and line.strip() == GAP]
    before = np.unique(np.searchsorted(numbers, said) - 1)
    return tuple(before[(before > 0) & (before < len(numbers) - 1)].tolist())


def _build(
    table: FloatArray,
    columns: Columns,
    arm: RobotArm,
    name: str,
    origin: str,
    end: Location,
    gaps: tuple[int, ...],
) -> Trajectory:
    degrees = sorted(columns.degrees)
    radians = table.copy() if degrees else table
    radians[:, degrees] = np.deg2rad(table[:, degrees])
    given = {kind: radians[:, list(places)] for kind, places in columns.by_kind.items()}
    absent = [kind for kind in KINDS if kind not in given]
    shortest = int(np.diff([0, *gaps, len(table)]).min())
    if absent and shortest < FEWEST_SET_POINTS:
        raise TrajectoryError(
            f"too few set points to derive {' and '.join(absent)}",
            where=end,
            expected=f"at least {FEWEST_SET_POINTS} set points{' between gaps' if gaps else ''}, "
            f"or columns for {' and '.join(absent)}",
            found=f"{shortest} set point{'s' if shortest > 1 else ''}",
            next_step=f"add columns {', '.join(f'{k}1..{k}{arm.n_joints}' for k in absent)}, or set points",
        )
    time, q = table[:, columns.time], given["q"]
    qd, qdd, rates_from = complete_rates(time, q, given.get("qd"), given.get("qdd"), gaps)
    for kind, rates in (("qd", qd), ("qdd", qdd)):
        if kind in absent and not are_possible(rates):
            raise TrajectoryError(
                f"{kind} cannot be derived: it is too large for any motion",
                where=Location(end.path),
                expected=f"time steps in s, even enough that {kind} stays below {LARGEST:g}",
                found=f"time steps of {np.diff(time).min():g} s to {np.diff(time).max():g} s",
                next_step=f"check the instants, or add columns for {kind}",
            )
    return Trajectory(time, q, qd, qdd, name=name, origin=origin, rates_from=rates_from, gaps=gaps)
