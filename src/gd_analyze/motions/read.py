"""Reads a log: opens it, chooses columns, and puts them into SI units in the order of the arm's joints."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.choice import Choice, choose
from gd_analyze.motions.logged import ColumnUse, Logged
from gd_analyze.motions.mapping import choice_by, mapping_of, read_mapping, write_mapping
from gd_analyze.motions.open_log import open_log
from gd_analyze.motions.reading import ROLES, Reading
from gd_analyze.motions.refusals import AmbiguityError
from gd_analyze.motions.table import LogTable, Progress, Stamps, no_progress
from gd_analyze.motions.time_axis import SAMPLE, in_seconds, unit_by_velocity
from gd_analyze.motions.units import units_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.text import visible

# Rows by which velocities are held against positions, for a message.
_JUDGED = 20_000


def read_log(
    path: str | Path,
    arm: RobotArm | str | Path,
    reading: Reading | None = None,
    *,
    data: bytes | None = None,
    progress: Progress = no_progress,
) -> Logged:
    """Read what a log holds of an arm's motion.

    Parameters
    ----------
    path
        A text table, a bag, Parquet or YAML; or what to call the bytes.
    arm
        Whose motion it is, or its name or the path of its file.
    reading
        What the log does not tell itself.
    data
        Its bytes, where it is no file.
    progress
        Told how much of how much is read.

    Returns
    -------
    Logged
        In SI units; `Logged.columns` tells how every column was understood.

    Raises
    ------
    TrajectoryError
        If it cannot be read, or may be understood in several ways; the message lists them.

    Warns
    -----
    GdAnalyzeWarning
        Where joints are matched although their names differ.
    """
    arm, reading = arm_of(arm), reading or Reading()
    _refuse_writing_over(path, reading)
    mapping = None
    if reading.mapping is not None:
        _refuse_beside_mapping(reading)
        mapping, lines = read_mapping(reading.mapping)
        reading = Reading(
            columns=tuple(mapping.names),
            rate=reading.rate or mapping.rate,
            topic=reading.topic or mapping.topic,
            measured=reading.measured,
            save_mapping=reading.save_mapping,
        )
    table = open_log(path, reading, data, progress)
    held: dict[int, FloatArray] = {}
    if mapping is not None:
        choice = choice_by(mapping, lines, table, arm)
        times = choice.time.columns if choice.time is not None else ()
        stamps = _hold(table, [use.column for use in choice.uses], times, held, progress)
    else:
        choice, stamps = _chosen(table, arm, reading, held, progress)
    for sentence in choice.told:
        warnings.warn(f"log {Path(path).name}: {sentence}", GdAnalyzeWarning, stacklevel=2)
    return _logged(table, arm, reading, choice, held, stamps)


def _refuse_writing_over(path: str | Path, reading: Reading) -> None:
    if reading.save_mapping is None:
        return
    for read in (path, reading.mapping):
        with suppress(OSError):
            if read is not None and Path(read).samefile(reading.save_mapping):
                raise TrajectoryError(
                    "the mapping would be written over what is read",
                    where="--save-mapping",
                    expected="another file",
                    found=str(reading.save_mapping),
                )


def _refuse_beside_mapping(reading: Reading) -> None:
    if reading.columns or reading.map or reading.family or reading.time_unit or reading.degrees:
        raise TrajectoryError(
            "a mapping file says all of a log's columns",
            where="--mapping",
            expected="no other option on columns, units or families beside it",
            found="such options",
            next_step="change the mapping file, or leave it out and write it anew with --save-mapping",
        )


def _chosen(
    table: LogTable, arm: RobotArm, reading: Reading, held: dict[int, FloatArray], progress: Progress
) -> tuple[Choice, tuple[Stamps, ...]]:
    """Choose columns, and choose again where those of a family are 0 throughout."""
    zero: frozenset[object] = frozenset()
    stamps: tuple[Stamps, ...] = ()
    while True:
        try:
            choice = choose(table, arm, reading, zero)
        except AmbiguityError as error:
            columns = [column for family in error.families for column in family.all_columns]
            _hold(table, columns, (), held, progress)
            dead = {family.key for family in error.families if not _moves(family.all_columns, held)}
            if dead <= zero:
                raise
            zero |= dead
            continue
        times = choice.time.columns if choice.time is not None and not stamps else ()
        stamps = _hold(table, [use.column for use in choice.uses], times, held, progress) or stamps
        chosen = (choice.families or {}).items()
        dead = {f.key for role, f in chosen if not _moves([use.column for use in choice.of(role)], held)}
        if dead <= zero:
            return choice, stamps
        zero |= dead


def _moves(columns: Sequence[int], held: Mapping[int, FloatArray]) -> bool:
    """Whether any number is not 0."""
    return any(bool(np.nan_to_num(held[column]).any()) for column in columns)


def _hold(
    table: LogTable,
    columns: Sequence[int],
    times: Sequence[int],
    held: dict[int, FloatArray],
    progress: Progress,
) -> tuple[Stamps, ...]:
    """Read what is not held yet; a column that two things are read from is read once."""
    wanted = sorted(set(columns) - set(held))
    if not wanted and not times:
        return ()
    read = table.read(wanted, times, progress)
    for k, column in enumerate(wanted):
        held[column] = read.numbers[:, k]
    return read.stamps


def _logged(
    table: LogTable,
    arm: RobotArm,
    reading: Reading,
    choice: Choice,
    held: Mapping[int, FloatArray],
    stamps: tuple[Stamps, ...],
) -> Logged:
    arrays = {role: _in_si(choice, role, arm, held) for role in ROLES}
    q = arrays["q"]
    if q is None or not len(q):
        raise TrajectoryError(
            "the log has no rows", where=table.where(), expected="a line per sample", found="none"
        )
    if choice.time is None or not stamps:
        time, unit, why = np.arange(len(q)) / (reading.rate or 1.0), SAMPLE, f"rows at {reading.rate:g} Hz"
    else:
        name = table.names[choice.time.columns[0]] or f"column {choice.time.columns[0] + 1}"
        hint = _hint(stamps, q, arrays["qd"])
        rate = reading.rate if choice.time.unit in (SAMPLE, "") or reading.time_unit is None else None
        where = table.where(None, choice.time.columns[0])
        time, unit, why = in_seconds(stamps, choice.time, reading.time_unit, rate, name, where, hint)
    # Rows of other topics, and those without an instant, say nothing of the motion.
    known = np.isfinite(time) & np.isfinite(q).any(axis=1)
    if not known.any():
        raise TrajectoryError(
            "no row has a time and a position",
            where=table.where(),
            expected="numbers in the columns of time and positions",
            found="empty cells",
            next_step="check the recording",
        )
    if not known.all():
        why += f"; {int((~known).sum())} rows without it or positions left out"
        time, q = time[known], q[known]
        arrays = {of: None if x is None or of == "q" else x[known] for of, x in arrays.items()}
    logged = Logged(
        time=time - time[0],
        q=q,
        qd=arrays["qd"],
        qdd=arrays["qdd"],
        torque=arrays["torque"],
        measured=choice.measured if reading.measured is None else reading.measured,
        columns=_table(table, arm, choice, unit, why),
        name=visible(Path(table.path).stem),
        origin=visible(f"read from {table.path}"),
    )
    if reading.save_mapping is not None:
        write_mapping(mapping_of(choice, logged, table, arm, reading, unit), reading.save_mapping)
    return logged


def _in_si(choice: Choice, role: str, arm: RobotArm, held: Mapping[int, FloatArray]) -> FloatArray | None:
    uses = choice.of(role)
    if not uses:
        return None
    array = np.empty((len(held[uses[0].column]), len(uses)))
    for k, use in enumerate(uses):
        factor = units_of(role, arm.joints[use.joint].kind == "revolute")[use.unit]
        np.multiply(held[use.column], factor, out=array[:, k])
    return None if role in ("qd", "qdd", "torque") and not np.isfinite(array).any() else array


def _hint(stamps: tuple[Stamps, ...], q: FloatArray, qd: FloatArray | None) -> str:
    if qd is None or len(stamps) != 1:
        return ""
    unit = unit_by_velocity(stamps[0].rest[:_JUDGED], q[:_JUDGED], qd[:_JUDGED])
    return "" if unit is None else f"; the log's own velocities say --time-unit {unit}"


def _table(table: LogTable, arm: RobotArm, choice: Choice, unit: str, why: str) -> tuple[ColumnUse, ...]:
    """How every column was understood, in the order of the log."""
    told: dict[int, ColumnUse] = {}
    names = [visible(name) or str(k) for k, name in enumerate(table.names, 1)]
    for k, reason in choice.unused.items():
        told[k] = ColumnUse(names[k], "unused", why=reason)
    times = choice.time.columns if choice.time is not None else ()
    for k, column in enumerate(times):
        told[column] = ColumnUse(names[column], "time", unit="ns" if k else unit, why=why)
    for use in choice.uses:
        told[use.column] = ColumnUse(
            names[use.column],
            use.role,
            arm.joints[use.joint].name,
            use.unit,
            use.why,
        )
    for k, name in enumerate(names):
        if k not in told:
            told[k] = ColumnUse(name, "unused", why="another time" if times else "no time is needed")
    return tuple(told[k] for k in range(len(names)))
