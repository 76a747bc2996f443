"""The log of a motion in SI units, and how the columns of a table become one."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import warn_caller
from gd_analyze.motions.column_units import units_of
from gd_analyze.motions.columns import Choice, ColumnUse
from gd_analyze.motions.corrections import as_options, typed
from gd_analyze.motions.corrupt_rows import jumping_rows, require_sound
from gd_analyze.motions.instants import BY_VELOCITIES, SAMPLE, in_seconds
from gd_analyze.motions.reading import ROLES, Reading, refusal
from gd_analyze.motions.table import Columns, LogTable, Stamps
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.units_by_numbers import (
    joint_in_degrees,
    look_like_radians,
    options_of,
    units_of_factors,
    usual_reach,
)
from gd_analyze.motions.velocities import derivative_factors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS, UNITS


@dataclass(frozen=True, eq=False)
class Log:
    """The columns of an arm's motion, in SI units and in the order of the joints, untreated."""

    time: FloatArray  # s, shape (N,); in a log instants may repeat, jump or leave gaps
    q: FloatArray  # joint variables, rad (m), shape (N, n); nan where a cell is empty
    # Velocities, accelerations and torques at the joints, same shape; None if missing
    qd: FloatArray | None
    qdd: FloatArray | None
    torque: FloatArray | None
    measured: bool  # whether these are readings of sensors; a plan otherwise
    columns: tuple[ColumnUse, ...] = ()  # how every column was understood
    # Short identifier, and where it was read
    name: str = "log"
    origin: str = ""
    # For a file of set points, whose rows are used unchanged: the rows, from 0, before which it states a gap.
    # None for any other log
    gaps: tuple[int, ...] | None = None
    judged: bool = False  # whether `measured` follows from names alone, so that the numbers may contradict it

    def __repr__(self) -> str:
        quantities = [role for role in ROLES if getattr(self, role) is not None]
        size = f"{self.q.shape[1]} joints, {len(self.time)} rows of {', '.join(quantities)}"
        return f"Log({self.name!r}, {size}, {'readings' if self.measured else 'a plan'})"


def log_of(
    table: LogTable, arm: RobotArm, reading: Reading, choice: Choice, columns: Columns, name: str, origin: str
) -> Log:
    """The log in SI units, without corrupt rows, corrected as the reading says; or refuse it.

    Warns
    -----
    GdAnalyzeWarning
        Of units that are not stated and follow from the numbers.
    """
    # A trajectory takes arrays that nobody can write to as they are: a long motion is in memory once.
    columns.numbers.flags.writeable = False
    if not len(columns.numbers):
        raise refusal("the file has no rows", table.where(), "a line per instant", "none")
    wanted, _ = choice.wanted
    if not choice.measured and np.isnan(columns.numbers).any():
        column_values = dict(zip(wanted, columns.numbers.T, strict=True))
        _require_numbers(table, column_values, choice.set_points, [*columns.wrong])
    arrays = _in_stated_units(choice, arm, columns.numbers)
    gaps, degrees = None, dict[str, str]()
    if choice.set_points and choice.time is not None:
        clock = choice.time.unit, choice.time.why
        column = choice.time.columns[0]
        instants = columns.numbers[:, wanted.index(column)].copy()
        _require_increasing(table, column, instants)
        time = instants * TIME_UNITS[choice.time.unit]
        gaps = columns.gaps
    else:
        time, clock, degrees = _units_by_numbers(choice, arm, arrays, columns.stamps, table)
        _tell(name, clock, degrees)
        sizes = np.where(arm.is_revolute, UNITS["angle"]["deg"], 1.0)
        arrays |= {role: _columns(arrays[role], range(arm.n_joints), sizes) for role in degrees}
    faults = jumping_rows(time, arrays["q"], arm, table) if choice.measured else {}
    faults |= columns.wrong
    require_sound(faults, len(time), table, name, reading.drop_rows)
    # Rows of other topics and rows without an instant do not describe the motion.
    usable = np.isfinite(time) & np.isfinite(arrays["q"]).any(axis=1)
    if not usable.any():
        expected = "numbers in the columns of time and positions"
        raise refusal("no row has a time and a position", table.where(), expected, "empty cells")
    corrupt = sorted(faults)
    empty = np.delete(~usable, corrupt).sum()
    if empty:
        clock = clock[0], f"{clock[1]}; rows without time or positions, left out: {int(empty)}"
    usable[corrupt] = False
    if not usable.all():
        time, arrays = time[usable], {role: array[usable] for role, array in arrays.items()}
        for array in arrays.values():
            array.flags.writeable = False
        gaps = gaps and tuple(int(usable[:gap].sum()) for gap in gaps)
    constants = reading.torque_constant or () if "torque" in arrays else ()
    if reading.corrections or constants:
        if "torque" not in arrays:
            reading.corrections.require_torques()
        correction = reading.corrections.of_arm(arm, constants)
        arrays = correction.applied(time, arrays)
        words = shlex.join(as_options(typed(correction, arm.is_revolute)))
        origin += words and f"; corrected by {words}"
    return Log(
        time=time if gaps is not None else time - time[0],
        q=arrays["q"],
        qd=arrays.get("qd"),
        qdd=arrays.get("qdd"),
        torque=arrays.get("torque"),
        measured=choice.measured,
        columns=_uses(arm, choice, clock, degrees),
        name=name,
        origin=origin,
        gaps=gaps,
        judged=reading.measured is None,
    )


