"""Physically consistent bodies that fit the logs: a semidefinite program, solved by Clarabel.

A body of non-negative density has a positive definite pseudo-inertia [[second moment, m r], [m r^T, m]] (P.
Wensing, S. Kim, J.-J. Slotine, Linear matrix inequalities for physically consistent inertial parameter
identification, IEEE Robotics and Automation Letters 3, 2018). Along identifiable directions, the numbers
deviate from the least squares by as few standard errors as possible; along others they stay as close to the
file as possible, in plausible sizes.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import PARAMETERS
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.identification.estimate import Estimate
from gd_analyze.identification.rows import Unknowns

# Least thickness of a body in any direction, as a share of its plausible length, squared.
_LEAST_THICKNESS_SQUARED = 1e-4
_LEAST_MASS_SHARE = 1e-3  # least share of a link's plausible mass
_ROOM_AT_BOUND = 1e-12  # room for round-off at a bound
# A solver with ten digits does not resolve larger ratios of standard errors.
_LARGEST_STRENGTH = 1e5


_SQRT2 = np.sqrt(2.0)


def pseudo_inertias() -> FloatArray:
    """Pseudo-inertia per unit of each of a body's `PARAMETERS`, (10, 4, 4)."""
    out = np.zeros((len(PARAMETERS), 4, 4))
    for k, name in enumerate(PARAMETERS):
        if name == "m":
            out[k, 3, 3] = 1.0
        elif name[0] == "m":
            axis = "xyz".index(name[1])
            out[k, axis, 3] = out[k, 3, axis] = 1.0
        else:
            a, b = ("xyz".index(axis) for axis in name[1:])
            out[k, a, b] = out[k, b, a] = -1.0
            if a == b:  # second moment: tr(I)/2 - I
                out[k, [0, 1, 2], [0, 1, 2]] += 0.5
    return out


def consistent(estimate: Estimate, unknowns: Unknowns) -> FloatArray:
    """Unknowns nearest to an estimate with physically consistent bodies, drives and friction, (p,)."""
    import clarabel
    from scipy import sparse

    p = len(estimate.start)
    thickness = _LEAST_THICKNESS_SQUARED * _triangle(np.eye(4))
    scaled, aims = _objective(estimate)
    upper = sparse.csc_matrix(np.triu(scaled.T @ scaled))
    bodies = _bodies(unknowns)
    at_least_0 = _nonnegative(unknowns)
    # s = b - A x in the cones: drives and friction, then a triangle of every body.
    lengths = [_lengths(estimate.sizes[body]) for body in bodies]
    rows = [-np.eye(p)[at_least_0] * estimate.sizes]
    shift = [estimate.start[at_least_0]]
    for body, length in zip(bodies, lengths, strict=True):
        unit = pseudo_inertias() / np.outer(length, length)
        triangle = np.array([_triangle(matrix) for matrix in unit])
        block = np.zeros((10, p))
        block[:, body] = triangle.T * estimate.sizes[body]
        rows.append(-block)
        shift.append(triangle.T @ estimate.start[body] - thickness)
    cones = [clarabel.NonnegativeConeT(len(at_least_0)), *(clarabel.PSDTriangleConeT(4) for _ in bodies)]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    linear, cut = -(scaled.T @ aims), np.concatenate(shift)
    constraints = sparse.csc_matrix(np.concatenate(rows))
    solver = clarabel.DefaultSolver(upper, linear, constraints, cut, cones, settings)
    solution = solver.solve()
    values = estimate.start + estimate.sizes * np.array(solution.x)
    values[at_least_0] = np.maximum(values[at_least_0], 0.0)
    matrices = [np.tensordot(values[body], pseudo_inertias(), 1) for body in bodies]
    if not all(np.linalg.eigvalsh(matrix)[0] > 0.0 for matrix in matrices):
        raise GdAnalyzeError(
            "no physically consistent parameters were found",
            found=f"the solver's answer: {solution.status}",
            next_step="physical=False takes plain least squares; check its parameters",
        )
    return values


def bounded(estimate: Estimate, unknowns: Unknowns) -> FloatArray:
    """Unknowns nearest to an estimate without negative masses, drive inertias or friction, (p,)."""
    from scipy.optimize import lsq_linear

    lower = np.full(len(estimate.start), -np.inf)
    signed = [*(body.start for body in _bodies(unknowns)), *_nonnegative(unknowns)]
    least = np.zeros_like(lower)
    # A link with mass in the file keeps a little.
    masses = [body.start for body in _bodies(unknowns)]
    least[masses] = np.minimum(estimate.start[masses], _LEAST_MASS_SHARE * estimate.sizes[masses])
    lower[signed] = (least[signed] - estimate.start[signed]) / estimate.sizes[signed]
    lower[signed] -= _ROOM_AT_BOUND
    solution = lsq_linear(*_objective(estimate), (lower, np.inf), method="bvls")
    values = estimate.start + estimate.sizes * solution.x
    values[signed] = np.maximum(values[signed], least[signed])
    return values


def _objective(estimate: Estimate) -> tuple[FloatArray, FloatArray]:
    """A and b of the objective |A x - b|^2, with x in plausible sizes from the start."""
    unidentifiable = len(estimate.start) - estimate.identifiable
    strength = np.minimum(estimate.strength, _LARGEST_STRENGTH)
    weights = np.concatenate([strength, np.ones(unidentifiable)])
    steps = np.concatenate([estimate.steps, np.zeros(unidentifiable)])
    return weights[:, None] * estimate.directions, weights * steps


def _nonnegative(unknowns: Unknowns) -> list[int]:
    """Drive inertias, Coulomb and viscous friction; an offset may have either sign."""
    friction = range(unknowns.count)[unknowns.of_friction]
    return [*range(unknowns.count)[unknowns.of_drives], *(k for i, k in enumerate(friction) if i % 3 < 2)]


def _bodies(unknowns: Unknowns) -> list[slice]:
    links = [slice(10 * i, 10 * i + 10) for i in range(unknowns.n_joints)]
    return [*links, unknowns.of_payload] if unknowns.payload else links


def _lengths(sizes: FloatArray) -> FloatArray:
    """Square roots of a body's plausible pseudo-inertia along its diagonal, (4,)."""
    return np.sqrt(np.array([sizes[4], sizes[4], sizes[4], sizes[0]]))


def _triangle(matrix: FloatArray) -> FloatArray:
    """Upper triangle of a symmetric matrix, column by column, scaled to the same norm, (10,)."""
    return np.array([matrix[a, b] * (1.0 if a == b else _SQRT2) for b in range(4) for a in range(b + 1)])
