"""Basis functions of an arm's dynamics: products of sines and cosines of sums of joint angles.

Neighbouring joints whose axes are parallel for every q form a run. Within a run a mode is the cosine or sine
of an integer combination of the run's angles, so that cos(q2 + q3) is one mode of the PUMA's joints 2 and 3,
not a sum of products. A sliding joint is a run of its own with the modes 1, q, q^2. A basis function is the
product of one mode of every run; it is known by its number, whose digits (one per run) number the modes.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

DEGREE = 2  # of D in every joint variable: each of its two velocities turns (or moves) with the joint once

Ids = NDArray[np.int64]


FactorKind = Literal["cos", "sin", "power"]


@dataclass(frozen=True)
class Mode:
    """One factor of a basis function.

    Parameters
    ----------
    kind
        "cos" or "sin" of an integer combination of angles, or "power" of a sliding joint's variable.
    multiples
        How often each joint of the run goes into the argument; for "power" the exponent. The mode 1 is the
        cosine of nothing, or the power 0.
    """

    kind: FactorKind
    multiples: tuple[int, ...]

    @property
    def is_one(self) -> bool:
        """Whether this is the constant mode."""
        return not any(self.multiples)


@dataclass(frozen=True)
class Run:
    """Joints with parallel axes, or one sliding joint; joints count from 0.

    Parameters
    ----------
    joints
        Neighbours.
    sliding
        Whether it is a sliding joint.
    directions
        1 for every axis that points the way of the run's first, -1 for the others.
    """

    joints: tuple[int, ...]
    sliding: bool
    directions: tuple[int, ...] = (1,)

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """1, then cosines and sines of the half-space of combinations; or powers.

        A link of the run has turned by the sum of the angles up to it, and so has its share of any later
        position. D is of second degree in these: nothing but the sum or difference of two of them occurs,
        m^2 + m of the 5^m combinations that the degree in each angle would allow.
        """
        if self.sliding:
            return tuple(Mode("power", (p,)) for p in range(DEGREE + 1))
        turned = np.tril(np.tile(self.directions, (len(self.joints), 1)))
        turned = np.vstack([np.zeros_like(turned[:1]), turned])
        zero = (0,) * len(self.joints)
        found = {
            tuple(int(k) for k in one + sign * other)
            for one, other in itertools.product(turned, repeat=2)
            for sign in (1, -1)
        }
        half = sorted({max(k, tuple(-x for x in k)) for k in found} - {zero})
        return (Mode("cos", zero), *(Mode(kind, k) for k in half for kind in ("cos", "sin")))

    def values(self, q: FloatArray) -> FloatArray:
        """Every mode at q of shape (n, N): shape (number of modes, N)."""
        if self.sliding:
            return np.stack([q[self.joints[0]] ** p for p in range(DEGREE + 1)])
        multiples = np.array([mode.multiples for mode in self.modes[1::2]], dtype=float).reshape(
            -1, len(self.joints)
        )
        angles = multiples @ q[list(self.joints)]
        out = np.ones((len(self.modes), q.shape[1]))
        out[1::2], out[2::2] = np.cos(angles), np.sin(angles)
        return out

    def derivative(self, joint: int) -> tuple[NDArray[np.int64], FloatArray]:
        """For every mode the mode its derivative by q_joint is, and the factor in front."""
        target, factor = np.zeros(len(self.modes), dtype=np.int64), np.zeros(len(self.modes))
        place = self.joints.index(joint)
        for m, mode in enumerate(self.modes):
            multiple = mode.multiples[place]
            if multiple == 0:
                continue
            if mode.kind == "power":
                target[m], factor[m] = m - 1, multiple
            else:
                target[m] = m + 1 if mode.kind == "cos" else m - 1
                factor[m] = -multiple if mode.kind == "cos" else multiple
        return target, factor


@dataclass(frozen=True)
class Basis:
    """All basis functions of an arm."""

    n_joints: int
    runs: tuple[Run, ...]

    @classmethod
    def of(cls, arm: RobotArm) -> Basis:
        """Find the runs of an arm."""
        groups: list[dict[int, int]] = []
        for i in range(arm.n_joints):
            turning = i > 0 and arm.is_revolute[i] and arm.is_revolute[i - 1]
            direction = _direction(arm, i) if turning else 0
            if direction:
                groups[-1][i] = direction * groups[-1][i - 1]
            else:
                groups.append({i: 1})
        return cls(
            arm.n_joints, tuple(Run(tuple(g), not arm.is_revolute[min(g)], tuple(g.values())) for g in groups)
        )

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """Number of modes of every run."""
        return tuple(len(run.modes) for run in self.runs)

    @cached_property
    def run_of(self) -> tuple[int, ...]:
        """Run of every joint."""
        return tuple(
            next(r for r, run in enumerate(self.runs) if j in run.joints) for j in range(self.n_joints)
        )

    def digits(self, ids: Ids) -> NDArray[np.int64]:
        """Mode numbers of basis functions, shape (runs, len(ids))."""
        return np.array(np.unravel_index(ids, self.sizes), dtype=np.int64)

    def modes(self, function: int) -> tuple[tuple[Run, Mode], ...]:
        """Factors of one basis function other than 1."""
        numbers = self.digits(np.array([function]))[:, 0]
        pairs = [(run, run.modes[m]) for run, m in zip(self.runs, numbers, strict=True)]
        return tuple((run, mode) for run, mode in pairs if not mode.is_one)

    def evaluate(self, ids: Ids, q: FloatArray) -> FloatArray:
        """Basis functions at q of shape (n, N): shape (len(ids), N)."""
        out = np.ones((len(ids), q.shape[1]))
        for run, numbers in zip(self.runs, self.digits(ids), strict=True):
            used = np.flatnonzero(numbers)
            if used.size:
                out[used] *= run.values(q)[numbers[used]]
        return out

    def derivative(self, ids: Ids, joint: int) -> tuple[Ids, FloatArray]:
        """Derivative by q_joint of every function: another function, and the factor in front (0 for none)."""
        r = self.run_of[joint]
        digits = self.digits(ids)
        target, factor = self.runs[r].derivative(joint)
        factors = factor[digits[r]]
        digits[r] = target[digits[r]]
        return np.ravel_multi_index(tuple(digits), self.sizes), factors


def _direction(arm: RobotArm, i: int) -> int:
    """1 where axes i-1 and i are parallel for every q and point the same way, -1 where opposite, else 0.

    Both are constant in link frame i-1. Unit vectors: a deviation of the angle by d changes the cosine by d^2
    / 2, so the cross product, which is d itself, is what to look at; 1e-9 rad is nothing a table states.
    """
    behind = arm.links[i - 1].frame.rotation
    one = behind.T @ arm.joints[i - 1].axis
    other = arm.joints[i].placement.rotation @ arm.joints[i].axis
    return int(np.sign(one @ other)) if np.abs(np.cross(one, other)).max() < 1e-9 else 0