def _in_stated_units(choice: Choice, arm: RobotArm, numbers: FloatArray) -> dict[str, FloatArray]:
    """The numbers of each role, (N, n), in SI units where a unit is stated; as they are where none is."""
    wanted, _ = choice.wanted
    arrays: dict[str, FloatArray] = {}
    for role in ROLES:
        if role not in choice.columns:
            continue
        units = [choice.uses[column].unit for column in choice.columns[role]]
        sizes = [units_of(role, revolute, True) for revolute in arm.is_revolute]
        factors = np.array([size[unit] if unit else 1.0 for unit, size in zip(units, sizes, strict=True)])
        values = _columns(numbers, [wanted.index(column) for column in choice.columns[role]], factors)
        if role == "q" or np.isfinite(values).any():
            arrays[role] = values
    return arrays


def _units_by_numbers(
    choice: Choice, arm: RobotArm, arrays: Mapping[str, FloatArray], stamps: Sequence[Stamps], table: LogTable
) -> tuple[FloatArray, tuple[str, str], dict[str, str]]:
    """Seconds of the rows; the unit of time, and why; and the roles in degrees that say no unit, and why."""
    q, qd = arrays["q"], arrays.get("qd")
    stated = {use.role for use in choice.uses if use.unit.startswith(("deg", "rad", "mrad", "rev", "rpm"))}
    unstated = {role for role in ROLES[:3] if role in arrays and role not in stated and any(arm.is_revolute)}
    # What looks like velocities in rad/s beside degrees is then a time in minutes.
    unstated -= {"q"} if look_like_radians(usual_reach(q)) else set()
    factors = partial(_velocity_factors, arm, q, qd)
    if choice.time is None:
        assert choice.rate is not None  # else a column of time is required
        time = np.arange(float(len(q))) / choice.rate
        clock = SAMPLE, f"rows at {choice.rate:g} Hz"
    else:
        time, clock = in_seconds(stamps, choice.time, choice.rate, table, factors, unstated)
    units = units_of_factors(factors(time), unstated=unstated)
    degrees: dict[str, str] = {role: BY_VELOCITIES for role in ("q", "qd") if role in (units or {})}
    # Velocities that contradict the positions of some joints leave their unit open.
    is_open = "q" in unstated and not degrees and units is not None
    joint = joint_in_degrees(arm, usual_reach(q)) if is_open else None
    if joint is not None:
        reach, end = usual_reach(q)[joint], arm.joints[joint].upper
        limit = "without limits" if end is None else f"whose limit is {end:.3g} rad"
        degrees = {"q": f"{arm.joints[joint].name}, {limit}, reaches {reach:.3g}"}
        degrees |= {"qd": "as the positions"} if "qd" in unstated else {}
    degrees |= {"qdd": "as the velocities"} if "qdd" in unstated and "qd" in degrees else {}
    return time, clock, degrees


