"""Absolute velocities of joints with parallel axes.

Revolute joints whose axes stay parallel for every q form a run; prismatic joints between them do not break
it. The link beyond joint j of a run turns about the run's direction at the absolute velocity p_j = qd_j +-
p_i, where i is the joint before j in the run, with minus if the two axes are opposite. In matrices qd = A p
and tau = A^-T tau', where tau' are the torques that do work on p. A joint without a parallel one, and every
prismatic joint, forms its own run.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.terms import Torques, TorqueTerm, Velocity, summed
from gd_analyze.robots.arm import RobotArm


class Signed(NamedTuple):
    """A joint, from 0, and 1 if its axis has the direction of another's, -1 if it is opposite."""

    joint: int
    sign: int


@dataclass(frozen=True)
class AbsoluteVelocities:
    """The runs of parallel joints of an arm, and how velocities and torques follow from them."""

    runs: tuple[tuple[int, ...], ...]  # joints of every run, from 0, ascending; by their first joints
    signs: tuple[int, ...]  # 1 for every joint with the direction of its run's first, -1 if opposite

    @classmethod
    def of(cls, arm: RobotArm) -> AbsoluteVelocities:
        """Find the runs of an arm."""
        runs: list[tuple[int, ...]] = []
        signs: list[int] = []
        # The last run of revolute joints, and its last axis in the frame before the next joint.
        last, axis = -1, np.zeros(3)
        for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
            joint_axis = joint.placement.rotation @ joint.axis
            # Parallel to 1e-9 rad, finer than any table; linear in a small angle, which the cosine is not.
            if arm.is_revolute[i] and last >= 0 and np.abs(np.cross(axis, joint_axis)).max() < 1e-9:
                signs.append(signs[runs[last][-1]] * (1 if axis @ joint_axis > 0.0 else -1))
                runs[last] += (i,)
            else:
                runs.append((i,))
                signs.append(1)
                last = len(runs) - 1 if arm.is_revolute[i] else last
            if arm.is_revolute[i]:
                axis = joint_axis
            axis = (joint.placement.rotation @ link.frame.rotation).T @ axis
        return cls(tuple(runs), tuple(signs))

    @classmethod
    def of_joints(cls, n: int) -> AbsoluteVelocities:
        """The velocities of n joints themselves: every joint is a run of its own."""
        return cls(tuple((joint,) for joint in range(n)), (1,) * n)

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.signs)

    @cached_property
    def before(self) -> dict[int, Signed]:
        """For each joint, the one before it in its run, with their relative direction."""
        pairs = (pair for run in self.runs for pair in itertools.pairwise(run))
        predecessors = {outer: Signed(inner, self.signs[inner] * self.signs[outer]) for inner, outer in pairs}
        return dict(sorted(predecessors.items()))

    @cached_property
    def carried(self) -> dict[int, Signed]:
        """For each joint, the next one in its run, whose torque it carries, with its sign."""
        return dict(sorted((inner, Signed(outer, sign)) for outer, (inner, sign) in self.before.items()))

    @cached_property
    def matrix(self) -> FloatArray:
        """A in qd = A p, shape (n, n)."""
        matrix = np.eye(self.n_joints)
        for outer, (inner, sign) in self.before.items():
            matrix[outer, inner] = -sign
        return matrix

    def inboard(self, joint: int) -> tuple[Signed, ...]:
        """Joints whose velocities add up to p_joint; the same joints carry row `joint` of tau'."""
        run = next(run for run in self.runs if joint in run)
        return tuple(Signed(k, self.signs[k] * self.signs[joint]) for k in run if k <= joint)

    def outboard(self, joint: int) -> tuple[Signed, ...]:
        """Joints to whose absolute velocities qd_joint adds."""
        run = next(run for run in self.runs if joint in run)
        return tuple(Signed(k, self.signs[k] * self.signs[joint]) for k in run if k >= joint)

    def is_part(self, multiples: FloatArray) -> bool:
        """Whether multiples within one run are those of the angle between two links, the first positive.

        If all axes have one direction, that is a sum of neighbouring angles, each once.
        """
        used = np.flatnonzero(multiples)
        if not used.size or multiples[used[0]] != 1:
            return False
        run = next(run for run in self.runs if used[0] in run)
        within = multiples[[*run]] * np.array([self.signs[k] * self.signs[used[0]] for k in run])
        return bool((within[within != 0] == 1).all()) and int(np.ptp(np.flatnonzero(within))) + 1 == len(used)

    def absolute(self, joint_velocities: Iterable[Any]) -> list[Any]:
        """Absolute velocities p from the joints' own, or other quantities that sum in the same way."""
        out = list(joint_velocities)
        for joint, (inner, sign) in self.before.items():
            out[joint] = _sum(out[joint], sign, out[inner])
        return out

    def joint_rows(self, rows: Iterable[Any]) -> list[Any]:
        """Torques tau = A^-T tau' from the rows of tau'."""
        out = list(rows)
        for joint, (outer, sign) in reversed(self.carried.items()):
            out[joint] = _sum(out[joint], sign, out[outer])
        return out

    def in_joint_velocities(self, torques: Torques) -> Torques:
        """The same torques as terms of tau in the joints' own velocities and accelerations."""
        if not self.before:  # every joint forms its own run
            return torques
        return summed((weight, self._in_joint_velocities(term)) for term, weight in torques.items())

    def _in_joint_velocities(self, term: TorqueTerm) -> Torques:
        out: dict[TorqueTerm, float] = defaultdict(float)
        of_velocities = [self.inboard(velocity.joint) for velocity in term.velocities]
        for carrier, *signed_joints in itertools.product(self.inboard(term.row), *of_velocities):
            pairs = zip(term.velocities, signed_joints, strict=True)
            moving = tuple(sorted(Velocity(old.order, new.joint) for old, new in pairs))
            signs = (signed.sign for signed in (carrier, *signed_joints))
            out[TorqueTerm(carrier.joint, moving, term.monomial)] += math.prod(signs)
        return out


def _sum(a: Any, sign: int, b: Any) -> Any:
    return a + b if sign > 0 else a - b
