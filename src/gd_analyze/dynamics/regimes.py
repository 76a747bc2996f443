"""Which way a joint moves at the set points of a recording, and where the filter has not settled."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.motions.trajectory import Trajectory

# A zero-phase low-pass spreads a jump over half a period of its cut-off: of a Butterworth filter's step, some
# hundredths are left there.
_SETTLED = 0.5
# Noise decides the sign of a rate beyond so many of its standard deviations in one of a thousand readings.
_SIGMAS = 3.0
# And a joint slower than this part of its fastest is not sliding: teeth and bearings stick and creep first,
# so that friction grows with the rate before it is Coulomb's. B. Armstrong-Helouvry, P. Dupont, C. Canudas
# de Wit, A survey of models, analysis tools and compensation methods for the control of machines with
# friction, Automatica 30 (1994).
_CREEPING = 0.05


def settled(trajectory: Trajectory) -> Array:
    """Set points at which the filter's own start and end are over, (N,); all where none would be left."""
    wait = _settling(trajectory)
    inside = np.ones(trajectory.n_set_points, dtype=bool)
    for stretch in trajectory.stretches:
        time = trajectory.time[stretch]
        inside[stretch] = (time - time[0] >= wait) & (time[-1] - time >= wait)
    return inside if inside.any() else np.ones_like(inside)


def direction(trajectory: Trajectory, joint: int) -> FloatArray:
    """1 where the joint moves forwards, -1 backwards, 0 where it hardly moves, (N,)."""
    rate, recording = trajectory.qd[:, joint], trajectory.recording
    noise = 0.0
    if recording is not None:
        # The spectrum S of noise gives positions, rates and accelerations the variances of S, w^2 S and w^4 S
        # summed over frequencies w, so by Cauchy and Schwarz the rate's is at most the root of the product of
        # the other two, whatever the filter.
        noise = float(np.sqrt(recording.noise_q[joint] * recording.noise_qdd[joint]))
    still = max(_SIGMAS * np.nan_to_num(noise), _CREEPING * float(np.abs(rate).max()))
    return np.where(np.abs(rate) > still, np.sign(rate), 0.0)


def far_from_jumps(trajectory: Trajectory, way: FloatArray) -> Array:
    """Set points far enough from those where the direction changes for friction's jump to be over, (N,)."""
    time, wait = trajectory.time, _settling(trajectory)
    after = np.flatnonzero(np.diff(way) != 0.0)
    jumps = np.concatenate([[-np.inf], (time[after] + time[after + 1]) / 2.0, [np.inf]])
    following = np.searchsorted(jumps, time)
    far = np.minimum(time - jumps[following - 1], jumps[following] - time) >= wait
    return np.asarray(far)


def _settling(trajectory: Trajectory) -> float:
    """Seconds that the torques' filter, the fastest of the joints', needs; none where there is none."""
    recording = trajectory.recording
    if recording is None or recording.cutoff is None:
        return 0.0
    known = recording.cutoff[np.isfinite(recording.cutoff) & (recording.cutoff > 0.0)]
    return _SETTLED / float(known.max()) if len(known) else 0.0
