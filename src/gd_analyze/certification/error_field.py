"""The torque error of a model as trigonometric polynomials, and climbing to its largest value."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.motion import MotionFactors
from gd_analyze.harmonics.expansion import expansion_factors
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial

_EPS = float(np.finfo(float).eps)
# Harmonics up to this share of the torque remain where model and exact form cancel. There may be many, in
# many joints; bounding them by their amplitudes is free and keeps them out of the choice of grids.
_CANCELLED = 1e-12

# Coefficients up to which trying the worst velocities everywhere is not slower than holding them.
_MOST_COEFFICIENTS_EXACTLY = 16_000
_FIRST_STEP = 1 / 32  # first step, as a share of the box's width
_HALVINGS = 9  # number of times that the step is halved
_MOST_MOVES = 40  # most moves, so that a long ridge is not followed forever
_MOST_VELOCITY_CHOICES = 40  # most choices of velocities, for the same reason
_POSITIONS_ALONG_JOINT = 33  # positions tried along a joint
_NEWTON_STEPS = 3  # newton steps from the best of these positions
_LEAST_GAIN = 3e-4  # a smaller relative gain does not count

_EFFECTS = 2


@dataclass(frozen=True, eq=False)
class ErrorField:
    """One joint's torque error over a box."""

    box: Box
    polynomial: TrigonometricPolynomial  # F_r(q) max|r| for every factor r
    motion: MotionFactors
    round_off: float  # largest round-off of evaluating the error at a position of the box
    omitted: float  # largest value of omitted parts: harmonics that cancel, rounding of coefficients

    @classmethod
    def of(
        cls,
        exact: tuple[TrigonometricPolynomial, list[int]],
        model: TrigonometricPolynomial | None,
        roundings: float,
        box: Box,
    ) -> ErrorField:
        """Subtract a model's row from an `exact_row`, accounting for its rounded coefficients."""
        parts, places = exact
        factors = expansion_factors(box.n_joints)
        limits = {"1": np.ones(box.n_joints), "qd": box.velocity, "qdd": box.acceleration}
        largest = np.array([np.prod(limits[kind][list(joints)]) for kind, joints in factors])
        error = parts.added(places, len(factors))
        if model is not None:
            error = TrigonometricPolynomial.summed([error, -1.0 * model])
        error = largest * error
        # Every coefficient is the sum of three slopes of sums over links and a drive, and a difference.
        size = float(largest[places] @ parts.sizes(box.farthest).sum(axis=1))
        omitted = (box.n_joints + 8) * _EPS * size + roundings
        sizes = error.sizes(box.farthest)
        cancelled = sizes <= _CANCELLED * size
        coefficients = np.where(cancelled, 0.0, error.coefficients)
        used = (coefficients != 0.0).any(axis=1)
        error = TrigonometricPolynomial(error.prismatic, error.multiples, coefficients)[used].above(0.0)
        motion = MotionFactors(
            box.n_joints, tuple(f for f, is_used in zip(factors, used, strict=True) if is_used)
        )
        return cls(
            box, error, motion, polynomial_round_off(error, box), omitted + float(sizes[cancelled].sum())
        )

    def worst(self, starts: FloatArray) -> tuple[float, FloatArray, FloatArray, FloatArray]:
        """Largest error found by climbing from positions (n, S), and its state q, qd, qdd, shape (n,).

        Velocities and accelerations are the worst at each position.
        """
        box = self.box
        if not len(self.polynomial):
            return 0.0, box.centre, np.zeros(box.n_joints), np.zeros(box.n_joints)
        if self.polynomial.coefficients.size <= _MOST_COEFFICIENTS_EXACTLY:
            q, _ = local_maximum(lambda q: self.motion.reached(self.polynomial(q)), box, starts)
        else:
            q = _highest_position(self.polynomial, self.motion, box, starts)
        (error,), velocities, pushes = self.motion.worst(self.polynomial(q[:, None]))
        return float(error), q, velocities[:, 0] * box.velocity, pushes[:, 0] * box.acceleration


