"""Rotations about the axes of a frame, exact at right angles."""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray


def exact_cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine with exact zeros and ones at multiples of a right angle.

    cos(pi/2) in floating point is 6e-17, which would turn structural zeros of the dynamics into noise.
    """
    quarter_turns = angle / (math.pi / 2)
    nearest = round(quarter_turns)
    if abs(quarter_turns - nearest) <= 4 * np.finfo(float).eps * max(1.0, abs(quarter_turns)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return math.cos(angle), math.sin(angle)


def about_x(angle: float) -> FloatArray:
    """Rotation about x."""
    c, s = exact_cos_sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_y(angle: float) -> FloatArray:
    """Rotation about y."""
    c, s = exact_cos_sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def about_z(angle: float) -> FloatArray:
    """Rotation about z."""
    c, s = exact_cos_sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Rotation about x, then y, then z, all of the fixed frame, as URDF has it; zeros without a sign."""
    return about_z(yaw) @ about_y(pitch) @ about_x(roll) + 0.0


def angles_of(rotation: FloatArray) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a rotation, rad, to round-off; pitch within a quarter turn."""
    cosine = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], cosine)
    if cosine < 1e-9:  # roll and yaw turn about one axis then
        return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0
    return (
        math.atan2(rotation[2, 1], rotation[2, 2]),
        pitch,
        math.atan2(rotation[1, 0], rotation[0, 0]),
    )
