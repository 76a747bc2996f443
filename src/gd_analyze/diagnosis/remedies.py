"""What a user does about a cause: options that do what was tried, whose words are made here, or an edit."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.samples import Samples
from gd_analyze.errors import GdAnalyzeError, argument
from gd_analyze.motions.correction import Correction
from gd_analyze.motions.corrections import as_options, typed
from gd_analyze.motions.reading import ROLES, MotionRole, Reading
from gd_analyze.text import number
from gd_analyze.units import TIME_UNITS, UNITS

# Significant digits of factors that are known.
_DIGITS = 9
# Relative difference of numbers that are typed and those tried, beyond which they do something else.
_TYPED_AGREES = 1e-6
# Radians per degree, and what all joints that turn are in where their variables are multiplied so.
ONE_DEGREE = UNITS["angle"]["deg"]
_UNITS_OF_ANGLES = {ONE_DEGREE: "deg", 1.0 / ONE_DEGREE: "rad"}
NO_PAYLOAD = "leave out --payload"
# How the unit of positions, and gravity, are said.
IN_DEGREES, OF_GRAVITY = "--map q=:deg", "--gravity"


@dataclass(frozen=True, eq=False)
class Remedy:
    """What mends logs: numbers of how they are read and then corrected, the arm's options, and edits.

    Parameters
    ----------
    samples
        Those of the logs, whose columns have names and units.
    change
        What corrections do to the numbers read.
    read
        Order of the columns and unit of positions, as against those logged.
    pace
        Seconds per second as logged.
    arm
        Keywords of the arm's options and their words.
    edits
        What no option does, in words.
    """

    samples: Samples
    change: Correction
    read: Correction
    pace: float = 1.0
    arm: Mapping[str, str] = field(default_factory=dict)
    edits: tuple[str, ...] = ()

    def then(self, other: Remedy) -> Remedy:
        """Both, in the order in which a log is read: its columns and their units come first."""
        moved = other.read.inverse.then(self.change).then(other.read)
        moved = replace(moved, lag=self.change.lag * other.pace)
        return replace(
            self,
            change=moved.then(other.change),
            read=self.read.then(other.read),
            pace=self.pace * other.pace,
            arm={**self.arm, **other.arm},
            edits=self.edits + other.edits,
        )

    @property
    def reading(self) -> dict[str, Any]:
        """Keywords of `Reading.of` that read the log so."""
        maps = self._maps()
        sizes = {*np.abs(self.read.position).ravel().tolist()}
        for angle in (unit for size, unit in _UNITS_OF_ANGLES.items() if size in sizes):
            maps += [f"{role}=:{angle}" for role in ROLES[:3] if role in self._roles]
        if self.pace != 1.0:
            unit = self._unit_of_time()
            rate = float(number(1.0 / (self.samples.step * self.pace)))
            maps.append(f"time={rate:g}Hz" if unit is None else f"time=:{unit}")
        return ({"map": maps} if maps else {}) | self._corrections()

    @property
    def _roles(self) -> set[str]:
        """Roles of the log's columns; of a log without any, positions."""
        recording = self.samples.logs[0].recording
        return {"q"} | {str(use.role) for use in (recording.columns if recording is not None else ())}

    @property
    def options(self) -> str:
        """Options as typed; "" if there are none."""
        return shlex.join(as_options({**self.reading, **self.arm}))

    @property
    def is_all_typed(self) -> bool:
        """Whether its options are all that there is to do."""
        return bool(self.options) and not self._all_edits() and self.is_typed

    @property
    def advice(self) -> str:
        """What to do, in sentences."""
        options, edits = self.options, self._all_edits()
        sentences = [f"Use {options}."] if options else []
        return " ".join([*sentences, *(f"{edit[0].upper()}{edit[1:]}." for edit in edits)])

    @property
    def as_arguments(self) -> str:
        """What to do, with arguments of a call in place of options."""
        return "; ".join(filter(None, (_arguments({**self.reading, **self.arm}), *self._all_edits())))

    def __str__(self) -> str:
        return "; ".join(filter(None, (self.options, *self._all_edits())))

    def __repr__(self) -> str:
        return f"Remedy({str(self)!r})"

    @property
    def is_typed(self) -> bool:
        """Whether the options, read again, do what was tried: those of two causes may not."""
        try:
            reading = Reading.of(**self._corrections())
            change = reading.corrections.of_arm(self.samples.arm, reading.torque_constant or ())
        except GdAnalyzeError:
            return False
        pairs = ((change.position, self.change.position), (change.torque, self.change.torque))
        is_a_unit = np.isin(np.abs(self.read.position), (0.0, 1.0, *_UNITS_OF_ANGLES)).all()
        return bool(is_a_unit) and all(
            np.abs(a - b).max() <= _TYPED_AGREES * np.abs(b).max() for a, b in pairs
        )

    def _corrections(self) -> dict[str, Any]:
        return dict(typed(self.change, self.samples.arm.is_revolute))

    def _sources(self) -> dict[MotionRole, list[int]]:
        """Joint, from 0, of whose column each joint's values are taken, by role."""
        position, torque = (
            np.abs(matrix).argmax(axis=1).tolist() for matrix in (self.read.position, self.read.torque)
        )
        return {role: torque if role == "torque" else position for role in ROLES}

    def _maps(self) -> list[str]:
        recording, names = self.samples.logs[0].recording, [joint.name for joint in self.samples.arm.joints]
        uses = () if recording is None else recording.columns
        columns = {(str(use.role), use.joint): use.column for use in uses}
        return [
            f"{role}:{names[i]}={columns[role, names[k]]}"
            for role, sources in self._sources().items()
            for i, k in enumerate(sources)
            if i != k and (role, names[k]) in columns
        ]

    def _all_edits(self) -> list[str]:
        """Edits, and how columns without names are exchanged."""
        if self._maps():
            return [*self.edits]
        moved: dict[str, list[str]] = {}
        sources = self._sources()
        for source, what in ((sources["q"], "positions"), (sources["torque"], "torques")):
            pairs = [f"{i + 1} from {k + 1}" for i, k in enumerate(source) if i != k]
            moved.setdefault(", ".join(pairs), []).append(what)
        exchanges = [
            f"exchange the columns of {' and '.join(what)}: joint {pairs}"
            for pairs, what in moved.items()
            if pairs
        ]
        return [*exchanges, *self.edits]

    def _unit_of_time(self) -> str | None:
        """The unit of the log's time at the right pace; None if it is none."""
        recording = self.samples.logs[0].recording
        columns = () if recording is None else recording.columns
        logged = next((use.unit for use in columns if use.role == "time"), "s")
        size = TIME_UNITS.get(logged, 1.0) * self.pace
        return next((name for name, x in TIME_UNITS.items() if np.isclose(x, size, rtol=0.01)), None)


