"""Absolute velocities of parallel joints: revolute joints whose axes are parallel for every q form a run.

The links of a run turn about one direction; prismatic joints between them turn nothing. Each turns at the sum
of the velocities up to its joint, counted about that joint's own axis: p_j = qd_j +- p_i, i the joint
before it in
the run, minus where their axes are opposite. In matrices qd = A p and tau = A^-T tau', tau' being the torques
that do work on p. A joint with no parallel one, and every prismatic joint, is a run of its own.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.arm import RobotArm


class Signed(NamedTuple):
    """A joint, from 0, and 1 where its axis has the direction of another's, -1 where it is opposite."""

    joint: int
    sign: int


@dataclass(frozen=True)
class AbsoluteVelocities:
    """Which joints share a direction, and what follows for velocities and torques.

    Parameters
    ----------
    runs
        Joints of every run, from 0, ascending; runs in the order of their first joints.
    signs
        1 of every joint whose axis has the direction of its run's first, -1 where it is opposite.
    """

    runs: tuple[tuple[int, ...], ...]
    signs: tuple[int, ...]

    @classmethod
    def of(cls, arm: RobotArm) -> AbsoluteVelocities:
        """Find the runs of an arm."""
        runs: list[tuple[int, ...]] = []
        signs: list[int] = []
        # The run that a parallel joint would join, and its last axis in the frame before the next joint.
        last, axis = -1, np.zeros(3)
        for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
            own = joint.placement.rotation @ joint.axis
            if arm.is_revolute[i] and last >= 0 and _are_parallel(axis, own):
                signs.append(signs[runs[last][-1]] * (1 if axis @ own > 0.0 else -1))
                runs[last] += (i,)
            else:
                runs.append((i,))
                signs.append(1)
                last = len(runs) - 1 if arm.is_revolute[i] else last
            if arm.is_revolute[i]:
                axis = own
            axis = (joint.placement.rotation @ link.frame.rotation).T @ axis
        return cls(tuple(runs), tuple(signs))

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.signs)

    @cached_property
    def before(self) -> tuple[Signed | None, ...]:
        """Of every joint the one before it in its run, with whether their axes have one direction."""
        out: list[Signed | None] = [None] * self.n_joints
        for run in self.runs:
            for inner, outer in itertools.pairwise(run):
                out[outer] = Signed(inner, self.signs[inner] * self.signs[outer])
        return tuple(out)

    @cached_property
    def carried(self) -> tuple[Signed | None, ...]:
        """Of every joint the one whose torque it carries besides its own row of tau', with its sign."""
        out: list[Signed | None] = [None] * self.n_joints
        for outer, inner in enumerate(self.before):
            if inner:
                out[inner.joint] = Signed(outer, inner.sign)
        return tuple(out)

    @cached_property
    def matrix(self) -> FloatArray:
        """A of qd = A p, shape (n, n): in a run qd_j = p_j -+ p_i."""
        matrix = np.eye(self.n_joints)
        for outer, inner in enumerate(self.before):
            if inner:
                matrix[outer, inner.joint] = -inner.sign
        return matrix

    def inboard(self, joint: int) -> tuple[Signed, ...]:
        """Joints whose velocities add up to p_joint; those that carry row `joint` of tau' are the same."""
        run = next(run for run in self.runs if joint in run)
        return tuple(Signed(k, self.signs[k] * self.signs[joint]) for k in run if k <= joint)

    def is_part(self, multiples: FloatArray) -> bool:
        """Whether multiples within one run are those of the angle between two links, the first one positive.

        Where axes have one direction that is a sum of neighbouring angles, each once.
        """
        used = np.flatnonzero(multiples)
        if not used.size or multiples[used[0]] != 1:
            return False
        run = next(run for run in self.runs if used[0] in run)
        within = multiples[[*run]] * np.array([self.signs[k] * self.signs[used[0]] for k in run])
        return bool((within[within != 0] == 1).all()) and int(np.ptp(np.flatnonzero(within))) + 1 == len(used)

    def absolute(self, own: Iterable[Any]) -> list[Any]:
        """P from the joints' own velocities, or whatever else of each joint can be added up."""
        out = list(own)
        for joint, inner in enumerate(self.before):
            if inner:
                out[joint] = _sum(out[joint], inner.sign, out[inner.joint])
        return out

    def joint_rows(self, rows: Iterable[Any]) -> list[Any]:
        """Tau = A^-T tau' from rows that can be added up: a joint carries what the run behind it carries."""
        out = list(rows)
        for joint, outer in reversed(list(enumerate(self.carried))):
            if outer:
                out[joint] = _sum(out[joint], outer.sign, out[outer.joint])
        return out


def _sum(one: Any, sign: int, other: Any) -> Any:
    return one + other if sign > 0 else one - other


def _are_parallel(one: FloatArray, other: FloatArray) -> bool:
    """Whether unit vectors are parallel.

    A deviation of the angle by d changes the cosine by d^2 / 2, so the cross product, which is d itself, is
    what to look at; 1e-9 rad is nothing a table states.
    """
    return bool(np.abs(np.cross(one, other)).max() < 1e-9)
