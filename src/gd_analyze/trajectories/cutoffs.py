"""The cut-off of an arm's low-pass: by rule, or as asked for; and from what accelerations come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.errors import TrajectoryError
from gd_analyze.formatting import figures
from gd_analyze.trajectories.noise import HIGHEST, HIGHEST_SHARE, Noise, best_cutoff
from gd_analyze.trajectories.spectrum import Spectrum
from gd_analyze.trajectories.stamps import Stamps
from gd_analyze.trajectories.treatment import Treatment
from gd_analyze.vectors import FloatArray

# Of the readings per second: above it hardly anything is smoothed.
_LARGEST_SHARE = 0.25


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

    def cutoff(self, stamps: Stamps) -> float:
        """Cut-off by which the joints together are best served, Hz."""
        return best_cutoff(self.noises, highest_cutoff(stamps))


def highest_cutoff(stamps: Stamps) -> float:
    """Highest cut-off that the rule chooses, Hz."""
    return min(HIGHEST, HIGHEST_SHARE / stamps.step)


def chosen(sources: Sequence[Source], stamps: Stamps, treatment: Treatment) -> tuple[Source, FloatArray, str]:
    """Choose a source and its cut-offs.

    The rule gives all joints one cut-off, so that they move together and torques can be compared. The source
    is the one that leaves less noise at the higher of the cut-offs that suit each.

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
    own = [source.cutoff(stamps) for source in sources]
    common = np.full(n, max(own))
    noise = [float((source.left(common) ** 2).sum()) for source in sources]
    place = int(np.argmin(noise))
    cutoff = own[place]
    told = "which makes the least expected error of the accelerations"
    if cutoff >= highest_cutoff(stamps) * 0.999:
        why = (
            f"a share of {HIGHEST_SHARE:g} of the readings per second"
            if cutoff < HIGHEST * 0.999
            else "above it arms are not rigid"
        )
        told = f"the highest that the rule takes ({why})"
    return sources[place], np.full(n, cutoff), told


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
