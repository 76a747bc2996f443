"""Motions known exactly, and readings of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.logged import Logged

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


def readings(time: FloatArray, q: FloatArray, **more: Any) -> Logged:
    """A log of readings."""
    values = {"qd": None, "qdd": None, "torque": None, "measured": True} | more
    return Logged(time, q, **values)


def rms(values: FloatArray) -> FloatArray:
    """Root mean square of every column."""
    return np.asarray(np.sqrt(np.square(values).mean(axis=0)))
