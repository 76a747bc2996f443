"""The torque error of a model: exact torque minus the model's, as waves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.climbing import highest_position, local_maximum
from gd_analyze.certification.motion import Motion
from gd_analyze.harmonics.expansion import VelocityFactor, velocity_factors
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial

_EPS = float(np.finfo(float).eps)
# What should cancel between model and exact form leaves waves of this share of the torque, or less. There may
# be many, in many joints; a bound by their amplitudes costs nothing and keeps them from the choice of grids.
_CANCELLED = 1e-12
# Coefficients up to which trying the worst velocities at every place takes no longer than holding them on
# the way.
_FEW = 16_000


@dataclass(frozen=True, eq=False)
class ErrorField:
    """One joint's torque error over a box.

    Parameters
    ----------
    waves
        F_r(q) max|r| of every factor r.
    motion
        The factors.
    round_off
        What evaluating it, at any position of the box, can be off by.
    rest
        Largest value of what is not in it: what should cancel, and the rounding of all coefficients.
    """

    waves: TrigonometricPolynomial
    motion: Motion
    round_off: float
    rest: float

    @classmethod
    def of(
        cls,
        exact: tuple[TrigonometricPolynomial, list[int]],
        model: TrigonometricPolynomial,
        roundings: float,
        box: Box,
    ) -> ErrorField:
        """Prepare a joint's row of the error.

        Parameters
        ----------
        exact
            What adds up to the exact torque, see `exact_row`.
        model, roundings
            The model's row, and what its coefficients' rounding makes of the torque.
        box
            The states.
        """
        parts, places = exact
        factors = velocity_factors(box.n_joints)
        largest = np.array([_largest(factor, box) for factor in factors])
        waves = largest * TrigonometricPolynomial.summed([parts.added(places, len(factors)), -1.0 * model])
        # Every coefficient is the sum of three slopes of sums over links and a drive, and a difference.
        size = float(largest[places] @ parts.sizes(box.farthest).sum(axis=1))
        rest = (box.n_joints + 8) * _EPS * size + roundings
        sizes = waves.sizes(box.farthest)
        cancelled = sizes <= _CANCELLED * size
        kept = np.where(cancelled, 0.0, waves.coefficients)
        there = (kept != 0.0).any(axis=1)
        waves = TrigonometricPolynomial(waves.prismatic, waves.multiples, kept)[there].above(0.0)
        motion = Motion(box.n_joints, tuple(f for f, used in zip(factors, there, strict=True) if used))
        return cls(waves, motion, round_off_of(waves, box), rest + float(sizes[cancelled].sum()))

    def worst(self, box: Box, starts: FloatArray) -> tuple[float, FloatArray, FloatArray, FloatArray]:
        """Largest error that climbing from positions (n, S) finds, and its state: q, qd and qdd, shape (n,).

        Velocities and accelerations are the worst at each position.
        """
        if not len(self.waves):
            return 0.0, box.centre, np.zeros(box.n_joints), np.zeros(box.n_joints)
        if self.waves.coefficients.size <= _FEW:
            q, _ = local_maximum(lambda q: self.motion.reached(self.waves(q)), box, starts)
        else:
            q = highest_position(self.waves, self.motion, box, starts)
        error, velocities, pushes = self.motion.worst(self.waves(q[:, None])[:, 0])
        return error, q, velocities * box.velocity, pushes * box.acceleration


def round_off_of(waves: TrigonometricPolynomial, box: Box) -> float:
    """What the value of a sum of waves can be off by.

    Every value is a sum of products in which no more than `count` roundings follow one another: one per wave
    and polynomial, some ten per joint. Each is eps/2 of terms that add up to `reach`: on a grid products of
    cosines and sines, which add up to sqrt(2) times a wave's amplitude per revolute joint at most. An angle
    m.q, and the place of a node, is off by some eps of the farthest one, which may be a turn beyond the box.
    """
    degrees = np.array(waves.degrees)
    count = sum(waves.coefficients.shape) + 32 * (1 + len(degrees))
    revolute = int((degrees[~np.array(waves.prismatic)] > 0).sum())
    reach = 2.0 ** (revolute / 2) * float(waves.sizes(box.farthest).sum())
    farthest = box.farthest + 2 * np.pi * ~np.array(waves.prismatic)
    return count * (1.0 + float(degrees @ farthest)) * _EPS * reach


def _largest(factor: VelocityFactor, box: Box) -> float:
    kind, joints = factor
    limit = box.acceleration if kind == "qdd" else box.velocity
    return float(np.prod([limit[joint] for joint in joints]))


_EFFECTS = 2


def harmonics_slack(harmonics: Harmonics, box: Box) -> FloatArray:
    """Torque per joint, N m (N), shape (n,), that the noise of the exact dynamics can hide in a box."""
    n, velocity = harmonics.arm.n_joints, box.velocity
    cut, cut_of_potential = harmonics.cut
    grown = _grown(harmonics, DEGREE, box)
    inertia = np.zeros((n, n))
    for (s, i, j), parts in harmonics.inertia_by_link.items():
        own = _interpolated(harmonics, range(i + 1, s + 1), DEGREE, box)
        inertia[i, j] += cut * (_EFFECTS * own + grown * np.count_nonzero(parts.coefficients))
    inertia += np.triu(inertia, 1).T
    # No function has a slope beyond the degree times its bound.
    slope = DEGREE * inertia
    h = 0.5 * (2 * (slope @ velocity) * velocity.sum() + velocity @ slope @ velocity)
    added = _grown(harmonics, 1, box) * np.count_nonzero(harmonics.potential_by_link.coefficients)
    potential = cut_of_potential * (n * _interpolated(harmonics, range(n), 1, box) + added)
    return np.asarray(inertia @ box.acceleration + h + potential)


def _interpolated(harmonics: Harmonics, joints: range, degree: int, box: Box) -> float:
    """Error over the cut of a function of some joints: of what is kept, and of all that may be left out."""
    value, count = 1.0, 1
    for run in harmonics.velocities.runs:
        present = sum(joint in joints for joint in run)
        if present and harmonics.potential.prismatic[run[0]]:
            # Lagrange polynomials on -1, 0, 1 (0, 1), and half their slopes, add up to no more than this.
            value *= 2.0 + 4.0 * float(box.farthest[run[0]]) ** 2
            count *= degree + 1
        else:
            # The sum or difference of two of the m sums of angles that links have turned by; of degree 1 one
            # of them or a difference. Cosine and sine of each, and 1.
            functions = 1 + degree * (present**2 + present)
            value *= math.sqrt(functions)
            count *= functions
    return value + harmonics.left_out * count * _grown(harmonics, degree, box)


def _grown(harmonics: Harmonics, degree: int, box: Box) -> float:
    """Largest magnitude over the box of a product of powers; half its slopes are no larger."""
    return math.prod(np.maximum(1.0, box.farthest[list(harmonics.potential.prismatic)]).tolist()) ** degree
