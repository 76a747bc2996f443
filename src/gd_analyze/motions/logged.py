"""What was understood of a log, and the readings behind a measured trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.reading import ROLES, Quantity

Role = Literal["time", "unused"] | Quantity


@dataclass(frozen=True)
class ColumnUse:
    """How one column of a log was understood.

    Parameters
    ----------
    column
        Its name, or its number from 1 where it has none.
    role
        "time", "q", "qd", "qdd", "torque" or "unused".
    joint
        Name of the arm's joint; "" of time and unused columns.
    unit
        Unit of its numbers in the log.
    why
        The reason for the role.
    """

    column: str
    role: Role
    joint: str = ""
    unit: str = ""
    why: str = ""


@dataclass(frozen=True, eq=False)
class Logged:
    """The columns of an arm's motion, in SI units and in the order of the joints, not yet treated.

    Parameters
    ----------
    time
        s, shape (N,); of a log, instants may repeat, jump or leave gaps.
    q
        Joint variables, rad (m), shape (N, n); nan where a cell is empty.
    qd, qdd, torque
        Velocities, accelerations and torques at the joints, same shape; None where there are none.
    measured
        Whether these are readings of sensors; a plan otherwise.
    columns
        How every column was understood.
    name, origin
        Short identifier, and where it was read.
    gaps
        Of a file of set points, whose rows are taken as they are: the rows, from 0, before which it states a
        gap. None of any other log.
    """

    time: FloatArray
    q: FloatArray
    qd: FloatArray | None
    qdd: FloatArray | None
    torque: FloatArray | None
    measured: bool
    columns: tuple[ColumnUse, ...] = ()
    name: str = "log"
    origin: str = ""
    gaps: tuple[int, ...] | None = None

    def __repr__(self) -> str:
        found = [role for role in ROLES if getattr(self, role) is not None]
        size = f"{self.q.shape[1]} joints, {len(self.time)} rows of {', '.join(found)}"
        return f"Logged({self.name!r}, {size}, {'readings' if self.measured else 'a plan'})"


@dataclass(frozen=True, eq=False)
class Recording:
    """The numbers of a log at the set points of its trajectory, and what was made of them.

    Parameters
    ----------
    q
        Joint variables as read, unwrapped, rad (m), shape (N, n).
    torque, torque_filtered
        Torques at the joints as read, and through the filter of the motion, N m (N), shape (N, n), or None.
    cutoff
        Cut-off frequency of the filter, Hz, shape (n,); None of a plan, which is not smoothed.
    noise_q, noise_qdd
        Standard deviation of the noise in the readings, and of what is left of it in the accelerations,
        rad (m) and per s^2, shape (n,).
    columns
        How the log's columns were understood.
    treatment
        What was done: rows left out, gaps, unwrapping, filter and the rule of its cut-off.
    """

    q: FloatArray
    torque: FloatArray | None
    torque_filtered: FloatArray | None
    cutoff: FloatArray | None
    noise_q: FloatArray
    noise_qdd: FloatArray
    columns: tuple[ColumnUse, ...] = ()
    treatment: tuple[str, ...] = ()

    @property
    def measured(self) -> bool:
        """Whether these are smoothed readings; else a plan that a log holds."""
        return self.cutoff is not None
