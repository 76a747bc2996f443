"""Of how much acceleration of which frequency the readings of a joint speak: motion and noise together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray

# Length of the pieces whose spectra are averaged, s, and in readings at least.
_PIECE, _SHORTEST = 8.0, 64
# Frequencies averaged into one: a share of the frequency to either side, and these many at least.
_SHARE, _FEWEST = 0.15, 2
# Steps that differ by less than this share are even.
_EVEN = 1e-3


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power spectral density of a joint's accelerations.

    Parameters
    ----------
    frequency
        Hz, even steps from the first above zero, shape (F,).
    density
        One-sided, (rad/s^2)^2 per Hz, or in m, shape (F,); averaged over neighbouring frequencies.
    """

    frequency: FloatArray
    density: FloatArray

    @property
    def step(self) -> float:
        """Hz between frequencies."""
        return float(self.frequency[0])

    @classmethod
    def of(
        cls, times: Sequence[FloatArray], readings: Sequence[FloatArray], rate: float, order: int
    ) -> Spectrum:
        """Estimate it by Welch's method.

        Differences of the readings stand for derivatives; what these lack of them at high frequencies is
        made up for. Unlike positions, they have no trend that would leak into all frequencies.

        Parameters
        ----------
        times, readings
            Of one joint, stretch by stretch.
        rate
            Readings per second.
        order
            Derivatives from readings to accelerations: 2 of positions, 1 of rates, 0 of accelerations.
        """
        from scipy.signal import welch

        longest = max(map(len, readings))
        piece = min(max(int(_PIECE * rate), _SHORTEST), longest - order)
        total, weight = np.zeros(piece // 2 + 1), 0
        for time, x in zip(times, readings, strict=True):
            if len(x) - order < piece:
                continue
            differences = np.diff(_even(time, x, rate), order) * rate**order
            _, power = welch(differences, rate, "hann", nperseg=piece, detrend="constant")
            total, weight = total + power * len(x), weight + len(x)
        frequency = np.fft.rfftfreq(piece, 1 / rate)
        lacking = np.sinc(frequency / rate) ** (2 * order)
        return cls(np.asarray(frequency[1:]), _averaged((total / weight / lacking)[1:]))


def _even(time: FloatArray, x: FloatArray, rate: float) -> FloatArray:
    """Readings at as many instants with even steps."""
    from scipy.interpolate import PchipInterpolator

    steps = np.diff(time) * rate
    if np.abs(steps - 1).max(initial=0.0) < _EVEN:
        return x
    return np.asarray(PchipInterpolator(time, x)(np.linspace(time[0], time[-1], len(time))))


def _averaged(density: FloatArray) -> FloatArray:
    number = np.arange(len(density))
    wide = np.maximum((_SHARE * (number + 1)).astype(int), _FEWEST)
    low, high = np.maximum(number - wide, 0), np.minimum(number + wide + 1, len(density))
    sums = np.concatenate([[0.0], np.cumsum(density)])
    return np.asarray((sums[high] - sums[low]) / (high - low))
