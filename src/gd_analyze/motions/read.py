"""From a file to a motion: a table, the role, joint and unit of its columns, SI numbers."""

from __future__ import annotations

import difflib
import re
import sys
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice
from os import PathLike
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, Location, TrajectoryError
from gd_analyze.files import RESULT_FILES, megabytes, read_at_most, shipped
from gd_analyze.motions.arrays_and_lists import (
    READERS,
    begins_json,
    has_lists,
    read_json,
    read_list_cells,
)
from gd_analyze.motions.corrupt_rows import jumping_rows, require_sound
from gd_analyze.motions.families import SAMPLE
from gd_analyze.motions.headerless import naming
from gd_analyze.motions.limits import check_against_arm, warn_if_radians
from gd_analyze.motions.logged import ColumnUse, Logged
from gd_analyze.motions.mapping import AmbiguityError, Choice, choose
from gd_analyze.motions.mapping_file import choice_by, read_mapping, write_mapping
from gd_analyze.motions.reading import ROLES, Reading, Treatment, refusal
from gd_analyze.motions.roles import units_of
from gd_analyze.motions.ros import echoed_names, read_bag, read_yaml
from gd_analyze.motions.spool import Spool, blocks, is_mapped
from gd_analyze.motions.table import Columns, LogTable, ParquetTable, Progress, in_seconds, no_progress
from gd_analyze.motions.text import TextTable, is_number, refuse_long_names
from gd_analyze.motions.trajectory import Trajectory, recorded_command
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of, builtin_arms, load_arm
from gd_analyze.text import in_python, visible
from gd_analyze.units import TIME_UNITS

