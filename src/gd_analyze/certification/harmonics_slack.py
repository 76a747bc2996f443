r"""What the exact dynamics can be off by, being read off numbers, as torque over a box.

The transform takes values of D_ij, link by link and effect by effect, on a grid of angles; each is off by at
most delta, what the noise was made from, and the transform's own rounding doubles that once: 2 delta, no more
than the cut. In sup norm a trigonometric interpolation, cut down to the waves that can occur, is off by at
most the largest error of its values times sqrt(number of functions) (Cauchy-Schwarz on its kernel), and its
slopes by the degree times that (Bernstein). Waves that cannot occur are never kept, as they are made of
errors alone. Waves left out as structural zeros were no larger than `left_out` times the cut, and adding up
links leaves out no more than the cut. With

    tau_i = sum_j D_ij qdd_j + sum_jk h_ijk qd_j qd_k + c_i,
    h_ijk = (dD_ij/dq_k + dD_ik/dq_j - dD_jk/dq_i) / 2,

this bounds the error of the torque.
"""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE

_EFFECTS = 2


def harmonics_slack(harmonics: Harmonics, box: Box) -> FloatArray:
    """Torque per joint, N m (N), shape (n,), that the noise of the exact dynamics can hide in a box."""
    n, rate = harmonics.arm.n_joints, box.rate
    cut, cut_of_potential = harmonics.cut
    grown = _grown(harmonics, DEGREE, box)
    inertia = np.zeros((n, n))
    for (s, i, j), parts in harmonics.inertia_by_link.items():
        own = _interpolated(harmonics, range(i + 1, s + 1), DEGREE, box)
        inertia[i, j] += cut * (_EFFECTS * own + grown * np.count_nonzero(parts.coefficients))
    inertia += np.triu(inertia, 1).T
    # No function has a slope beyond the degree times its bound.
    slope = DEGREE * inertia
    h = 0.5 * (2 * (slope @ rate) * rate.sum() + rate @ slope @ rate)
    added = _grown(harmonics, 1, box) * np.count_nonzero(harmonics.potential_by_link.coefficients)
    potential = cut_of_potential * (n * _interpolated(harmonics, range(n), 1, box) + added)
    return np.asarray(inertia @ box.acceleration + h + potential)


def _interpolated(harmonics: Harmonics, joints: range, degree: int, box: Box) -> float:
    """Error over the cut of a function of some joints: of what is kept, and of all that may be left out."""
    value, count = 1.0, 1
    for run in harmonics.rates.runs:
        present = sum(joint in joints for joint in run)
        if present and harmonics.potential.sliding[run[0]]:
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
    return math.prod(np.maximum(1.0, box.farthest[list(harmonics.potential.sliding)]).tolist()) ** degree
