"""Absolute rates of parallel joints: neighbours whose axes are parallel for every q form a run.

The links of a run turn about one direction, each at the sum of the rates up to its joint, p_j = qd_a + .. +
qd_j, a the first joint of the run. In matrices qd = A p and tau = A^-T tau', tau' being the torques that do
work on p. A joint with no parallel neighbour, and every sliding joint, is a run of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True)
class AbsoluteRates:
    """Which joints share a direction, and what follows for rates and torques.

    Parameters
    ----------
    runs
        Joints of every run, from 0; all joints in order.
    """

    runs: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, arm: RobotArm) -> AbsoluteRates:
        """Find the runs of an arm."""
        runs: list[tuple[int, ...]] = []
        for i in range(arm.n_joints):
            if i and arm.is_revolute[i] and arm.is_revolute[i - 1] and _parallel(arm, i):
                runs[-1] += (i,)
            else:
                runs.append((i,))
        return cls(tuple(runs))

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return self.runs[-1][-1] + 1

    @cached_property
    def matrix(self) -> FloatArray:
        """A of qd = A p, shape (n, n): in a run qd_j = p_j - p_{j-1}."""
        matrix = np.eye(self.n_joints)
        for joint in filter(self.carries_next, range(self.n_joints)):
            matrix[joint + 1, joint] = -1.0
        return matrix

    def carries_next(self, joint: int) -> bool:
        """Whether a joint carries what the next one carries: within a run, in absolute rates, it does."""
        return any(joint in run[:-1] for run in self.runs)

    def inboard(self, joint: int) -> tuple[int, ...]:
        """Joints whose rates add up to p_joint; those that carry row `joint` of tau' are the same."""
        return next(run[: run.index(joint) + 1] for run in self.runs if joint in run)

    def absolute(self, own: Iterable[Any]) -> list[Any]:
        """P from the joints' own rates, or whatever else of each joint can be added up."""
        out = list(own)
        for joint in filter(self.carries_next, range(self.n_joints)):
            out[joint + 1] = out[joint] + out[joint + 1]
        return out

    def joint_rows(self, rows: Iterable[Any]) -> list[Any]:
        """Tau = A^-T tau' from rows that can be added up: a joint carries what the run behind it carries."""
        out = list(rows)
        for joint in filter(self.carries_next, reversed(range(self.n_joints))):
            out[joint] = out[joint] + out[joint + 1]
        return out


def _parallel(arm: RobotArm, i: int) -> bool:
    """Whether axes i-1 and i are parallel for every q; both are constant in link frame i-1.

    Unit vectors: a deviation of the angle by d changes the cosine by d^2 / 2, so the cross product, which is
    d itself, is what to look at; 1e-9 rad is nothing a table states.
    """
    one = arm.links[i - 1].frame.rotation.T @ arm.joints[i - 1].axis
    other = arm.joints[i].placement.rotation @ arm.joints[i].axis
    return bool(np.abs(np.cross(one, other)).max() < 1e-9)