_LFS = b"version https://git-lfs"
_FORMATS = {".db3": "bag", ".mcap": "bag", ".bag": "bag"} | {
    **{".parquet": "parquet", ".pq": "parquet", ".yaml": "yaml", ".yml": "yaml"},
    **{".jsonl": "json", ".ndjson": "json"},
    **dict.fromkeys(READERS, "arrays"),
}
# Suffixes of text files in a folder that may be motions.
_TEXT = frozenset({".csv", ".tsv", ".txt", ".dat", ".log"})
# Limit for a pipe; a million set points of seven joints with all digits take 0.45 GB.
_LARGEST_STREAM = 1_000_000_000


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
        The arm of the motion, its name, or the path of its file.
    reading
        How to read a log; fields left out are inferred from the log.
    treatment
        How to treat readings; by default chosen by rule.
    progress
        Called with the amount read and the total.

    Returns
    -------
    Trajectory
        Named after the file. `Trajectory.derivatives_from` says how missing velocities and accelerations were
        derived; `Trajectory.recording` holds the readings of a measured log.

    Raises
    ------
    TrajectoryError
        If it cannot be read or is ambiguous; the message names line and column.

    Warns
    -----
    GdAnalyzeWarning
        If the arm's limits are exceeded, angles seem to be in another unit than stated, or joints with
        different names are matched.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> read_trajectory("pick-and-place", load_arm("puma560")).n_set_points
    31
    """
    arm = arm_of(arm)
    return motion_of(read_log(path_or_name, arm, reading, progress=progress), path_or_name, arm, treatment)


def motion_of(
    logged: Logged, path_or_name: str | Path, arm: RobotArm, treatment: Treatment | None
) -> Trajectory:
    """Make a motion from a log, and check its numbers; see `read_trajectory`."""
    try:
        trajectory = Trajectory.from_log(logged, arm, treatment)
    except TrajectoryError as error:
        if str(path_or_name) in str(error):
            raise
        # The error, raised from numbers alone, does not know the file.
        expected, content, step = (error.details.get(key, "") for key in ("expected", "found", "next"))
        where = Location("standard input" if str(path_or_name) == "-" else path_or_name)
        raise refusal(error.what, where, expected, content, step or None) from None
    names = [joint.name for joint in arm.joints]
    degrees = [names.index(use.joint) for use in logged.columns if use.role == "q" and use.unit == "deg"]
    if degrees:
        ends = trajectory.extremes[0][:, degrees] if trajectory.recording is None else logged.q[:, degrees]
        warn_if_radians(trajectory.name, np.degrees(ends))
    check_against_arm(trajectory, arm)
    return trajectory


def read_log(
    path_or_name: str | Path,
    arm: RobotArm | str | Path,
    reading: Reading | None = None,
    *,
    progress: Progress = no_progress,
) -> Logged:
    """Read the motion of an arm from a log or a file of set points, without treating it.

    Parameters
    ----------
    path_or_name
        As for `read_trajectory`.
    arm
        The arm of the motion, its name, or the path of its file.
    reading
        How to read the log; fields left out are inferred from the log.
    progress
        Called with the amount read and the total.

    Returns
    -------
    Logged
        The motion in SI units; `Logged.columns` states role, joint and unit of every column.

    Raises
    ------
    TrajectoryError
        If it cannot be read or is ambiguous; the message lists the choices.

    Warns
    -----
    GdAnalyzeWarning
        If joints with different names are matched.
    """
    arm, reading = arm_of(arm), reading or Reading()
    path, name, origin, data = _source(path_or_name)
    for file in (path, reading.mapping):
        with suppress(OSError):
            if file and reading.save_mapping and Path(reading.save_mapping).samefile(file):
                message = "the mapping file would overwrite an input"
                raise refusal(message, "--save-mapping", "another file", str(reading.save_mapping))
    mapping = None
    if reading.mapping is not None:
        if reading.columns or reading.map or reading.family or reading.time_unit or reading.degrees:
            message, expected = "a mapping file defines all columns of a log", "no option on columns or units"
            step = "change the mapping file, or write a new one with --save-mapping"
            raise refusal(message, "--mapping", expected, "such options", step)
        mapping, lines = read_mapping(reading.mapping)
        rate, topic = reading.rate or mapping.rate, reading.topic or mapping.topic
        reading = replace(reading, columns=tuple(mapping.names), rate=rate, topic=topic)
    table = _opened(path, reading, data, progress, arm.n_joints)
    command = recorded_command(table.first_lines[:20]) if isinstance(table, TextTable) else None
    if command:
        _require_kinds(command, arm, name, path)
        origin += f"; made by: {command}"
    if mapping is not None:
        choice = choice_by(mapping, lines, table, arm)
        if reading.measured is not None:
            choice = replace(choice, measured=reading.measured)
        columns = table.read(*choice.wanted, progress)
    else:
        choice, columns = _chosen(table, arm, reading, progress)
    used: dict[int, ColumnUse] = {}
    for column, use in choice.uses:
        if column in used or column in (choice.time.columns if choice.time else ()):
            other_use = used.get(column, ColumnUse("", "time"))
            message, place = f"column {use.column} is given two roles", table.where(None, column)
            roles = " and ".join(f"{claim.role} {claim.joint}".strip() for claim in (other_use, use))
            where = f"{reading.mapping or '--map'}; {place}"
            raise refusal(
                message, where, "a column for each", roles, "`gd-analyze columns` shows the columns"
            )
        used[column] = use
    for remark in choice.remarks:
        warnings.warn(f"log {name}: {remark}", GdAnalyzeWarning, stacklevel=2)
    return _logged(table, arm, reading, choice, columns, visible(name), visible(origin))


def _require_kinds(command: str, arm: RobotArm, name: str, path: Path) -> None:
    """Refuse a motion planned for a built-in arm that turns where this one slides, or the other way round."""
    planned = next((word for word in command.split() if word in builtin_arms()), arm.name)
    joints = () if planned == arm.name else load_arm(planned).joints
    if len(joints) != arm.n_joints:
        return  # another error says so
    for number, (planned_joint, arm_joint) in enumerate(zip(joints, arm.joints, strict=True), start=1):
        if planned_joint.kind != arm_joint.kind:
            kind = f"joint {number} ({arm_joint.name}) is {arm_joint.kind}"
            message = f"trajectory {name} is not for arm {arm.name}: {kind}"
            expected = f"q{number} in {arm_joint.unit}"
            column = f"q{number} in {planned_joint.unit}, planned for {planned}"
            step = f"choose arm {planned}, or plan a motion with `gd-analyze plan`"
            raise refusal(message, Location(path), expected, column, step)


def last_link(path_or_name: str | Path, paths: Mapping[str, Sequence[str]]) -> str | None:
    """Link of the last joint that a log names; None unless all joints it names are on one path.

    `paths` holds the joints on the path to every link. Also None if the log can be read only once.
    """
    path = Path(path_or_name)
    joints = sorted({joint for chain in paths.values() for joint in chain}, key=len, reverse=True)
    try:
        table = _opened(path, Reading(), None, no_progress, 1)
    except (TrajectoryError, OSError):
        return None  # reading it for an arm gives a better message
    named = set()
    for name in table.names:
        matches = (joint for joint in joints if re.search(rf"(?<![^\W_]){re.escape(joint)}(?![^\W_])", name))
        named |= {*islice(matches, 1)}
    ends = [link for link, chain in paths.items() if named and chain[-1] in named and named <= {*chain}]
    return ends[0] if len(ends) == 1 else None


def files_in(folder: Path) -> list[Path] | None:
    """Trajectories of a folder, by name, except hidden files and results; None if it is not a folder."""
    if not folder.is_dir() or _format(folder) is not None:
        return None
    try:
        entries = sorted(folder.iterdir(), key=lambda path: path.name)
    except OSError as error:
        raise _unreadable(folder, error) from None
    visible_paths = [path for path in entries if not path.name.startswith(".")]
    logs = [p for p in visible_paths if _format(p) is not None or (p.is_file() and p.suffix.lower() in _TEXT)]
    trajectories = [path for path in logs if path.name not in RESULT_FILES.values()]
    if not trajectories:
        names = ", ".join(visible(path.name) for path in visible_paths[:5]) or "nothing"
        names += f" and {len(visible_paths) - 5} more" if len(visible_paths) > 5 else ""
        expected = f"files that end in {', '.join(sorted(_TEXT))}; bags, .parquet or .yaml"
        step = "name the files themselves, or another folder"
        raise refusal("the folder holds no trajectories", Location(folder), expected, names, step)
    return trajectories


def _format(path: Path) -> str | None:
    """Format of a log by its name: "bag" (also a folder with metadata.yaml), "parquet" or "yaml"."""
    if path.is_dir():
        return "bag" if (path / "metadata.yaml").is_file() else None
    return _FORMATS.get(path.suffix.lower())


def _source(path_or_name: str | Path) -> tuple[Path, str, str, bytes | None]:
    """Path, name and origin of a motion, and its bytes if it can be read only once."""
    if not isinstance(path_or_name, str | PathLike):
        expected = "the name of a shipped one, or the path of a file"
        raise refusal("this is not a trajectory", "trajectory", expected, in_python(path_or_name))
    shipped_files, path = shipped_trajectories(), Path(path_or_name)
    if str(path_or_name) == "-":
        return Path("standard input"), "stdin", "read from standard input", _stream(None)
    if str(path_or_name) in shipped_files:
        return shipped_files[str(path_or_name)], path.name, f"shipped trajectory {path_or_name}", None
    origin = f"read from {path_or_name}"
    with suppress(OSError, ValueError):
        if path.is_file() or _format(path) is not None:
            return path, path.stem, origin, None
    return path, path.stem, origin, _stream(path)


def _stream(path: Path | None) -> bytes:
    """All bytes of a pipe, or of standard input."""
    name = path or Path("standard input")
    try:
        data = read_at_most(path or sys.stdin.buffer, _LARGEST_STREAM)
    except (FileNotFoundError, ValueError):
        shipped_files = shipped_trajectories()
        near = difflib.get_close_matches(name.stem, shipped_files, n=1)
        message, reason = f"there is no trajectory {str(name)!r}", "neither an existing file nor a known name"
        expected = f"a CSV file, a log or a shipped trajectory ({', '.join(shipped_files)})"
        step = f"did you mean {near[0]!r}?" if near else "check the path, or see `gd-analyze plan`"
        raise refusal(message, Location(name), expected, reason, step) from None
    except OSError as error:
        raise _unreadable(name, error) from None
    if data is None:
        expected, step = f"up to {megabytes(_LARGEST_STREAM)}", "write fewer set points, or split the motion"
        raise refusal("the trajectory is too large to be read", Location(name), expected, "more", step)
    return data


def _unreadable(path: Path, error: OSError) -> TrajectoryError:
    reason, step = error.strerror or str(error), "give a path you may read"
    expected = "a file" if isinstance(error, IsADirectoryError) else "a file, or a folder of files"
    return refusal("cannot read the trajectory", Location(path), expected, reason, step)


def _begin(path: Path) -> bytes:
    with suppress(OSError), path.open("rb") as file:
        return file.read(len(_LFS))
    return b""


def _opened(path: Path, reading: Reading, data: bytes | None, progress: Progress, joints: int) -> LogTable:
    """The table of a file, with names from its header, its messages, or the user."""
    kind = None if data is not None else _format(path)
    begin = data if data is not None or path.is_dir() else _begin(path)
    if (begin or b"").startswith(_LFS):
        content, step = "a pointer of Git LFS", "`git lfs pull` in its repository fetches the file itself"
        raise refusal("this is not a log", Location(path), "the log itself", content, step)
    if kind == "bag":
        return read_bag(path, reading.topic, progress)
    if kind == "parquet":
        return ParquetTable(path)
    if kind == "yaml":
        return read_yaml(path, progress)
    if kind == "arrays":
        return READERS[path.suffix.lower()](path)
    if kind == "json" or begins_json(begin or b""):
        return read_json(path, data)
    table = TextTable(path, data)
    where = Location(path, table.layout.first)
    if (table.names or table.first_cells)[0].lstrip().startswith("<"):
        expected, content = "a log: text in columns, a bag, Parquet or YAML", "XML, as robots' files are"
        raise refusal("this is not a log", where, expected, content, "name the robot first, then the log")
    if any(table.names):
        return read_list_cells(table) if has_lists(table) else table
    cells = table.first_cells
    echoed = echoed_names(cells)
    if echoed is not None and not reading.columns:
        refuse_long_names(echoed, where)
        table.require_constant({k: c for k, c in enumerate(cells) if k > 2 and c and not is_number(c)})
        return TextTable(path, data, echoed)
    if not reading.columns:
        content, step = f"numbers in {len(cells)} columns", naming(table, joints)
        raise refusal("the file has no header line", where, "the names of the columns", content, step)
    width = len(table.names)
    if len(reading.columns) != width:
        expected, content = f"{width} names, - for a column that is not needed", str(len(reading.columns))
        raise refusal("the names given do not fit the columns", f"--columns; {where}", expected, content)
    table = TextTable(path, data, tuple("" if name == "-" else name for name in reading.columns))
    return read_list_cells(table) if has_lists(table) else table


def _chosen(table: LogTable, arm: RobotArm, reading: Reading, progress: Progress) -> tuple[Choice, Columns]:
    """Choose columns and read them; choose again if those of a family are 0 throughout."""
    zero: frozenset[object] = frozenset()
    while True:
        try:
            outcome: Choice | AmbiguityError = choose(table, arm, reading, zero)
        except AmbiguityError as error:
            outcome = error
        if isinstance(outcome, Choice):
            families = () if outcome.set_points else tuple(outcome.families.values())
            numbers, times = outcome.wanted
        else:
            families, times = outcome.families, ()
            numbers = sorted({column for family in families for column in family.all_columns})
        columns = table.read(numbers, times, progress)
        zero_keys: set[object] = set()
        if families:
            moving = {k for i, k in enumerate(numbers) if np.nan_to_num(columns.numbers[:, i]).any()}
            zero_keys = {family.key for family in families if not moving & set(family.all_columns)}
        if zero_keys <= zero:
            if isinstance(outcome, Choice):
                return outcome, columns
            raise outcome
        zero |= zero_keys


def _logged(
    table: LogTable, arm: RobotArm, reading: Reading, choice: Choice, columns: Columns, name: str, origin: str
) -> Logged:
    numbers, _ = choice.wanted
    column_values = dict(zip(numbers, columns.numbers.T, strict=True))
    arrays: dict[str, FloatArray] = {}
    for role in ROLES:
        uses = ((column, use.unit) for column, use in choice.uses if use.role == role)
        paired = [*zip(uses, arm.joints, strict=False)]
        factors = np.array(
            [units_of(role, joint.kind == "revolute")[column_unit] for (_, column_unit), joint in paired]
        )
        values = _columns(columns.numbers, [numbers.index(column) for (column, _), _ in paired], factors)
        if paired and (role == "q" or any(np.isfinite(values[chunk]).any() for chunk in blocks(values))):
            arrays[role] = values
    if reading.torque_constant is not None:
        constants = len(reading.torque_constant) if "torque" in arrays else 0
        if constants != arm.n_joints:
            message, where = "torque constants do not fit the log", f"--torque-constant; {table.where()}"
            expected = f"{arm.n_joints} constants, and columns of torque or currents"
            step = "name the currents' columns: --map torque=current1..current6, or --map torque:JOINT=COLUMN"
            raise refusal(message, where, expected, str(constants or "no such columns"), step)
        arrays["torque"] = arrays["torque"] * np.array(reading.torque_constant, dtype=float)
    q = arrays["q"]
    if not len(q):
        raise refusal("the file has no rows", table.where(), "a line per instant", "none")
    gaps = None
    if not choice.measured and any(
        np.isnan(columns.numbers[chunk]).any() for chunk in blocks(columns.numbers)
    ):
        _require_numbers(table, column_values, choice.set_points, [*columns.wrong])
    if choice.set_points and choice.time is not None:
        unit, why = choice.time.unit, choice.time.why
        column = choice.time.columns[0]
        rows = columns.numbers[:, numbers.index(column)]
        instants = np.concatenate([rows[chunk].copy() for chunk in blocks(rows)])
        _require_increasing(table, column, instants)
        time = instants * TIME_UNITS[unit]
        gaps = columns.gaps
    elif choice.time is None:
        time, unit, why = np.arange(len(q)) / (reading.rate or 1.0), SAMPLE, f"rows at {reading.rate:g} Hz"
    else:
        column = choice.time.columns[0]
        rate = reading.rate if choice.time.unit in (SAMPLE, "") or reading.time_unit is None else None
        place = (table.label(column), table.where(None, column))
        time, unit, why = in_seconds(columns.stamps, choice.time, reading.time_unit, rate, *place)
    jumping = jumping_rows(time, q, arm) if choice.measured else {}
    require_sound(columns.wrong, jumping, table, name, reading.drop_rows)
    # Rows of other topics and rows without an instant do not describe the motion.
    usable = np.isfinite(time)
    for chunk in blocks(q):
        usable[chunk] &= np.isfinite(q[chunk]).any(axis=1)
    if not usable.any():
        expected = "numbers in the columns of time and positions"
        raise refusal("no row has a time and a position", table.where(), expected, "empty cells")
    corrupt = sorted({*columns.wrong, *jumping})
    empty = np.delete(~usable, corrupt).sum()
    if empty:
        why += f"; rows without time or positions, left out: {int(empty)}"
    usable[corrupt] = False
    if not usable.all():
        time, arrays = time[usable], {role: array[usable] for role, array in arrays.items()}
        gaps = gaps and tuple(int(usable[:gap].sum()) for gap in gaps)
    if reading.corrections:
        arrays = reading.corrections.applied(time, arrays, arm)
        origin += f"; corrected by {reading.corrections.words}"
    if reading.save_mapping is not None:
        write_mapping(choice, table, reading, unit)
    return Logged(
        time=time if gaps is not None else time - time[0],
        q=arrays["q"],
        qd=arrays.get("qd"),
        qdd=arrays.get("qdd"),
        torque=arrays.get("torque"),
        measured=choice.measured,
        columns=_uses(table, choice, unit, why),
        name=name,
        origin=origin,
        gaps=gaps,
        judged=reading.measured is None,
    )


def _columns(numbers: FloatArray, places: Sequence[int], factors: FloatArray) -> FloatArray:
    """Take columns, each times its factor; memory-mapped columns stay mapped."""
    if is_mapped(numbers) and (factors == 1.0).all() and (np.diff(places) == 1).all() and places:
        return numbers[:, places[0] : places[-1] + 1]
    spool = Spool(len(places))
    for chunk in blocks(numbers):
        spool.add(numbers[chunk][:, places] * factors)
    return spool.array()


def _require_numbers(
    table: LogTable, column_values: dict[int, FloatArray], refuse_empty: bool, corrupt: Sequence[int]
) -> None:
    """Refuse a plan with a cell nan, and a file of set points with an empty cell, but for corrupt rows."""
    for column, values in column_values.items():
        empty = np.isnan(values)
        empty[corrupt] = False
        for row in np.flatnonzero(empty)[:1].tolist():
            cell = (isinstance(table, TextTable) and table.cell(row, column)) or "an empty cell"
            if refuse_empty or cell.lower().strip("-") == "nan":
                message, step = f"{table.label(column)} is not finite", "give one, or omit the set point"
                step += "; --measured leaves out such rows of a recording"
                raise refusal(message, table.where(row, column), "a number", cell, step)


def _require_increasing(table: LogTable, column: int, time: FloatArray) -> None:
    """Refuse set points whose time does not increase."""
    for k in np.flatnonzero(np.diff(time) <= 0)[:1].tolist():
        where, expected = table.where(k + 1, column), f"more than {time[k]!s}, the time of the line before"
        step = "sort the set points by time and keep one per instant; for readings, --measured does this"
        raise refusal("time does not increase", where, expected, str(time[k + 1]), step)


def _uses(table: LogTable, choice: Choice, unit: str, why: str) -> tuple[ColumnUse, ...]:
    """Role of every column, in the order of the log."""
    times = choice.time.columns if choice.time is not None else ()
    reason = "another time" if times else "no time is needed"
    numbers = range(len(table.names))
    uses = {k: ColumnUse(table.shown(k), "unused", why=choice.unused.get(k, reason)) for k in numbers}
    uses |= {k: ColumnUse(table.shown(k), "time", unit=unit, why=why) for k in times[:1]}
    uses |= {k: ColumnUse(table.shown(k), "time", unit="ns", why=why) for k in times[1:]}
    return tuple((uses | dict(choice.uses)).values())
