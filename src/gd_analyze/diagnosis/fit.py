"""The fit of file and friction to corrected logs, and its score.

The score is J = sum over joints of w log(r^2 + floor^2) + (changes of the links / sigma)^2, with the residual
r of samples not fitted as a share of the joint's torque, and half the number w of independent samples. It is
minus twice the logarithm of a likelihood but for constants: noise is unknown, the links' errors are normal.
Multiplying torques changes their density: its logarithm is a part of J.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT, TorqueSums

# Weight of a joint's log of its mean squared residual: half its independent samples, this at most.
_MOST_WEIGHT = 50.0
# Samples of a short log for each unit of weight.
_SAMPLES_PER_WEIGHT = 4.0
# Share of a joint's torque below which a residual is worth no more.
_LEAST_RESIDUAL_SHARE = 0.015
# Changes of the links, squared in standard deviations, beyond which another cause is looked for; logs with no
# fault stay below.
MOST_CHANGES = 40.0

_MOST_ROUNDS = 6  # most rounds of weighting joints by the previous residuals
_SETTLED_CHANGE = 0.05  # relative change of squared residuals below which the rounds end
_FIRST_NOISE_SHARE = 0.01  # squared residual, as a share of the torque's, to begin with
_SINGULAR_ROUND_OFF = 1e-12  # added to equations scaled to 1 that rounding makes singular
_HALVINGS_OF_PRICE = 40  # halvings of the logarithm of the price of changes


@dataclass(frozen=True, eq=False)
class FileFit:
    """A fit by joint, nan where a joint says nothing."""

    score: float  # J without the cost of numbers
    unexplained: float  # J above that of residuals of 0
    changed: float  # squared changes of the links and of what was added, in standard deviations
    off: float  # torque of the links' changes over the file's torque, as RMS
    free: FloatArray  # numbers of links and of what was added, in standard deviations
    information: FloatArray  # inverse of their covariance
    # With links changed by no more than a file's usually are off:
    residuals: FloatArray  # r by joint, (n,)
    shared: FloatArray  # the same numbers
    joint_numbers: FloatArray  # drive inertia, friction and offset, (n, 4)

    @classmethod
    def of_nothing(cls, n: int) -> FileFit:
        """What is known of n joints that are not compared."""
        joint_numbers = np.full((n, NUMBERS_OF_JOINT), np.nan)
        nothing = np.zeros(0)
        residuals = np.full(n, np.nan)
        return cls(0.0, 0.0, 0.0, np.nan, nothing, np.zeros((0, 0)), residuals, nothing, joint_numbers)

    @property
    def errors(self) -> FloatArray:
        """Standard errors of `free`."""
        # Under a wrong hypothesis columns may be many times as large as the file's error.
        root = np.sqrt(np.diag(self.information))
        scaled = self.information / np.outer(root, root) + _SINGULAR_ROUND_OFF * np.eye(len(root))
        return np.asarray(np.sqrt(np.maximum(np.diag(np.linalg.inv(scaled)), 0.0)) / root)

    @property
    def remains(self) -> float:
        """What remains of all joints, as a share of torque: quadratic mean."""
        residuals = self.residuals[np.isfinite(self.residuals)]
        return float(np.sqrt(np.mean(residuals**2))) if len(residuals) else np.nan


def fitted(equations: TorqueSums, torque: FloatArray, fewest_samples: int, freedom: float = 1.0) -> FileFit:
    """Fit to torques that a matrix makes of those logged, (n, n); links may be `freedom` times as far off.

    A joint of fewer samples, fitted or scored, says nothing.
    """
    n, end = equations.n_joints, equations.shared + NUMBERS_OF_JOINT
    used = equations.counts.min(axis=0) >= fewest_samples
    torque_squares = np.einsum("id,ide,ie->i", torque, equations.total[:, end + 1 :, end + 1 :], torque)
    counts = equations.counts.sum(axis=0)
    size = torque_squares / np.maximum(counts, 1.0)
    least = _LEAST_RESIDUAL_SHARE**2 * size + np.finfo(float).tiny
    weight = np.minimum(_MOST_WEIGHT, counts / _SAMPLES_PER_WEIGHT) * used
    # The target is corrected torques less the file's.
    targets = np.concatenate([-np.ones((n, 1)), torque], axis=1)
    fit = _Fit(equations, targets, size, least, weight)
    changes, joint_numbers, mean, normal = fit.solved(freedom**-2, np.inf)
    changed = float(changes @ changes) / freedom**2
    # Torques are measured in units of those logged, so that no unit matters.
    logged = np.einsum("ijj->ij", equations.total[:, end + 1 :, end + 1 :])[np.arange(n), np.arange(n)]
    unit = np.where(used, logged / np.maximum(counts, 1.0), 1.0) + np.finfo(float).tiny
    score = float((weight * np.log((mean + least) / unit))[used].sum())
    score -= _density(torque, weight, used) - changed
    if freedom != 1.0:
        # Of errors that the log determines, a wider range makes the true ones less likely.
        determined = np.maximum(np.linalg.eigvalsh(normal), 0.0) * freedom**2
        score += 2.0 * np.log(freedom) * float((determined / (1.0 + determined)).sum())
    unexplained = float((weight * np.log1p(mean / least))[used].sum())
    off, free = _off(equations, changes, used), changes
    information = fit.weighed(mean) + freedom**-2 * np.eye(len(changes))
    if changed > MOST_CHANGES:
        changes, joint_numbers, mean, _ = fit.solved(freedom**-2, MOST_CHANGES * freedom**2)
    with np.errstate(divide="ignore", invalid="ignore"):
        residuals = np.where(used, np.sqrt(np.maximum(mean, 0.0) / size), np.nan)
    return FileFit(score, unexplained, changed, off, free, information, residuals, changes, joint_numbers)


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fit of links, drives and friction, whatever changes of the links cost."""

    equations: TorqueSums
    targets: FloatArray  # by column of torque, (n, 1 + n)
    size: FloatArray  # squared torque by joint, (n,)
    least: FloatArray  # squared residual that is worth no more, (n,)
    weight: FloatArray  # of a joint's logarithm of residuals, (n,)

    def solved(
        self, price: float, most_changes: float
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Changes of the links at a price, and what follows.

        These are the numbers of joints, (n, 4), mean squares of samples not fitted, (n,), and the changes'
        equations.
        """
        equations, weight, least = self.equations, self.weight, self.least
        n, shared = equations.n_joints, equations.shared
        end, used = shared + NUMBERS_OF_JOINT, weight > 0.0
        target, square = _right_hand_side(equations.fitted, self.targets, end)
        free = [(True,) * NUMBERS_OF_JOINT] * n
        noise = np.maximum(_FIRST_NOISE_SHARE * self.size, least)
        changes: FloatArray = np.zeros(shared)
        joint_numbers: FloatArray = np.zeros((n, NUMBERS_OF_JOINT))
        joints = np.flatnonzero(used).tolist()
        for _ in range(_MOST_ROUNDS):
            before = noise
            normal, right = np.zeros((shared, shared)), np.zeros(shared)
            for i in joints:
                eliminated = equations.without_own(i, free[i])
                factor = weight[i] / (noise[i] * equations.counts[0, i])
                normal += factor * eliminated.normal
                right += factor * (target[i, :shared] - eliminated.follows.T @ target[i, shared:end])
            changes = _changes(normal, right, price, most_changes)
            for i in joints:
                eliminated = equations.without_own(i, free[i])
                joint_numbers[i] = eliminated.inverse @ target[i, shared:end] - eliminated.follows @ changes
                if (joint_numbers[i, :-1] < 0.0).any():
                    is_free = (joint_numbers[i, :-1] >= 0.0) & free[i][:-1]
                    free[i] = (*is_free.tolist(), True)
                    eliminated = equations.without_own(i, free[i])
                    joint_numbers[i] = (
                        eliminated.inverse @ target[i, shared:end] - eliminated.follows @ changes
                    )
            squares = _squares(equations.fitted, square, target, changes, joint_numbers)
            noise = squares / np.maximum(equations.counts[0], 1.0) + least
            if (np.abs(noise - before) < _SETTLED_CHANGE * before)[used].all():
                break
        target, square = _right_hand_side(equations.scored, self.targets, end)
        squares = _squares(equations.scored, square, target, changes, joint_numbers)
        return changes, joint_numbers, squares / np.maximum(equations.counts[1], 1.0), normal

    def weighed(self, squares: FloatArray) -> FloatArray:
        """The changes' equations, weighed by squared residuals of the joints, (n,), their numbers free.

        Those of samples not fitted hold what friction has beside its model; a fit bends to its own.
        """
        equations = self.equations
        normal = np.zeros((equations.shared, equations.shared))
        for i in np.flatnonzero(self.weight).tolist():
            noise = (squares[i] + self.least[i]) * equations.counts[0, i]
            eliminated = equations.without_own(i, (True,) * NUMBERS_OF_JOINT)
            normal += self.weight[i] / noise * eliminated.normal
        return normal


def _changes(normal: FloatArray, right: FloatArray, price: float, most: float) -> FloatArray:
    """Changes of the links that fit best at a price, or at the higher one that keeps them to `most`."""
    # Under a wrong hypothesis columns may be many times as large as the file's error.
    priced = normal + price * np.eye(len(right))
    # What is eliminated may leave a negative square, by round-off.
    root = np.sqrt(np.maximum(np.diag(priced), price))
    scaled = priced / np.outer(root, root) + _SINGULAR_ROUND_OFF * np.eye(len(root))
    changes = np.asarray(np.linalg.solve(scaled, right / root) / root, dtype=float)
    if changes @ changes <= most:
        return changes
    sizes, ways = np.linalg.eigh(normal)
    along, sizes = ways.T @ right, np.maximum(sizes, 0.0)
    # Below the lower price they are too large; at the upper one they are not, as |along| / price is less.
    low, high = np.log(price), np.log(np.linalg.norm(along) / np.sqrt(most) + price)
    for _ in range(_HALVINGS_OF_PRICE):
        middle = 0.5 * (low + high)
        is_small = float(np.square(along / (sizes + np.exp(middle))).sum()) <= most
        low, high = (low, middle) if is_small else (middle, high)
    return np.asarray(ways @ (along / (sizes + np.exp(high))), dtype=float)


def _right_hand_side(sums: FloatArray, targets: FloatArray, end: int) -> tuple[FloatArray, FloatArray]:
    """Products of all columns with the target, (n, c), and the target's square, (n,)."""
    products = np.einsum("icd,id->ic", sums[:, :, end:], targets)
    return products, np.einsum("id,idc,ic->i", targets, sums[:, end:, end:], targets)


def _squares(
    sums: FloatArray, square: FloatArray, target: FloatArray, changes: FloatArray, joint_numbers: FloatArray
) -> FloatArray:
    """Squared residuals of every joint, (n,)."""
    n, end = len(joint_numbers), len(changes) + NUMBERS_OF_JOINT
    values = np.concatenate([np.broadcast_to(changes, (n, len(changes))), joint_numbers], axis=1)
    quadratic = np.einsum("ic,ic->i", (sums[:, :end, :end] @ values[:, :, None])[:, :, 0], values)
    linear = np.einsum("ic,ic->i", target[:, :end], values)
    return np.maximum(quadratic - 2.0 * linear + square, 0.0)


def _density(torque: FloatArray, weight: FloatArray, used: Array) -> float:
    """Logarithm of the factor by which multiplication makes all torques denser, squared, weighted."""
    if not used.any():
        return 0.0
    block = torque[np.ix_(used, used)]
    if np.count_nonzero(block) == np.count_nonzero(np.diag(block)):
        return float(weight[used] @ np.log(np.maximum(np.diag(block) ** 2, 1e-300)))
    sign, log = np.linalg.slogdet(block)
    return float(2.0 * weight[used].mean() * log) if sign else 0.0


def _off(equations: TorqueSums, changes: FloatArray, used: Array) -> float:
    """Torque of the links' changes over the file's, as RMS: the larger of revolute and prismatic joints."""
    shared, total = equations.shared, equations.total
    counts = np.maximum(equations.counts.sum(axis=0), 1.0)
    file = total[:, shared + NUMBERS_OF_JOINT, shared + NUMBERS_OF_JOINT] / counts
    moved = ((total[:, :shared, :shared] @ changes) @ changes) / counts
    shares = [np.nan]
    for kind in (used & equations.is_revolute, used & ~equations.is_revolute):
        if kind.any():
            with np.errstate(divide="ignore", invalid="ignore"):
                shares.append(float(np.sqrt(moved[kind].sum() / file[kind].sum())))
    return float(np.fmax.reduce(shares))
