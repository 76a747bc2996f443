"""What is drawn of a joint's readings: beside the smoothed motion, and their difference from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.results.findings import Findings

# Length of what is drawn large, in periods of the cut-off, and readings at least.
_PERIODS, _FEWEST = 6.0, 40


@dataclass(frozen=True, eq=False)
class ReadingCurves:
    """Curves of one joint, angles in degrees, lengths in m.

    Parameters
    ----------
    read, smooth
        Readings and smoothed motion at all set points, shape (N,).
    near
        Set points, from 0, of some periods of the cut-off around the largest acceleration.
    """

    read: FloatArray
    smooth: FloatArray
    near: NDArray[np.intp]

    @classmethod
    def of(cls, findings: Findings, joint: int) -> ReadingCurves:
        """Take those of a joint, from 0, of a measured motion."""
        motion, table = findings.trajectory, findings.tables["recording"]
        read, smooth = table.q_read.values[:, joint], motion.q[:, joint]
        fastest = int(np.abs(motion.qdd[:, joint]).argmax())
        stretch = next(part for part in motion.stretches if part.start <= fastest < part.stop)
        half = _PERIODS / 2 / float(table.cutoff[joint])
        middle = float(motion.time[fastest])
        first, last = np.searchsorted(motion.time, (middle - half, middle + half))
        first, last = min(first, fastest - _FEWEST // 2), max(last, fastest + _FEWEST // 2)
        near = np.arange(max(first, stretch.start), min(last, stretch.stop))
        turns = findings.arm.joints[joint].kind == "revolute"
        if turns:
            read, smooth = np.degrees(read), np.degrees(smooth)
        return cls(read, smooth, near)

    @property
    def difference(self) -> FloatArray:
        """Readings minus smoothed motion near the largest acceleration."""
        return (self.read - self.smooth)[self.near]
