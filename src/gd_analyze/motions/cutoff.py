"""The cut-off of the low-pass, by rule or as given, and the readings from which accelerations are derived.

Motion and noise are distinguished by their spectra: see docs/decisions/0021-cut-off.md.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.motions.reading import Treatment, refusal
from gd_analyze.motions.sampling import Sampling
from gd_analyze.text import named_joints, significant

# Length of the pieces whose spectra are averaged, s.
_PIECE = 8.0
# Least number of readings in a piece.
_SHORTEST = 64
# Frequencies averaged into one, to either side, as a share of the frequency.
_SHARE = 0.15
# Least number of frequencies averaged to either side.
_FEWEST = 2
# Hz; above it elastic joints make arms vibrate, which no model of rigid links describes.
_HIGHEST = 30.0
# Share of the sample rate: aliased noise must not reach the pass band.
_HIGHEST_SHARE = 0.2
# Lowest cut-off chosen by rule, Hz.
_LOWEST = 0.5
# Least number of its periods in a motion.
_FEWEST_PERIODS = 2.0
# Ratio of neighbouring cut-offs that are compared.
_RATIO = 1.05
# A density is of motion if a density above it is smaller by this factor: averaged noise varies less, and a
# sensor's filter falls less.
_STANDS_OUT = 6.0
# Multiple of a frequency up to which densities are compared with its own.
_WITHIN = 5.0
# The law of the noise is fitted from the highest frequency of motion times this,
_CLEAR = 1.3
# up to this multiple of the frequency where the fit begins.
_DECADE = 10.0
# Least number of frequencies fitted.
_FEWEST_FITTED = 5
# Steepest rise of a density: white noise, differentiated twice.
_STEEPEST = 4.0
# Least acceleration of a joint, as a share of that of the joint that moves most.
_HARDLY = 0.1
# Integral of the squared error from a constant jerk at both ends of a stretch, times f_c^3.
_ENDS = 0.0228
# Highest cut-off that a user may give, as a share of the sample rate: above it hardly anything is smoothed.
_LARGEST_SHARE = 0.25
# Share of the motion in the best readings that others must show, too, unless all is noise.
_SEEN = 0.5
# Share of a joint's acceleration at too high frequencies that causes a warning.
_MISSED = 0.1
# Smallest acceleration at too high frequencies that causes a warning, per s^2.
_AT_REST = 1e-3
# Steps that differ by less than this share are even.
_EVEN = 1e-3


def passed(frequency: FloatArray, cutoff: float) -> FloatArray:
    """Share H of the amplitude that a cut-off lets pass."""
    return np.asarray(1 / (1 + (frequency / cutoff) ** 6))


def power(time: FloatArray, readings: FloatArray, rate: float, order: int, piece: int) -> FloatArray:
    """Power spectral density of the derivative of readings, by Welch's method on their differences.

    Unlike positions, differences have no trend that leaks into all frequencies; their attenuation of high
    frequencies is compensated.
    """
    from scipy.interpolate import PchipInterpolator
    from scipy.signal import welch

    if np.abs(np.diff(time) * rate - 1).max(initial=0.0) >= _EVEN:
        even = np.linspace(time[0], time[-1], len(time))
        readings = np.asarray(PchipInterpolator(time, readings)(even))
    differences = np.diff(readings, order) * rate**order
    frequency, density = welch(differences, rate, "hann", nperseg=piece, detrend="constant")
    return np.asarray(density / np.sinc(frequency / rate) ** (2 * order))


@dataclass(frozen=True, eq=False)
class Noise:
    """Motion and noise in a joint's accelerations."""

    frequency: FloatArray  # Hz, even steps from the first above zero, shape (F,)
    # S and N, one-sided, (rad/s^2)^2 per Hz, or in m, shape (F,)
    motion: FloatArray
    noise: FloatArray
    seconds: float  # T, mean length of the stretches
    # RMS acceleration of peaks above the frequencies of motion, per s^2: noise of one frequency, or motion
    # too fast for the readings
    missed: float

    @classmethod
    def of(
        cls, parts: Sequence[tuple[FloatArray, FloatArray]], rate: float, order: int, highest: float
    ) -> Noise:
        """Separate a joint's motion and noise, stretch by stretch; above `highest`, Hz, all is noise."""
        piece = min(max(int(_PIECE * rate), _SHORTEST), max(len(x) for _, x in parts) - order)
        pairs = [(t, x) for t, x in parts if len(x) - order >= piece]
        total = sum(power(t, x, rate, order, piece) * len(x) for t, x in pairs)
        frequency: FloatArray = np.asarray(np.fft.rfftfreq(piece, 1 / rate)[1:], dtype=float)
        density = _averaged((np.asarray(total) / sum(len(x) for _, x in pairs))[1:])
        ends = np.minimum((_WITHIN * np.arange(1, len(density) + 1)).astype(int), len(density))
        least = np.array([density[first:end].min() for first, end in enumerate(ends)])
        stands_out = density > _STANDS_OUT * least
        moving = np.flatnonzero(stands_out & (frequency <= highest))
        edge = float(frequency[moving[-1]]) if moving.size else 0.0
        law = np.minimum(_law(frequency, density, ~stands_out, edge), density)
        noise = np.where(frequency > edge, density, law)
        beyond = density[stands_out & (frequency > highest)]
        missed = math.sqrt(float(beyond.sum() * frequency[0]))
        seconds = float(np.mean([time[-1] - time[0] for time, _ in parts]))
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


