"""An arm written for recursion: frames on the joints' axes, and link parameters regrouped.

W. Khalil, J.-F. Kleinfinger, Minimum operations and minimum parameters of the dynamic models of tree
structure robots, IEEE Journal of Robotics and Automation RA-3 (1987). Frame i moves with link i; its z axis
is that of a revolute joint. Three freedoms leave torques unchanged and make constants vanish: the rotation of
frames about their z axes, the position of origins along these, and the assignment to links of mass that a
joint does not move. Mass on the axis of a revolute joint, and the second moment of everything that a
prismatic joint carries, act as parts of the link before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from gd_analyze.arrays import Array, FloatArray, homogeneous
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import pseudo_inertia

# Some dozen products and sums of numbers of equal size have less than this relative error.
_ROUND_OFF = 1e-14
# The common normal of axes closer to parallel than this is too far away for an origin.
_LEAST_SINE_BETWEEN_AXES = 1e-3


@dataclass(frozen=True, eq=False)
class RegroupedLink:
    """One link in its own frame i."""

    # Frame i in frame i-1, (3, 3) and, m, (3,), before the joint moves
    rotation: FloatArray
    translation: Array
    # Unit vector along which a prismatic joint moves; None for a revolute joint, about z
    prismatic: FloatArray | None
    # The frame turns by sign * q + offset, rad; the sign is -1 if axes are antiparallel
    sign: int
    offset: float
    # Whether the axes of this joint and the previous revolute one are parallel for every q
    is_parallel: bool
    is_round: bool  # whether it is the last link and a body of revolution, so that its angle does not matter
    # Regrouped m, kg, first moment, kg m, shape (3,), and second moment, kg m^2, shape (3, 3)
    mass: Any
    first: Array
    second: Array

    def turned(self, angle: float) -> FloatArray:
        """Rotation of frame i in frame i-1, (3, 3), after the joint has turned by `angle`."""
        c, s = math.cos(self.offset + self.sign * angle), math.sin(self.offset + self.sign * angle)
        return self.rotation @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class RegroupedArm:
    """An arm's links."""

    # The frame before the first link in the base frame, (3, 3) and, m, (3,)
    rotation: FloatArray
    origin: Array
    gravity: FloatArray  # in that frame, m/s^2, shape (3,)
    links: tuple[RegroupedLink, ...]  # one per joint


@lru_cache(maxsize=8)
def regrouped(arm: RobotArm) -> RegroupedArm:
    """Choose the frames of an arm, and regroup its parameters."""
    n, revolute = arm.n_joints, arm.is_revolute
    axes, points, moments = _at_zero(arm)
    signs, parallel = _aligned(revolute, axes)
    origins = _origins(revolute, axes, points, moments)
    frames = _frames(revolute, axes, origins, arm.gravity_vector)
    rotations, offsets = zip(*(_step(frames[i], frames[i + 1], revolute[i]) for i in range(n)), strict=True)
    from_base = [_moved(moments[i], frames[i + 1].T, -frames[i + 1].T @ origins[i]) for i in range(n)]
    steps = [frames[i].T @ (origins[i] - origins[max(i - 1, 0)]) for i in range(n)]
    steps = [_without_round_off(step, np.array(origins)) for step in steps]
    link_moments = _regrouped(
        revolute, axes, from_base, [frames[i].T @ frames[i + 1] for i in range(n)], steps
    )
    # Whether the last link is a body of revolution about z with its centre there.
    is_round = (
        revolute[-1]
        and not parallel[-1]
        and link_moments[-1].dtype != object
        and not link_moments[-1][3, :3].any()
    )
    if is_round:
        uneven = link_moments[-1][:3, :3] - link_moments[-1][0, 0] * np.diag([1.0, 1.0, 0.0])
        is_round = not _without_round_off(uneven, np.array(moments)[:, :3, :3]).any()
    if is_round:
        link_moments[-1][1, 1] = link_moments[-1][0, 0]
    links = tuple(
        RegroupedLink(
            rotation=rotations[i],
            translation=steps[i],
            prismatic=None if revolute[i] else frames[i + 1].T @ axes[i],
            sign=signs[i],
            offset=offsets[i],
            is_parallel=parallel[i],
            is_round=is_round and i == n - 1,
            mass=link_moments[i][3, 3],
            first=link_moments[i][:3, 3],
            second=link_moments[i][:3, :3],
        )
        for i in range(n)
    )
    return RegroupedArm(frames[0], origins[0], _without_round_off(frames[0].T @ arm.gravity_vector), links)


