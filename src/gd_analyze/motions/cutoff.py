"""The cut-off of the low-pass, by rule or as given, and the readings from which accelerations are derived.

Motion and noise are distinguished by their spectra: see docs/decisions/0021-cut-off.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import warn_caller
from gd_analyze.motions.reading import Treatment, refusal
from gd_analyze.motions.sampling import Sampling
from gd_analyze.text import named_joints, significant


def passed(frequency: FloatArray, cutoff: float) -> FloatArray:
    """Share H of the amplitude that a cut-off lets pass."""
    return np.asarray(1 / (1 + (frequency / cutoff) ** 6))


# Readings whose steps differ by a larger share are interpolated before a spectrum is taken.
_EVEN_STEP_TOLERANCE = 1e-3


def power(
    time: FloatArray,
    readings: FloatArray,
    rate: float,
    order: int,
    piece: int,
) -> FloatArray:
    """Power spectral density of the derivative of readings, by Welch's method on their differences.

    Unlike positions, differences have no trend that leaks into all frequencies; their attenuation of high
    frequencies is compensated.
    """
    if np.abs(np.diff(time) * rate - 1).max(initial=0.0) >= _EVEN_STEP_TOLERANCE:
        from scipy.interpolate import PchipInterpolator  # slow to load

        even = np.linspace(time[0], time[-1], len(time))
        readings = np.asarray(PchipInterpolator(time, readings)(even))
    differences = np.diff(readings, order) * rate**order
    frequency = np.fft.rfftfreq(piece, 1 / rate)
    return np.asarray(_density(differences, rate, piece) / np.sinc(frequency / rate) ** (2 * order))


def _density(values: FloatArray, rate: float, piece: int) -> FloatArray:
    """Mean one-sided power spectral density of pieces that overlap by half, each without its mean.

    They pass a Hann window. It is what `scipy.signal.welch` returns, whose module is slow to load and large.
    """
    window = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, piece + 1)[:-1])
    window = window * (1.0 / np.sqrt(sum(window**2) / (1.0 / rate)))
    densities = []
    for start in range(0, len(values) - piece + 1, piece - piece // 2):
        part = values[start : start + piece]
        spectrum = np.fft.rfft((part - part.mean()) * window)
        densities.append(spectrum.real**2 + spectrum.imag**2)
    density = np.stack(densities, axis=-1)
    density[1 : (piece + 1) // 2] *= 2.0  # the negative frequencies
    return np.asarray(density.mean(axis=-1))


# Length of the pieces whose spectra are averaged, and the least number of readings in one.
_PIECE_SECONDS = 8.0
_FEWEST_PIECE_READINGS = 64
# A density is of motion if it is larger by the first factor than some density above it, up to the second
# factor times its frequency: averaged noise varies less, and a sensor's filter falls less.
_MOTION_FACTOR = 6.0
_COMPARED_FREQUENCY_FACTOR = 5.0
# Integral of the squared error that a constant jerk causes at both ends of a stretch, times f_c^3.
_END_ERROR = 0.0228


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
        cls,
        parts: Sequence[tuple[FloatArray, FloatArray]],
        rate: float,
        order: int,
        highest: float,
    ) -> Noise:
        """Separate a joint's motion and noise, stretch by stretch; above `highest`, Hz, all is noise."""
        usual_piece = max(int(_PIECE_SECONDS * rate), _FEWEST_PIECE_READINGS)
        piece = min(usual_piece, max(len(x) for _, x in parts) - order)
        pairs = [(t, x) for t, x in parts if len(x) - order >= piece]
        total = sum(power(t, x, rate, order, piece) * len(x) for t, x in pairs)
        frequency: FloatArray = np.asarray(np.fft.rfftfreq(piece, 1 / rate)[1:], dtype=float)
        density = _averaged((np.asarray(total) / sum(len(x) for _, x in pairs))[1:])
        numbers = np.arange(1, len(density) + 1)
        ends = np.minimum((_COMPARED_FREQUENCY_FACTOR * numbers).astype(int), len(density))
        least = np.array([density[first:end].min() for first, end in enumerate(ends)])
        stands_out = density > _MOTION_FACTOR * least
        moving = np.flatnonzero(stands_out & (frequency <= highest))
        edge = float(frequency[moving[-1]]) if moving.size else 0.0
        law = np.minimum(_law(frequency, density, ~stands_out, edge), density)
        noise = np.where(frequency > edge, density, law)
        beyond = density[stands_out & (frequency > highest)]
        missed = math.sqrt(float(beyond.sum() * frequency[0]))
        seconds = float(np.mean([time[-1] - time[0] for time, _ in parts]))
        return cls(frequency, density - noise, noise, seconds, missed)

    def remaining(self, cutoff: float) -> float:
        """Standard deviation of the noise that a cut-off leaves in the accelerations, per s^2."""
        return math.sqrt(self._sum(passed(self.frequency, cutoff) ** 2 * self.noise))

    def error(self, cutoff: float) -> float:
        """Root of the expected squared error of accelerations that passed a cut-off."""
        through = passed(self.frequency, cutoff)
        jerk = self._sum((2 * math.pi * self.frequency) ** 2 * self.motion)
        between = self._sum((1 - through) ** 2 * self.motion + through**2 * self.noise)
        return math.sqrt(between + _END_ERROR * jerk / (cutoff**3 * self.seconds))

    @property
    def moved(self) -> float:
        """Root mean square acceleration of the motion."""
        return math.sqrt(self._sum(self.motion))

    def _sum(self, density: FloatArray) -> float:
        return float(density.sum() * self.frequency[0])


