"""What a file leaves of the torque as it is: links and drives unchanged, friction and an offset fitted."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.diagnosis.equations import NUMBERS_OF_JOINT, corrected_columns
from gd_analyze.diagnosis.hypothesis import Problem


def residuals_as_filed(problem: Problem) -> FloatArray:
    """Residual of samples not fitted by joint, as a share of the torque's RMS, (n,); nan if not compared.

    What hypotheses added, such as a payload, keeps the numbers of the fit.
    """
    from scipy.optimize import lsq_linear  # slow to load

    out = np.full(problem.n, np.nan)
    if not problem.moving:
        return out
    samples, correction, arm = problem.samples, problem.correction, problem.arm
    columns, counts, shared = corrected_columns(samples, correction)
    n_added = sum(unknowns.columns.shape[2] for unknowns in correction.added)
    added = problem.null.shared[shared - n_added :]
    inertia = arm.drive_inertia if arm.drives else np.zeros(problem.n)
    torque = correction.of_torques(correction.steady(samples.torque))
    file_place = shared + NUMBERS_OF_JOINT
    for i in problem.moving:
        own, is_used = columns[i, :, shared:file_place], counts[:, i]
        left = torque[:, i] - columns[i, :, file_place] - inertia[i] * own[:, 0]
        left = left - columns[i, :, shared - n_added : shared] @ added
        friction = own[:, 1:]
        is_fitted, is_scored = is_used & ~samples.scored, is_used & samples.scored
        # Friction does not drive a joint; the offset may have either sign.
        bounds = ([0.0, 0.0, -np.inf], np.inf)
        numbers = lsq_linear(friction[is_fitted], left[is_fitted], bounds).x
        residual = (left - friction @ numbers)[is_scored]
        size = np.sqrt(np.mean(torque[is_used, i] ** 2))
        out[i] = np.sqrt(np.mean(residual**2)) / size if size > 0.0 else np.nan
    return out