def polynomial_round_off(polynomial: TrigonometricPolynomial, box: Box) -> float:
    """Largest round-off of the sum of all polynomials' values in a box.

    A value is a sum of products with at most `count` roundings in a row, each eps/2 of terms that sum to
    `reach`.
    """
    degrees = np.array(polynomial.degrees)
    # One per harmonic and polynomial, some ten per joint.
    count = sum(polynomial.coefficients.shape) + 32 * (1 + len(degrees))
    # Products of cosines and sines, on a grid, are at most sqrt(2) times an amplitude per revolute joint.
    revolute = int((degrees[polynomial.revolute] > 0).sum())
    reach = 2.0 ** (revolute / 2) * float(polynomial.sizes(box.farthest).sum())
    # A node may be a turn beyond the box.
    farthest = box.farthest + 2 * np.pi * polynomial.revolute
    return count * (1.0 + float(degrees @ farthest)) * _EPS * reach


def harmonics_slack(harmonics: Harmonics, box: Box) -> FloatArray:
    """Largest torque error per joint of the exact dynamics themselves, N m (N), shape (n,).

    The proof is in docs/certificate.md, "The noise of the exact form".
    """
    n, velocity = harmonics.arm.n_joints, box.velocity
    cut, cut_of_potential = harmonics.cut
    grown = _grown(harmonics, DEGREE, box)
    inertia = np.zeros((n, n))
    for (s, i, j), parts in harmonics.inertia_by_link.items():
        interpolated = _interpolated(harmonics, range(i + 1, s + 1), DEGREE, box)
        inertia[i, j] += cut * (_EFFECTS * interpolated + grown * np.count_nonzero(parts.coefficients))
    inertia += np.triu(inertia, 1).T
    # A slope is at most the degree times the function's bound.
    slope = DEGREE * inertia
    h = 0.5 * (2 * (slope @ velocity) * velocity.sum() + velocity @ slope @ velocity)
    added = _grown(harmonics, 1, box) * np.count_nonzero(harmonics.potential_by_link.coefficients)
    potential = cut_of_potential * (n * _interpolated(harmonics, range(n), 1, box) + added)
    return np.asarray(inertia @ box.acceleration + h + potential)


def _interpolated(harmonics: Harmonics, joints: range, degree: int, box: Box) -> float:
    """Error over the cut of a function of some joints: of kept harmonics, and of all that may be omitted."""
    value, count = 1.0, 1
    for run in harmonics.velocities.runs:
        present = sum(joint in joints for joint in run)
        if present and harmonics.potential.prismatic[run[0]]:
            # Bound on the sum of Lagrange polynomials on -1, 0, 1 (0, 1), and of half their slopes.
            value *= 2.0 + 4.0 * float(box.farthest[run[0]]) ** 2
            count *= degree + 1
        else:
            # Cosine and sine of the sum or difference of two of the links' m absolute angles; for degree 1 of
            # one angle or a difference, and 1.
            functions = 1 + degree * (present**2 + present)
            value *= math.sqrt(functions)
            count *= functions
    return value + harmonics.left_out * count * _grown(harmonics, degree, box)


def _grown(harmonics: Harmonics, degree: int, box: Box) -> float:
    """Largest magnitude over the box of a product of powers; half its slopes are no larger."""
    return math.prod(np.maximum(1.0, box.farthest[list(harmonics.potential.prismatic)]).tolist()) ** degree


def local_maximum(
    value: Callable[[FloatArray], FloatArray], box: Box, starts: FloatArray
) -> tuple[FloatArray, float]:
    """Climb from every start (n, S) of a function of positions; return the highest position and its value."""
    q, reached = local_maxima(value, box, starts)
    top = int(reached.argmax())
    return q[:, top], float(reached[top])