def nothing(samples: Samples) -> Remedy:
    """Leave all as it is."""
    none = Correction.none(samples.arm.n_joints)
    return Remedy(samples, none, none)


def corrected(samples: Samples, change: Correction) -> Remedy:
    """Correct the numbers."""
    return replace(nothing(samples), change=change)


def edited(samples: Samples, words: str) -> Remedy:
    """Do what no option does."""
    return replace(nothing(samples), edits=(words,))


def multiplied(samples: Samples, position: FloatArray, torque: FloatArray) -> Remedy:
    """Joint variables and torques as logged times factors that are known, (n,)."""
    factors, constants = (
        np.diag([in_digits(x, _DIGITS) for x in values.tolist()]) for values in (position, position * torque)
    )
    # Torques are divided by the factors of their joints: power stays the same.
    none = Correction.none(samples.arm.n_joints)
    return corrected(samples, none.with_torque(constants).with_joints(factors))


def with_constants(samples: Samples, constants: FloatArray) -> Remedy:
    """Torques as logged times a number of each joint."""
    none = Correction.none(samples.arm.n_joints)
    return corrected(samples, none.with_torque(np.diag(constants)))


def in_unit(samples: Samples, sizes: FloatArray) -> Remedy:
    """Positions in a unit of each joint, of some size in rad (m), (n,)."""
    none = Correction.none(len(sizes))
    for size in _UNITS_OF_ANGLES:
        if np.array_equal(sizes, np.where(samples.arm.is_revolute, size, 1.0)):
            return replace(nothing(samples), read=none.with_position(np.diag(sizes)))
    return multiplied(samples, sizes, np.ones(len(sizes)))


def reordered(samples: Samples, position: FloatArray, torque: FloatArray) -> Remedy:
    """Columns of motion and of torque taken in another order, (n, n) each."""
    return replace(
        nothing(samples), read=Correction.none(len(position)).with_position(position).with_torque(torque)
    )


def at_pace(samples: Samples, pace: float) -> Remedy:
    """Seconds per second as logged."""
    return replace(nothing(samples), pace=pace)


def under_gravity(samples: Samples, gravity: FloatArray) -> Remedy:
    """The arm mounted so that gravity is this, m/s^2."""
    return replace(nothing(samples), arm={"gravity": vector(gravity)})


def with_load(samples: Samples, numbers: Sequence[str]) -> Remedy:
    """The arm with a payload: mass and place, as told."""
    return replace(nothing(samples), arm={"payload": ",".join(numbers)})


def in_digits(value: float, digits: int, size: float = 1.0) -> float:
    """A value to significant digits of a unit of some size."""
    return float(f"{value / size:.{digits}g}") * size


def vector(values: FloatArray) -> str:
    """A vector of an option."""
    return ",".join(f"{value + 0.0:.4g}" for value in np.round(values, 4))


def reversed_torques(signs: Sequence[float]) -> str:
    """How torques of joints are reversed whose sign is -1: an argument."""
    n = len(signs)
    return _arguments(typed(Correction.none(n).with_torque(np.diag(signs)), [True] * n))


def _arguments(words: Mapping[str, str | list[str]]) -> str:
    """Keywords of a call and their words, as a message names them."""
    return " and ".join(argument(name, value) for name, value in words.items())


def another_column(role: str, joint: int) -> str:
    """How another column is named for a joint, from 0: an argument."""
    return argument("map", [f"{role}:{joint + 1}=COLUMN"])


def leaving_out(role: str) -> str:
    """How all columns of a role are left out: an argument."""
    return argument("map", [f"{role}=none"])