def _averaged(density: FloatArray) -> FloatArray:
    """Mean over neighbouring frequencies."""
    number = np.arange(len(density))
    wide = np.maximum((_SHARE * (number + 1)).astype(int), _FEWEST)
    low, high = np.maximum(number - wide, 0), np.minimum(number + wide + 1, len(density))
    sums = np.concatenate([[0.0], np.cumsum(density)])
    return np.asarray((sums[high] - sums[low]) / (high - low))


def _law(frequency: FloatArray, density: FloatArray, quiet: np.ndarray, edge: float) -> FloatArray:
    """Power law, not falling, that the noise above `edge` follows."""
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


@dataclass(frozen=True, eq=False)
class Source:
    """Readings that accelerations may come from: positions differentiated twice, or velocities once."""

    values: FloatArray  # (N, n)
    order: int
    noises: tuple[Noise, ...]

    @classmethod
    def of(cls, sampling: Sampling, values: FloatArray, order: int) -> Source:
        """Compute the spectra of readings, shape (N, n)."""
        of_joints = ([(sampling.time[part], x[part]) for part in sampling.stretches] for x in values.T)
        rate, highest = 1 / sampling.step, _highest(sampling)
        return cls(values, order, tuple(Noise.of(parts, rate, order, highest) for parts in of_joints))

    def left(self, cutoffs: FloatArray) -> FloatArray:
        """Standard deviation of the noise that cut-offs leave in the accelerations, shape (n,)."""
        return np.array([noise.left(float(f)) for noise, f in zip(self.noises, cutoffs, strict=True)])

    @property
    def sizes(self) -> FloatArray:
        """RMS accelerations that scale the joints' errors, shape (n,).

        A joint that hardly moves counts as moving a tenth as much as the joint that moves most: its noise
        must not determine the cut-off of the others.
        """
        moved = np.array([noise.moved for noise in self.noises])
        size = np.maximum(moved, _HARDLY * moved.max(initial=0.0))
        return np.where(size > 0.0, size, 1.0)

    def error(self, size: FloatArray, cutoff: float) -> float:
        """Expected squared errors of the joints, each over its size, summed."""
        return float(np.square([noise.error(cutoff) for noise in self.noises] / size).sum())

    def best_cutoff(self, highest: float) -> float:
        """Cut-off, Hz, with the least expected error of all joints together."""
        lowest = min(max(_LOWEST, _FEWEST_PERIODS / self.noises[0].seconds), highest)
        count = math.ceil(math.log(highest / lowest) / math.log(_RATIO)) + 1
        size = self.sizes
        cutoffs = np.geomspace(lowest, highest, count).tolist()
        return float(min(cutoffs, key=lambda cutoff: self.error(size, cutoff)))


def _highest(sampling: Sampling) -> float:
    """Highest cut-off that the rule chooses, Hz."""
    return min(_HIGHEST, _HIGHEST_SHARE / sampling.step)


def chosen(
    sources: Sequence[Source], sampling: Sampling, treatment: Treatment
) -> tuple[Source, FloatArray, str]:
    """Choose a source and its cut-offs, Hz, shape (n,), and name the rule.

    The rule gives all joints one cut-off, so that they move together and torques can be compared. Of the
    sources that show the motion, the one with the least expected error of accelerations is taken.
    """
    n = sources[0].values.shape[1]
    if treatment.cutoff is not None:
        cutoffs = _cutoffs_of_joints(treatment.cutoff, n, sampling)
        best = min(sources, key=lambda source: float((source.left(cutoffs) ** 2).sum()))
        return best, cutoffs, "as asked for"
    highest = _highest(sampling)
    square_sums = [sum(noise.moved**2 for noise in source.noises) for source in sources]
    moving = [
        source
        for source, square_sum in zip(sources, square_sums, strict=True)
        if square_sum >= _SEEN**2 * max(square_sums)
    ]
    size = np.max([source.sizes for source in moving], axis=0)
    best_cutoffs = [source.best_cutoff(highest) for source in moving]
    place = int(np.argmin([source.error(size, f) for source, f in zip(moving, best_cutoffs, strict=True)]))
    missed = np.array([noise.missed for noise in moving[place].noises])
    joints = (np.flatnonzero(missed > np.maximum(_MISSED * size, _AT_REST)) + 1).tolist()
    if highest < _HIGHEST and joints:
        message = (
            f"accelerations above {significant(highest)} Hz in the log, left out: {named_joints(joints, n)}"
        )
        advice = f"{significant(1 / sampling.step)} readings per second are too few for these; log faster"
        warnings.warn(f"{message}; {advice}", GdAnalyzeWarning, stacklevel=4)
    rule = "least expected error of the accelerations"
    if best_cutoffs[place] >= highest * 0.999:
        slow = best_cutoffs[place] < _HIGHEST * 0.999
        why = f"{_HIGHEST_SHARE:g} of the sample rate" if slow else "arms are not rigid above it"
        rule = f"the highest allowed: {why}"
    return moving[place], np.full(n, best_cutoffs[place]), rule


def _cutoffs_of_joints(cutoff: float | tuple[float, ...], n: int, sampling: Sampling) -> FloatArray:
    cutoffs = np.full(n, cutoff) if isinstance(cutoff, float | int) else np.array(cutoff, dtype=float)
    if cutoffs.shape != (n,):
        expected = f"one for all joints, or {n}"
        raise refusal("wrong number of cut-offs", "--cutoff", expected, str(cutoffs.size))
    most = _LARGEST_SHARE / sampling.step
    if cutoffs.max() > most:
        message = "the cut-off is too high for the sample rate"
        highest = f"{significant(float(cutoffs.max()))} Hz"
        expected = (
            f"up to {significant(most)} Hz, a quarter of {significant(1 / sampling.step)} readings per second"
        )
        raise refusal(message, "--cutoff", expected, highest, "give a lower one, or none to have it chosen")
    return cutoffs