def _velocity_factors(
    arm: RobotArm, q: FloatArray, qd: FloatArray | None, instants: FloatArray
) -> FloatArray:
    """Factors by which velocities of joints that move are too large; of those that turn, if any does."""
    if qd is None:
        return np.zeros(0)
    rows = np.isfinite(instants) & np.isfinite(q).all(axis=1) & np.isfinite(qd).all(axis=1)
    if not rows.all():
        instants, q, qd = instants[rows], q[rows], qd[rows]
    with np.errstate(over="ignore", invalid="ignore"):
        factors, contradicts = derivative_factors(instants, q, qd)
    turns = np.array(arm.is_revolute)
    judged = (turns if turns.any() else ~turns) & (np.isfinite(factors) | contradicts)
    return np.abs(factors[judged])


_DEGREES = {"q": "deg", "qd": "deg/s", "qdd": "deg/s^2"}


def _tell(name: str, clock: tuple[str, str], degrees: Mapping[str, str]) -> None:
    """Warn of units that follow from the numbers alone, with the options that confirm them."""
    facts = [f"{role} in {_DEGREES[role]} ({reason})" for role, reason in degrees.items()]
    units = dict.fromkeys(degrees, "deg")
    if clock[1] == BY_VELOCITIES:
        facts.insert(0, f"time in {clock[0]} ({BY_VELOCITIES})")
        units = {"time": clock[0]} | units
    if facts:
        message = (
            f"no unit is stated, and the numbers say {', '.join(facts)}: {options_of(units)} confirms this"
        )
        warn_caller(f"log {name}: {message}")


def _columns(numbers: FloatArray, places: Sequence[int], factors: FloatArray) -> FloatArray:
    """Take columns, each times its factor; columns side by side that need none are not copied."""
    if places and (factors == 1.0).all() and (np.diff(places) == 1).all():
        return numbers[:, places[0] : places[-1] + 1]
    values = numbers[:, list(places)] * factors
    values.flags.writeable = False
    return values


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
                step += "; measured=True leaves out such rows of a recording"
                raise refusal(message, table.where(row, column), "a number", cell, step)


def _require_increasing(table: LogTable, column: int, time: FloatArray) -> None:
    """Refuse set points whose time does not increase."""
    for k in np.flatnonzero(np.diff(time) <= 0)[:1].tolist():
        where, expected = table.where(k + 1, column), f"more than {time[k]!s}, the time of the line before"
        step = "sort the set points by time and keep one per instant; for readings, measured=True does this"
        raise refusal("time does not increase", where, expected, str(time[k + 1]), step)


def _uses(
    arm: RobotArm, choice: Choice, clock: tuple[str, str], degrees: Mapping[str, str]
) -> tuple[ColumnUse, ...]:
    """Role and unit of every column, in the order of the log."""
    (unit, why), times = clock, choice.time.columns if choice.time is not None else ()
    uses = [*choice.uses]
    for k, column in enumerate(times):
        uses[column] = replace(uses[column], unit="ns" if k else unit, why=why)
    for role, columns in choice.columns.items():
        for column, turns in zip(columns, arm.is_revolute, strict=True):
            use = uses[column]
            if not use.unit and role in degrees and turns:
                uses[column] = replace(use, unit=_DEGREES[role], why=f"{use.why}; unit by the numbers")
            elif not use.unit:
                uses[column] = replace(use, unit=next(iter(units_of(role, turns))))
    return tuple(uses)
