"""Samples of logs, spread over their time, with the joints that move in each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, FloatArray, evenly
from gd_analyze.motions.correction import at_instants
from gd_analyze.motions.measured import directions, fastest_of, filtered_torque
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

_SAMPLES_OF_LOGS = 400  # samples taken of all logs together
_STRETCHES = 10  # stretches of a log, fitted and scored in turn
# A joint that travels less than both, an angle (or this share of the reach) and this share of the widest
# travel of its kind, rests: controllers hold a joint within a degree while others move.
_TREMBLING_ANGLE, _TREMBLING_SHARE = 0.02, 0.02
# Duration of a log and of the pause after it, over its own.
_LOG_AND_PAUSE = 1.05
# Least samples of a joint that moves, fitted and scored alike.
FEWEST_SAMPLES = 12


@dataclass(frozen=True, eq=False)
class Samples:
    """N instants of one or several logs, all of shape (N, n) unless stated otherwise."""

    arm: RobotArm
    logs: tuple[Trajectory, ...]
    log: Array  # number of the log, from 0, (N,)
    row: Array  # set point of the log, (N,)
    time: FloatArray  # s, as in the log, (N,)
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    torque: FloatArray  # measured, filtered like the motion; 0 at a joint without readings
    slowest: FloatArray  # velocity below which a joint rests or creeps, (n,)
    counts: Array  # whether the joint moves and its torque is measured
    scored: Array  # whether the sample is scored rather than fitted, (N,)

    def __len__(self) -> int:
        return len(self.time)

    def at(self, chosen: Array | slice) -> Samples:
        """Some of the samples."""
        of = {name: getattr(self, name)[chosen] for name in _BY_SAMPLE}
        return Samples(self.arm, self.logs, slowest=self.slowest, **of)

    def shifted(self, lag: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """States so many seconds earlier, between set points interpolated."""
        q, qd, qdd = (np.empty_like(self.q) for _ in range(3))
        for k, log in enumerate(self.logs):
            is_of_log = self.log == k
            instants = np.clip(self.time[is_of_log] - lag, log.time[0], log.time[-1])
            for out, values in ((q, log.q), (qd, log.qd), (qdd, log.qdd)):
                out[is_of_log] = at_instants(instants, log.time, values)
        return q, qd, qdd

    @property
    def step(self) -> float:
        """Time between two readings, s."""
        return float(np.median(np.concatenate([np.diff(log.time) for log in self.logs])))

    @property
    def clock(self) -> FloatArray:
        """Time of several logs one after the other, of one as in the log, s, (N,)."""
        out, start = self.time.copy(), 0.0
        for k, log in enumerate(self.logs if len(self.logs) > 1 else ()):
            out[self.log == k] += start - log.time[0]
            start += _LOG_AND_PAUSE * float(log.time[-1] - log.time[0])
        return out


_BY_SAMPLE = ("log", "row", "time", "q", "qd", "qdd", "torque", "counts", "scored")


def samples_of(arm: RobotArm, logs: Sequence[Trajectory], usable: Sequence[Array]) -> Samples:
    """Take samples where joints move; `usable` tells, by log, which readings of torque are, (N, n)."""
    n = arm.n_joints
    fastest = fastest_of(logs)
    moves_at_all = _moving_joints(arm, logs)
    moving = []
    for log, good in zip(logs, usable, strict=True):
        is_compared = good & np.isfinite(filtered_torque(log)) & moves_at_all
        moving.append((directions(log, fastest) != 0) & is_compared)
    total = sum(int(moves.any(axis=1).sum()) for moves in moving)
    parts: dict[str, list[FloatArray]] = {name: [] for name in _BY_SAMPLE}
    slowest = np.full(n, np.inf)
    for k, (log, moves) in enumerate(zip(logs, moving, strict=True)):
        rows = np.flatnonzero(moves.any(axis=1))
        rows = rows[evenly(len(rows), max(round(_SAMPLES_OF_LOGS * len(rows) / max(total, 1)), 1))]
        place = np.arange(len(rows)) * _STRETCHES // max(len(rows), 1)
        torque = filtered_torque(log)[rows]
        values = {
            "log": np.full(len(rows), k),
            "row": rows,
            "time": log.time[rows],
            "q": log.q[rows],
            "qd": log.qd[rows],
            "qdd": log.qdd[rows],
            "torque": np.nan_to_num(torque),
            "counts": moves[rows],
            "scored": place % 2 == 1,
        }
        for name, array in values.items():
            parts[name].append(array)
        speeds = [np.abs(log.qd[moves[:, i], i]) for i in range(n)]
        slowest = np.minimum(slowest, [speed.min(initial=np.inf) for speed in speeds])
    joined = {name: np.concatenate(arrays) for name, arrays in parts.items()}
    samples = Samples(arm, tuple(logs), slowest=slowest, **joined)
    enough = [
        min((samples.counts[samples.scored == is_scored]).sum(axis=0)[i] for is_scored in (False, True))
        >= FEWEST_SAMPLES
        for i in range(n)
    ]
    samples.counts[:, ~np.array(enough)] = False
    return samples


def _moving_joints(arm: RobotArm, logs: Sequence[Trajectory]) -> Array:
    """Joints that do not merely tremble while others move, (n,)."""
    travels = np.max([np.ptp(log.q, axis=0) for log in logs], axis=0)
    turns = np.array(arm.is_revolute)
    small = np.where(turns, _TREMBLING_ANGLE, _TREMBLING_SHARE * (arm.reach or 1.0))
    widest = np.array([travels[turns == kind].max() for kind in turns.tolist()])
    return (travels > small) | (travels > _TREMBLING_SHARE * widest)
