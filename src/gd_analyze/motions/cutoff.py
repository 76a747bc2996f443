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

# Integral of the squared error that a constant jerk causes at both ends of a stretch, times f_c^3.
_END_ERROR = 0.0228


@dataclass(frozen=True, kw_only=True)
class CutoffSettings:
    """How motion and noise are told apart in spectra, and which cut-off is chosen."""

    # Length of the pieces whose spectra are averaged, and the least number of readings in one.
    piece_seconds: float = 8.0
    fewest_piece_readings: int = 64
    # Readings whose steps differ by a larger share are interpolated before a spectrum is taken.
    even_step_tolerance: float = 1e-3
    # A density is averaged with those of so many frequencies to either side: this share of its own frequency,
    # and no fewer than this number.
    averaged_share: float = 0.15
    fewest_averaged: int = 2

    # A density is of motion if it is larger by the first factor than some density above it, up to the second
    # factor times its frequency: averaged noise varies less, and a sensor's filter falls less.
    motion_factor: float = 6.0
    compared_frequency_factor: float = 5.0
    # The noise's power law is fitted from the highest frequency of motion times the first factor, up to the
    # second factor times that.
    fit_begin_factor: float = 1.3
    fit_width_factor: float = 10.0
    # With fewer frequencies in between, the noise is taken as white.
    fewest_fitted: int = 5
    # Steepest rise of the noise: the power of the frequency of white noise that is differentiated twice.
    steepest_power: float = 4.0

    # Highest cut-off by rule: above these hertz elastic joints make arms vibrate, which no model of rigid
    # links describes; above this share of the sample rate aliased noise would reach the pass band.
    highest_hertz: float = 30.0
    highest_rate_share: float = 0.2
    # Lowest cut-off by rule, and the least number of its periods in a motion.
    lowest_hertz: float = 0.5
    fewest_periods: float = 2.0
    # Ratio of neighbouring cut-offs that are compared.
    cutoff_ratio: float = 1.05
    # A joint counts as accelerating by at least this share of what the joint that moves most does.
    least_acceleration_share: float = 0.1
    # Share of the largest motion in any readings that others must show to be chosen, unless all is noise.
    seen_motion_share: float = 0.5

    # A warning says that the log is too slow if accelerations above the highest cut-off exceed this share of
    # a joint's own, and this size, per s^2.
    warned_acceleration_share: float = 0.1
    warned_acceleration: float = 1e-3
    # Highest cut-off that a user may give, as a share of the sample rate: above it hardly anything is
    # smoothed.
    highest_given_rate_share: float = 0.25


USUAL_CUTOFF = CutoffSettings()


def passed(frequency: FloatArray, cutoff: float) -> FloatArray:
    """Share H of the amplitude that a cut-off lets pass."""
    return np.asarray(1 / (1 + (frequency / cutoff) ** 6))


def power(
    time: FloatArray,
    readings: FloatArray,
    rate: float,
    order: int,
    piece: int,
    settings: CutoffSettings,
) -> FloatArray:
    """Power spectral density of the derivative of readings, by Welch's method on their differences.

    Unlike positions, differences have no trend that leaks into all frequencies; their attenuation of high
    frequencies is compensated.
    """
    from scipy.interpolate import PchipInterpolator
    from scipy.signal import welch

    if np.abs(np.diff(time) * rate - 1).max(initial=0.0) >= settings.even_step_tolerance:
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
        cls,
        parts: Sequence[tuple[FloatArray, FloatArray]],
        rate: float,
        order: int,
        highest: float,
        settings: CutoffSettings,
    ) -> Noise:
        """Separate a joint's motion and noise, stretch by stretch; above `highest`, Hz, all is noise."""
        usual_piece = max(int(settings.piece_seconds * rate), settings.fewest_piece_readings)
        piece = min(usual_piece, max(len(x) for _, x in parts) - order)
        pairs = [(t, x) for t, x in parts if len(x) - order >= piece]
        total = sum(power(t, x, rate, order, piece, settings) * len(x) for t, x in pairs)
        frequency: FloatArray = np.asarray(np.fft.rfftfreq(piece, 1 / rate)[1:], dtype=float)
        density = _averaged((np.asarray(total) / sum(len(x) for _, x in pairs))[1:], settings)
        numbers = np.arange(1, len(density) + 1)
        ends = np.minimum((settings.compared_frequency_factor * numbers).astype(int), len(density))
        least = np.array([density[first:end].min() for first, end in enumerate(ends)])
        stands_out = density > settings.motion_factor * least
        moving = np.flatnonzero(stands_out & (frequency <= highest))
        edge = float(frequency[moving[-1]]) if moving.size else 0.0
        law = np.minimum(_law(frequency, density, ~stands_out, edge, settings), density)
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


