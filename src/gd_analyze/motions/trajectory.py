"""A trajectory as a value: time, joint variables, velocities and accelerations, SI and radians."""

from __future__ import annotations

import hashlib
import numbers
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray, array_of, chunks, frozen
from gd_analyze.errors import TrajectoryError, require_type
from gd_analyze.files import path_of, replaces_own, write_text
from gd_analyze.motions.log import Log
from gd_analyze.motions.reading import Treatment, refusal
from gd_analyze.motions.smoothing import Recording, treated
from gd_analyze.motions.text import GAP
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, counted, html_of, number

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

Gaps = tuple[int, ...]
# Stands for velocities or accelerations that a new trajectory derives itself; none that exists has it.
_TO_DERIVE: Any = None
_COMMAND = re.compile(r"(?m)^#[ \t]*(gd-analyze plan .*\S)\s*$")


@dataclass(frozen=True)
class Motion:
    """One of several motions in a trajectory."""

    name: str  # unique in the trajectory
    # Its set points, from 0: `first` is the first, `end` the one after the last
    first: int
    end: int
    start: float = 0.0  # instant of its first set point on its own clock, s
    # Attributes of the motion, see `Trajectory`
    origin: str = ""
    derivatives_from: str = "given"
    fingerprint: str = ""
    # Filter, noise and treatment of its readings, if it has some, without their rows
    treated: Recording | None = field(default=None, repr=False, compare=False)

    @property
    def rows(self) -> slice:
        """Its set points."""
        return slice(self.first, self.end)

    @property
    def n_set_points(self) -> int:
        """Number of set points."""
        return self.end - self.first


def listed(motions: Iterable[Motion]) -> str:
    """Names of motions, comma-separated; commas in names are left out."""
    return ", ".join(motion.name.replace(",", " ") for motion in motions)


def counted_motions(names: Sequence[str], most: int = 4) -> str:
    """Number of motions, with their names if there are few: "2 motions (a, b)"."""
    return f"{len(names)} motions" + (f" ({', '.join(names)})" if len(names) <= most else "")


