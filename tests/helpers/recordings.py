"""Motions known exactly, readings and logs of them, and motions to be taken together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.motions.columns import ColumnUse
from gd_analyze.tables import states_of
from gd_analyze.types import Log, Recording, RobotArm

# Of the sines that a motion consists of, Hz.
FREQUENCIES = np.array([0.23, 0.61, 1.4])


@dataclass(frozen=True)
class Motion:
    """Sum of sines, joint by joint."""

    amplitudes: FloatArray
    phases: FloatArray

    @classmethod
    def of(cls, seed: int, n_joints: int = 2) -> Motion:
        """Draw one that accelerates with some rad/s^2."""
        rng = np.random.default_rng(seed)
        shape = (len(FREQUENCIES), n_joints)
        sizes = rng.uniform(0.5, 1.5, shape) / (2 * np.pi * FREQUENCIES[:, None]) ** 2
        return cls(sizes, rng.uniform(0.0, 2 * np.pi, shape))

    def at(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Derivative of some order, shape (N, n)."""
        omega = 2 * np.pi * FREQUENCIES
        angle = omega * time[:, None] + order * np.pi / 2
        waves = np.sin(angle[:, :, None] + self.phases)
        return np.asarray((waves * self.amplitudes * omega[:, None] ** order).sum(axis=1))


def instants(rate: float, seconds: float, jitter: float = 0.0, seed: int = 0) -> FloatArray:
    """Stamps; jitter is a share of the step."""
    count = int(rate * seconds)
    shake = np.random.default_rng(seed).uniform(-0.5, 0.5, count)
    return np.asarray((np.arange(count) + jitter * shake) / rate)


def readings(time: FloatArray, q: FloatArray, **more: Any) -> Log:
    """A log of readings."""
    values = {"qd": None, "qdd": None, "torque": None, "measured": True} | more
    return Log(time, q, **values)


def rms(values: FloatArray) -> FloatArray:
    """Root mean square of every column."""
    return np.asarray(np.sqrt(np.square(values).mean(axis=0)))


# Hz of the readings and of the filter they passed.
RATE, CUTOFF = 125.0, 8.0
# Readings of a log that nobody asks for more: four seconds.
MEASURED = 500


def swinging(arm: RobotArm, count: int = MEASURED, gaps: Sequence[int] = ()) -> Trajectory:
    """All joints swing, each at its own frequency and not about zero, with the exact velocities."""
    joints = np.arange(arm.n_joints)
    time, omega = np.arange(count) / RATE, 2.0 * np.pi * (0.31 + 0.13 * ((5 * joints) % 7) / 2.0)
    phase = time[:, None] * omega + joints
    for gap in gaps:
        time[gap:] += 2.0
    q, qd, qdd = np.sin(phase), omega * np.cos(phase), -(omega**2) * np.sin(phase)
    return Trajectory(time, 0.3 + 0.5 * q, 0.5 * qd, 0.5 * qdd, "log", gaps=tuple(gaps))


def friction_of(motion: Trajectory, coulomb: float, viscous: float, offset: float) -> FloatArray:
    """The friction that the fit is about, shape (N, n)."""
    return coulomb * np.sign(motion.qd) + viscous * motion.qd + offset


def with_torques(motion: Trajectory, torque: FloatArray, cutoff: float | None = None) -> Trajectory:
    """The motion as recorded with these torques, without noise in its positions."""
    n = motion.n_joints
    frequency = None if cutoff is None else np.full(n, cutoff)
    filtered = None if cutoff is None else torque
    noise = np.full(n, 1e-4)
    columns = (ColumnUse("Time", "time", unit="s", why="by name"), ColumnUse("temp", "unused"))
    recording = Recording(motion.q, torque, filtered, frequency, noise, 100 * noise, columns, ("smoothed",))
    return replace(motion, recording=recording)


def recorded(
    arm: RobotArm,
    *,
    count: int = MEASURED,
    gain: Sequence[float] | float = 1.0,
    friction: tuple[float, float, float] = (0.0, 0.0, 0.0),
    noise: float = 0.0,
    seed: int = 0,
    cutoff: float | None = None,
    gaps: Sequence[int] = (),
) -> Trajectory:
    """A log of a swinging arm whose torques are exact times a gain, and friction and white noise beside."""
    motion = swinging(arm, count, gaps)
    torque = torque_of(arm, states_of(motion)) * np.asarray(gain) + friction_of(motion, *friction)
    torque += noise * np.random.default_rng(seed).normal(size=torque.shape)
    return with_torques(motion, torque, cutoff)


def swung(duration: float, name: str, count: int = 41) -> Trajectory:
    """Swing both joints to and fro in so many seconds."""
    time = np.linspace(0.0, duration, count)
    rate = 2.0 * np.pi / duration
    size = np.array([0.6, 0.9])
    angle = np.stack([rate * time, rate * time + 0.7], axis=1)
    return Trajectory(
        time,
        0.3 + size * np.sin(angle),
        size * rate * np.cos(angle),
        -size * rate**2 * np.sin(angle),
        name,
        f"made up: {name}",
    )