def _averaged(density: FloatArray, settings: CutoffSettings) -> FloatArray:
    """Mean over neighbouring frequencies."""
    number = np.arange(len(density))
    wide = np.maximum((settings.averaged_share * (number + 1)).astype(int), settings.fewest_averaged)
    low, high = np.maximum(number - wide, 0), np.minimum(number + wide + 1, len(density))
    sums = np.concatenate([[0.0], np.cumsum(density)])
    return np.asarray((sums[high] - sums[low]) / (high - low))


def _law(
    frequency: FloatArray, density: FloatArray, quiet: np.ndarray, edge: float, settings: CutoffSettings
) -> FloatArray:
    """Power law, not falling, that the noise above `edge` follows."""
    begin = settings.fit_begin_factor * edge
    end = max(settings.fit_width_factor * begin, begin + 1.0)
    fitted = np.flatnonzero(quiet & (frequency >= begin) & (frequency <= end))
    if len(fitted) < settings.fewest_fitted:
        return np.full_like(density, density[-1])
    x, y = np.log(frequency[fitted]), np.log(np.maximum(density[fitted], np.finfo(float).tiny))
    # A weight for every step of log f.
    weight = 1 / frequency[fitted]
    x_mean, y_mean = (float(np.average(values, weights=weight)) for values in (x, y))
    offset = x - x_mean
    rise = float((weight * offset * (y - y_mean)).sum() / (weight * offset**2).sum())
    exponent = np.clip(rise, 0.0, settings.steepest_power)
    return np.asarray(np.exp(y_mean + exponent * (np.log(frequency) - x_mean)))


@dataclass(frozen=True, eq=False)
class Source:
    """Readings that accelerations may come from: positions differentiated twice, or velocities once."""

    values: FloatArray  # (N, n)
    order: int
    noises: tuple[Noise, ...]

    @classmethod
    def of(
        cls, sampling: Sampling, values: FloatArray, order: int, settings: CutoffSettings = USUAL_CUTOFF
    ) -> Source:
        """Compute the spectra of readings, shape (N, n)."""
        rate, highest = 1 / sampling.step, _highest(sampling, settings)
        noises = []
        for joint_values in values.T:
            parts = [(sampling.time[part], joint_values[part]) for part in sampling.stretches]
            noises.append(Noise.of(parts, rate, order, highest, settings))
        return cls(values, order, tuple(noises))

    def remaining_noise(self, cutoffs: FloatArray) -> FloatArray:
        """Standard deviation of the noise that cut-offs leave in the accelerations, shape (n,)."""
        return np.array([noise.remaining(float(f)) for noise, f in zip(self.noises, cutoffs, strict=True)])

    def sizes(self, settings: CutoffSettings) -> FloatArray:
        """RMS accelerations that scale the joints' errors, shape (n,).

        A joint that hardly moves counts as moving a share of what the joint that moves most does: its noise
        must not determine the cut-off of the others.
        """
        moved = np.array([noise.moved for noise in self.noises])
        size = np.maximum(moved, settings.least_acceleration_share * moved.max(initial=0.0))
        return np.where(size > 0.0, size, 1.0)

    def error(self, size: FloatArray, cutoff: float) -> float:
        """Expected squared errors of the joints, each over its size, summed."""
        return float(np.square([noise.error(cutoff) for noise in self.noises] / size).sum())

    def best_cutoff(self, highest: float, settings: CutoffSettings) -> float:
        """Cut-off, Hz, with the least expected error of all joints together."""
        lowest = max(settings.lowest_hertz, settings.fewest_periods / self.noises[0].seconds)
        lowest = min(lowest, highest)
        count = math.ceil(math.log(highest / lowest) / math.log(settings.cutoff_ratio)) + 1
        size = self.sizes(settings)
        cutoffs = np.geomspace(lowest, highest, count).tolist()
        return float(min(cutoffs, key=lambda cutoff: self.error(size, cutoff)))


