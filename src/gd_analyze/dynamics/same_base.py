"""Two files of one robot brought together: the motion of the second base with which the joints' axes meet.

Files of one robot differ in base frame, in link frames, in the sense in which joints count, and in where they
count from. The joints' axes are lines in space, whatever the frames are.
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
# Where joints may count from, rad, beside where those of the other file do.
_QUARTERS = (0.0, np.pi / 2, -np.pi / 2, np.pi)
# Candidates that are kept from joint to joint.
_KEPT = 32
# Angles in rad, and distances in units of the arm's reach, up to which axes meet.
_MEET = 1e-5
# Other senses and zeros are taken where no axes meet exactly if they miss by less than this share.
_MUCH_BETTER = 0.1
# Distances in units of the reach, and shares of inertias, up to which links are alike.
_ALIKE = 1e-4
# Share of gravity, or of the link before, among the directions: it counts where the axes do not tell a turn.
_LITTLE = 1e-4
# Sine of the angle between axes that are parallel.
_PARALLEL = 1e-6


@dataclass(frozen=True, eq=False)
class SameBase:
    """How the second arm lies in the first one's base frame; its joints are at signs q + zeros.

    Parameters
    ----------
    first, second
        The arms, with the same kinds of joints.
    ours, theirs
        The arms with q = 0, each in its base frame.
    rotations, translations
        For each link: from the second base frame to the first, m, (n, 3, 3) and (n, 3). They differ from link
        to link where the axes do not meet.
    signs
        -1 for joints that count the other way in the second arm, shape (n,).
    zeros
        Joint variables of the second arm where those of the first are 0: multiples of a right angle, (n,).
    turned, apart
        Angle between the two axes of each joint, rad, and their distance, m (0 for prismatic joints), seen
        from the link before, shape (n,) each.
    """

    first: RobotArm
    second: RobotArm
    ours: Kinematics
    theirs: Kinematics
    rotations: FloatArray
    translations: FloatArray
    signs: FloatArray
    zeros: FloatArray
    turned: FloatArray
    apart: FloatArray

    @classmethod
    def of(cls, first: RobotArm, second: RobotArm) -> SameBase:
        """Fit the motion of the base, for the senses and zeros of joints with which the axes meet best.

        Of several that do equally well, such as in a wrist whose axes meet in a point, those with which the
        arms differ least.
        """
        zeros = np.zeros(first.n_joints)
        plain = min((_fit(first, second, signs, zeros) for signs in _senses(first.n_joints)), key=_ranked)
        if plain.off <= _MEET and not plain.differing:
            return plain
        fits = [plain, *_joint_by_joint(first, second)]
        meeting = [fit for fit in fits if fit.off <= _MEET]
        if meeting:
            return min(meeting, key=lambda fit: (fit.differing, *_ranked(fit)[1:]))
        best = min(fits, key=_ranked)
        return _link_by_link(best if best.off < _MUCH_BETTER * plain.off else plain)

    @property
    def off(self) -> float:
        """How far the axes are from meeting: sum of angles, and of distances in units of the reach."""
        return float((self.turned + self.apart / _reach(self.first, self.second)).sum())

    @property
    def differing(self) -> int:
        """In how many links the arms differ, and in gravity."""
        change = float(np.linalg.norm(self.gravity - self.first.gravity_vector))
        is_other_gravity = change > _ALIKE * float(np.linalg.norm(self.first.gravity_vector))
        return sum(map(self._is_apart, range(self.first.n_joints))) + is_other_gravity

    def _is_apart(self, index: int) -> bool:
        ours, theirs = self.first.links[index], self.link(index)
        distance = float(np.linalg.norm(ours.com - theirs.com))
        size = max(np.abs(ours.inertia_com).max(), np.abs(theirs.inertia_com).max())
        change = np.abs(ours.inertia_com - theirs.inertia_com).max()
        return bool(distance > _ALIKE * _reach(self.first, self.second) or change > _ALIKE * size)

    @property
    def reversed(self) -> SameBase:
        """How the first arm lies in the second one's base frame."""
        return replace(
            self,
            first=self.second,
            second=self.first,
            ours=self.theirs,
            theirs=self.ours,
            rotations=np.swapaxes(self.rotations, 1, 2),
            translations=-np.einsum("iba,ib->ia", self.rotations, self.translations),
        )

    @property
    def gravity(self) -> FloatArray:
        """Gravity of the second arm in the first one's base frame, m/s^2."""
        turned: FloatArray = self.rotations[0] @ self.second.gravity_vector
        return turned

    def link(self, index: int) -> Link:
        """The first arm's link with mass, centre and inertia of the second one's, in its own frame."""
        into_link = self.ours.link_rotations[index, :, :, 0].T
        rotation, translation = self.rotations[index], self.translations[index]
        turn = into_link @ rotation @ self.theirs.link_rotations[index, :, :, 0]
        origin = rotation @ self.theirs.link_origins[index, :, 0] + translation
        source = self.second.links[index]
        return replace(
            self.first.links[index],
            mass=source.mass,
            com=turn @ source.com + into_link @ (origin - self.ours.link_origins[index, :, 0]),
            inertia_com=turn @ source.inertia_com @ turn.T,
        )


