"""The Newton-Euler recursion (RNEA) with regrouped link parameters: the fewest operations of all.

As in link frames, but frames are on the joints' axes, and parameters that act like those of the previous link
are moved there, see `regrouped_links`: a revolute joint keeps neither mass nor first moment along its axis.
Motion enters through one matrix A, where A r is the acceleration of point r relative to the origin, and
torque through the skew part of A P, with P the second moment. Links of parallel axes take their angular
velocity from the frame before the first of them, at the sum of their angles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import Array, FloatArray, apply, cross, dot, times_constant
from gd_analyze.dynamics.regrouped_links import RegroupedArm, RegroupedLink, regrouped
from gd_analyze.robots.arm import RobotArm

# A quarter turn, rad.
_QUARTER_TURN = 0.5 * math.pi
# An offset within this of quarter turns is exact quarter turns, rad.
_ROUND_OFF = 1e-14


def torque(arm: RobotArm, q: Array, qd: Array, qdd: Array, *, gravity: bool = True) -> Array:
    """Generalized torque by Newton-Euler, shape (n, N). Khalil and Kleinfinger 1987."""
    return torque_of_links(regrouped(arm), q, qd, qdd, gravity=gravity)


def torque_of_links(
    rewritten: RegroupedArm, q: Array, qd: Array, qdd: Array, *, gravity: bool = True
) -> Array:
    """Generalized torque of regrouped links, shape (n, N)."""
    start = np.broadcast_to(-int(gravity) * rewritten.gravity[:, None], (3, qd.shape[1]))
    motions = list(_motions(rewritten, start, (q, qd, qdd)))
    out = np.empty((len(motions), qd.shape[1]), np.result_type(qd, motions[-1].acceleration))
    force = moment = np.zeros((3, 1))
    for i, link in reversed(list(enumerate(rewritten.links))):
        turn, spin, lever, acceleration, field = motions[i]
        first = link.first[:, None]
        moved = times_constant(field, link.second)
        force = force + apply(field, first)
        moment = moment + cross(first, acceleration)
        turning = [moved[b, a] - moved[a, b] for a, b in ((1, 2), (2, 0), (0, 1))]
        if link.is_round:  # equal, without products of velocities that cancel
            turning[2] = 2.0 * link.second[0, 0] * spin.omega_dot[2]
        moment = moment + np.stack(turning)
        if link.prismatic is None:
            out[i] = moment[2] if link.sign > 0 else -moment[2]
        else:
            force = force + link.mass * acceleration
            out[i] = dot(np.broadcast_to(link.prismatic[:, None], force.shape), force)
        force, moment = turn.turned_back(force), turn.turned_back(moment)
        force, moment = turn.back_across(force), turn.back_across(moment)
        moment = moment + cross(lever, force)
    return out


def _motions(arm: RegroupedArm, start: Array, state: tuple[Array, ...]) -> Iterator[_Motion]:
    """Motion of every link, from the acceleration of the base on."""
    spin, run = _Spin(np.zeros_like(start), np.zeros_like(start)), None
    acceleration, field = start, np.zeros((3, *start.shape))
    for link, q, qd, qdd in zip(arm.links, *state, strict=True):
        lever = link.translation[:, None]
        if link.prismatic is None:
            joint_run = _Run.starting(link, spin, q, qd, qdd)
            run = run.joined(joint_run) if run and link.is_parallel else joint_run
            turn, spin = joint_run.turn(link), run.spin(link)
        else:
            turn, lever = _Turn(link.rotation), lever + link.prismatic[:, None] * q
        acceleration = acceleration + apply(field, lever)
        across = turn.across(acceleration)
        acceleration = turn.turned(across)
        if link.prismatic is not None:
            axis = link.prismatic[:, None]
            acceleration = acceleration + axis * qdd + 2.0 * cross(spin.omega, axis * qd)
        field = spin.field()
        yield _Motion(turn, spin, lever, acceleration, field)


class _Motion(NamedTuple):
    """Step from the frame before: origin in it, that origin's acceleration, and the matrix A."""

    turn: _Turn
    spin: _Spin
    lever: Array
    acceleration: Array
    field: Array


