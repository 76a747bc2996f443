"""What a log holds of an arm's motion, understood but not yet treated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gd_analyze.arrays import FloatArray

Quantity = Literal["q", "qd", "qdd", "torque"]
Role = Literal["time", "unused"] | Quantity


@dataclass(frozen=True)
class ColumnUse:
    """How one column of a log was understood.

    Parameters
    ----------
    column
        Its name in the log, or its number there, from 1, where there is no header.
    role
        What it holds; "unused" of one that is left out.
    joint
        Name of the arm's joint it is of; empty of time and of unused ones.
    unit
        Unit of its numbers in the log.
    why
        By what it was understood so, or why it is left out.
    """

    column: str
    role: Role
    joint: str = ""
    unit: str = ""
    why: str = ""


@dataclass(frozen=True, eq=False)
class Logged:
    """The columns of a log that are of an arm, in SI units and in the order of its joints.

    Parameters
    ----------
    time
        s, shape (N,), as logged: may repeat, jump or have holes.
    q
        Joint variables, rad (m), shape (N, n); nan where a cell is empty.
    qd, qdd, torque
        Rates, accelerations and torques at the joints, same shape; None where the log has none.
    measured
        Whether these are readings of sensors; a plan otherwise.
    columns
        How every column was understood.
    name, origin
        Short identifier, and where the log was read.
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

    def __repr__(self) -> str:
        found = [role for role in ("q", "qd", "qdd", "torque") if getattr(self, role) is not None]
        size = f"{self.q.shape[1]} joints, {len(self.time)} rows of {', '.join(found)}"
        return f"Logged({self.name!r}, {size}, {'readings' if self.measured else 'a plan'})"