# A density is averaged with those of so many frequencies to either side: this share of its own frequency,
# and no fewer than this number.
_AVERAGED_SHARE = 0.15
_FEWEST_AVERAGED = 2


def _averaged(density: FloatArray) -> FloatArray:
    """Mean over neighbouring frequencies."""
    number = np.arange(len(density))
    wide = np.maximum((_AVERAGED_SHARE * (number + 1)).astype(int), _FEWEST_AVERAGED)
    low, high = np.maximum(number - wide, 0), np.minimum(number + wide + 1, len(density))
    sums = np.concatenate([[0.0], np.cumsum(density)])
    return np.asarray((sums[high] - sums[low]) / (high - low))


# The noise's power law is fitted from the highest frequency of motion times the first factor, up to the
# second factor times that.
_FIT_BEGIN_FACTOR = 1.3
_FIT_WIDTH_FACTOR = 10.0
# With fewer frequencies in between, the noise is taken as white.
_FEWEST_FITTED = 5
# Steepest rise of the noise: the power of the frequency of white noise that is differentiated twice.
_STEEPEST_POWER = 4.0


def _law(frequency: FloatArray, density: FloatArray, quiet: np.ndarray, edge: float) -> FloatArray:
    """Power law, not falling, that the noise above `edge` follows."""
    begin = _FIT_BEGIN_FACTOR * edge
    end = max(_FIT_WIDTH_FACTOR * begin, begin + 1.0)
    fitted = np.flatnonzero(quiet & (frequency >= begin) & (frequency <= end))
    if len(fitted) < _FEWEST_FITTED:
        return np.full_like(density, density[-1])
    x, y = np.log(frequency[fitted]), np.log(np.maximum(density[fitted], np.finfo(float).tiny))
    # A weight for every step of log f.
    weight = 1 / frequency[fitted]
    x_mean, y_mean = (float(np.average(values, weights=weight)) for values in (x, y))
    offset = x - x_mean
    rise = float((weight * offset * (y - y_mean)).sum() / (weight * offset**2).sum())
    exponent = np.clip(rise, 0.0, _STEEPEST_POWER)
    return np.asarray(np.exp(y_mean + exponent * (np.log(frequency) - x_mean)))


# Lowest cut-off by rule, and the least number of its periods in a motion.
_LOWEST_HERTZ = 0.5
_FEWEST_PERIODS = 2.0
# Ratio of neighbouring cut-offs that are compared.
_CUTOFF_RATIO = 1.05
# A joint counts as accelerating by at least this share of what the joint that moves most does.
_LEAST_ACCELERATION_SHARE = 0.1


@dataclass(frozen=True, eq=False)
class Source:
    """Readings that accelerations may come from: positions differentiated twice, or velocities once."""

    values: FloatArray  # (N, n)
    order: int
    noises: tuple[Noise, ...]

    @classmethod
    def of(cls, sampling: Sampling, values: FloatArray, order: int) -> Source:
        """Compute the spectra of readings, shape (N, n)."""
        rate, highest = 1 / sampling.step, _highest(sampling)
        noises = []
        for joint_values in values.T:
            parts = [(sampling.time[part], joint_values[part]) for part in sampling.stretches]
            noises.append(Noise.of(parts, rate, order, highest))
        return cls(values, order, tuple(noises))

    def remaining_noise(self, cutoffs: FloatArray) -> FloatArray:
        """Standard deviation of the noise that cut-offs leave in the accelerations, shape (n,)."""
        return np.array([noise.remaining(float(f)) for noise, f in zip(self.noises, cutoffs, strict=True)])

    def sizes(self) -> FloatArray:
        """RMS accelerations that scale the joints' errors, shape (n,).

        A joint that hardly moves counts as moving a share of what the joint that moves most does: its noise
        must not determine the cut-off of the others.
        """
        moved = np.array([noise.moved for noise in self.noises])
        size = np.maximum(moved, _LEAST_ACCELERATION_SHARE * moved.max(initial=0.0))
        return np.where(size > 0.0, size, 1.0)

    def error(self, size: FloatArray, cutoff: float) -> float:
        """Expected squared errors of the joints, each over its size, summed."""
        return float(np.square([noise.error(cutoff) for noise in self.noises] / size).sum())

    def best_cutoff(self, highest: float) -> float:
        """Cut-off, Hz, with the least expected error of all joints together."""
        lowest = max(_LOWEST_HERTZ, _FEWEST_PERIODS / self.noises[0].seconds)
        lowest = min(lowest, highest)
        count = math.ceil(math.log(highest / lowest) / math.log(_CUTOFF_RATIO)) + 1
        size = self.sizes()
        cutoffs = np.geomspace(lowest, highest, count).tolist()
        return float(min(cutoffs, key=lambda cutoff: self.error(size, cutoff)))


