"""A still picture of the motion as inline SVG: what paper, and a screen without WebGL, shows of the arm."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from gd_analyze.report.motion import motion
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import Array, FloatArray

WIDTH, HEIGHT, MARGIN = 640.0, 420.0, 24.0
POSTURES = 6
MOST_PATH_POINTS = 400


def stroboscope(arm: RobotArm, q: FloatArray) -> Markup:
    """Draw some postures from first (faint) to last (strong), and the path of the hand.

    Parameters
    ----------
    arm
        The arm.
    q
        Joint variables along the trajectory, shape (N, n).
    """
    shown = _even(len(q), POSTURES)
    postures = motion(arm, q[shown]).points
    path = motion(arm, q[_even(len(q), MOST_PATH_POINTS)]).hand
    flat = _projected(np.concatenate([postures.reshape(-1, 3), path]), _view(arm, path, postures))
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = min((np.array([WIDTH, HEIGHT]) - 2 * MARGIN) / np.maximum(high - low, 1e-6))
    placed = (flat - (low + high) / 2) * scale * (1, -1) + (WIDTH / 2, HEIGHT / 2)
    drawn = placed[: -len(path)].reshape(len(shown), -1, 2)
    strengths = np.linspace(0.25, 1.0, len(shown)) if len(shown) > 1 else np.ones(1)
    lines = [
        Markup('<polyline class="posture" style="opacity:{}" points="{}"/>').format(
            f"{strength:.2f}", _points(line)
        )
        for line, strength in zip(drawn, strengths, strict=True)
    ]
    dots = [Markup('<circle cx="{}" cy="{}" r="4"/>').format(f"{x:.1f}", f"{y:.1f}") for x, y in drawn[-1]]
    return Markup(
        '<svg class="stroboscope" viewBox="0 0 {} {}" role="img" aria-label="{}">'
        '<polyline class="path" points="{}"/>{}{}</svg>'
    ).format(
        f"{WIDTH:.0f}",
        f"{HEIGHT:.0f}",
        f"{len(shown)} postures of the arm along the trajectory and the path of its hand",
        _points(placed[-len(path) :]),
        Markup("").join(lines),
        Markup("").join(dots),
    )


def _even(count: int, most: int) -> Array:
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def _view(arm: RobotArm, path: FloatArray, postures: FloatArray) -> FloatArray:
    """Right and up directions of the picture, shape (2, 3): oblique, but head-on for a flat arm."""
    up_axis = int(np.abs(arm.gravity).argmax()) if arm.gravity.any() else 2
    up = np.zeros(3)
    up[up_axis] = -1.0 if arm.gravity[up_axis] > 0 else 1.0
    spans = np.ptp(np.concatenate([postures.reshape(-1, 3), path]), axis=0)
    level = [a for a in range(3) if a != up_axis]
    toward = np.zeros(3)
    thin = min(level, key=lambda a: spans[a])
    toward[level] = (1.0, -0.7)
    if spans[thin] < 0.05 * spans.max():
        toward = np.eye(3)[thin]
    else:
        toward += 0.55 * up
    toward /= np.linalg.norm(toward)
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right)])


def _projected(points: FloatArray, view: FloatArray) -> FloatArray:
    flat: FloatArray = points @ view.T
    return flat


def _points(line: FloatArray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in line)
