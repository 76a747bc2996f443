r"""What of a joint's accelerations is noise, and the cut-off that leaves the least error.

Motion makes less acceleration the higher the frequency, noise of readings makes more: differentiating white
noise of positions twice makes a density that rises as f^4; instants that are stamped late or early, as f^2.
So noise is what does not fall with frequency, and what stands above that is motion. The expected squared
error of accelerations that passed a cut-off f_c is

    sum_f ((1 - H(f))^2 S(f) + H(f)^2 N(f)) df,

S the density of the motion, N that of the noise: motion that the filter takes, and noise that it leaves. To
this the ends of a stretch add what the smoothing spline, which knows of no jerk there, makes of one,
0.0228 J^2 / (f_c^3 T) of a root mean square jerk J and a stretch of T seconds: for little noise they decide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.smoothing import passed
from gd_analyze.motions.spectrum import Spectrum

# Above it arms swing in the elasticity of their joints, which no model of rigid links describes.
HIGHEST = 30.0
# Of the readings per second: noise that they fold must not reach what passes.
HIGHEST_SHARE = 0.2
# And the lowest that is chosen, of any joint and of a short one in periods.
_LOWEST, _FEWEST_PERIODS = 0.5, 2.0
# Steps between the cut-offs that are compared.
_RATIO = 1.05
# How much more a density has to be than somewhere up to so many times its frequency, to be of motion:
# averaged as it is, noise varies less, and what a sensor filters falls less.
_STANDS_OUT, _WITHIN = 6.0, 5.0
# The law of the noise is fitted from the highest frequency of motion times this, for a decade.
_CLEAR, _DECADE = 1.3, 10.0
_FEWEST_FITTED = 5
# Steepest rise of a density: white noise, differentiated twice.
_STEEPEST = 4.0
# Share of the most moving joint's acceleration as which that of a still one counts.
_HARDLY = 0.1
# Integral of the squared error of a constant jerk at both ends of a stretch, times f_c^3.
_ENDS = 0.0228


@dataclass(frozen=True, eq=False)
class Noise:
    """Densities of motion and of noise of a joint's accelerations.

    Parameters
    ----------
    frequency
        Hz, even steps, shape (F,).
    motion, noise
        S and N, (rad/s^2)^2 per Hz, or in m, shape (F,).
    seconds
        T, mean length of the stretches.
    missed
        RMS acceleration that stands out above the frequencies of motion, per s^2: noise of some frequency, or
        motion too fast for the readings.
    """

    frequency: FloatArray
    motion: FloatArray
    noise: FloatArray
    seconds: float
    missed: float

    @classmethod
    def of(cls, spectrum: Spectrum, highest: float, seconds: float) -> Noise:
        """Tell them apart up to a frequency; above it all is noise."""
        frequency, density = spectrum.frequency, spectrum.density
        ends = np.minimum((_WITHIN * np.arange(1, len(density) + 1)).astype(int), len(density))
        least = np.array([density[first:end].min() for first, end in enumerate(ends)])
        stands_out = density > _STANDS_OUT * least
        moving = np.flatnonzero(stands_out & (frequency <= highest))
        edge = float(frequency[moving[-1]]) if moving.size else 0.0
        law = np.minimum(_law(frequency, density, ~stands_out, edge), density)
        noise = np.where(frequency > edge, density, law)
        beyond = density[stands_out & (frequency > highest)]
        missed = math.sqrt(float(beyond.sum() * spectrum.step))
        return cls(frequency, density - noise, noise, seconds, missed)

    def left(self, cutoff: float) -> float:
        """Standard deviation of the noise that a cut-off leaves in the accelerations, per s^2."""
        return math.sqrt(self._sum(passed(self.frequency, cutoff) ** 2 * self.noise))

    def error(self, cutoff: float) -> float:
        """Root of the expected squared error of accelerations that passed a cut-off."""
        through = passed(self.frequency, cutoff)
        jerk = self._sum((2 * math.pi * self.frequency) ** 2 * self.motion)
        between = self._sum((1 - through) ** 2 * self.motion + through**2 * self.noise)
        return math.sqrt(between + _ENDS * jerk / (cutoff**3 * self.seconds))

    @property
    def moved(self) -> float:
        """Root mean square acceleration of the motion."""
        return math.sqrt(self._sum(self.motion))

    def _sum(self, density: FloatArray) -> float:
        return float(density.sum() * self.frequency[0])


def sizes(noises: Sequence[Noise]) -> FloatArray:
    """RMS accelerations by which errors of several joints are measured, shape (n,).

    A joint that hardly moves counts as if it moved by a tenth of what the most moving one does: its noise
    must not take the motion from others, nor theirs pass for its motion.
    """
    moved = np.array([noise.moved for noise in noises])
    size = np.maximum(moved, _HARDLY * moved.max(initial=0.0))
    return np.where(size > 0.0, size, 1.0)


def common_error(noises: Sequence[Noise], size: FloatArray, cutoff: float) -> float:
    """Expected squared errors of several joints, each over its size, summed."""
    return float(np.square([noise.error(cutoff) for noise in noises] / size).sum())


def best_cutoff(noises: Sequence[Noise], highest: float) -> float:
    """Cut-off for several joints with the least `common_error`, Hz."""
    lowest = min(max(_LOWEST, _FEWEST_PERIODS / noises[0].seconds), highest)
    count = math.ceil(math.log(highest / lowest) / math.log(_RATIO)) + 1
    size = sizes(noises)
    tried = np.geomspace(lowest, highest, count).tolist()
    return float(min(tried, key=lambda cutoff: common_error(noises, size, cutoff)))


def _law(frequency: FloatArray, density: FloatArray, quiet: np.ndarray, edge: float) -> FloatArray:
    """Power of the frequency, none of falling, that the noise above `edge` follows."""
    begin = _CLEAR * edge
    chosen = np.flatnonzero(quiet & (frequency >= begin) & (frequency <= max(_DECADE * begin, begin + 1.0)))
    if len(chosen) < _FEWEST_FITTED:
        return np.full_like(density, density[-1])
    x, y = np.log(frequency[chosen]), np.log(np.maximum(density[chosen], np.finfo(float).tiny))
    # A weight for every step of log f.
    weight = 1 / frequency[chosen]
    middle = [float(np.average(values, weights=weight)) for values in (x, y)]
    off = x - middle[0]
    rise = float((weight * off * (y - middle[1])).sum() / (weight * off**2).sum())
    return np.asarray(np.exp(middle[1] + np.clip(rise, 0.0, _STEEPEST) * (np.log(frequency) - middle[0])))
