"""Two files of one robot brought together: the motion of the second base with which the joints' axes meet.

Files of one robot differ in base frame, in link frames and in the sense in which joints count. Where every
joint is at 0, the joints' axes are lines in space, whatever the frames are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.kinematics import Kinematics, solve_kinematics
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Link

# All combinations of senses are tried up to so many joints, of more joints each alone.
_MOST_COMBINED = 8
# Share of gravity among the directions: it counts where the axes do not tell how a base is turned.
_GRAVITY_SHARE = 1e-4
# Sine of the angle between axes that are parallel.
_PARALLEL = 1e-6


@dataclass(frozen=True, eq=False)
class SameBase:
    """How the second arm lies in the first one's base frame, every joint at 0.

    Parameters
    ----------
    first, second
        The arms, with the same kinds of joints.
    rotation, translation
        From the second base frame to the first, m.
    signs
        -1 for joints that count the other way in the second arm, shape (n,).
    turned
        Angle between the two axes of each joint, rad, shape (n,).
    apart
        Distance of the second axis of each joint from the first, m, shape (n,); 0 for prismatic joints.
    """

    first: RobotArm
    second: RobotArm
    rotation: FloatArray
    translation: FloatArray
    signs: FloatArray
    turned: FloatArray
    apart: FloatArray

    @classmethod
    def of(cls, first: RobotArm, second: RobotArm) -> SameBase:
        """Fit the motion of the base, for the senses of the joints with which it fits best."""
        reach = max(first.reach, second.reach) or 1.0
        fits = [_fit(first, second, signs, reach) for signs in _senses(first.n_joints)]
        return min(fits, key=lambda fit: round(float((fit.turned + fit.apart / reach).sum()), 9))

    @property
    def reversed(self) -> SameBase:
        """How the first arm lies in the second one's base frame."""
        rotation = self.rotation.T
        return replace(
            self,
            first=self.second,
            second=self.first,
            rotation=rotation,
            translation=-rotation @ self.translation,
        )

    @property
    def gravity(self) -> FloatArray:
        """Gravity of the second arm in the first one's base frame, m/s^2."""
        turned: FloatArray = self.rotation @ self.second.gravity
        return turned

    def link(self, index: int) -> Link:
        """The first arm's link with mass, centre and inertia of the second one's, in its own frame."""
        ours, theirs = _home(self.first), _home(self.second)
        into_link = ours.link_rotations[index, :, :, 0].T
        turn = into_link @ self.rotation @ theirs.link_rotations[index, :, :, 0]
        origin = self.rotation @ theirs.link_origins[index, :, 0] + self.translation
        source = self.second.links[index]
        return replace(
            self.first.links[index],
            mass=source.mass,
            com=turn @ source.com + into_link @ (origin - ours.link_origins[index, :, 0]),
            inertia_com=turn @ source.inertia_com @ turn.T,
        )


def _home(arm: RobotArm) -> Kinematics:
    return solve_kinematics(arm, np.zeros((arm.n_joints, 1)))


def _senses(n: int) -> Iterator[FloatArray]:
    """Senses of the joints to try, all alike first."""
    if n <= _MOST_COMBINED:
        yield from (np.array(signs) for signs in product((1.0, -1.0), repeat=n))
        return
    yield np.ones(n)
    yield from (np.where(np.arange(n) == i, -1.0, 1.0) for i in range(n))


def _fit(first: RobotArm, second: RobotArm, signs: FloatArray, reach: float) -> SameBase:
    """Fit by least squares: first the directions of the axes and from axis to axis, then their places."""
    revolute = np.array(first.is_revolute)
    ours, theirs = _home(first), _home(second)
    our_axes, our_points = ours.joint_axes[:, :, 0], ours.joint_origins[:, :, 0]
    their_axes, their_points = signs[:, None] * theirs.joint_axes[:, :, 0], theirs.joint_origins[:, :, 0]
    pairs = list(zip(our_axes, their_axes, strict=True))
    ways = (_ways(our_axes, our_points, revolute), _ways(their_axes, their_points, revolute))
    pairs += [(a / reach, b / reach) for a, b in zip(*ways, strict=True)]
    gravities = [arm.gravity / (np.linalg.norm(arm.gravity) or 1.0) for arm in (first, second)]
    pairs.append((_GRAVITY_SHARE * gravities[0], gravities[1]))
    left, _, right = np.linalg.svd(sum(np.outer(a, b) for a, b in pairs))
    rotation = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    across = np.eye(3) - our_axes[:, :, None] * our_axes[:, None, :]
    across = across * revolute[:, None, None]
    missing = np.einsum("iab,ib->ia", across, our_points - their_points @ rotation.T)
    translation = np.linalg.lstsq(across.reshape(-1, 3), missing.reshape(-1), rcond=1e-9)[0]
    turned_axes = their_axes @ rotation.T
    sines = np.linalg.norm(np.cross(our_axes, turned_axes), axis=1)
    return SameBase(
        first,
        second,
        rotation,
        translation,
        signs,
        turned=np.arctan2(sines, (our_axes * turned_axes).sum(axis=1)),
        apart=np.linalg.norm(missing - across @ translation, axis=1),
    )


def _ways(axes: FloatArray, points: FloatArray, revolute: Sequence[bool] | FloatArray) -> list[FloatArray]:
    """The shortest way from the axis of each revolute joint to that of the next; zero where they meet."""
    ways, lines = [], np.flatnonzero(revolute)
    for i, j in pairwise(lines):
        way, normal = points[j] - points[i], np.cross(axes[i], axes[j])
        is_parallel = np.linalg.norm(normal) < _PARALLEL
        ways.append(
            way - (way @ axes[i]) * axes[i] if is_parallel else (way @ normal) * normal / (normal @ normal)
        )
    return ways