# Highest cut-off by rule: above these hertz elastic joints make arms vibrate, which no model of rigid links
# describes; above this share of the sample rate aliased noise would reach the pass band.
_HIGHEST_HERTZ = 30.0
_HIGHEST_RATE_SHARE = 0.2


def _highest(sampling: Sampling) -> float:
    """Highest cut-off that the rule chooses, Hz."""
    return min(_HIGHEST_HERTZ, _HIGHEST_RATE_SHARE / sampling.step)


# Share of the largest motion in any readings that others must show to be chosen, unless all is noise.
_SEEN_MOTION_SHARE = 0.5
# A warning says that the log is too slow if accelerations above the highest cut-off exceed this share of a
# joint's own, and this size, per s^2.
_WARNED_ACCELERATION_SHARE = 0.1
_WARNED_ACCELERATION = 1e-3


def chosen(
    sources: Sequence[Source],
    sampling: Sampling,
    treatment: Treatment,
) -> tuple[Source, FloatArray, str]:
    """Choose a source and its cut-offs, Hz, shape (n,), and name the rule.

    The rule gives all joints one cut-off, so that they move together and torques can be compared. Of the
    sources that show the motion, the one with the least expected error of accelerations is taken.
    """
    n = sources[0].values.shape[1]
    if treatment.cutoff is not None:
        cutoffs = _cutoffs_of_joints(treatment.cutoff, n, sampling)
        best = min(sources, key=lambda source: float((source.remaining_noise(cutoffs) ** 2).sum()))
        return best, cutoffs, "as asked for"
    highest = _highest(sampling)
    square_sums = [sum(noise.moved**2 for noise in source.noises) for source in sources]
    moving = [
        source
        for source, square_sum in zip(sources, square_sums, strict=True)
        if square_sum >= _SEEN_MOTION_SHARE**2 * max(square_sums)
    ]
    size = np.max([source.sizes() for source in moving], axis=0)
    best_cutoffs = [source.best_cutoff(highest) for source in moving]
    place = int(np.argmin([source.error(size, f) for source, f in zip(moving, best_cutoffs, strict=True)]))
    missed = np.array([noise.missed for noise in moving[place].noises])
    warned = np.maximum(_WARNED_ACCELERATION_SHARE * size, _WARNED_ACCELERATION)
    joints = (np.flatnonzero(missed > warned) + 1).tolist()
    if highest < _HIGHEST_HERTZ and joints:
        message = (
            f"accelerations above {significant(highest)} Hz in the log, left out: {named_joints(joints, n)}"
        )
        advice = f"{significant(1 / sampling.step)} readings per second are too few for these; log faster"
        warn_caller(f"{message}; {advice}")
    rule = "least expected error of the accelerations"
    if best_cutoffs[place] >= highest * 0.999:
        slow = best_cutoffs[place] < _HIGHEST_HERTZ * 0.999
        why = f"{_HIGHEST_RATE_SHARE:g} of the sample rate" if slow else "arms are not rigid above it"
        rule = f"the highest allowed: {why}"
    return moving[place], np.full(n, best_cutoffs[place]), rule


# Highest cut-off that a user may give, as a share of the sample rate: above it hardly anything is smoothed.
_HIGHEST_GIVEN_RATE_SHARE = 0.25


def _cutoffs_of_joints(cutoff: float | tuple[float, ...], n: int, sampling: Sampling) -> FloatArray:
    cutoffs = np.full(n, cutoff) if isinstance(cutoff, float | int) else np.array(cutoff, dtype=float)
    if cutoffs.shape != (n,):
        expected = f"one for all joints, or {n}"
        raise refusal("wrong number of cut-offs", "cutoff", expected, str(cutoffs.size))
    most = _HIGHEST_GIVEN_RATE_SHARE / sampling.step
    if cutoffs.max() > most:
        message = "the cut-off is too high for the sample rate"
        highest = f"{significant(float(cutoffs.max()))} Hz"
        expected = (
            f"up to {significant(most)} Hz, a quarter of {significant(1 / sampling.step)} readings per second"
        )
        raise refusal(message, "cutoff", expected, highest, "give a lower one, or none to have it chosen")
    return cutoffs
