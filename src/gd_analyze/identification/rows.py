"""A log as linear equations of a joint's torque, with a row per window of time.

Torque is linear in ten parameters of every link, the inertia of drives, Coulomb and viscous friction and an
offset. Both sides of an equation are means over the same window, which filters and decimates both equally, so
that the motion's filter does not matter for jumping torques (parallel filtering: M. Gautier, Dynamic
identification of robots with power model, ICRA 1997).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import CHUNK, Array, FloatArray
from gd_analyze.dynamics.base_parameters import PARAMETERS, link_regressor
from gd_analyze.dynamics.friction import own_columns
from gd_analyze.motions.measured import directions
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

# Windows per period of the fastest cut-off, beyond which the motion has almost no content; readings per
# window of an unfiltered log.
_WINDOWS_PER_PERIOD, _READINGS_PER_WINDOW = 4.0, 5
_OF_LINK = len(PARAMETERS)


@dataclass(frozen=True)
class Unknowns:
    """Layout of the unknowns: links, drives, friction by joint, payload."""

    n_joints: int
    payload: bool = False

    @property
    def of_links(self) -> slice:
        """Ten of every link, as in `parameters_of`."""
        return slice(0, _OF_LINK * self.n_joints)

    @property
    def of_drives(self) -> slice:
        """Inertia of every drive, at the joint."""
        return slice(self.of_links.stop, (_OF_LINK + 1) * self.n_joints)

    @property
    def of_friction(self) -> slice:
        """Coulomb and viscous friction and an offset of every joint."""
        return slice(self.of_drives.stop, self.of_drives.stop + 3 * self.n_joints)

    def friction_of(self, joint: int) -> slice:
        """The three of one joint, from 0."""
        first = self.of_friction.start + 3 * joint
        return slice(first, first + 3)

    @property
    def of_payload(self) -> slice:
        """Ten of a payload, in the frame of the last link; none without one."""
        return slice(self.of_friction.stop, self.of_friction.stop + _OF_LINK * self.payload)

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return self.of_payload.stop


@dataclass(frozen=True, eq=False)
class JointRows:
    """Equations of one joint: torque = columns @ unknowns, N m (N)."""

    columns: FloatArray  # (rows, unknowns)
    torque: FloatArray  # measured, (rows,)
    time: FloatArray  # middle of each window, s, (rows,)

    def at(self, chosen: Array | slice) -> JointRows:
        """Some of the rows."""
        return JointRows(self.columns[chosen], self.torque[chosen], self.time[chosen])

    @classmethod
    def joined(cls, parts: list[JointRows]) -> JointRows:
        """Rows of several logs, one after the other."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in cls.__annotations__))


def columns_of_unknowns(
    unknowns: Unknowns, per_unit: FloatArray, own: FloatArray, *, loaded: bool = False
) -> FloatArray:
    """Torque of every joint per unit of each unknown, (n, unknowns, N).

    `per_unit` are torques per unit of the links' parameters, (n, n, 10, N), and `own` those of a joint's
    own drive and friction, (n, N, 4). A `loaded` arm carries the payload.
    """
    n, count = unknowns.n_joints, per_unit.shape[-1]
    columns = np.zeros((n, unknowns.count, count))
    columns[:, unknowns.of_links] = per_unit.reshape(n, -1, count)
    for i in range(n):
        drive, *friction = own[i].T
        columns[i, unknowns.of_drives.start + i] = drive
        columns[i, unknowns.friction_of(i)] = friction
    if loaded:
        columns[:, unknowns.of_payload] = per_unit[:, -1]
    return columns


def identification_rows(
    arm: RobotArm, motion: Trajectory, unknowns: Unknowns, fastest: FloatArray, *, loaded: bool = False
) -> list[JointRows]:
    """Equations of every joint along a recorded motion.

    Parameters
    ----------
    arm, motion
        The arm, and a recording of it with torques.
    unknowns
        Layout of the unknowns.
    fastest
        Largest velocity of every joint over all logs, (n,): a joint much slower than this creeps.
    loaded
        Whether the arm carried the payload.
    """
    recording, n = motion.recording, arm.n_joints
    assert recording is not None  # checked by callers
    assert recording.torque is not None
    signs = directions(motion, fastest)
    parts: list[list[JointRows]] = [[] for _ in range(n)]
    for at, starts in _windows(motion):
        per_unit = link_regressor(arm, motion.q[at].T, motion.qd[at].T, motion.qdd[at].T)
        counts = np.diff(starts, append=at.stop - at.start)
        time = np.add.reduceat(motion.time[at], starts) / counts
        own = own_columns(motion.qdd[at].T, signs[at].T, motion.qd[at].T)
        columns_by_joint = columns_of_unknowns(unknowns, per_unit, own, loaded=loaded)
        for i in range(n):
            sign, torque = signs[at, i], recording.torque[at, i]
            # Both sides are means over the readings that there are, at least half of a window's.
            is_read = np.isfinite(torque)
            number_read = np.add.reduceat(is_read.astype(int), starts)
            torque = np.where(is_read, torque, 0.0)
            columns = np.where(is_read, columns_by_joint[i], 0.0)
            means = np.add.reduceat(columns, starts, axis=1) / np.maximum(number_read, 1)
            torque = np.add.reduceat(torque, starts) / np.maximum(number_read, 1)
            # Where the joint creeps or reverses, its friction has no definite sign.
            moves = np.abs(np.add.reduceat(sign, starts, dtype=int)) == counts
            parts[i].append(JointRows(means.T, torque, time).at(moves & (2 * number_read >= counts)))
    return [JointRows.joined(joint_parts) for joint_parts in parts]


def _windows(motion: Trajectory) -> Iterator[tuple[slice, Array]]:
    """Slices of up to `CHUNK` set points, and starts of their windows; none is cut or spans a gap."""
    recording = motion.recording
    step = float(np.median(np.diff(motion.time)))
    cutoff = None if recording is None or recording.cutoff is None else float(recording.cutoff.max())
    width = _READINGS_PER_WINDOW * step if not cutoff else max(1.0 / (_WINDOWS_PER_PERIOD * cutoff), step)
    for stretch in motion.stretches:
        time = motion.time[stretch] - motion.time[stretch.start]
        number = np.floor(time / width + 1e-9).astype(int)
        starts = stretch.start + np.flatnonzero(np.diff(number, prepend=-1))
        ends = np.append(starts[1:], stretch.stop)
        # The last window of a stretch may hold a reading or two.
        if len(starts) > 1 and 2 * (ends[-1] - starts[-1]) < ends[0] - starts[0]:
            starts, ends = starts[:-1], ends[:-1]
        first = 0
        while first < len(starts):
            last = max(int(np.searchsorted(ends, starts[first] + CHUNK, "right")), first + 1)
            yield slice(int(starts[first]), int(ends[last - 1])), starts[first:last] - starts[first]
            first = last