@dataclass(frozen=True)
class _Turn:
    """From frame i-1 to frame i: a constant rotation, then a turn about z if there is one."""

    rotation: FloatArray
    about_z: tuple[Array, Array] | None = None  # cosine and sine

    def across(self, vector: Array) -> Array:
        """Express a vector of frame i-1 in frame i before it turns."""
        return np.asarray(np.einsum("ba,bn->an", self.rotation, vector))

    def turned(self, vector: Array) -> Array:
        """Express a vector of frame i before it turns in frame i."""
        if self.about_z is None:
            return vector
        (cos, sin), (x, y, z) = self.about_z, vector
        return np.stack([cos * x + sin * y, cos * y - sin * x, z])

    def turned_back(self, vector: Array) -> Array:
        """Express a vector of frame i in frame i before it turns."""
        if self.about_z is None:
            return vector
        (cos, sin), (x, y, z) = self.about_z, vector
        return np.stack([cos * x - sin * y, sin * x + cos * y, z + 0.0 * x])

    def back_across(self, vector: Array) -> Array:
        """Express a vector of frame i before it turns in frame i-1."""
        return np.asarray(np.einsum("ab,bn->an", self.rotation, vector))


@dataclass(frozen=True)
class _Spin:
    """Angular velocity and acceleration of a link, in its frame, (3, N)."""

    omega: Array
    omega_dot: Array

    def field(self) -> Array:
        """Matrix A of the accelerations of its points, (3, 3, N): omega_dot x and omega x omega x."""
        x, y, z = self.omega
        x_dot, y_dot, z_dot = self.omega_dot
        xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
        return np.stack(
            [
                np.stack([-(yy + zz), xy - z_dot, xz + y_dot]),
                np.stack([xy + z_dot, -(xx + zz), yz - x_dot]),
                np.stack([xz - y_dot, yz + x_dot, -(xx + yy)]),
            ]
        )


@dataclass(frozen=True)
class _Run:
    """Joints with parallel axes: their combined turn, from the frame before them.

    Prismatic joints among them do not turn, and keep the orientation of the frame before.
    """

    before: _Spin  # how the link before them moves
    rotation: FloatArray  # of the first one
    # Sums over the joints so far
    angle: Array
    offset: float
    velocity: Array
    acceleration: Array

    @classmethod
    def starting(cls, link: RegroupedLink, before: _Spin, *state: Array) -> _Run:
        """Start with one joint."""
        q, qd, qdd = state if link.sign > 0 else (-x for x in state)
        return cls(before, link.rotation, q, link.offset, qd, qdd)

    def joined(self, joint_run: _Run) -> _Run:
        """Add a joint."""
        names = ("angle", "offset", "velocity", "acceleration")
        sums = {name: getattr(self, name) + getattr(joint_run, name) for name in names}
        return replace(self, **sums)

    def turn(self, link: RegroupedLink) -> _Turn:
        """Turn from the frame before to that of the last one; the frame of a round link need not turn."""
        if link.is_round:
            return _Turn(self.rotation)
        quarters = round(self.offset / _QUARTER_TURN)
        if abs(self.offset - quarters * _QUARTER_TURN) > _ROUND_OFF:
            angle = self.angle + self.offset
            return _Turn(self.rotation, (np.cos(angle), np.sin(angle)))
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return _Turn(self.rotation, ((cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos))[quarters % 4])

    def spin(self, link: RegroupedLink) -> _Spin:
        """Motion of the last one."""
        turn = self.turn(link)
        x, y, z = turn.turned(turn.across(self.before.omega))
        x_dot, y_dot, z_dot = turn.turned(turn.across(self.before.omega_dot))
        return _Spin(
            np.stack([x, y, z + self.velocity]),
            np.stack([x_dot + y * self.velocity, y_dot - x * self.velocity, z_dot + self.acceleration]),
        )
