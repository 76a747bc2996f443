"""Motions of the two-link arm to be taken together: one path, run slowly and fast."""

from __future__ import annotations

import numpy as np

from gd_analyze.motions.trajectory import Trajectory


def swung(duration: float, name: str, count: int = 41) -> Trajectory:
    """Swing both joints to and fro in so many seconds."""
    time = np.linspace(0.0, duration, count)
    rate = 2.0 * np.pi / duration
    size = np.array([0.6, 0.9])
    angle = np.stack([rate * time, rate * time + 0.7], axis=1)
    return Trajectory(
        time,
        0.3 + size * np.sin(angle),
        size * rate * np.cos(angle),
        -size * rate**2 * np.sin(angle),
        name,
        f"made up: {name}",
    )
