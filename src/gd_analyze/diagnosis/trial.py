"""What is tried on logs and file before they are compared: corrections, and what no option does."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.samples import Samples
from gd_analyze.motions.correction import Correction


@dataclass(frozen=True, eq=False)
class Added:
    """Unknowns beside the file's links: torque per unit of each."""

    columns: FloatArray  # (n joints, N, k)
    sizes: FloatArray  # plausible sizes, (k,)


@dataclass(frozen=True, eq=False)
class Trial(Correction):
    """Changes of n joints' logs and of the arm; `Trial.none(n)` changes nothing."""

    gain: FloatArray | None = None  # torque as logged per torque, by sample, (N, n)
    pace: float = 1.0  # seconds per second as logged; infinite where motion shows in no torque
    gravity: FloatArray | None = None  # in place of the arm's, m/s^2, (3,)
    taken_off: FloatArray | None = None  # a body's ten numbers, less than the file's last link, (10,)
    left_out: Array | None = None  # samples of joints not compared, (N, n)
    added: tuple[Added, ...] = field(default=())
    freedom: float = 1.0  # factor on what a file's links are usually off by

    def without(self, samples: Array) -> Self:
        """Samples left out, (N, n)."""
        return replace(self, left_out=samples if self.left_out is None else self.left_out | samples)

    def with_added(self, added: Added) -> Self:
        """Further unknowns."""
        return replace(self, added=(*self.added, added))

    def at(self, chosen: Array | slice) -> Self:
        """The same for some of the samples."""
        left_out = None if self.left_out is None else self.left_out[chosen]
        gain = None if self.gain is None else self.gain[chosen]
        added = tuple(Added(unknowns.columns[:, chosen], unknowns.sizes) for unknowns in self.added)
        return replace(self, left_out=left_out, gain=gain, added=added)

    def steady(self, torque: FloatArray) -> FloatArray:
        """Torques as logged, of one gain throughout, (N, n)."""
        return torque if self.gain is None else torque / self.gain

    @property
    def changes_torques(self) -> bool:
        """Whether torques are multiplied."""
        return not np.array_equal(self.torque, np.eye(len(self.torque)))

    @property
    def mixes(self) -> bool:
        """Whether a joint variable is made of several, or of other instants: other samples may rest."""
        return self.lag != 0.0 or bool((np.count_nonzero(self.position, axis=1) > 1).any())

    def states(self, samples: Samples) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Joint variables, velocities, accelerations and directions of motion, (N, n) each."""
        # Interpolated torques would have less noise: the states are taken as much earlier.
        q, qd, qdd = samples.shifted(self.lag) if self.lag else (samples.q, samples.qd, samples.qdd)
        q, qd, qdd = self.of_positions(q), self.of_velocities(qd), self.of_velocities(qdd)
        slowest = np.where(np.isfinite(samples.slowest), samples.slowest, 0.0) @ np.abs(self.position).T
        # `slowest` is the velocity of a sample that counts; its last digits may round either way.
        direction = np.where(np.abs(qd) >= (1.0 - 1e-9) * slowest, np.sign(qd), 0.0)
        return q, qd / self.pace, qdd / self.pace**2, direction

    def counts(self, samples: Samples, direction: FloatArray) -> Array:
        """Samples of joints that are compared, (N, n)."""
        is_usable = samples.counts
        if (np.count_nonzero(self.position, axis=1) == 1).all():
            is_usable = is_usable[:, np.abs(self.position).argmax(axis=1)]
        counts = is_usable & (direction != 0.0)
        return counts if self.left_out is None else counts & ~self.left_out

    @property
    def key(self) -> tuple[object, ...]:
        """What the equations depend on: all but the matrix of torques."""
        arrays = (self.position, self.offset, self.gain, self.gravity, self.taken_off, self.left_out)
        parts = [None if array is None else array.tobytes() for array in arrays]
        return (*parts, self.lag, self.pace, *self.added)
