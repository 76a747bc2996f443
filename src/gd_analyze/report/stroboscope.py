"""A still picture of the motion as inline SVG: what paper, and a screen without WebGL, shows of the arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from gd_analyze.arrays import FloatArray
from gd_analyze.figures.arm import _plain_views as plain_views
from gd_analyze.figures.arm import _turned, skeleton, upright_frame, view_angles
from gd_analyze.report.thinning import breaks, evenly
from gd_analyze.robots.arm import RobotArm

WIDTH, HEIGHT, MARGIN = 640.0, 420.0, 24.0
POSTURES = 6
MOST_PATH_POINTS = 400


def stroboscope(arm: RobotArm, q: FloatArray, gaps: Sequence[int] = ()) -> Markup:
    """Draw some postures from first (faint) to last (strong), and the path of the hand.

    Parameters
    ----------
    arm
        The arm.
    q
        Joint variables along the trajectory, shape (N, n).
    gaps
        Set points before which nothing is known of the motion: the path breaks there.
    """
    postures = skeleton(arm, q[evenly(len(q), POSTURES)])
    places = evenly(len(q), MOST_PATH_POINTS)
    path = skeleton(arm, q[places])[:, -1]
    every = np.concatenate([postures.reshape(-1, 3), path])
    frame = upright_frame(arm)
    plain = plain_views(frame, every)
    # A flat arm is seen head-on.
    flat = (plain[0] if len(plain) == 1 else _turned(*view_angles(None))).project(every)
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = min((np.array([WIDTH, HEIGHT]) - 2 * MARGIN) / np.maximum(high - low, 1e-6))
    placed = (flat - (low + high) / 2) * scale * (1, -1) + (WIDTH / 2, HEIGHT / 2)
    drawn = placed[: -len(path)].reshape(len(postures), -1, 2)
    strengths = np.linspace(1.0, 0.25, len(postures))[::-1]
    lines = [
        Markup('<polyline class="posture" style="opacity:{}" points="{}"/>').format(
            f"{strength:.2f}", _points(line)
        )
        for line, strength in zip(drawn, strengths, strict=True)
    ]
    dots = [Markup('<circle cx="{}" cy="{}" r="4"/>').format(f"{x:.1f}", f"{y:.1f}") for x, y in drawn[-1]]
    return Markup(
        '<svg class="stroboscope" viewBox="0 0 {} {}" role="img" aria-label="{}">{}{}{}</svg>'
    ).format(
        f"{WIDTH:.0f}",
        f"{HEIGHT:.0f}",
        f"{len(postures)} postures of the arm along the trajectory and the path of its hand",
        Markup("").join(
            Markup('<polyline class="path" points="{}"/>').format(_points(part))
            for part in np.split(placed[-len(path) :], breaks(places, gaps))
        ),
        Markup("").join(lines),
        Markup("").join(dots),
    )


def _points(line: FloatArray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in line)
