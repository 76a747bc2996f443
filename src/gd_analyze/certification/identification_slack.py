r"""What the identified dynamics can be off by, as torque over a box.

The identification takes values of D_ij, link by link and effect by effect, on a grid of angles; each is off
by at most delta, what its noise eta was made from. In sup norm a trigonometric interpolation on F evenly
spaced nodes, cut down to the modes that can occur, is off by at most delta sqrt(number of modes) (Cauchy-
Schwarz on its kernel), and its slopes by the degree times that (Bernstein). Coefficients left out as
structural zeros were no larger than smallest kept / gap. Adding up links cuts at eta, and writing an energy
term in products takes coefficients for equal that are 2 eta apart per element that went into it. With

    tau_i = sum_j D_ij qdd_j + sum_jk h_ijk qd_j qd_k + c_i,
    h_ijk = (dD_ij/dq_k + dD_ik/dq_j - dD_jk/dq_i) / 2,

this bounds the error of the torque.
"""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.certification.box import Box
from gd_analyze.harmonics import Harmonics
from gd_analyze.harmonics.basis import DEGREE, Basis
from gd_analyze.harmonics.lagrangian import absolute_rates
from gd_analyze.vectors import FloatArray

_EFFECTS = 2
# Of eta, per coefficient: cutting when links are added up, effect by effect; merging two equal ones into a
# product (2), dropping what is left of a constant (2) and cutting (1) when an element is written.
_ADDING, _WRITING = 1.0, 5.0


def identification_slack(harmonics: Harmonics, box: Box) -> FloatArray:
    """Torque per joint that the identification's noise can hide anywhere in a box.

    Parameters
    ----------
    harmonics
        The identified dynamics.
    box
        The states.

    Returns
    -------
    numpy.ndarray
        N m (N), shape (n,).
    """
    basis, n = harmonics.basis, harmonics.arm.n_joints
    eta, eta_potential = harmonics.noise
    left_out = _largest_left_out(harmonics)
    rates = absolute_rates(basis)
    grown = _grown(basis, range(n), DEGREE, box)
    kept = np.zeros((n, n))
    own = np.zeros((n, n))
    for (s, i, j), parts in harmonics.inertia_by_link.items():
        kept[i, j] += sum(len(part) for part in parts)
        value, count = _interpolated(basis, range(i + 1, s + 1), DEGREE, box)
        own[i, j] += _EFFECTS * eta * (value + left_out * count * grown)
    kept, own = _mirrored(kept), _mirrored(own) + _ADDING * eta * grown * _mirrored(kept)
    # In absolute rates, D' = A^T D A with entries of 1 and -1 in A, and back.
    into, back = np.abs(rates), np.abs(np.linalg.inv(rates))
    parts_of = into.T @ np.ones((n, n)) @ into
    written = _WRITING * eta * grown * parts_of * (into.T @ kept @ into)
    inertia = own + back.T @ written @ back
    # No function has a slope beyond the degree times its bound.
    slope = DEGREE * inertia
    rate = box.rate
    h = 0.5 * (2 * (slope @ rate) * rate.sum() + rate @ slope @ rate)
    value, count = _interpolated(basis, range(n), 1, box)
    grown = _grown(basis, range(n), 1, box)
    potential = eta_potential * (
        value + left_out * count * grown + _WRITING * grown * len(harmonics.potential)
    )
    # A slope in the joints' own angles is a sum of slopes in the run's.
    return np.asarray(inertia @ box.acceleration + h + potential)


def _largest_left_out(harmonics: Harmonics) -> float:
    """Largest coefficient left out as a structural zero, over the noise."""
    smallest = math.inf
    families = [
        *((part, harmonics.noise[0]) for parts in harmonics.inertia_by_link.values() for part in parts),
        (harmonics.potential, harmonics.noise[1]),
    ]
    for series, noise in families:
        if len(series) and noise > 0.0:
            smallest = min(smallest, float(np.abs(series.coefficients).min()) / noise)
    # Nothing kept, or no gap known: all that is sure is the cut itself.
    return min(1.0, smallest / harmonics.gap) if math.isfinite(smallest) else 1.0


def _interpolated(basis: Basis, joints: range, degree: int, box: Box) -> tuple[float, int]:
    """Error of an interpolated function over eta, and the number of its basis functions.

    delta is eta without the doubling for every run; the transform's own round-off doubles it once.
    """
    value, count = 2.0 / 2.0 ** len(basis.runs), 1
    for run in basis.runs:
        present = [joint for joint in run.joints if joint in joints]
        if not present:
            continue
        if run.sliding:
            # Lagrange polynomials on -1, 0, 1 (0, 1), and half their slopes, add up to no more than this.
            value *= 2.0 + 4.0 * float(box.farthest[run.joints[0]]) ** 2
            count *= degree + 1
            continue
        modes = sum(
            all(
                abs(m) <= (degree if joint in present else 0)
                for joint, m in zip(run.joints, mode.multiples, strict=True)
            )
            for mode in run.modes
        )
        value *= math.sqrt(modes)
        count *= modes
    return value, count


def _grown(basis: Basis, joints: range, degree: int, box: Box) -> float:
    """Largest magnitude of a basis function over the box; half its slopes are no larger."""
    far = [
        float(box.farthest[run.joints[0]]) for run in basis.runs if run.sliding and run.joints[0] in joints
    ]
    return math.prod(max(1.0, x) ** degree for x in far)


def _mirrored(upper: FloatArray) -> FloatArray:
    return np.asarray(upper + np.triu(upper, 1).T)
