"""What a file leaves of the torque as it is: links and drives unchanged, friction and an offset fitted."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT, corrected_columns
from gd_analyze.diagnosis.hypothesis import Problem
from gd_analyze.dynamics.friction import residual_beside_friction


class AsFiled(NamedTuple):
    """What is left of each joint's torque at the samples, (n,); nan where a joint is not compared."""

    rms: FloatArray  # N m (N)
    below_95: FloatArray  # what 95 % of the samples stay below, N m (N)
    share: FloatArray  # of the RMS of the measured torque


def residuals_as_filed(problem: Problem) -> AsFiled:
    """Compare measured torque with that of the file as it is, and friction.

    Friction is fitted to the same samples: three numbers of hundreds. Those of a part of a log are not those
    of the whole, as friction falls while a robot warms. What hypotheses added, such as a payload, keeps the
    numbers of the fit.
    """
    residuals = AsFiled(*np.full((3, problem.n), np.nan))
    if not problem.moving:
        return residuals
    samples, correction, arm = problem.samples, problem.correction, problem.arm
    columns, counts, shared = corrected_columns(samples, correction)
    n_added = sum(unknowns.columns.shape[2] for unknowns in correction.added)
    added = problem.null.shared[shared - n_added :]
    inertia = arm.drive_inertia if arm.drives else np.zeros(problem.n)
    torque = correction.of_torques(correction.steady(samples.torque))
    file_place = shared + NUMBERS_OF_JOINT
    for i in problem.moving:
        measured, of_joint = torque[counts[:, i], i], columns[i, counts[:, i]]
        acceleration, direction, velocity, _ = of_joint[:, shared:file_place].T
        model = of_joint[:, file_place] + inertia[i] * acceleration
        model = model + of_joint[:, shared - n_added : shared] @ added
        residual = residual_beside_friction(measured - model, direction, velocity)
        residuals.rms[i], size = (float(np.sqrt(np.mean(x**2))) for x in (residual, measured))
        residuals.below_95[i] = np.quantile(np.abs(residual), 0.95)
        residuals.share[i] = residuals.rms[i] / size if size > 0.0 else np.nan
    return residuals