def _highest(sampling: Sampling, settings: CutoffSettings) -> float:
    """Highest cut-off that the rule chooses, Hz."""
    return min(settings.highest_hertz, settings.highest_rate_share / sampling.step)


def chosen(
    sources: Sequence[Source],
    sampling: Sampling,
    treatment: Treatment,
    settings: CutoffSettings = USUAL_CUTOFF,
) -> tuple[Source, FloatArray, str]:
    """Choose a source and its cut-offs, Hz, shape (n,), and name the rule.

    The rule gives all joints one cut-off, so that they move together and torques can be compared. Of the
    sources that show the motion, the one with the least expected error of accelerations is taken.
    """
    n = sources[0].values.shape[1]
    if treatment.cutoff is not None:
        cutoffs = _cutoffs_of_joints(treatment.cutoff, n, sampling, settings)
        best = min(sources, key=lambda source: float((source.remaining_noise(cutoffs) ** 2).sum()))
        return best, cutoffs, "as asked for"
    highest = _highest(sampling, settings)
    square_sums = [sum(noise.moved**2 for noise in source.noises) for source in sources]
    moving = [
        source
        for source, square_sum in zip(sources, square_sums, strict=True)
        if square_sum >= settings.seen_motion_share**2 * max(square_sums)
    ]
    size = np.max([source.sizes(settings) for source in moving], axis=0)
    best_cutoffs = [source.best_cutoff(highest, settings) for source in moving]
    place = int(np.argmin([source.error(size, f) for source, f in zip(moving, best_cutoffs, strict=True)]))
    missed = np.array([noise.missed for noise in moving[place].noises])
    warned = np.maximum(settings.warned_acceleration_share * size, settings.warned_acceleration)
    joints = (np.flatnonzero(missed > warned) + 1).tolist()
    if highest < settings.highest_hertz and joints:
        message = (
            f"accelerations above {significant(highest)} Hz in the log, left out: {named_joints(joints, n)}"
        )
        advice = f"{significant(1 / sampling.step)} readings per second are too few for these; log faster"
        warnings.warn(f"{message}; {advice}", GdAnalyzeWarning, stacklevel=4)
    rule = "least expected error of the accelerations"
    if best_cutoffs[place] >= highest * 0.999:
        slow = best_cutoffs[place] < settings.highest_hertz * 0.999
        why = f"{settings.highest_rate_share:g} of the sample rate" if slow else "arms are not rigid above it"
        rule = f"the highest allowed: {why}"
    return moving[place], np.full(n, best_cutoffs[place]), rule


def _cutoffs_of_joints(
    cutoff: float | tuple[float, ...], n: int, sampling: Sampling, settings: CutoffSettings
) -> FloatArray:
    cutoffs = np.full(n, cutoff) if isinstance(cutoff, float | int) else np.array(cutoff, dtype=float)
    if cutoffs.shape != (n,):
        expected = f"one for all joints, or {n}"
        raise refusal("wrong number of cut-offs", "--cutoff", expected, str(cutoffs.size))
    most = settings.highest_given_rate_share / sampling.step
    if cutoffs.max() > most:
        message = "the cut-off is too high for the sample rate"
        highest = f"{significant(float(cutoffs.max()))} Hz"
        expected = (
            f"up to {significant(most)} Hz, a quarter of {significant(1 / sampling.step)} readings per second"
        )
        raise refusal(message, "--cutoff", expected, highest, "give a lower one, or none to have it chosen")
    return cutoffs
