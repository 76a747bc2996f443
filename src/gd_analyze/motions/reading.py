"""The user's choices for a log: how to read its columns and how to treat its readings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from gd_analyze.arguments import require_flags_of
from gd_analyze.errors import Location, TrajectoryError, UsageError
from gd_analyze.motions.corrections import Corrections
from gd_analyze.text import LARGEST, number_in
from gd_analyze.units import Quantity

MotionRole = Literal["q", "qd", "qdd", "torque"]
ROLES: tuple[MotionRole, ...] = ("q", "qd", "qdd", "torque")

# Rates, Hz, at which motions are sampled.
_LOWEST_RATE, _HIGHEST_RATE = 0.1, 1e5


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
    map
        Pairs of a role and what is said of it. Roles are q, qd, qdd, torque, time and joints; "q:JOINT" is of
        one joint. Columns are given by a pattern whose star stands for a joint's name or number ("AIPos.A*"),
        by a list in the order of the joints ("mp1..mp7", "#2..#8") or by name or number ("Position3", "#3").
        A unit may follow ("AIPos.A*:deg") or stand alone (":deg"), as may the rate of samples ("250Hz").
        "none" leaves a role out. "joints" are the joints' names in the log, in the arm's order.
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
        If a value is invalid.
    """

    map: tuple[tuple[str, str], ...] = ()
    topic: str | None = None
    measured: bool | None = None
    torque_constant: tuple[float | None, ...] | None = None
    drop_rows: bool = False
    corrections: Corrections = field(default_factory=Corrections)

    @classmethod
    def of(cls, map: Iterable[str] | Mapping[str, str] = (), **settings: Any) -> Reading:
        """Parse words as typed: "q=AIPos.A*:deg", "time=250Hz", "joints=s,l,u,r,b,t".

        Corrections are given by their names: torque_sign="-1", offset=["3=90deg"].

        Raises
        ------
        TrajectoryError
            If they cannot be read.
        UsageError
            If a correction cannot be read.
        """
        words = [map] if isinstance(map, str) else map
        pairs = words.items() if isinstance(words, Mapping) else (_pair(word) for word in words)
        constants = settings.pop("torque_constant", None)
        if isinstance(constants, str):
            constants = [number_in(word) for word in constants.split(",")]
        names = [field.name for field in fields(Corrections) if field.name in settings]
        if names:
            settings["corrections"] = Corrections.of(**{name: settings.pop(name) for name in names})
        return cls(
            map=tuple((role.strip(), value.strip()) for role, value in pairs),
            torque_constant=None if constants is None else tuple(constants),
            **settings,
        )

    def __post_init__(self) -> None:
        require_flags_of(self)
        for role, value in self.map:
            _require_role(role, value)
        if self.torque_constant is not None and {None, 0.0} & {*self.torque_constant}:
            expected = "a number per joint, N m/A, with commas"
            step = "`torque_constant='10.7,10.7,8.5'` for an arm of three joints"
            content = "another word" if None in self.torque_constant else "0"
            message = "the torque constants are not numbers other than 0"
            raise refusal(message, "torque_constant", expected, content, step)


def _pair(entry: str) -> tuple[str, str]:
    role, _, value = entry.partition("=")
    if not role.strip() or not value.strip():
        expected = "ROLE=COLUMNS, such as time=Time, 'q=Position*:deg', q:elbow_joint=Position3"
        step = "`gd-analyze columns ROBOT LOG` lists the columns"
        raise refusal("this is not a mapping", "map", expected, repr(entry), step)
    return role, value


def _require_role(role: str, value: str) -> None:
    name, colon, joint = role.partition(":")
    if name == "q" and value == "none":
        raise refusal("a motion needs positions", "map", "their columns", f"{role}={value}")
    if name in ROLES and bool(colon) == bool(joint) and not (joint and value == "none"):
        return
    if role == "joints" or (role == "time" and value != "none"):
        return
    message, expected = f"unknown role {role!r}", f"{', '.join(ROLES)}, one of them with :JOINT; time; joints"
    step = "count the rows with `map='time=250Hz'`" if role == "time" else None
    raise refusal(message, "map", expected, f"{role}={value}", step)


def rate_in(text: str) -> float | None:
    """Samples per second of a text with its unit, such as 250Hz; None for any other text.

    Raises
    ------
    TrajectoryError
        If no motion is sampled so.
    """
    rate = Quantity.parse(text)
    if rate is None or rate.kind != "frequency":
        return None
    if not _LOWEST_RATE <= rate.si <= _HIGHEST_RATE:
        expected, content = f"{_LOWEST_RATE:g} to {_HIGHEST_RATE:g} Hz", f"{rate.si:g} Hz"
        seconds = 1 / rate.si if rate.si > 0.0 else 0.0
        step = f"for steps of {rate.si:g} s give {seconds:.6g}Hz"
        raise refusal("no motion is sampled so", "map", expected, content, step if seconds else None)
    return rate.si


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
