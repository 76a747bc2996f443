"""The user's choices for a log: how to read its columns and how to treat its readings."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from gd_analyze.arguments import require_flags_of
from gd_analyze.errors import Location, TrajectoryError, UsageError
from gd_analyze.motions.corrections import Corrections
from gd_analyze.text import LARGEST, number_in
from gd_analyze.units import TIME_UNITS

MotionRole = Literal["q", "qd", "qdd", "torque"]
ROLES: tuple[MotionRole, ...] = ("q", "qd", "qdd", "torque")

_RANGE = re.compile(r"(.*?)([0-9]{1,4})\.\.(.*?)([0-9]{1,4})")
# Rates, Hz, at which motions are sampled.
_LOWEST_RATE, _HIGHEST_RATE = 0.1, 1e5
# Columns that one range q1..qN names, at most.
_MOST_COLUMNS = 10_000


def refusal(
    message: str, where: Location | str, expected: str, found: str | list[str], next_step: str | None = None
) -> TrajectoryError:
    """Make a TrajectoryError."""
    return TrajectoryError(message, where=where, expected=expected, found=found, next_step=next_step)


@dataclass(frozen=True)
class Reading:
    """How to read a log; fields left out are inferred from the log.

    Parameters
    ----------
    columns
        Column names of a file without a header, `-` for a column that is not needed; for a file with a
        header, the only columns to use. `q1..q6` stands for six names.
    map
        Pairs of a role and its column: "time" or "q:JOINT" (qd, qdd, torque) and a name or #NUMBER from 1;
        "q" (qd, qdd, torque) and a pattern whose star stands for a joint's name or number; "joint:JOINT" and
        the joint's name in the log; "torque" (qd, qdd) and "none". A unit may follow a column or pattern:
        "Timestamp:us", "AIPos.A*:deg".
    rate
        Samples per second, Hz, if the log counts samples or has no time.
    time_unit
        Unit of time: s, ms, us or ns.
    degrees
        Whether angles in columns without a unit are in degrees.
    family
        Pairs of a role ("" for all) and a word in the names of the columns to take.
    topic
        Topic of a bag to read.
    measured
        True for sensor readings, False for a plan.
    torque_constant
        Torque at each joint per unit of its torque column: N m/A (N/A) if these are currents.
    drop_rows
        Whether to leave out corrupt rows, which are refused otherwise.
    corrections
        What is done to the log's numbers: signs, zeros, coupled joints, late torques.

    Raises
    ------
    TrajectoryError
        If a value is invalid, or rate and unit of time are both given.
    """

    columns: tuple[str, ...] = ()
    map: tuple[tuple[str, str], ...] = ()
    rate: float | None = None
    time_unit: str | None = None
    degrees: bool = False
    family: tuple[tuple[str, str], ...] = ()
    topic: str | None = None
    measured: bool | None = None
    torque_constant: tuple[float | None, ...] | None = None
    drop_rows: bool = False
    corrections: Corrections = field(default_factory=Corrections)

    @classmethod
    def of(
        cls,
        columns: str | Iterable[str] = (),
        map: Iterable[str] | dict[str, str] = (),
        family: str | Iterable[str] = (),
        **settings: Any,
    ) -> Reading:
        """Parse words as typed: "time,q1..q6", "q:elbow=Position3", "q=mp1..mp7", "torque=cur".

        Patterns are typed so, too: "q=AIPos.A*:deg". Corrections are given by their names:
        torque_sign="-1", offset=["3=90deg"].

        Raises
        ------
        TrajectoryError
            If they cannot be read.
        UsageError
            If a correction cannot be read.
        """
        listed = columns.split(",") if isinstance(columns, str) else list(columns)
        pairs = map.items() if isinstance(map, dict) else (_pair(entry, "--map") for entry in map)
        constants = settings.pop("torque_constant", None)
        if isinstance(constants, str):
            constants = [number_in(word) for word in constants.split(",")]
        families = [family] if isinstance(family, str) else list(family)
        names = [field.name for field in fields(Corrections) if field.name in settings]
        if names:
            settings["corrections"] = Corrections.of(**{name: settings.pop(name) for name in names})
        return cls(
            columns=tuple(name for entry in listed if entry for name in _expanded(entry.strip())),
            map=tuple(
                pair for role, column in pairs for pair in _joint_by_joint(role.strip(), column.strip())
            ),
            family=tuple(_pair(word, "--family") if "=" in word else ("", word) for word in families),
            torque_constant=None if constants is None else tuple(constants),
            **settings,
        )

    def __post_init__(self) -> None:
        require_flags_of(self)
        if self.time_unit is not None and self.time_unit not in TIME_UNITS:
            step = "--time-unit ms for milliseconds"
            raise refusal(
                "unknown unit of time", "time_unit", ", ".join(TIME_UNITS), repr(self.time_unit), step
            )
        if self.rate is not None and not 0.0 < self.rate <= LARGEST:
            step = "--rate 125 for 125 samples per second"
            raise refusal("impossible sample rate", "rate", "Hz, above 0", repr(self.rate), step)
        if self.rate is not None and not _LOWEST_RATE <= self.rate <= _HIGHEST_RATE:
            expected, content = f"{_LOWEST_RATE:g} to {_HIGHEST_RATE:g} Hz", f"{self.rate:g} Hz"
            step = f"--rate {1 / self.rate:.6g} if {self.rate:g} is the time from sample to sample, in s"
            raise refusal("no motion is sampled so", "rate", expected, content, step)
        if self.torque_constant is not None and {None, 0.0} & {*self.torque_constant}:
            expected = "a number per joint, N m/A, with commas"
            step = "--torque-constant 10.7,10.7,8.5 for an arm of three joints"
            content = "another word" if None in self.torque_constant else "0"
            message = "the torque constants are not numbers other than 0"
            raise refusal(message, "torque_constant", expected, content, step)
        if self.rate is not None and self.time_unit is not None:
            expected, values = "one of the two", f"{self.rate:g} Hz and {self.time_unit}"
            message, step = "a rate and a unit of time contradict each other", "omit one of the two"
            raise refusal(message, "rate", expected, values, step)
        for role, word in self.family:
            if role not in ("", *ROLES):
                step = f"--family torque={word} for torques, --family {word} for all"
                raise refusal(f"unknown role {role!r}", "family", ", ".join(ROLES), f"{role}={word}", step)

    def words_for(self, role: str) -> tuple[str, ...]:
        """Words that the names of a role's columns must contain."""
        role_words = tuple(word for family_role, word in self.family if family_role == role)
        return role_words or tuple(word for family_role, word in self.family if not family_role)


