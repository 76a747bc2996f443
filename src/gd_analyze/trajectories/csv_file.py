"""Reads and writes trajectories; the contract of their CSV files is in docs/trajectories.md.

Whatever else a robot writes goes to the reader of logs.
"""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.files import megabytes, read_at_most, write_text
from gd_analyze.given_numbers import LARGEST, are_possible
from gd_analyze.logs import Reading
from gd_analyze.logs.open_log import format_by_name
from gd_analyze.logs.table import Progress, no_progress
from gd_analyze.resources import shipped
from gd_analyze.robots import RobotArm, arm_of
from gd_analyze.trajectories.checks import check_against_arm, warn_if_radians
from gd_analyze.trajectories.csv_columns import KINDS, Columns, header_for, read_columns
from gd_analyze.trajectories.csv_lines import Lines
from gd_analyze.trajectories.csv_rows import Rows
from gd_analyze.trajectories.derived_rates import FEWEST_SET_POINTS, complete_rates
from gd_analyze.trajectories.log_file import HEAD, beginning_of, keeps_contract, motion_of_log
from gd_analyze.trajectories.trajectory import Trajectory
from gd_analyze.trajectories.treatment import Treatment
from gd_analyze.vectors import FloatArray
from gd_analyze.visible import in_python, visible

# A million set points of a seven-joint arm, every number with all its digits, are 0.45 GB.
LARGEST_FILE = 1_000_000_000

# A line of its own where nothing is known of the motion between the set points above and below.
GAP = "# gap"

_COMMAND = re.compile(r"#\s*(gd-analyze plan .*\S)\s*")


def shipped_trajectories() -> dict[str, Path]:
    """Shipped trajectory files by name, in alphabetical order."""
    return shipped("trajectories", ".csv")


def read_trajectory(
    path_or_name: str | Path,
    arm: RobotArm | str | Path,
    reading: Reading | None = None,
    treatment: Treatment | None = None,
    *,
    progress: Progress = no_progress,
) -> Trajectory:
    """Read a trajectory for an arm, or the log of a motion.

    Parameters
    ----------
    path_or_name
        A file, the folder of a bag, the name of a shipped trajectory, or "-" for standard input.
    arm
        The arm that shall follow it, or did, or its name or the path of its file.
    reading
        What a log does not tell itself of its columns.
    treatment
        What is done to a measured one; by default rules decide.
    progress
        Told how much of a log is read.

    Returns
    -------
    Trajectory
        Named after the file; missing rates are derived, and `Trajectory.rates_from` says how. Of a measured
        log, `Trajectory.recording` holds what it was made of.

    Raises
    ------
    TrajectoryError
        If there is no such file, it breaks the contract of trajectories, or a log is not understood; the
        message names line and column.

    Warns
    -----
    GdAnalyzeWarning
        If the arm's limits are exceeded, angles seem to be in another unit than stated, or joints are matched
        although their names differ.

    Examples
    --------
    >>> from gd_analyze.robots import load_arm
    >>> read_trajectory("pick-and-place", load_arm("puma560")).n_set_points
    31
    """
    if not isinstance(path_or_name, str | PathLike):
        raise TrajectoryError(
            "this is no trajectory",
            where="trajectory",
            expected="the name of a shipped one, or the path of a file",
            found=in_python(path_or_name),
        )
    arm = arm_of(arm)
    log = _log_in(path_or_name, arm, reading or Reading(), treatment, progress)
    trajectory, degrees = (log, None) if isinstance(log, Trajectory) else _by_contract(*log, arm)
    if degrees is not None:
        warn_if_radians(trajectory.name, degrees)
    check_against_arm(trajectory, arm)
    return trajectory


