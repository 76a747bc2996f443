"""The cut-off of an arm's low-pass: by rule, or as asked for; and from what accelerations come."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.noise import HIGHEST, HIGHEST_SHARE, Noise, best_cutoff, common_error, sizes
from gd_analyze.motions.spectrum import Spectrum
from gd_analyze.motions.stamps import Stamps
from gd_analyze.motions.treatment import Treatment
from gd_analyze.text import figures, named_joints

# Of the readings per second: above it hardly anything is smoothed.
_LARGEST_SHARE = 0.25
# Share of the motion that the best readings show, which others have to show as well: where all is noise, no
# motion is missed.
_SEEN = 0.5
# Share of a joint's acceleration that stands out at too high frequencies from which on that is told.
_MISSED = 0.1
# Accelerations below this, rad/s^2 or m/s^2, are none.
_AT_REST = 1e-3


@dataclass(frozen=True, eq=False)
class Source:
    """Readings that accelerations may come from: positions differentiated twice, rates once.

    Parameters
    ----------
    values
        Shape (N, n).
    order
        How often they are differentiated.
    noises
        Of every joint.
    """

    values: FloatArray
    order: int
    noises: tuple[Noise, ...]

    @classmethod
    def of(cls, stamps: Stamps, values: FloatArray, order: int) -> Source:
        """Look at the spectra of readings."""
        times = [stamps.time[stretch] for stretch in stamps.stretches]
        seconds = float(np.mean([time[-1] - time[0] for time in times]))
        noises = []
        for x in values.T:
            readings = [x[stretch] for stretch in stamps.stretches]
            spectrum = Spectrum.of(times, readings, 1 / stamps.step, order)
            noises.append(Noise.of(spectrum, highest_cutoff(stamps), seconds))
        return cls(values, order, tuple(noises))

    def left(self, cutoffs: FloatArray) -> FloatArray:
        """Standard deviation of the noise that cut-offs leave in the accelerations, shape (n,)."""
        return np.array(
            [noise.left(float(cutoff)) for noise, cutoff in zip(self.noises, cutoffs, strict=True)]
        )

    @property
    def seen(self) -> float:
        """RMS acceleration that stands out of the noise, of all joints together."""
        return float(np.sqrt(sum(noise.moved**2 for noise in self.noises)))

    def cutoff(self, stamps: Stamps) -> float:
        """Cut-off by which the joints together are best served, Hz."""
        return best_cutoff(self.noises, highest_cutoff(stamps))


def highest_cutoff(stamps: Stamps) -> float:
    """Highest cut-off that the rule chooses, Hz."""
    return min(HIGHEST, HIGHEST_SHARE / stamps.step)


def chosen(sources: Sequence[Source], stamps: Stamps, treatment: Treatment) -> tuple[Source, FloatArray, str]:
    """Choose a source and its cut-offs.

    The rule gives all joints one cut-off, so that they move together and torques can be compared. The source
    is the one whose accelerations have the least expected error, of those that show the motion.

    Returns
    -------
    source, cutoffs, told
        Cut-offs in Hz, shape (n,); and how they were chosen, in words.
    """
    n = sources[0].values.shape[1]
    if treatment.cutoff is not None:
        cutoffs = _given(treatment.cutoff, n, stamps)
        best = min(sources, key=lambda source: float((source.left(cutoffs) ** 2).sum()))
        return best, cutoffs, "as asked for"
    seeing = [source for source in sources if source.seen >= _SEEN * max(source.seen for source in sources)]
    size = np.max([sizes(source.noises) for source in seeing], axis=0)
    own = [source.cutoff(stamps) for source in seeing]
    errors = [common_error(source.noises, size, f) for source, f in zip(seeing, own, strict=True)]
    place = int(np.argmin(errors))
    cutoff = own[place]
    if highest_cutoff(stamps) < HIGHEST:
        _warn_of_missed(seeing[place], size, stamps)
    told = "which makes the least expected error of the accelerations"
    if cutoff >= highest_cutoff(stamps) * 0.999:
        why = (
            f"a share of {HIGHEST_SHARE:g} of the readings per second"
            if cutoff < HIGHEST * 0.999
            else "above it arms are not rigid"
        )
        told = f"the highest that the rule takes: {why}"
    return seeing[place], np.full(n, cutoff), told


def _warn_of_missed(source: Source, size: FloatArray, stamps: Stamps) -> None:
    missed = np.array([noise.missed for noise in source.noises])
    joints = (np.flatnonzero(missed > np.maximum(_MISSED * size, _AT_REST)) + 1).tolist()
    if joints:
        who = f"{named_joints(joints, len(size))} of the log accelerate{'s' * (len(joints) == 1)}"
        rate = f"{figures(1 / stamps.step)} readings per second"
        warnings.warn(
            f"{who} at frequencies above {figures(highest_cutoff(stamps))} Hz, for which {rate} are too few: "
            "the accelerations lack that; log faster",
            GdAnalyzeWarning,
            stacklevel=5,
        )


def _given(cutoff: float | tuple[float, ...], n: int, stamps: Stamps) -> FloatArray:
    given = np.full(n, cutoff) if isinstance(cutoff, float | int) else np.array(cutoff, dtype=float)
    if given.shape != (n,):
        raise TrajectoryError(
            "the cut-offs are not one for all joints, or one each",
            where="--cutoff",
            expected=f"1 or {n} numbers",
            found=str(given.size),
        )
    most = _LARGEST_SHARE / stamps.step
    if given.max() > most:
        raise TrajectoryError(
            "the cut-off is too high for so few readings",
            where="--cutoff",
            expected=f"up to {figures(most)} Hz, a quarter of {figures(1 / stamps.step)} readings per second",
            found=f"{figures(float(given.max()))} Hz",
            next_step="give a lower one, or none: a rule chooses one then",
        )
    return given
