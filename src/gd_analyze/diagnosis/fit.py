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
from gd_analyze.diagnosis.settings import DiagnosisSettings


@dataclass(frozen=True, kw_only=True)
class _FitSettings:
    """Rounds and round-off of a fit."""

    most_rounds: int = 6  # most rounds of weighting joints by the previous residuals
    settled_change: float = 0.05  # relative change of squared residuals below which the rounds end
    first_noise_share: float = 0.01  # squared residual, as a share of the torque's, to begin with
    singular_round_off: float = 1e-12  # added to equations scaled to 1 that rounding makes singular


_SETTINGS = _FitSettings()


@dataclass(frozen=True, eq=False)
class FileFit:
    """A fit by joint, nan where a joint says nothing."""

    score: float  # J without the cost of numbers
    unexplained: float  # J above that of residuals of 0
    residuals: FloatArray  # r by joint, (n,)
    changed: float  # squared changes of the links and of what was added, in standard deviations
    off: float  # torque of the links' changes over the file's torque, as RMS
    shared: FloatArray  # numbers of links and of what was added, in standard deviations
    joint_numbers: FloatArray  # drive inertia, friction and offset, (n, 4)

    @classmethod
    def of_nothing(cls, n: int) -> FileFit:
        """What is known of n joints that are not compared."""
        joint_numbers = np.full((n, NUMBERS_OF_JOINT), np.nan)
        return cls(0.0, 0.0, np.full(n, np.nan), 0.0, np.nan, np.zeros(0), joint_numbers)

    @property
    def remains(self) -> float:
        """What remains of all joints, as a share of torque: quadratic mean."""
        residuals = self.residuals[np.isfinite(self.residuals)]
        return float(np.sqrt(np.mean(residuals**2))) if len(residuals) else np.nan


def fitted(equations: TorqueSums, torque: FloatArray, settings: DiagnosisSettings) -> FileFit:
    """Fit to torques that a matrix makes of those logged, (n, n)."""
    n, shared = equations.n_joints, equations.shared
    end = shared + NUMBERS_OF_JOINT
    used = equations.counts.min(axis=0) >= settings.fewest_samples
    # The target is corrected torques less the file's.
    targets = np.concatenate([-np.ones((n, 1)), torque], axis=1)
    target, square = _right_hand_side(equations.fitted, targets, end)
    torque_squares = np.einsum("id,ide,ie->i", torque, equations.total[:, end + 1 :, end + 1 :], torque)
    counts = equations.counts.sum(axis=0)
    size = torque_squares / np.maximum(counts, 1.0)
    least = settings.least_residual_share**2 * size + np.finfo(float).tiny
    weight = np.minimum(settings.most_weight, counts / settings.samples_per_weight) * used
    free = [(True,) * NUMBERS_OF_JOINT] * n
    noise = np.maximum(_SETTINGS.first_noise_share * size, least)
    changes: FloatArray = np.zeros(shared)
    joint_numbers: FloatArray = np.zeros((n, NUMBERS_OF_JOINT))
    joints = np.flatnonzero(used).tolist()
    for _ in range(_SETTINGS.most_rounds):
        before = noise
        normal, right = np.eye(shared), np.zeros(shared)
        for i in joints:
            eliminated = equations.without_own(i, free[i])
            factor = weight[i] / (noise[i] * equations.counts[0, i])
            normal += factor * eliminated.normal
            right += factor * (target[i, :shared] - eliminated.follows.T @ target[i, shared:end])
        # Under a wrong hypothesis columns may be many times as large as the file's error.
        root = np.sqrt(np.diag(normal))
        scaled = normal / np.outer(root, root) + _SETTINGS.singular_round_off * np.eye(shared)
        changes = np.asarray(np.linalg.solve(scaled, right / root) / root, dtype=float)
        for i in joints:
            eliminated = equations.without_own(i, free[i])
            joint_numbers[i] = eliminated.inverse @ target[i, shared:end] - eliminated.follows @ changes
            if (joint_numbers[i, :-1] < 0.0).any():
                is_free = (joint_numbers[i, :-1] >= 0.0) & free[i][:-1]
                free[i] = (*is_free.tolist(), True)
                eliminated = equations.without_own(i, free[i])
                joint_numbers[i] = eliminated.inverse @ target[i, shared:end] - eliminated.follows @ changes
        squares = _squares(equations.fitted, square, target, changes, joint_numbers)
        mean = squares / np.maximum(equations.counts[0], 1.0)
        noise = mean + least
        if (np.abs(noise - before) < _SETTINGS.settled_change * before)[used].all():
            break
    target, square = _right_hand_side(equations.scored, targets, end)
    squares = _squares(equations.scored, square, target, changes, joint_numbers)
    mean = squares / np.maximum(equations.counts[1], 1.0)
    # Torques are measured in units of those logged, so that no unit matters.
    logged = np.einsum("ijj->ij", equations.total[:, end + 1 :, end + 1 :])[np.arange(n), np.arange(n)]
    unit = np.where(used, logged / np.maximum(counts, 1.0), 1.0) + np.finfo(float).tiny
    score = float((weight * np.log((mean + least) / unit))[used].sum())
    score -= _density(torque, weight, used) - float(changes @ changes)
    with np.errstate(divide="ignore", invalid="ignore"):
        residuals = np.where(used, np.sqrt(np.maximum(mean, 0.0) / size), np.nan)
    unexplained = float((weight * np.log1p(mean / least))[used].sum())
    return FileFit(
        score=score,
        unexplained=unexplained,
        residuals=residuals,
        changed=float(changes @ changes),
        off=_off(equations, changes, used),
        shared=changes,
        joint_numbers=joint_numbers,
    )


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
    """Torque of the links' changes over the file's torque, as RMS."""
    shared, counts = equations.shared, equations.counts.sum(axis=0)[used]
    file = equations.total[used, shared + NUMBERS_OF_JOINT, shared + NUMBERS_OF_JOINT]
    moved = (equations.total[used][:, :shared, :shared] @ changes) @ changes
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.sqrt(np.sum(moved / counts) / np.sum(file / counts)))