def local_maxima(
    value: Callable[[FloatArray], FloatArray], box: Box, starts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Climb from every start (n, S) of a function of positions; return all positions and values reached.

    One step to either side is tried for every joint. The best is taken; if none is better the step is halved.
    """
    lower, upper = box.lower[:, None], box.upper[:, None]
    width = box.upper - box.lower
    moves = np.vstack([np.diag(width), -np.diag(width)])[np.tile(width > 0.0, 2)].T
    q = np.clip(starts, lower, upper)
    reached = value(q)
    step = np.full(q.shape[1], _FIRST_STEP)
    for _ in range(_MOST_MOVES if moves.size else 0):
        places = np.flatnonzero(step > _FIRST_STEP / 2**_HALVINGS)
        if not places.size:
            break
        tried = q[:, places, None] + step[places, None] * moves[:, None]
        tried = np.clip(tried, lower[..., None], upper[..., None])
        values = value(tried.reshape(len(q), -1)).reshape(tried.shape[1:])
        best = values.argmax(axis=1)
        rows = np.arange(len(best))
        better = values[rows, best] > reached[places]
        q[:, places[better]] = tried[:, rows[better], best[better]]
        reached[places[better]] = values[rows[better], best[better]]
        step[places[~better]] /= 2
    return q, reached


def _highest_position(
    polynomial: TrigonometricPolynomial, motion: MotionFactors, box: Box, starts: FloatArray
) -> FloatArray:
    """Climb from every start (n, S); return the position of the largest error reached, shape (n,).

    With velocities and accelerations held at the worst, the error is one polynomial, with few coefficients
    along one joint, so that its maximum is found directly. Joints take turns, and after all of them the
    velocities are chosen again.
    """
    q = np.clip(starts, box.lower[:, None], box.upper[:, None])
    values = polynomial(q)
    reached = motion.reached(values)
    climbing = np.arange(q.shape[1])
    for _ in range(_MOST_VELOCITY_CHOICES):
        shares = motion.shares(values[:, climbing])
        real, imaginary = (part.T @ shares for part in polynomial.parts)
        higher = _higher(polynomial, real + 1j * imaginary, q[:, climbing], box)
        higher_values = polynomial(higher)
        moved = motion.reached(higher_values)
        better = moved > (1.0 + _LEAST_GAIN) * reached[climbing]
        climbing = climbing[better]
        if not climbing.size:
            break
        q[:, climbing], values[:, climbing] = higher[:, better], higher_values[:, better]
        reached[climbing] = moved[better]
    return q[:, int(reached.argmax())]


def _higher(
    polynomial: TrigonometricPolynomial, coefficients: NDArray[np.complex128], start: FloatArray, box: Box
) -> FloatArray:
    """Move S positions (n, S), each with its own coefficients (W, S), joint after joint."""
    q, all_multiples, revolute = start.copy(), polynomial.multiples, polynomial.revolute
    harmonics = coefficients * np.exp(1j * (all_multiples[:, revolute] @ q[revolute]))
    for joint in map(int, np.flatnonzero(polynomial.degrees)):
        multiples, positions, turns = all_multiples[:, joint], q[joint].copy(), bool(revolute[joint])
        values: Array = harmonics
        for k in np.flatnonzero(~revolute):
            if k != joint:
                values = values * q[k] ** all_multiples[:, [k]]
        orders = np.unique(multiples)
        along = np.stack([values[multiples == m].sum(axis=0) for m in orders])
        if turns:
            along *= np.exp(-1j * np.outer(orders, positions))
        places = np.linspace(box.lower[joint], box.upper[joint], _POSITIONS_ALONG_JOINT)
        best = places[_along(along, orders, places[:, None, None], turns)[0].argmax(axis=0)]
        for _ in range(_NEWTON_STEPS):
            _, slope, curve = _along(along, orders, best, turns)
            step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, 1.0), 0.0)
            best = np.clip(best + step, box.lower[joint], box.upper[joint])
        old, new = (_along(along, orders, x, turns)[0] for x in (positions, best))
        q[joint] = np.where(new > old, best, positions)
        if turns:
            phases = np.exp(1j * np.outer(orders, q[joint] - positions))
            harmonics *= phases[np.searchsorted(orders, multiples)]
    return q


def _along(
    coefficients: Array, orders: NDArray[np.int64], x: FloatArray, revolute: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values, slopes and curvatures of polynomials (D, S) in one joint at places (..., S)."""
    m = orders[:, None].astype(float)
    x = x[..., None, :]
    if revolute:
        basis = coefficients * np.exp(1j * m * x)
        derivatives = basis, 1j * m * basis, -(m**2) * basis
    else:
        powers = [x ** np.maximum(m - order, 0.0) for order in range(3)]
        derivatives = (
            coefficients * powers[0],
            coefficients * m * powers[1],
            coefficients * m * (m - 1) * powers[2],
        )
    value, slope, curve = (part.real.sum(axis=-2) for part in derivatives)
    return value, slope, curve
