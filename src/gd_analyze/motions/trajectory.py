"""A trajectory as a value: time and the joint variables with their rates, SI and radians."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray, are_possible, array_of
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.motions import Motion
from gd_analyze.motions.recording import Recording
from gd_analyze.text import LARGEST, html_of, number

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from gd_analyze.motions.treatment import Treatment
    from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Set points of one motion, or of several one after the other.

    Parameters
    ----------
    time
        Strictly increasing, s, shape (N,).
    q, qd, qdd
        Joint variables, rates and accelerations, rad (m) and per s, s^2, shape (N, n).
    name
        Short identifier, used for output folders and titles.
    origin
        How it came about, e.g. the file read or the plan's command; and what was derived.
    rates_from
        "given", or how missing rates were derived.
    gaps
        Set points (from 0, ascending, not the first) before which nothing is known of the motion: a recording
        broke off there, or another motion begins.
    recording
        The readings behind a measured motion; None of a plan.
    motions
        Which set points are whose, where the trajectory is a pool of several motions.

    Raises
    ------
    TrajectoryError
        If shapes disagree, a number is not finite or too large, time does not increase, or there are no such
        set points for gaps.
    """

    time: FloatArray
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    name: str = "trajectory"
    origin: str = ""
    rates_from: str = "given"
    gaps: tuple[int, ...] = ()
    recording: Recording | None = None
    motions: tuple[Motion, ...] = ()

    def __post_init__(self) -> None:
        shape = array_of(self.q, "q", TrajectoryError).shape
        if len(shape) != 2 or shape[0] < 1:
            raise TrajectoryError(
                "a trajectory needs at least one set point", expected="q of shape (N, n)", found=str(shape)
            )
        for what, wanted in (("time", shape[:1]), ("q", shape), ("qd", shape), ("qdd", shape)):
            array = array_of(getattr(self, what), what, TrajectoryError).copy()
            if array.shape != wanted:
                raise TrajectoryError(
                    f"{what} has the wrong shape", expected=str(wanted), found=str(array.shape)
                )
            if not np.isfinite(array).all():
                row = int(np.argwhere(~np.isfinite(array))[0][0])
                raise TrajectoryError(
                    f"{what} is not finite at set point {row + 1}",
                    where=f"trajectory {self.name}",
                    expected="finite numbers",
                    found=str(array[row].tolist()),
                )
            if not are_possible(array):
                row = int(np.argwhere(np.abs(array) > LARGEST)[0][0])
                raise TrajectoryError(
                    f"{what} is too large for any motion",
                    where=f"set point {row + 1} of trajectory {self.name}",
                    expected=f"numbers up to {LARGEST:g} in SI units",
                    found=str(np.abs(array[row]).max()),
                    next_step="check units, and that no two set points share almost the same instant",
                )
            array.flags.writeable = False
            object.__setattr__(self, what, array)
        if (np.diff(self.time) <= 0).any():
            row = int(np.flatnonzero(np.diff(self.time) <= 0)[0])
            raise TrajectoryError(
                "time does not increase",
                where=f"set point {row + 2}",
                expected=f"more than {self.time[row]:g} s",
                found=f"{self.time[row + 1]:g} s",
            )
        object.__setattr__(self, "gaps", tuple(map(int, self.gaps)))
        if any(not before < row < shape[0] for before, row in pairwise((0, *self.gaps))):
            raise TrajectoryError(
                "the gaps are not those of set points",
                where=f"trajectory {self.name}",
                expected=f"ascending numbers from 1 to {shape[0] - 1}",
                found=str(self.gaps),
            )

    @classmethod
    def from_arrays(
        cls,
        time: ArrayLike,
        q: ArrayLike,
        qd: ArrayLike | None = None,
        qdd: ArrayLike | None = None,
        *,
        name: str = "trajectory",
        measured: bool = False,
        arm: RobotArm | None = None,
        treatment: Treatment | None = None,
    ) -> Trajectory:
        """Take a motion from arrays.

        Parameters
        ----------
        time
            s, shape (N,).
        q, qd, qdd
            Joint variables and, where known, rates and accelerations, rad (m) and per s, s^2, shape (N, n).
        name
            Short identifier.
        measured
            Whether these are readings: they are smoothed then as those of a log; see `motion_of`. Of a plan
            time has to increase, and what is missing is derived, see `complete_rates`.
        arm, treatment
            Of readings: whose joints, so that jumps of full turns are undone; and how to treat them.

        Raises
        ------
        TrajectoryError
            If shapes disagree, there are too few set points to derive what is missing, or as for the value.

        Examples
        --------
        >>> import numpy as np
        >>> time = np.linspace(0.0, 2.0, 101)
        >>> motion = Trajectory.from_arrays(time, np.column_stack([np.sin(time), np.cos(time)]))
        >>> motion.rates_from
        'qd and qdd derived: C4 (quintic) spline through the given q'
        """
        from gd_analyze.motions.from_arrays import planned_motion, recorded_motion

        if measured:
            return recorded_motion(time, q, qd, qdd, name, arm, treatment)
        return planned_motion(time, q, qd, qdd, name)

    def __repr__(self) -> str:
        size = f"{self.n_joints} joints, {self.n_set_points} set points"
        return f"Trajectory({self.name!r}, {size}, {self.time[0]:g} to {self.time[-1]:g} s)"

    def _repr_html_(self) -> str:
        """Where it goes and how fast, for a notebook; whether joints turn, an arm would know."""
        largest = [np.abs(x).max(axis=0) for x in (self.qd, self.qdd)]
        columns = np.column_stack([self.q[0], self.q[-1], *largest])
        rows = [[str(i), *map(number, row)] for i, row in enumerate(columns.tolist(), start=1)]
        headings = ["joint", "start", "end", "largest rate", "largest acceleration"]
        return html_of(repr(self), headings, rows, "In rad and s; in m where a joint slides.")

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
        """Which of "qd" and "qdd" were derived, as `rates_from` says."""
        before, said, _ = self.rates_from.partition(" derived")
        return tuple(before.split(" and ")) if said else ()

    @property
    def stretches(self) -> list[slice]:
        """Set points of each stretch without a gap."""
        ends = [0, *self.gaps, self.n_set_points]
        return [slice(first, last) for first, last in pairwise(ends)]

    @property
    def fingerprint(self) -> str:
        """SHA-256 of the numbers."""
        digest = hashlib.sha256(repr(self.gaps).encode() if self.gaps else b"")
        for array in (self.time, self.q, self.qd, self.qdd):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()