@dataclass(frozen=True, kw_only=True)
class Treatment:
    """How to treat readings; fields left out are chosen by rule, see docs/trajectories.md.

    Parameters
    ----------
    cutoff
        Cut-off frequency of the low-pass, Hz: one for all joints, or one per joint.
    largest_gap
        Longest time between two readings that is not a gap in the motion, s.
    use_velocities
        Whether accelerations may be derived from measured velocities; by default if they have less noise.

    Raises
    ------
    UsageError
        If a number is not positive and finite.
    """

    cutoff: float | tuple[float, ...] | None = None
    largest_gap: float | None = None
    use_velocities: bool = True

    def __post_init__(self) -> None:
        require_flags_of(self)
        cutoffs = self.cutoff if isinstance(self.cutoff, tuple) else (self.cutoff,)
        for name, unit, values in (("cutoff", "Hz", cutoffs), ("largest_gap", "s", (self.largest_gap,))):
            for value in values:
                if value is not None and not 0.0 < value <= LARGEST:
                    where, expected = f"Treatment, {name}", f"a number above 0, in {unit}"
                    raise UsageError(f"impossible {name}", where=where, expected=expected, found=f"{value:g}")


def _pair(entry: str, where: str) -> tuple[str, str]:
    role, _, column = entry.partition("=")
    if not role.strip() or not column.strip():
        expected = "ROLE=COLUMN, such as time=Time, 'q=Position*:deg', q:elbow_joint=Position3"
        step = "`gd-analyze columns ROBOT LOG` lists the columns"
        raise refusal("this is not a mapping", where, expected, repr(entry), step)
    return role.strip(), column.strip()


def _joint_by_joint(role: str, column: str) -> list[tuple[str, str]]:
    """Roles of `q=mp1..mp7`, a column per joint; any other pair itself."""
    before_unit = column.rpartition(":")[0]
    span = before_unit if _RANGE.fullmatch(before_unit) else column
    names = _expanded(span) if role in ROLES else [column]
    if len(names) == 1:
        return [(role, column)]
    of_unit = column.removeprefix(span)
    return [(f"{role}:{joint}", f"{name}{of_unit}") for joint, name in enumerate(names, start=1)]


def _expanded(entry: str) -> list[str]:
    """Names of `q1..q6`; any other entry itself."""
    match = _RANGE.fullmatch(entry)
    if match is None:
        return [entry]
    first, last = int(match[2]), int(match[4])
    if match[3] not in ("", match[1]) or not first <= last < first + _MOST_COLUMNS:
        expected = "q1..q6, with the same letters on both sides"
        step = "write the names one by one, with commas"
        raise refusal("this is not a range of names", "--columns", expected, repr(entry), step)
    return [f"{match[1]}{k}" for k in range(first, last + 1)]
