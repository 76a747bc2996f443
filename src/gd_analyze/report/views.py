"""Orthographic projections of an arm: lengths along an axis can be compared."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True)
class View:
    """A projection: drawn to the right and upward are the coordinates along two unit vectors."""

    title: str
    right: FloatArray
    up: FloatArray

    def project(self, points: FloatArray) -> FloatArray:
        """Coordinates on paper of points (..., 3), m, shape (..., 2)."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


def upright_frame(arm: RobotArm) -> FloatArray:
    """Unit vectors to draw by, rows: two horizontal ones and up, against gravity (z without gravity)."""
    strength = float(np.linalg.norm(arm.gravity))
    up = -np.asarray(arm.gravity) / strength if strength > 0 else np.array([0.0, 0.0, 1.0])
    first = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = first - (first @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up]) + 0.0


def oblique_view(frame: FloatArray) -> View:
    """Look down on the arm from the front, 25 degrees above the horizon."""
    turn, tilt = np.radians(-52.0), np.radians(24.0)
    right = np.cos(turn + np.pi / 2) * frame[0] + np.sin(turn + np.pi / 2) * frame[1]
    toward = np.cos(turn) * frame[0] + np.sin(turn) * frame[1]
    return View("oblique view", right, np.cos(tilt) * frame[2] - np.sin(tilt) * toward)


def plain_views(frame: FloatArray, points: FloatArray) -> tuple[View, ...]:
    """Views along the frame's axes, largest motion first: two, or one of an arm that stays in a plane."""
    names = {(0, 1): "from above", (0, 2): "from the front", (1, 2): "from the side"}
    across = np.ptp(points.reshape(-1, 3) @ frame.T, axis=0)
    flat = 1e-6 * float(across.max())
    pairs = [pair for pair in combinations(range(3), 2) if min(across[list(pair)]) > flat] or [(0, 2)]
    pairs.sort(key=lambda pair: -across[pair[0]] * across[pair[1]])
    return tuple(View(names[pair], frame[pair[0]], frame[pair[1]]) for pair in pairs[:2])


def flat_normal(points: FloatArray) -> int | None:
    """Axis, of those of `upright_frame`, that an arm never moves along; None for one that fills space."""
    across = np.ptp(points.reshape(-1, 3), axis=0)
    return int(across.argmin()) if across.min() <= 1e-6 * across.max() else None
