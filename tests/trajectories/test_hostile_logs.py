"""Logs with whatever numbers: a sound motion, or an error that says what is wrong."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.measured import motion_of
from gd_analyze.motions.treatment import Treatment


def drawn(seed: int) -> tuple[Logged, Treatment | None]:
    """Readings of any number, rate and size; stamps shaken, rounded, torn, shuffled or of a date; holes."""
    rng = np.random.default_rng(seed)
    count, rate = int(rng.choice([1, 2, 16, 17, 40, 100, 400])), 10.0 ** rng.uniform(-3, 5)
    time = np.arange(count) / rate
    changes = [
        lambda t: t + rng.uniform(-1, 1, count) / rate * rng.choice([0.1, 0.6, 3.0]),
        lambda t: np.round(t * rate / 3) * 3 / rate,
        lambda t: np.where(np.arange(count) < count // 2, t, t + 10.0 ** rng.uniform(-2, 9)),
        rng.permutation,
        lambda t: t + 1.7e9,
        lambda t: np.where(np.arange(count) == 0, rng.choice([np.nan, 1e12, -1e12]), t),
        lambda t: np.where(np.arange(count) < count // 2, t + count / rate / 3, t),
    ]
    for change in changes:
        if rng.random() < 0.15:
            time = change(time)
    q = rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-12, 10)
    q = [q, np.cumsum(q, axis=0), np.ones_like(q)][rng.integers(3)]
    if rng.random() < 0.2:
        q[rng.integers(0, count, size=max(count // 20, 1)), 0] = np.nan
    qd, qdd, torque = (rng.normal(size=(count, 2)) if rng.random() < 0.3 else None for _ in range(3))
    if torque is not None:
        torque[rng.random(torque.shape) < 0.3] = np.nan
    cutoff = 10.0 ** rng.uniform(-6, 2) if rng.random() < 0.2 else None
    gap = 10.0 ** rng.uniform(-3, 9) if rng.random() < 0.2 else None
    measured = bool(rng.random() < 0.8)
    return Logged(time, q, qd, qdd, torque, measured), Treatment(cutoff=cutoff, largest_gap=gap)


@pytest.mark.parametrize("first", range(0, 600, 100))
def test_whatever_is_logged_is_a_motion_or_an_error(two_link, first):
    made = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        for seed in range(first, first + 100):
            logged, treatment = drawn(seed)
            try:
                motion = motion_of(logged, two_link, treatment)
            except TrajectoryError:
                continue
            made += 1
            recording = motion.recording
            assert np.isfinite(recording.q).all(), seed
            for noise in (recording.noise_q, recording.noise_qdd):
                assert np.isfinite(noise).all(), seed
                assert (noise >= 0.0).all(), seed
            assert (np.diff(motion.time) > 0).all(), seed
    assert made > 10
