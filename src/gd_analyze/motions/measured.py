"""Torques recorded with a motion, and where a joint moves steadily enough to compare them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory

# A joint below this share of its largest velocity does not slip yet: teeth and bearings stick and creep,
# so that friction grows with velocity before it is Coulomb friction. B. Armstrong-Helouvry, P. Dupont,
# C. Canudas de Wit, A survey of models, analysis tools and compensation methods for the control of machines
# with friction, Automatica 30 (1994).
CREEPING_SHARE = 0.05

# Noise determines the sign of a velocity beyond this many of its standard deviations in one of 1000
# readings.
_NOISE_SIGMAS = 3.0


def require_torques(motion: Trajectory) -> None:
    """Check that torques were recorded with a motion."""
    if not has_torques(motion):
        raise UsageError(
            "there are no measured torques to compare with",
            where=f"trajectory {motion.name}",
            expected="a recording with a torque of every joint",
            found="a plan" if motion.recording is None else "a recording without torques",
            next_step="give a log with columns of measured torques",
        )


def has_torques(motion: Trajectory | None) -> bool:
    """Whether torques were recorded with a motion."""
    return motion is not None and motion.recording is not None and motion.recording.torque is not None


def filtered_torque(motion: Trajectory) -> FloatArray:
    """Measured torques after the filter of the motion, (N, n)."""
    recording = motion.recording
    assert recording is not None  # callers check this
    torque = recording.torque if recording.torque_filtered is None else recording.torque_filtered
    assert torque is not None
    return torque


def fastest_of(motions: Sequence[Trajectory]) -> FloatArray:
    """Largest velocity of every joint along some motions, (n,)."""
    return np.asarray(np.max([np.abs(motion.extremes[1]).max(axis=0) for motion in motions], axis=0))


def directions(motion: Trajectory, fastest: FloatArray | None = None) -> NDArray[np.int8]:
    """1 where a joint moves forwards, -1 backwards, 0 where it hardly moves, (N, n).

    `fastest` are the joints' largest velocities, by default along this motion.
    """
    recording = motion.recording
    assert recording is not None  # callers check this
    # Noise of spectrum S gives positions, velocities and accelerations variances that sum S, w^2 S and w^4 S
    # over frequencies w; by Cauchy-Schwarz that of the velocity is at most the root of the product of the
    # other two, for any filter.
    noise = np.sqrt(recording.noise_q * recording.noise_qdd)
    fastest = fastest_of([motion]) if fastest is None else fastest
    still = np.maximum(_NOISE_SIGMAS * np.nan_to_num(noise), CREEPING_SHARE * fastest)
    return (motion.qd > still).astype(np.int8) - (motion.qd < -still)


def settled(motion: Trajectory) -> Array:
    """Set points away from the ends of stretches, where the filter has settled, (N,); all if none is."""
    wait, inside = _settling(motion), np.ones(motion.n_set_points, dtype=bool)
    for stretch in motion.stretches:
        time = motion.time[stretch]
        inside[stretch] = (time - time[0] >= wait) & (time[-1] - time >= wait)
    return inside if inside.any() else ~inside


def far_from_jumps(motion: Trajectory, sign: Array) -> Array:
    """Set points far enough from changes of direction that the jump of friction has settled, (N,)."""
    time, wait = motion.time, _settling(motion)
    after = np.flatnonzero(np.diff(sign))
    jumps = np.concatenate([[-np.inf], (time[after] + time[after + 1]) / 2.0, [np.inf]])
    following = np.searchsorted(jumps, time)
    return np.asarray(np.minimum(time - jumps[following - 1], jumps[following] - time) >= wait)


# A zero-phase low-pass spreads a jump over half a period of its cut-off, where a Butterworth filter leaves
# some hundredths of it.
_SETTLING_PERIODS = 0.5


def _settling(motion: Trajectory) -> float:
    """Settling time of the torques' filter, the fastest of all joints, s; 0 without a filter."""
    recording = motion.recording
    if recording is None or recording.cutoff is None:
        return 0.0
    cutoffs = recording.cutoff[np.isfinite(recording.cutoff) & (recording.cutoff > 0.0)]
    return _SETTLING_PERIODS / float(cutoffs.max()) if len(cutoffs) else 0.0
