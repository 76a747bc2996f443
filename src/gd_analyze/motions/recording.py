"""What stands behind a trajectory that was measured: the readings, and how they were treated."""

from __future__ import annotations

from dataclasses import dataclass

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.logged import ColumnUse


@dataclass(frozen=True, eq=False)
class Recording:
    """Readings of a motion at its set points, and what was made of them; of a plan its numbers as logged.

    Parameters
    ----------
    q
        Joint variables as read, unwrapped, rad (m), shape (N, n).
    torque
        Torques at the joints as read, N m (N), shape (N, n); None where the log has none.
    torque_filtered
        The same through the filter that the motion passed, without delay like it.
    cutoff
        Cut-off frequency of the filter, Hz, shape (n,); None where none was used.
    noise_q, noise_qdd
        Standard deviation of the noise of the readings, and of what is left of it in the accelerations,
        rad (m) and per s^2, shape (n,).
    columns
        How the log's columns were understood.
    treatment
        What was done, a sentence each: rows left out, gaps, unwrapping, filter and the rule of its cut-off.
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
        """Whether these are readings that were smoothed; else a plan that a log holds."""
        return self.cutoff is not None
