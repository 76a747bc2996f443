"""Torque of a joint's own: its columns, and friction fitted to measured torque minus the model's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import Array, FloatArray, chunks

# A column with at most this share of its length independent of those before it is redundant: velocities and
# torques are not more accurate.
_DEPENDENT_SHARE = 1e-6


def triangle(blocks: Iterable[FloatArray], columns: int) -> FloatArray:
    """R of the QR decomposition of columns given as blocks of rows; squaring would lose half the digits."""
    r = np.zeros((columns, columns))
    for block in blocks:
        r = reduced(np.vstack([r, block]))
    return r


def reduced(columns: FloatArray) -> FloatArray:
    """R of the QR decomposition of columns in memory."""
    return np.asarray(np.linalg.qr(columns, mode="r"))


def independent(r: FloatArray, columns: Sequence[int]) -> list[int]:
    """Columns that are linearly independent of those before them."""
    basis: list[int] = []
    for column in columns:
        remainder = abs(reduced(r[:, [*basis, column]])[-1, -1])
        if remainder > _DEPENDENT_SHARE * float(np.linalg.norm(r[:, column])):
            basis.append(column)
    return basis


_BLOCK_READINGS = 2**14  # readings of a block: correlation extends over far less than half of it
# Correlations are summed over this multiple of their sum; beyond it they are noise. A. Sokal (1997),
# Monte Carlo methods in statistical mechanics, section 3.
_SUMMED_TIMES = 5.0
# Share of all pairs of readings below which those of a distance are too few to be reliable.
_LEAST_PAIRS_SHARE = 0.1


def correlation_time(
    residual: Callable[[slice], FloatArray], used: Array, stretches: Sequence[slice]
) -> float:
    """Readings per independent one, 1 or more: 1 + 2 sum_k rho_k, with the correlation rho_k at distance k.

    With T readings per independent one, a mean over N readings is as uncertain as one over N / T independent
    readings. The same holds for coefficients of a fit whose regressors change more slowly than the residuals,
    and is conservative otherwise. `residual` gives a fit's residuals in a slice, `used` the set points used,
    `stretches` slices without a gap.
    """
    products, pairs = np.zeros(_BLOCK_READINGS // 2), np.zeros(_BLOCK_READINGS // 2)
    for stretch in stretches:
        for start in range(stretch.start, stretch.stop, _BLOCK_READINGS):
            block = slice(start, min(start + _BLOCK_READINGS, stretch.stop))
            is_used = used[block].astype(float)
            if is_used.any():
                products += _at_distance(np.where(used[block], residual(block), 0.0))
                pairs += _at_distance(is_used)
    enough = pairs >= max(_LEAST_PAIRS_SHARE * pairs[0], 1.0)
    n_distances = len(enough) if enough.all() else int(np.argmin(enough))
    covariance = products[:n_distances] / pairs[:n_distances]
    if n_distances < 2 or not covariance[0] > 0:
        return 1.0
    times = 2.0 * np.cumsum(covariance / covariance[0]) - 1.0
    wide = np.flatnonzero(np.arange(n_distances) >= _SUMMED_TIMES * times)
    return max(1.0, float(times[wide[0] if len(wide) else -1]))


def _at_distance(values: FloatArray) -> FloatArray:
    """Sums of products of values 0, 1, 2, ... readings apart, for half a block."""
    length = 2 * _BLOCK_READINGS
    spectrum = np.fft.rfft(values, length)
    return np.fft.irfft(np.abs(spectrum) ** 2, length)[: length // 4]


def own_columns(qdd: FloatArray, direction: Array, qd: FloatArray) -> FloatArray:
    """Torque of joints per drive inertia, Coulomb and viscous friction and offset of their own, (..., 4)."""
    return np.stack([qdd, direction, qd, np.ones_like(qd)], axis=-1)


FRICTION_TERMS = ("coulomb", "viscous", "offset")
# Columns of the fit: an offset, the direction, the velocity, and measured minus model torque.
_OFFSET, _DIRECTION, _VELOCITY, _DIFFERENCE = range(4)
_OF_TERM = (_DIRECTION, _VELOCITY, _OFFSET)


@dataclass(frozen=True, eq=False)
class Friction:
    """Friction of every joint, fitted to measured minus model torque by ordinary least squares.

    measured - model = coulomb sign(qd) + viscous qd + offset. Unknown values are nan: without a measurement,
    and where the motion does not separate a term from the others, as for a joint that moves only one way or
    at constant speed.
    """

    # By joint and the names of `FRICTION_TERMS`: N m, N m s and N m (N, N s/m and N if prismatic), (n, 3).
    # Friction that would drive a joint is held at 0
    terms: FloatArray
    # Standard errors; nan for values held at 0. Correlated residuals count as fewer readings. They reflect
    # noise, not errors of the model
    errors: FloatArray
    # Measurement compared with model plus friction: RMS of the difference, its size that 95 % of the readings
    # stay below, and share of the measured variance explained, shape (n,)
    rms: FloatArray
    below_95: FloatArray
    explained: FloatArray

    @classmethod
    def of(cls, fits: Sequence[JointFriction]) -> Friction:
        """Collect the fits of all joints."""
        return cls(*(np.array(values) for values in zip(*fits, strict=True)))


class JointFriction(NamedTuple):
    """Friction of one joint, as in `Friction`: `terms` and `errors` have shape (3,)."""

    terms: FloatArray
    errors: FloatArray
    rms: float
    below_95: float
    explained: float


NOT_FITTED = JointFriction(np.full(3, np.nan), np.full(3, np.nan), np.nan, np.nan, np.nan)


def fit_joint(
    model: FloatArray,
    measured: FloatArray,
    sign: Array,
    velocity: FloatArray,
    used: Array,
    stretches: Sequence[slice],
) -> JointFriction:
    """Fit friction to one joint at the set points that are used; all of shape (N,)."""

    def columns(at: slice) -> FloatArray:
        difference = measured[at] - model[at]
        return np.column_stack([np.ones(len(difference)), sign[at], velocity[at], difference])

    r = triangle((columns(at)[used[at]] for at in chunks(len(model))), 4)
    count = int(used.sum())
    weights, terms, free = _friction_of(r)
    time = correlation_time(lambda at: columns(at) @ weights, used, stretches)
    deviation = _deviations(r, weights, free, time, count)
    is_fitted = [term in terms for term in _OF_TERM]
    rms = float(np.linalg.norm(r @ weights)) / np.sqrt(count)
    left = np.concatenate([(columns(at) @ weights)[used[at]] for at in chunks(len(model))])
    variance = float(measured[used].var())
    return JointFriction(
        terms=np.where(is_fitted, 0.0 - weights[[*_OF_TERM]], np.nan),
        errors=np.where(is_fitted, deviation[[*_OF_TERM]], np.nan),
        rms=rms,
        below_95=float(np.quantile(np.abs(left), 0.95)),
        explained=1.0 - rms**2 / variance if variance else np.nan,
    )


def residual_beside_friction(difference: FloatArray, sign: FloatArray, velocity: FloatArray) -> FloatArray:
    """Measured minus model torque of one joint less the friction and offset fitted to it, (N,)."""
    columns = np.column_stack([np.ones(len(difference)), sign, velocity, difference])
    return np.asarray(columns @ _friction_of(reduced(columns))[0])


def _friction_of(r: FloatArray) -> tuple[FloatArray, list[int], list[int]]:
    """Residual of the fit, as weights of the columns, the terms fitted, and those that are not held at 0."""
    from scipy.optimize import lsq_linear  # slow to load

    terms = independent(r, (_OFFSET, _DIRECTION, _VELOCITY))
    sizes = np.linalg.norm(r[:, terms], axis=0)
    least = np.where(np.array(terms) == _OFFSET, -np.inf, 0.0)
    # The method finds the active bounds in finitely many steps, and then solves without them.
    solution = lsq_linear(r[:, terms] / sizes, r[:, _DIFFERENCE], (least, np.inf), method="bvls")
    weights = np.zeros(4)
    weights[terms] = -solution.x / sizes
    weights[_DIFFERENCE] = 1.0
    free = [term for term, is_bound in zip(terms, solution.active_mask, strict=True) if not is_bound]
    return weights, terms, free


def _deviations(r: FloatArray, weights: FloatArray, free: list[int], time: float, count: int) -> FloatArray:
    """Standard errors of the free weights, nan for others, with `time` readings per independent one."""
    out = np.full(4, np.nan)
    # With fewer independent readings than weights the noise is unknown: one degree of freedom is assumed.
    spare = max(count / time - len(free), 1.0)
    square = float(np.linalg.norm(r @ weights)) ** 2 / spare
    sizes = np.linalg.norm(r[:, free], axis=0)
    inverse = np.linalg.inv(reduced(r[:, free] / sizes))
    out[free] = np.sqrt(square * (inverse**2).sum(axis=1)) / sizes
    return out