def _at_zero(arm: RobotArm) -> tuple[list[FloatArray], list[Array], list[Array]]:
    """Axes, points on them, and the links' `pseudo_inertia` in the base frame, with all joints at zero."""
    rotation, origin = np.eye(3), np.zeros(3)
    axes, points, moments = [], [], []
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        before = rotation @ joint.placement.rotation
        axes.append(before @ joint.axis)
        points.append(origin + rotation @ joint.placement.translation)
        rotation, origin = before @ link.frame.rotation, points[-1] + before @ link.frame.translation
        link_moments = pseudo_inertia(arm.mass[i], arm.com[i], arm.inertia_com[i])
        moments.append(_moved(link_moments, rotation, origin))
    return axes, points, moments


def _aligned(revolute: Sequence[bool], axes: list[FloatArray]) -> tuple[list[int], list[bool]]:
    """Make parallel axes equal to the last bit; signs of the joints, and which continue a turn."""
    signs, parallel, before = [], [], None
    for i, axis in enumerate(axes):
        parallel.append(before is not None and revolute[i] and _are_parallel(before, axis))
        signs.append(1)
        if before is not None and parallel[i]:
            signs[i] = -1 if before @ axis < 0.0 else 1
            axes[i] = before
        before = axes[i] if revolute[i] else before
    return signs, parallel


def _origins(
    revolute: Sequence[bool], axes: Sequence[FloatArray], points: Sequence[Array], moments: Sequence[Array]
) -> list[Array]:
    """Origins from which the next lies perpendicular to the axis; a prismatic joint takes the next origin."""
    last = len(axes) - 1
    origins: list[Array] = [points[last]]
    mass = moments[last][3, 3]
    if not revolute[last]:
        origins[0] = moments[last][:3, 3] / mass if isinstance(mass, float) and mass > 0.0 else points[last]
    elif last and revolute[last - 1]:
        # Nearest to the previous axis; the given point if the two are nearly parallel.
        normal = np.cross(axes[last], axes[last - 1])
        if np.linalg.norm(normal) >= _LEAST_SINE_BETWEEN_AXES:
            across = np.cross(points[last - 1] - points[last], axes[last - 1])
            origins[0] = points[last] + axes[last] * (across @ normal / (normal @ normal))
    for i in reversed(range(last)):
        beyond = origins[0]
        along = axes[i] * ((beyond - points[i]) @ axes[i])
        origins.insert(0, points[i] + along if revolute[i] else beyond)
    return origins


def _frames(
    revolute: Sequence[bool], axes: Sequence[FloatArray], origins: Sequence[Array], gravity: Array
) -> list[FloatArray]:
    """Base from every frame, including the first; x is perpendicular to this axis and the next, if any."""
    revolute_joints = [i for i, turns in enumerate(revolute) if turns]
    first = axes[revolute_joints[0]] if revolute_joints else np.array([0.0, 0.0, 1.0])
    frames = [_with_z(first, gravity, np.eye(3)[0])]
    for i, axis in enumerate(axes):
        beyond = [axes[k] for k in revolute_joints if k > i]
        if not revolute[i]:
            frames.append(frames[-1])
        elif not beyond:
            # Without a turn: the shortest rotation from the previous axis.
            frames.append(_with_z(axis, frames[-1][:, 0], frames[-1][:, 1]))
        elif _are_parallel(axis, beyond[0]):
            frames.append(_with_z(axis, origins[min(i + 1, len(axes) - 1)] - origins[i], frames[-1][:, 0]))
        else:
            frames.append(_with_z(axis, np.cross(axis, beyond[0]), frames[-1][:, 0]))
    return frames


