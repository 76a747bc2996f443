"""What was understood of a log, and the readings behind a measured trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.reading import ROLES, Quantity

Role = Literal["time", "unused"] | Quantity


@dataclass(frozen=True)
class ColumnUse:
    """How one column of a log was understood."""

    column: str  # its name, or its number from 1 where it has none
    role: Role  # "time", "q", "qd", "qdd", "torque" or "unused"
    joint: str = ""  # name of the arm's joint; "" of time and unused columns
    unit: str = ""  # unit of its numbers in the log
    why: str = ""  # the reason for the role


@dataclass(frozen=True, eq=False)
class Logged:
    """The columns of an arm's motion, in SI units and in the order of the joints, not yet treated."""

    time: FloatArray  # s, shape (N,); of a log, instants may repeat, jump or leave gaps
    q: FloatArray  # joint variables, rad (m), shape (N, n); nan where a cell is empty
    # Velocities, accelerations and torques at the joints, same shape; None where there are none
    qd: FloatArray | None
    qdd: FloatArray | None
    torque: FloatArray | None
    measured: bool  # whether these are readings of sensors; a plan otherwise
    columns: tuple[ColumnUse, ...] = ()  # how every column was understood
    # Short identifier, and where it was read
    name: str = "log"
    origin: str = ""
    # Of a file of set points, whose rows are taken as they are: the rows, from 0, before which it states a
    # gap. None of any other log
    gaps: tuple[int, ...] | None = None

    def __repr__(self) -> str:
        found = [role for role in ROLES if getattr(self, role) is not None]
        size = f"{self.q.shape[1]} joints, {len(self.time)} rows of {', '.join(found)}"
        return f"Logged({self.name!r}, {size}, {'readings' if self.measured else 'a plan'})"


@dataclass(frozen=True, eq=False)
class Recording:
    """The numbers of a log at the set points of its trajectory, and what was made of them."""

    q: FloatArray  # joint variables as read, unwrapped, rad (m), shape (N, n)
    # Torques at the joints as read, and through the filter of the motion, N m (N), shape (N, n), or None
    torque: FloatArray | None
    torque_filtered: FloatArray | None
    # Cut-off frequency of the filter, Hz, shape (n,); None of a plan, which is not smoothed
    cutoff: FloatArray | None
    # Standard deviation of the noise in the readings, and of what is left of it in the accelerations, rad (m)
    # and per s^2, shape (n,)
    noise_q: FloatArray
    noise_qdd: FloatArray
    columns: tuple[ColumnUse, ...] = ()  # how the log's columns were understood
    # What was done: rows left out, gaps, unwrapping, filter and the rule of its cut-off
    treatment: tuple[str, ...] = ()

    @property
    def measured(self) -> bool:
        """Whether these are smoothed readings; else a plan that a log holds."""
        return self.cutoff is not None
