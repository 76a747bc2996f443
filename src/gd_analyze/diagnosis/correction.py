"""What is done to logs and file before they are compared: what the options of the command line do."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.samples import Samples


@dataclass(frozen=True, eq=False)
class Added:
    """Unknowns beside the file's links: torque per unit of each."""

    columns: FloatArray  # (n joints, N, k)
    sizes: FloatArray  # plausible sizes, (k,)


@dataclass(frozen=True, eq=False)
class Correction:
    """Changes of n joints' logs and of the arm; `Correction.none(n)` changes nothing."""

    torque: FloatArray  # torques at the joints per torque as logged, (n, n)
    position: FloatArray  # joint variables per variable as logged, (n, n)
    offset: FloatArray  # added to them, rad (m), (n,)
    gain: FloatArray | None = None  # torque as logged per torque, by sample, (N, n)
    lag: float = 0.0  # by which torques are late, s
    pace: float = 1.0  # seconds per second as logged; infinite where motion shows in no torque
    gravity: FloatArray | None = None  # in place of the arm's, m/s^2, (3,)
    taken_off: FloatArray | None = None  # a body's ten numbers, less than the file's last link, (10,)
    left_out: Array | None = None  # samples of joints not compared, (N, n)
    added: tuple[Added, ...] = field(default=())
    freedom: float = 1.0  # factor on what a file's links are usually off by

    @classmethod
    def none(cls, n: int) -> Correction:
        """Change nothing."""
        return cls(np.eye(n), np.eye(n), np.zeros(n))

    def with_torque(self, matrix: FloatArray) -> Correction:
        """Torques multiplied, after what is done already."""
        return replace(self, torque=matrix @ self.torque)

    def with_position(self, matrix: FloatArray) -> Correction:
        """Joint variables multiplied, after what is done already."""
        return replace(self, position=matrix @ self.position, offset=matrix @ self.offset)

    def with_offset(self, joint: int, angle: float) -> Correction:
        """A joint's variable increased; joints count from 0."""
        offset = self.offset.copy()
        offset[joint] += angle
        return replace(self, offset=offset)

    def without(self, samples: Array) -> Correction:
        """Samples left out, (N, n)."""
        return replace(self, left_out=samples if self.left_out is None else self.left_out | samples)

    def with_added(self, added: Added) -> Correction:
        """Further unknowns."""
        return replace(self, added=(*self.added, added))

    def at(self, chosen: Array) -> Correction:
        """The same for some of the samples."""
        left_out = None if self.left_out is None else self.left_out[chosen]
        gain = None if self.gain is None else self.gain[chosen]
        added = tuple(Added(unknowns.columns[:, chosen], unknowns.sizes) for unknowns in self.added)
        return replace(self, left_out=left_out, gain=gain, added=added)

    def torques(self, samples: Samples) -> FloatArray:
        """Torques as logged, of one gain throughout; not yet those at the joints, (N, n)."""
        return samples.torque if self.gain is None else samples.torque / self.gain

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
        q, qd, qdd = (samples.q, samples.qd, samples.qdd) if not self.lag else samples.shifted(self.lag)
        slowest = np.where(np.isfinite(samples.slowest), samples.slowest, 0.0) @ np.abs(self.position).T
        q, qd, qdd = q @ self.position.T + self.offset, qd @ self.position.T, qdd @ self.position.T
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