def _log_in(
    path_or_name: str | Path,
    arm: RobotArm,
    reading: Reading,
    treatment: Treatment | None,
    progress: Progress,
) -> Trajectory | tuple[str | Path, str, str, bytes]:
    """Read the motion of a log; of a file of set points, fetch path for messages, name, origin and bytes."""
    given = Path(path_or_name)
    is_file = str(path_or_name) not in ("-", *shipped_trajectories()) and _is_regular(given)
    if is_file and (format_by_name(given) or reading.asked or not keeps_contract(beginning_of(given))):
        return motion_of_log(given, arm, reading, treatment, progress=progress)
    path, name, source, data = _fetch(path_or_name)
    if reading.asked or not keeps_contract(data[:HEAD]):
        motion = motion_of_log(path, arm, reading, treatment, data, progress)
        return replace(motion, name=visible(name), origin=visible(source))
    return path, name, source, data


def _is_regular(path: Path) -> bool:
    """Whether a path is that of a file that may be read twice, or of a bag's folder."""
    try:
        return path.is_file() or format_by_name(path) is not None
    except (OSError, ValueError):
        return False


def _by_contract(
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


def trajectory_csv(trajectory: Trajectory, comments: Iterable[str] = ()) -> str:
    """Text of a trajectory's CSV file: comments, header and every number in full precision; gaps as `# gap`.

    Parameters
    ----------
    trajectory
        The set points.
    comments
        Lines to put first, without their `#`.
    """
    table = np.column_stack([trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd])
    # Adding 0.0 turns -0.0 into 0.0; repr is the shortest text that reads back as the same number.
    rows = [",".join(map(repr, row)) for row in (table + 0.0).tolist()]
    for gap in reversed(trajectory.gaps):
        rows.insert(gap, GAP)
    lines = [f"# {line}".rstrip() for comment in comments for line in comment.splitlines()]
    return "\n".join([*lines, header_for(trajectory.n_joints), *rows]) + "\n"


def write_trajectory(trajectory: Trajectory, path: str | Path, comments: Iterable[str] = ()) -> None:
    """Write a trajectory as CSV, atomically; reading it back gives the same numbers.

    Parameters
    ----------
    trajectory
        The set points.
    path
        The file.
    comments
        Lines to put first, without their `#`; by custom the command that makes the file.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    write_text(path, trajectory_csv(trajectory, comments))


def recorded_command(comments: str) -> str | None:
    """Find the `gd-analyze plan` command that a trajectory file's comments record, or None."""
    matches = (_COMMAND.fullmatch(line) for line in comments.splitlines())
    return next((match[1] for match in matches if match), None)


def _fetch(path_or_name: str | Path) -> tuple[str | Path, str, str, bytes]:
    """Path for messages, name, origin and bytes of a trajectory."""
    given = str(path_or_name)
    if given == "-":
        return "standard input", "stdin", "read from standard input", _standard_input()
    known = shipped_trajectories()
    path = known.get(given, Path(path_or_name))
    source = f"shipped trajectory {given}" if given in known else f"read from {given}"
    try:
        return path, path.stem, source, _limited(read_at_most(path, LARGEST_FILE), path)
    except FileNotFoundError:
        near = difflib.get_close_matches(Path(given).stem, known, n=1)
        raise TrajectoryError(
            f"there is no trajectory {given!r}",
            where=Location(path),
            expected=f"a CSV file or a shipped trajectory ({', '.join(known)})",
            found="neither an existing file nor a known name",
            next_step=f"did you mean the shipped {near[0]!r}?"
            if near
            else "check the path, or make a trajectory with `gd-analyze plan`",
        ) from None
    except OSError as error:
        raise TrajectoryError(
            "cannot read the trajectory file",
            where=Location(path),
            found=error.strerror or str(error),
            next_step="give the path of a CSV file you may read",
        ) from None


def _limited(data: bytes | None, path: str | Path) -> bytes:
    if data is None:
        raise TrajectoryError(
            "the trajectory is too large to be read",
            where=Location(path),
            expected=f"up to {megabytes(LARGEST_FILE)}",
            found="more",
            next_step="write fewer digits or fewer set points, or split the motion",
        )
    return data


def _standard_input() -> bytes:
    try:
        data = read_at_most(sys.stdin.buffer, LARGEST_FILE)
    except OSError as error:
        raise TrajectoryError(
            "cannot read the trajectory from standard input",
            where="standard input",
            found=error.strerror or str(error),
            next_step="pipe a CSV file in, or give its path",
        ) from None
    return _limited(data, "standard input")


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
