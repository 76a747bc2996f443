"""Coulomb and viscous friction and an offset, fitted to what a measured torque has beyond the model's."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from gd_analyze.arrays import Array, FloatArray, chunks

# A column of whose length no more than this part is independent of those before it tells nothing of its own:
# velocities and torques have not as many good digits.
_DEPENDENT = 1e-6

# A column that varies less than this part of its length is constant: round-off of sums of a million terms.
_CONSTANT = 1e-12


def triangle(blocks: Iterable[FloatArray], columns: int) -> FloatArray:
    """R of the QR decomposition of columns given as blocks of rows: squaring would cost half the digits."""
    left = np.zeros((columns, columns))
    for block in blocks:
        left = reduced(np.vstack([left, block]))
    return left


def reduced(columns: FloatArray) -> FloatArray:
    """R of the QR decomposition of columns at hand."""
    return np.asarray(np.linalg.qr(columns, mode="r"))


def independent(r: FloatArray, columns: Sequence[int]) -> list[int]:
    """Those of some columns that are not made up of the ones before them."""
    kept: list[int] = []
    for column in columns:
        own = abs(reduced(r[:, [*kept, column]])[-1, -1])
        if own > _DEPENDENT * float(np.linalg.norm(r[:, column])):
            kept.append(column)
    return kept


def spread(columns: FloatArray) -> FloatArray:
    """Norm of columns of R less their means, where the first is of an offset; nan of what is constant."""
    varied = np.linalg.norm(columns[1:], axis=0)
    return np.where(varied > _CONSTANT * np.linalg.norm(columns, axis=0), varied, np.nan)


# Readings of one block: neighbours resemble each other over far fewer than half of it.
_BLOCK = 2**14
# Correlations are summed over so many times what they sum to: beyond, noise alone would be added.
# A. Sokal (1997), Monte Carlo methods in statistical mechanics, section 3.
_WINDOW = 5.0


def correlation_time(
    residual: Callable[[slice], FloatArray], used: Array, stretches: Sequence[slice]
) -> float:
    """Readings per independent one, 1 or more: 1 + 2 sum_k rho_k, rho_k the correlation of those k apart.

    A mean over N of them is as uncertain as one over N divided by this. For the coefficients of a fit the
    same holds as long as what they belong to changes more slowly than the residuals are alike, and errs to
    the safe side otherwise. `residual` gives what a fit leaves at the set points of a slice, `used` which
    took part, `stretches` slices without a gap.
    """
    products, pairs = np.zeros(_BLOCK // 2), np.zeros(_BLOCK // 2)
    for stretch in stretches:
        for start in range(stretch.start, stretch.stop, _BLOCK):
            block = slice(start, min(start + _BLOCK, stretch.stop))
            there = used[block].astype(float)
            if there.any():
                products += _at_distance(np.where(used[block], residual(block), 0.0))
                pairs += _at_distance(there)
    # Few pairs say little.
    enough = pairs >= max(0.1 * pairs[0], 1.0)
    known = len(enough) if enough.all() else int(np.argmin(enough))
    covariance = products[:known] / pairs[:known]
    if known < 2 or not covariance[0] > 0:
        return 1.0
    times = 2.0 * np.cumsum(covariance / covariance[0]) - 1.0
    wide = np.flatnonzero(np.arange(known) >= _WINDOW * times)
    return max(1.0, float(times[wide[0] if len(wide) else -1]))


def _at_distance(values: FloatArray) -> FloatArray:
    """Sums of products of values 0, 1, 2, ... readings apart, for half a block."""
    spectrum = np.fft.rfft(values, 2 * _BLOCK)
    return np.fft.irfft(np.abs(spectrum) ** 2, 2 * _BLOCK)[: _BLOCK // 2]


TERMS = ("coulomb", "viscous", "offset")
# Columns of the fits: an offset, the direction, the velocity, the model's torque, the measured one.
_OFFSET, _DIRECTION, _VELOCITY, _MODEL, _MEASURED = range(5)
_OF_TERM = (_DIRECTION, _VELOCITY, _OFFSET)


@dataclass(frozen=True, eq=False)
class Friction:
    """Friction of every joint beside the model's torque, at the joint, by ordinary least squares.

    measured - model = coulomb sign(qd) + viscous qd + offset. What is not known is nan: of a joint without a
    measurement, and where a motion does not tell one term from the others, as of a joint that only moves one
    way or always as fast.
    """

    # By joint and the names of `TERMS`: N m, N m s and N m (N, N s/m and N of a prismatic joint), (n, 3).
    # Friction that would drive a joint is held at 0
    terms: FloatArray
    # Their standard errors; nan of what is held at 0. Readings whose residuals resemble their neighbours'
    # count as fewer. They tell of noise, not of what is wrong with the model
    errors: FloatArray
    # Of the measurement beside model and friction: RMS of the difference, correlation, and share of the
    # measured variance explained, shape (n,)
    rms: FloatArray
    correlation: FloatArray
    explained: FloatArray

    @classmethod
    def of(cls, fits: Sequence[JointFit]) -> Friction:
        """Collect what was fitted to each joint."""
        return cls(*(np.array([getattr(fit, field.name) for fit in fits]) for field in fields(cls)))


@dataclass(frozen=True, eq=False)
class JointFit:
    """One joint's measured torque by friction beside the model: as the model is, and times a slope."""

    # As of `Friction`, with the model as it is; `terms` and `errors` of shape (3,)
    terms: FloatArray
    errors: FloatArray
    rms: float
    correlation: float
    explained: float
    # What the model has to be multiplied by, friction fitted beside it, and its standard error
    slope: float
    slope_error: float
    partial: float  # correlation of measured and model once friction is taken out of both
    own: float  # RMS of the model's torque that is not like friction
    left: float  # RMS of the measured torque that is not like friction
    like_friction: float  # RMS of the measured torque that is