class Whole(NamedTuple):
    """The whole motion behind a selection of its set points."""

    n_set_points: int
    fingerprint: str


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Set points of one motion, or of several one after the other.

    Parameters
    ----------
    time
        Instants, strictly increasing, s, shape (N,).
    q, qd, qdd
        Joint variables, velocities and accelerations, rad (m) and per s, s^2, shape (N, n). Velocities and
        accelerations that are left out are derived, as those of a CSV file are; `from_arrays` has options.
    name
        Short identifier, used for output folders and titles.
    origin
        Origin, such as the file read or the plan's command.
    derivatives_from
        "given", or how missing velocities and accelerations were derived.
    gaps
        Set points (from 0, ascending, not the first) before which the motion is unknown: a recording was
        interrupted, or another motion begins.
    recording
        The readings behind a measured motion; None for a plan.
    motions
        The motions of a pool, with their set points.
    whole
        The longer motion of which these set points are a selection; None if they are all.

    Raises
    ------
    TrajectoryError
        If shapes disagree, a number is not finite or too large, time does not increase, gaps do not fit, or
        there are too few set points to derive from.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.linspace(0.0, 2.0, 101)
    >>> Trajectory(time, np.column_stack([np.sin(time), np.cos(time)])).derivatives_from
    'qd and qdd derived: C4 (quintic) spline through the given q'
    """

    time: FloatArray
    q: FloatArray
    qd: FloatArray = _TO_DERIVE
    qdd: FloatArray = _TO_DERIVE
    name: str = "trajectory"
    origin: str = ""
    derivatives_from: str = "given"
    gaps: Gaps = ()
    recording: Recording | None = None
    motions: tuple[Motion, ...] = ()
    whole: Whole | None = None

    def __post_init__(self) -> None:
        arrays = _arrays(self.time, self.q, self.qd, self.qdd)
        if len(arrays) < 4:
            derived = Trajectory.from_log(_log(arrays, None, self.name, self.origin, self.gaps))
            arrays = {name: getattr(derived, name) for name in ("time", "q", "qd", "qdd")}
            for name in ("derivatives_from", "gaps", "recording"):
                object.__setattr__(self, name, getattr(derived, name))
        arrays = {name: frozen(array) for name, array in arrays.items()}
        _require_sound(self.name, arrays, self.gaps)
        for name, value in (arrays | {"gaps": tuple(map(int, self.gaps))}).items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_arrays(
        cls,
        time: ArrayLike,
        q: ArrayLike,
        qd: ArrayLike | None = None,
        qdd: ArrayLike | None = None,
        *,
        name: str = "trajectory",
        measured: bool | None = None,
        arm: RobotArm | None = None,
        treatment: Treatment | None = None,
    ) -> Trajectory:
        """Make a trajectory from arrays.

        Parameters
        ----------
        time
            Instants, s, shape (N,).
        q, qd, qdd
            Joint variables and, if known, velocities and accelerations, rad (m) and per s, s^2, shape
            (N, n).
        name
            Short identifier.
        measured
            Whether these are readings, to be treated like those of a log; by default if their accelerations
            are noise. Time must increase unless `measured` is True.
        arm, treatment
            For readings: the arm, so that jumps of full turns are undone, and how to treat them.

        Raises
        ------
        TrajectoryError
            If there are too few set points to derive missing derivatives, or as for `Trajectory`.

        Examples
        --------
        >>> import numpy as np
        >>> time = np.linspace(0.0, 2.0, 101)
        >>> readings = np.column_stack([np.sin(time), np.cos(time)]).round(3)
        >>> Trajectory.from_arrays(time, readings, measured=True).recording.measured
        True
        """
        arrays = _arrays(time, q, qd, qdd)
        return cls.from_log(_log(arrays, measured, name, "arrays in memory", ()), arm, treatment)

    @classmethod
    def from_log(
        cls, logged: Log, arm: RobotArm | None = None, treatment: Treatment | None = None
    ) -> Trajectory:
        """Make a trajectory from a log.

        Set points of a file are used unchanged. Rows of any other log are sorted and cut at gaps, and jumps
        of full turns are undone; readings are also smoothed. Missing derivatives of a plan are derived.

        Parameters
        ----------
        logged
            The log as read by `read_log`.
        arm
            The arm; None if unknown, and then no jumps of full turns are undone.
        treatment
            How to treat readings; by default chosen by rule.

        Raises
        ------
        TrajectoryError
            If the log has another number of joints or too few readings, or a cut-off does not suit it.

        Warns
        -----
        GdAnalyzeWarning
            If measured velocities contradict the positions and are not used.
        """
        if logged.gaps is not None and (logged.qd is None or logged.qdd is None):
            # Before a spline is fitted to it.
            _require_sound(logged.name, _arrays(logged.time, logged.q, logged.qd, logged.qdd), logged.gaps)
        result = treated(logged, arm, treatment)
        return cls(name=logged.name, origin=logged.origin, **vars(result))

    def __repr__(self) -> str:
        size = f"{counted(self.n_joints, 'joint')}, {counted(self.n_set_points, 'set point')}"
        return f"Trajectory({self.name!r}, {size}, {self.time[0]:g} to {self.time[-1]:g} s)"

    def _repr_html_(self) -> str:
        """Extent and largest derivatives of each joint, for a notebook."""
        largest = [np.abs(x).max(axis=0) for x in (self.qd, self.qdd)]
        columns = np.column_stack([self.q[0], self.q[-1], *largest])
        rows = [[str(i), *map(number, row)] for i, row in enumerate(columns.tolist(), start=1)]
        headings = ["joint", "start", "end", "largest velocity", "largest acceleration"]
        return html_of(repr(self), headings, rows, "In rad and s; m for prismatic joints.")

    @property
    def n_set_points(self) -> int:
        """Number of set points N."""
        return len(self.q)

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return int(self.q.shape[1])

    @property
    def derived(self) -> tuple[str, ...]:
        """Which of "qd" and "qdd" were derived, as `derivatives_from` says."""
        names, marker, _ = self.derivatives_from.partition(" derived")
        return tuple(names.split(" and ")) if marker else ()

    @property
    def stretches(self) -> list[slice]:
        """Set points of each stretch without a gap."""
        return [slice(first, last) for first, last in pairwise([0, *self.gaps, self.n_set_points])]

    @property
    def n_stated(self) -> int:
        """Number of set points of the whole motion, of which this may be a selection."""
        return self.n_set_points if self.whole is None else self.whole.n_set_points

    def at(self, points: NDArray[np.intp]) -> Trajectory:
        """Take some set points, ascending, to represent the whole."""
        time, q, qd, qdd = (x[points] for x in (self.time, self.q, self.qd, self.qdd))
        gaps = tuple(np.unique(np.searchsorted(points, self.gaps)).tolist()) if self.gaps else ()
        about, whole = (self.name, self.origin, self.derivatives_from), Whole(self.n_stated, self.fingerprint)
        recording = None if self.recording is None else self.recording.at(points)
        return Trajectory(time, q, qd, qdd, *about, gaps, recording, whole=whole)

    @cached_property
    def extreme_at(self) -> NDArray[np.intp]:
        """Set points of the smallest and largest q, qd and qdd of every joint, shape (3, 2, n)."""
        # A column at a time: of a whole array they would copy it.
        columns = (column for array in (self.q, self.qd, self.qdd) for column in array.T)
        ends = np.array([(column.argmin(), column.argmax()) for column in columns])
        return ends.reshape(3, self.n_joints, 2).swapaxes(1, 2)

    @cached_property
    def extremes(self) -> FloatArray:
        """Smallest and largest q, qd and qdd of every joint, shape (3, 2, n)."""
        pairs = zip((self.q, self.qd, self.qdd), self.extreme_at, strict=True)
        return np.stack([np.take_along_axis(array, at, axis=0) for array, at in pairs])

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 of the numbers."""
        if self.whole is not None:
            return self.whole.fingerprint
        digest = hashlib.sha256(repr(self.gaps).encode() if self.gaps else b"")
        for array in (self.time, self.q, self.qd, self.qdd):
            for chunk in chunks(len(array)):
                digest.update(np.ascontiguousarray(array[chunk]).data)
        return digest.hexdigest()


