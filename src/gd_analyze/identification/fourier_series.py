"""Fourier series from rest to rest within an arm's limits, from unconstrained numbers."""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.limits import BoxLimits

# Least and largest number of harmonics.
_FEWEST_HARMONICS, _MOST_HARMONICS = 5, 12
# Instants per period of the fastest harmonic at which limits are checked.
INSTANTS_PER_PERIOD = 30
# Least ratio of a trigonometric polynomial's largest value at these instants to that at all (H. Ehlich, K.
# Zeller, Schwankung von Polynomen zwischen Gitterpunkten, Mathematische Zeitschrift 86).
_SHOWN = math.cos(math.pi / INSTANTS_PER_PERIOD)
# Least share of the limits that a series uses.
_LEAST_SHARE_OF_LIMITS = 0.01


class FourierSeries:
    """All series of a duration within an arm's limits.

    Every joint moves by a_0 + sum_k (a_k cos k w t + b_k sin k w t). A series is an array (..., n, 2 H + 1):
    a_1 to a_H, b_1 to b_H and a_0 of every joint. It follows from numbers within `bounds`, by joint: 2 H - 2
    for its form, one for its position in the range (0 to 1), and one for its share of the limits.

    Parameters
    ----------
    limits
        Limits of the arm.
    duration
        Duration, s. A long motion repeats a shorter one.
    """

    def __init__(self, limits: BoxLimits, duration: float) -> None:
        self.limits, self.n_joints = limits, len(limits.lower)
        # Above it only accelerations limit a motion, which gets smaller and excites little but inertia.
        fastest = float(np.median(limits.acceleration / limits.velocity)) / (2.0 * np.pi)
        self.period = duration / max(1, int(fastest * duration / _MOST_HARMONICS))
        self.harmonics = min(max(_FEWEST_HARMONICS, math.ceil(fastest * self.period)), _MOST_HARMONICS)
        count = INSTANTS_PER_PERIOD * self.harmonics
        self._waves = self._waves_at(np.arange(count) * self.period / count)
        # At rest at both ends: sum k b_k = 0 and sum k^2 a_k = 0. One is one of velocity for every harmonic.
        k = np.arange(1.0, self.harmonics + 1)
        a, b = (np.linalg.svd(row[None])[2][1:].T / k[:, None] for row in (k, np.ones_like(k)))
        self._form = np.block([[a, np.zeros_like(a)], [np.zeros_like(b), b]])
        free: list[tuple[float | None, float | None]] = [(None, None)] * (2 * self.harmonics - 2)
        self.bounds = [*free, (0.0, 1.0), (_LEAST_SHARE_OF_LIMITS, 1.0)] * self.n_joints

    def _waves_at(self, time: FloatArray) -> FloatArray:
        """Cosines, sines and one, and their derivatives, (3, 2 H + 1, N)."""
        omega = 2.0 * np.pi / self.period * np.arange(1, self.harmonics + 1)[:, None]
        cos, sin, constant = np.cos(omega * time), np.sin(omega * time), np.ones((1, len(time)))
        first = np.vstack([-omega * sin, omega * cos, 0.0 * constant])
        second = np.vstack([-(omega**2) * cos, -(omega**2) * sin, 0.0 * constant])
        return np.array([np.vstack([cos, sin, constant]), first, second])

    def within_limits(self, x: FloatArray) -> FloatArray:
        """Series from numbers, (..., count), with the size and position that these state."""
        x = x.reshape(*x.shape[:-1], self.n_joints, -1)
        form, place, share = x[..., :-2] @ self._form.T, x[..., -2], x[..., -1]
        q, qd, qdd = (form @ wave[:-1] for wave in self._waves)
        limits, highest, lowest = self.limits, q.max(axis=-1), q.min(axis=-1)
        room, span = limits.upper - limits.lower, highest - lowest
        speed, pull = (np.abs(values).max(axis=-1) for values in (qd, qdd))
        used = np.max([span / room, speed / limits.velocity, pull / limits.acceleration], axis=0)
        size = share * _SHOWN / used
        free = room - size * span / _SHOWN
        middle = (limits.lower + limits.upper) / 2.0 + (place - 0.5) * free
        centre = middle - size * (highest + lowest) / 2.0
        return np.concatenate([size[..., None] * form, centre[..., None]], axis=-1)

    def motion(self, series: FloatArray, time: FloatArray | None = None) -> FloatArray:
        """Positions, velocities and accelerations, (3, ..., n, N), by default at the instants for limits."""
        return np.array([series @ wave for wave in (self._waves if time is None else self._waves_at(time))])

    def random(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Numbers of random series as large as limits allow, (count, n, 2 H)."""
        x = rng.normal(size=(count, self.n_joints, 2 * self.harmonics))
        x[..., -2], x[..., -1] = rng.uniform(0.3, 0.7, (count, self.n_joints)), 1.0
        return x