NOT_FITTED = JointFit(np.full(3, np.nan), np.full(3, np.nan), *(np.nan,) * 9)


def fit_joint(
    model: FloatArray,
    measured: FloatArray,
    way: FloatArray,
    velocity: FloatArray,
    used: Array,
    stretches: Sequence[slice],
) -> JointFit:
    """Fit friction to one joint at the set points that are used; all of shape (N,)."""

    def columns(at: slice) -> FloatArray:
        return np.column_stack([np.ones(at.stop - at.start), way[at], velocity[at], model[at], measured[at]])

    r = triangle((columns(at)[used[at]] for at in chunks(len(model))), 5)
    count = int(used.sum())
    terms = independent(r, (_OFFSET, _DIRECTION, _VELOCITY))

    def times(weights: FloatArray) -> float:
        return correlation_time(lambda at: columns(at) @ weights, used, stretches)

    weights, free = _friction_of(r, terms)
    deviation = _deviations(r, weights, free, times(weights), count)
    least = float(np.linalg.norm(r @ weights))
    fitted = -weights
    fitted[_MEASURED] = 0.0
    known, explained = [term in terms for term in _OF_TERM], r @ fitted

    # How measured and model go together beside friction, whatever they are multiplied by. The first row is
    # that of the offset, the last two are what friction leaves.
    mixed = reduced(r[:, [*terms, _MODEL, _MEASURED]])
    own, along = mixed[-2, -2:]
    left = float(np.hypot(along, mixed[-1, -1]))
    slope = slope_error = partial = np.nan
    if independent(r, [*terms, _MODEL])[-1] == _MODEL:
        beside = np.zeros(5)
        beside[[*terms, _MODEL]] = -np.linalg.solve(mixed[:-1, :-1], mixed[:-1, -1])
        beside[_MEASURED] = 1.0
        slope = float(along / own)
        slope_error = float(_deviations(r, beside, [*terms, _MODEL], times(beside), count)[_MODEL])
        partial = float(along * np.sign(own) / left) if left else np.nan
    else:
        own = 0.0
    root = np.sqrt(count)
    return JointFit(
        terms=np.where(known, fitted[[*_OF_TERM]] + 0.0, np.nan),
        errors=np.where(known, deviation[[*_OF_TERM]], np.nan),
        rms=least / root,
        correlation=float(explained[1:] @ r[1:, _MEASURED] / (spread(explained) * spread(r[:, _MEASURED]))),
        explained=1.0 - float(least / spread(r[:, _MEASURED])) ** 2,
        slope=slope,
        slope_error=slope_error,
        partial=partial,
        own=float(abs(own)) / root,
        left=left / root,
        like_friction=float(np.linalg.norm(mixed[1:-2, -1])) / root,
    )


def _friction_of(r: FloatArray, terms: list[int]) -> tuple[FloatArray, list[int]]:
    """What the fit leaves, as weights of the columns, and which terms of friction are not held at 0."""
    from scipy.optimize import lsq_linear  # slow to load

    sizes = np.linalg.norm(r[:, terms], axis=0)
    least = np.where(np.array(terms) == _OFFSET, -np.inf, 0.0)
    wanted = r[:, _MEASURED] - r[:, _MODEL]
    # The method finds which bounds are met in finitely many steps, and then solves without them.
    found = lsq_linear(r[:, terms] / sizes, wanted, (least, np.inf), method="bvls")
    weights = np.zeros(5)
    weights[terms] = -found.x / sizes
    weights[[_MODEL, _MEASURED]] = -1.0, 1.0
    return weights, [term for term, held in zip(terms, found.active_mask, strict=True) if not held]


def _deviations(r: FloatArray, weights: FloatArray, free: list[int], time: float, count: int) -> FloatArray:
    """Standard errors of the free weights, nan of others, where so many readings are worth one."""
    out = np.full(5, np.nan)
    # Fewer independent readings than there are weights leave no measure of noise: as if there were one more.
    spare = max(count / time - len(free), 1.0)
    square = float(np.linalg.norm(r @ weights)) ** 2 / spare
    sizes = np.linalg.norm(r[:, free], axis=0)
    inverse = np.linalg.inv(reduced(r[:, free] / sizes))
    out[free] = np.sqrt(square * (inverse**2).sum(axis=1)) / sizes
    return out
