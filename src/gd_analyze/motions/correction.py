"""What is done to a log's numbers once they are read: numbers by joint, composed and applied."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from gd_analyze.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Correction:
    """Changes of n joints' logs; `Correction.none(n)` changes nothing."""

    position: FloatArray  # joint variables per variable as logged, (n, n)
    torque: FloatArray  # torques at the joints per torque as logged, (n, n)
    offset: FloatArray  # added to the joint variables, rad (m), (n,)
    lag: float = 0.0  # by which torques are late, s

    @classmethod
    def none(cls, n: int) -> Self:
        """Change nothing."""
        return cls(np.eye(n), np.eye(n), np.zeros(n))

    def then(self, other: Correction) -> Self:
        """Do this, and the other after it."""
        return replace(
            self,
            position=other.position @ self.position,
            torque=other.torque @ self.torque,
            offset=other.position @ self.offset + other.offset,
            lag=self.lag + other.lag,
        )

    def with_torque(self, matrix: FloatArray) -> Self:
        """Torques multiplied, after what is done already."""
        return replace(self, torque=matrix @ self.torque)

    def with_position(self, matrix: FloatArray) -> Self:
        """Joint variables multiplied, after what is done already."""
        return replace(self, position=matrix @ self.position, offset=matrix @ self.offset)

    def with_joints(self, matrix: FloatArray) -> Self:
        """Joint variables multiplied, and torques by the transposed inverse: power stays the same."""
        return self.with_position(matrix).with_torque(inverse(matrix).T)

    def with_offset(self, joint: int, value: float) -> Self:
        """A joint's variable increased; joints count from 0."""
        offset = self.offset.copy()
        offset[joint] += value
        return replace(self, offset=offset)

    @property
    def inverse(self) -> Correction:
        """What undoes it."""
        position = inverse(self.position)
        return Correction(position, inverse(self.torque), -position @ self.offset, -self.lag)

    def of_positions(self, q: FloatArray) -> FloatArray:
        """Joint variables of those logged, (N, n)."""
        return _multiplied(q, self.position) + self.offset

    def of_velocities(self, qd: FloatArray) -> FloatArray:
        """Velocities of those logged, and so accelerations, (N, n)."""
        return _multiplied(qd, self.position)

    def of_torques(self, torque: FloatArray) -> FloatArray:
        """Torques of those logged, not yet brought back in time, (N, n)."""
        return _multiplied(torque, self.torque)

    def applied(self, time: FloatArray, arrays: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Correct q, qd, qdd and torque, (N, n) each, of those there are."""
        out = dict(arrays)
        out["q"] = self.of_positions(out["q"])
        for role in {"qd", "qdd"} & {*out}:
            out[role] = self.of_velocities(out[role])
        if "torque" in out:
            out["torque"] = self.of_torques(out["torque"])
            if self.lag:
                out["torque"] = at_instants(time + self.lag, time, out["torque"])
        return out


def inverse(matrix: FloatArray) -> FloatArray:
    """Inverse of a matrix that mixes joints."""
    return np.asarray(np.linalg.inv(matrix), dtype=float)


def _multiplied(values: FloatArray, matrix: FloatArray) -> FloatArray:
    """Rows of values times a matrix; a missing one is missing only in what is made of it."""
    if np.array_equal(matrix, np.eye(len(matrix))):
        return values
    columns = []
    for row in matrix:
        sources = np.flatnonzero(row)
        columns.append(values[:, sources] @ row[sources])
    return np.column_stack(columns)


def at_instants(instants: FloatArray, time: FloatArray, values: FloatArray) -> FloatArray:
    """Columns at other instants, each between its own readings; nan where the log has not begun, or ended."""
    if not (np.diff(time) >= 0.0).all():
        order = np.argsort(time, kind="stable")
        time, values = time[order], values[order]
    out = np.full((len(instants), values.shape[1]), np.nan)
    for i, column in enumerate(values.T):
        is_read = np.isfinite(column) & np.isfinite(time)
        if is_read.any():
            out[:, i] = np.interp(instants, time[is_read], column[is_read], left=np.nan, right=np.nan)
    return out
