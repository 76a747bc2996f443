"""What is drawn of a joint's measured torque: itself, the exact one, and friction where it was fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.friction import TERMS
from gd_analyze.results.findings import Findings


@dataclass(frozen=True, eq=False)
class TorqueCurves:
    """Curves of one joint, N m (N where it slides), shape (M,).

    Parameters
    ----------
    points
        The set points, from 0: those with a reading.
    read, measured
        The torque as read, and through the filter.
    exact
        The exact model's.
    friction
        Friction and offset as fitted; None where none was asked for.
    """

    points: NDArray[np.intp]
    read: FloatArray
    measured: FloatArray
    exact: FloatArray
    friction: FloatArray | None

    @property
    def difference(self) -> FloatArray:
        """Measured minus exact."""
        return self.measured - self.exact


def torque_curves(findings: Findings, joint: int) -> TorqueCurves:
    """Take the curves of a joint, from 0, that was measured, of a run with measured torques."""
    table = findings.tables["measured_torque"].isel(joint=joint)
    read, measured = table.measured.values, table.filtered.values
    points = np.flatnonzero(np.isfinite(measured) & np.isfinite(read))
    friction = None
    if "coulomb" in table:
        coulomb, viscous, offset = (np.nan_to_num(float(table[name])) for name in TERMS)
        rate = findings.trajectory.qd[points, joint]
        friction = coulomb * np.sign(rate) + viscous * rate + offset
    exact = findings.exact_torque[points, joint]
    return TorqueCurves(points, read[points], measured[points], exact, friction)


def measured_joints(findings: Findings) -> list[int]:
    """Joints, from 0, with a measured torque; none of a run without any."""
    if "measured_torque" not in findings.tables:
        return []
    verdicts = findings.tables["measured_torque"].verdict.values.tolist()
    return [i for i, verdict in enumerate(verdicts) if verdict != "not measured"]