def _with_z(axis: FloatArray, *towards: Array) -> FloatArray:
    """Frame about an axis with x as near as possible to the first vector that defines a direction."""
    for vector in (*towards, *np.eye(3)):
        if vector.dtype != object:
            x = vector - axis * (axis @ vector)
            size = np.linalg.norm(x)
            if size > _LEAST_SINE_BETWEEN_AXES * np.linalg.norm(vector):
                x = x / size
                return np.column_stack([x, np.cross(axis, x), axis])
    raise AssertionError("one of three unit vectors is not along the axis")


def _step(before: FloatArray, frame: FloatArray, revolute: bool) -> tuple[FloatArray, float]:
    """Rotation from frame to frame, and its part about the second frame's z axis, rad."""
    rotation = _without_round_off(before.T @ frame)
    x, y, z = rotation[:, 2]
    if not revolute or x != 0.0:
        return rotation, 0.0
    across = np.array([[1.0, 0.0, 0.0], [0.0, z, y], [0.0, -y, z]])
    turned = _without_round_off(across.T @ rotation)
    return across, math.atan2(turned[1, 0], turned[0, 0])


def _regrouped(
    revolute: Sequence[bool],
    axes: Sequence[FloatArray],
    moments: Sequence[Array],
    rotations: Sequence[FloatArray],
    steps: Sequence[Array],
) -> list[Array]:
    """Moments of every link in its frame; what its joint does not move is added to the previous link."""
    link_moments, original = list(moments), np.array(moments)
    blocks = (np.s_[:3, :3], np.s_[:3, 3], np.s_[3, :3], np.s_[3, 3])
    for i in reversed(range(len(link_moments))):
        fixed = np.zeros((4, 4), dtype=bool)
        fixed[2:, 2:] = revolute[i]
        if not revolute[i]:
            fixed[:3, :3] = True
            before = [axes[k] for k in range(i) if revolute[k]]
            # While all joints so far turn about one direction, z, mass distribution along it does not matter,
            # nor does mass that moves along it.
            if all(_are_parallel(before[0], axis) for axis in before):
                fixed[2, 3] = fixed[3, 2] = True
                fixed[:3, 3] |= not before or _are_parallel(before[0], axes[i])
                fixed[3, :3] = fixed[:3, 3]
        fixed_moments = np.where(fixed, link_moments[i], 0.0)
        link_moments[i] = np.where(fixed, 0.0, link_moments[i])
        for block in blocks if link_moments[i].dtype != object else ():
            link_moments[i][block] = _without_round_off(link_moments[i][block], original[:, *block])
        if i:
            link_moments[i - 1] = link_moments[i - 1] + _moved(fixed_moments, rotations[i], steps[i])
    revolute_joints = [i for i, turns in enumerate(revolute) if turns]
    for i in revolute_joints:
        if not _are_parallel(axes[revolute_joints[0]], axes[i]):
            break
        # So far all joints turn about one direction, and only the inertia about it matters.
        about = link_moments[i][0, 0] + link_moments[i][1, 1]
        link_moments[i][:3, :3] = 0.0
        link_moments[i][0, 0] = about
    return link_moments


def _moved(moments: Array, rotation: Array, translation: Array) -> Array:
    """Moments in the frame where the given one has this rotation and translation."""
    motion = homogeneous(rotation, translation)
    moved: Array = motion @ moments @ motion.T
    return moved


def _are_parallel(first: FloatArray, second: FloatArray) -> bool:
    return float(np.abs(np.cross(first, second)).max()) <= _ROUND_OFF


def _without_round_off(values: Array, beside: Array | None = None) -> Array:
    """Set values to zero that are round-off relative to `beside`, or to 1 if not given."""
    if values.dtype == object:
        return values
    size = 1.0 if beside is None else float(np.abs(beside).max())
    return np.where(np.abs(values) <= _ROUND_OFF * size, 0.0, values)