def _arrays(
    time: ArrayLike, q: ArrayLike, qd: ArrayLike | None, qdd: ArrayLike | None
) -> dict[str, FloatArray]:
    """The arrays given, by name, checked against the shape (N, n) of q."""
    values = {"q": q, "time": time} | {name: x for name, x in (("qd", qd), ("qdd", qdd)) if x is not None}
    arrays = {name: array_of(x, name, TrajectoryError) for name, x in values.items()}
    shape = arrays["q"].shape
    if len(shape) != 2 or not all(shape):
        raise refusal("a trajectory needs at least one set point", "q", "shape (N, n)", str(shape))
    for name, array in arrays.items():
        expected_shape = shape[:1] if name == "time" else shape
        if array.shape != expected_shape:
            raise refusal(f"{name} has the wrong shape", name, str(expected_shape), str(array.shape))
    return arrays


def _require_sound(name: str, arrays: Mapping[str, FloatArray], gaps: Gaps) -> None:
    """Raise a TrajectoryError if a number is impossible, time does not increase, or gaps do not fit."""
    where, time = f"trajectory {name}", arrays["time"]
    for quantity, array in arrays.items():
        for chunk in chunks(len(array)):
            for row in np.argwhere(~(np.abs(array[chunk]) <= LARGEST))[:1, 0] + chunk.start:
                problem = f"{quantity} is not finite, or too large for any motion, at set point {row + 1}"
                step = "check units, and that no two set points share almost the same instant"
                expected = f"finite numbers up to {LARGEST:g} in SI units"
                raise refusal(problem, where, expected, str(array[row].tolist()), step)
    for row in np.flatnonzero(np.diff(time) <= 0)[:1].tolist():
        expected, instant = f"more than {time[row]:g} s", f"{time[row + 1]:g} s"
        raise refusal("time does not increase", f"{where}, set point {row + 2}", expected, instant)
    for row in gaps:
        require_type(row, numbers.Integral, "gaps", "numbers of set points, from 0")
    if any(not before < row < len(time) for before, row in pairwise((0, *gaps))):
        expected = f"ascending numbers from 1 to {len(time) - 1}"
        raise refusal("the gaps are not those of set points", where, expected, str(tuple(map(int, gaps))))


def _log(arrays: Mapping[str, FloatArray], measured: bool | None, name: str, origin: str, gaps: Gaps) -> Log:
    """Arrays as a log; if `measured` is None, their numbers tell whether they are readings."""
    qd, qdd = arrays.get("qd"), arrays.get("qdd")
    rows = arrays["time"], arrays["q"], qd, qdd, None
    return Log(*rows, bool(measured), (), name, origin, None if measured else gaps, measured is None)


def trajectory_csv(trajectory: Trajectory, comments: Iterable[str] = ()) -> str:
    """Text of a trajectory's CSV file."""
    table = np.column_stack([trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd])
    # Adding 0.0 turns -0.0 into 0.0; repr is the shortest text that reads back as the same number.
    rows = [",".join(map(repr, row)) for row in (table + 0.0).tolist()]
    for gap in reversed(trajectory.gaps):
        rows.insert(gap, GAP)
    joints = range(1, trajectory.n_joints + 1)
    header = ",".join(["time", *(f"{role}{i}" for role in ("q", "qd", "qdd") for i in joints)])
    lines = [f"# {line}".rstrip() for comment in comments for line in comment.splitlines()]
    return "\n".join([*lines, header, *rows]) + "\n"


def write_trajectory(trajectory: Trajectory, path: str | Path, comments: Iterable[str] = ()) -> None:
    """Write a trajectory as CSV, atomically; reading it back gives the same numbers.

    `comments` come first, given without `#`; usually the command that makes the file. Raises an OutputError
    if it cannot be written, or would replace a file that is no such CSV.
    """
    require_type(trajectory, Trajectory, "trajectory", "a Trajectory")
    replaces_own(path_of(path), "time,q1", "trajectory")
    write_text(path, trajectory_csv(trajectory, comments))


def recorded_command(lines: Iterable[str]) -> str | None:
    """Find the `gd-analyze plan` command in the comments of a trajectory file, or None."""
    matches = (_COMMAND.fullmatch(line) for line in lines)
    return next((match[1] for match in matches if match is not None), None)