def _ranked(base: SameBase) -> tuple[float, int]:
    """The best first; of equals the one with fewer changes."""
    return round(base.off, 9), int((base.signs < 0).sum() + np.count_nonzero(base.zeros))


def _reach(first: RobotArm, second: RobotArm) -> float:
    return max(first.reach, second.reach) or 1.0


def _senses(n: int) -> Iterator[FloatArray]:
    """Senses of the joints to try, all alike first."""
    if n <= _MOST_COMBINED:
        yield from (np.array(signs) for signs in product((1.0, -1.0), repeat=n))
        return
    yield np.ones(n)
    yield from (np.where(np.arange(n) == i, -1.0, 1.0) for i in range(n))


def _joint_by_joint(first: RobotArm, second: RobotArm) -> list[SameBase]:
    """Candidates for senses and zeros, chosen joint by joint, each by the axes up to the next joint's.

    How the first joint's zero and the base's turn about its axis share an angle is not told: the base has it.
    """
    n = first.n_joints
    kept = [(np.array([sign] + [1.0] * (n - 1)), np.zeros(n)) for sign in (1.0, -1.0)]
    for joint in range(1, n):
        turns = first.is_revolute[joint - 1] and joint > 1
        tried = []
        for (signs, zeros), sign, quarter in product(kept, (1.0, -1.0), _QUARTERS if turns else (0.0,)):
            new_signs, new_zeros = signs.copy(), zeros.copy()
            new_signs[joint], new_zeros[joint - 1] = sign, quarter
            tried.append(_fit(first, second, new_signs, new_zeros, slice(joint + 1)))
        kept = [(fit.signs, fit.zeros) for fit in sorted(tried, key=_ranked)[:_KEPT]]
    # No axis tells the last joint's zero.
    last = _QUARTERS if first.is_revolute[-1] else (0.0,)
    return [
        _fit(first, second, signs, np.append(zeros[:-1], quarter))
        for signs, zeros in kept
        for quarter in last
    ]


def _link_by_link(base: SameBase) -> SameBase:
    """Let the axes of as many joints as possible meet, then those of the next ones, and so on.

    Where the axes of a link differ, what is behind it is brought together anew, moved as little as possible.
    """
    n = base.first.n_joints
    rotations, translations, turned, apart = (np.zeros((n, *shape)) for shape in ((3, 3), (3,), (), ()))
    start, before = 0, None
    while start < n:
        if before is not None:
            turned[start], apart[start] = _misses(base, before, start)
        fits = [
            _fit(base.first, base.second, base.signs, base.zeros, slice(start, end), before)
            for end in range(start + 1, n + 1)
        ]
        meeting = [end for end, fit in enumerate(fits, start=start + 1) if fit.off <= _MEET]
        end = max(meeting, default=start + 1)
        before = fits[end - start - 1]
        rotations[start:end], translations[start:end] = before.rotations[0], before.translations[0]
        start = end
    return replace(base, rotations=rotations, translations=translations, turned=turned, apart=apart)


