"""The torque error of a model: exact torque minus the model's, as waves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.local_maximum import local_maximum
from gd_analyze.certification.motion import Motion
from gd_analyze.certification.worst_state import highest_position
from gd_analyze.harmonics.torque_rows import RateFactor, rate_factors
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

_EPS = float(np.finfo(float).eps)
# What should cancel between model and exact form leaves waves of this share of the torque, or less. There may
# be many, in many joints; a bound by their amplitudes costs nothing and keeps them from the choice of grids.
_CANCELLED = 1e-12
# Coefficients up to which trying the worst rates at every place takes no longer than holding them on the way.
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
        factors = rate_factors(box.n_joints)
        largest = np.array([_largest(factor, box) for factor in factors])
        waves = largest * TrigonometricPolynomial.summed([parts.added(places, len(factors)), -1.0 * model])
        # Every coefficient is the sum of three slopes of sums over links and a drive, and a difference.
        size = float(largest[places] @ parts.sizes(box.farthest).sum(axis=1))
        rest = (box.n_joints + 8) * _EPS * size + roundings
        sizes = waves.sizes(box.farthest)
        cancelled = sizes <= _CANCELLED * size
        kept = np.where(cancelled, 0.0, waves.coefficients)
        there = (kept != 0.0).any(axis=1)
        waves = TrigonometricPolynomial(waves.sliding, waves.multiples, kept)[there].above(0.0)
        motion = Motion(box.n_joints, tuple(f for f, used in zip(factors, there, strict=True) if used))
        return cls(waves, motion, round_off_of(waves, box), rest + float(sizes[cancelled].sum()))

    def worst(self, box: Box, starts: FloatArray) -> tuple[float, FloatArray, FloatArray, FloatArray]:
        """Largest error that climbing from positions (n, S) finds, and its state: q, qd and qdd, shape (n,).

        Rates and accelerations are the worst at each position.
        """
        if not len(self.waves):
            return 0.0, box.centre, np.zeros(box.n_joints), np.zeros(box.n_joints)
        if self.waves.coefficients.size <= _FEW:
            q, _ = local_maximum(lambda q: self.motion.reached(self.waves(q)), box, starts)
        else:
            q = highest_position(self.waves, self.motion, box, starts)
        error, rates, pushes = self.motion.worst(self.waves(q[:, None])[:, 0])
        return error, q, rates * box.rate, pushes * box.acceleration


def round_off_of(waves: TrigonometricPolynomial, box: Box) -> float:
    """What the value of a sum of waves can be off by.

    Every value is a sum of products in which no more than `count` roundings follow one another: one per wave
    and polynomial, some ten per joint. Each is eps/2 of terms that add up to `reach`: on a grid products of
    cosines and sines, which add up to sqrt(2) times a wave's amplitude per turning joint at most. An angle
    m.q, and the place of a node, is off by some eps of the farthest one, which may be a turn beyond the box.
    """
    degrees = np.array(waves.degrees)
    count = sum(waves.coefficients.shape) + 32 * (1 + len(degrees))
    turning = int((degrees[~np.array(waves.sliding)] > 0).sum())
    reach = 2.0 ** (turning / 2) * float(waves.sizes(box.farthest).sum())
    farthest = box.farthest + 2 * np.pi * ~np.array(waves.sliding)
    return count * (1.0 + float(degrees @ farthest)) * _EPS * reach


def _largest(factor: RateFactor, box: Box) -> float:
    kind, joints = factor
    limit = box.acceleration if kind == "qdd" else box.rate
    return float(np.prod([limit[joint] for joint in joints]))