def _misses(base: SameBase, before: SameBase, joint: int) -> tuple[float, float]:
    """Angle and distance between the axes of a joint, brought together as the link before."""
    ours, theirs = base.ours, base.theirs
    rotation, translation = before.rotations[0], before.translations[0]
    axis = ours.joint_axes[joint, :, 0]
    other = base.signs[joint] * (rotation @ theirs.joint_axes[joint, :, 0])
    way = rotation @ theirs.joint_origins[joint, :, 0] + translation - ours.joint_origins[joint, :, 0]
    normal = np.cross(axis, other)
    size = float(np.linalg.norm(normal))
    distance = np.linalg.norm(np.cross(way, axis)) if size < _PARALLEL else abs(way @ normal) / size
    turned = float(np.arctan2(size, axis @ other))
    return turned, float(distance) if base.first.is_revolute[joint] else 0.0


def _fit(
    first: RobotArm,
    second: RobotArm,
    signs: FloatArray,
    zeros: FloatArray,
    some: slice = slice(None),
    before: SameBase | None = None,
) -> SameBase:
    """Fit by least squares, by some joints' axes: first the directions of and between them, then places.

    What these do not tell is as for the link before, or else as gravity is.
    """
    reach = _reach(first, second)
    revolute = np.array(first.is_revolute)[some]
    ours = solve_kinematics(first, np.zeros((first.n_joints, 1)))
    theirs = solve_kinematics(second, zeros[:, None])
    our_axes, our_points = ours.joint_axes[some, :, 0], ours.joint_origins[some, :, 0]
    their_axes = signs[some, None] * theirs.joint_axes[some, :, 0]
    their_points = theirs.joint_origins[some, :, 0]
    pairs = list(zip(our_axes, their_axes, strict=True))
    ways = (_ways(our_axes, our_points, revolute), _ways(their_axes, their_points, revolute))
    pairs += [(a / reach, b / reach) for a, b in zip(*ways, strict=True)]
    if before is None:
        gravities = [
            arm.gravity_vector / (np.linalg.norm(arm.gravity_vector) or 1.0) for arm in (first, second)
        ]
        pairs.append((_LITTLE * gravities[0], gravities[1]))
    else:
        pairs += list(zip(_LITTLE * before.rotations[0].T, np.eye(3), strict=True))
    left, _, right = np.linalg.svd(sum(np.outer(a, b) for a, b in pairs))
    rotation = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    near = np.zeros(3)
    if before is not None:
        near = (before.rotations[0] - rotation) @ their_points[0] + before.translations[0]
    across = np.eye(3) - our_axes[:, :, None] * our_axes[:, None, :]
    across = across * revolute[:, None, None]
    missing = np.einsum("iab,ib->ia", across, our_points - their_points @ rotation.T - near)
    moved = np.linalg.lstsq(across.reshape(-1, 3), missing.reshape(-1), rcond=1e-9)[0]
    turned_axes = their_axes @ rotation.T
    sines = np.linalg.norm(np.cross(our_axes, turned_axes), axis=1)
    return SameBase(
        first,
        second,
        ours,
        theirs,
        np.broadcast_to(rotation, (first.n_joints, 3, 3)),
        np.broadcast_to(near + moved, (first.n_joints, 3)),
        signs,
        zeros,
        turned=np.arctan2(sines, (our_axes * turned_axes).sum(axis=1)),
        apart=np.linalg.norm(missing - across @ moved, axis=1),
    )


def _ways(axes: FloatArray, points: FloatArray, revolute: Sequence[bool] | FloatArray) -> list[FloatArray]:
    """The shortest way from the axis of each revolute joint to that of the next; zero where they meet."""
    ways = []
    for i, j in pairwise(np.flatnonzero(revolute)):
        way, normal = points[j] - points[i], np.cross(axes[i], axes[j])
        is_parallel = np.linalg.norm(normal) < _PARALLEL
        ways.append(
            way - (way @ axes[i]) * axes[i] if is_parallel else (way @ normal) * normal / (normal @ normal)
        )
    return ways
