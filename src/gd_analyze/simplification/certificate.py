"""A bound on the torque error that no state of a box exceeds, proven from the dropped terms.

The error of joint i is a polynomial e_i = sum_r F_ir(q) r, r running over 1, the accelerations and the
products of two rates, and F over trigonometric polynomials whose coefficients are known. In a box of |rates|
<= v and |accelerations| <= a, whatever their signs,

    |e_i| <= g_i(q) = sum_r |F_ir(q)| max|r|.

g_i is bounded over boxes of positions by branch and bound. In a cell with centre c and half-widths w Taylor's
theorem gives, for every F, |F(q)| <= |F(c)| + sum_k |dF/dq_k(c)| w_k + 1/2 sum_kl S_kl w_k w_l with S_kl the
largest second derivative anywhere in the box, at most the sum of its coefficients' magnitudes. Cells of the
largest bound are halved until the largest bound meets the largest g_i seen, or time is up; the bound is
proven either way.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from gd_analyze.harmonics import identify
from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import energy_terms
from gd_analyze.models.harmonic import HarmonicModel, torques_of_energy
from gd_analyze.simplification.error_field import Box, ErrorField, ErrorRow, error_rows
from gd_analyze.vectors import FloatArray

# Halving stops when the bound is this close to the largest value seen.
_CLOSE = 1.02
_BATCH = 128
# Largest number of vertices of the rates' box that the search for the worst state tries at one position.
_VERTICES = 256
# Random search for the worst state: rounds and positions per round.
_ROUNDS, _SAMPLES = 12, 1500


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is proven and what was found, per joint, N m (N for a sliding joint), shape (n,).

    Parameters
    ----------
    box
        The states it is about.
    certified
        No state of the box has a larger torque error.
    worst_found
        Largest torque error that the search found in the box; the truth lies between.
    """

    box: Box
    certified: FloatArray
    worst_found: FloatArray

    @property
    def ratio(self) -> FloatArray:
        """Certified over worst found, at least 1; 1 where there is no error at all."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.certified == 0.0, 1.0, self.certified / self.worst_found)


def certify(model: HarmonicModel, box: Box | None = None, *, seconds: float = 1.0) -> Certificate:
    """Bound a model's torque error over a box of states.

    Parameters
    ----------
    model
        A model of harmonic terms.
    box
        The states; the arm's own limits by default.
    seconds
        Time per joint that the bound may take to tighten.

    Returns
    -------
    Certificate
        Proven bound and worst error found.

    Raises
    ------
    UsageError
        If no box is given and the arm does not state all its limits.
    """
    arm = model.arm
    box = box or Box.of(arm)
    exact = torques_of_energy(arm, energy_terms(identify(arm), arm.drive_inertia if model.drives else None))
    rows = error_rows(Basis.of(arm), exact, model.torques)
    found = [_bounded(rows[i], box, seconds) for i in range(arm.n_joints)]
    return Certificate(box, np.array([bound for bound, _ in found]), np.array([worst for _, worst in found]))


def _bounded(row: ErrorRow, box: Box, seconds: float) -> tuple[float, float]:
    """Proven bound and largest error found of one joint."""
    if not row:
        return 0.0, 0.0
    field = ErrorField(row, box)
    centre, width = ((box.upper + box.lower) / 2)[:, None], ((box.upper - box.lower) / 2)[:, None]
    bounds, seen = _evaluate(field, centre, width)
    best = float(seen.max())
    end = time.monotonic() + seconds
    while field.axes and bounds.max() > _CLOSE * best and time.monotonic() < end:
        chosen = np.argpartition(bounds, -min(_BATCH, len(bounds)))[-min(_BATCH, len(bounds)) :]
        halves = _halved(field, centre[:, chosen], width[:, chosen])
        new_bounds, new_seen = _evaluate(field, *halves)
        best = max(best, float(new_seen.max()))
        others = np.setdiff1d(np.arange(len(bounds)), chosen)
        # A cell that cannot hold the maximum need not be kept.
        alive = new_bounds > best
        centre = np.hstack([centre[:, others], halves[0][:, alive]])
        width = np.hstack([width[:, others], halves[1][:, alive]])
        bounds = np.concatenate([bounds[others], new_bounds[alive]])
        if not len(bounds):
            break
    bound = max(float(bounds.max(initial=0.0)), best)
    return float(np.nextafter(bound + field.round_off, np.inf)), _worst_found(field, box)


def _evaluate(field: ErrorField, centre: FloatArray, width: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Upper bound of g over every cell, and g at its centre."""
    values, slopes = field(centre)
    seen = field.sizes @ np.abs(values)
    inner = width[field.axes]
    linear = np.einsum("p,kpc,kc->c", field.sizes, np.abs(slopes), inner)
    quadratic = 0.5 * np.einsum("kc,km,mc->c", inner, field.curvature, inner)
    return seen + linear + quadratic, seen


def _halved(field: ErrorField, centre: FloatArray, width: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Halve every cell across the axis that its bound owes most to."""
    _, slopes = field(centre)
    inner = width[field.axes]
    owed = np.einsum("p,kpc,kc->kc", field.sizes, np.abs(slopes), inner)
    owed += 0.5 * inner * (field.curvature @ inner)
    axis = np.array(field.axes)[owed.argmax(axis=0)]
    cells = np.arange(centre.shape[1])
    narrow = width.copy()
    narrow[axis, cells] /= 2
    left, right = centre.copy(), centre.copy()
    left[axis, cells] -= narrow[axis, cells]
    right[axis, cells] += narrow[axis, cells]
    return np.hstack([left, right]), np.hstack([narrow, narrow])


def _worst_found(field: ErrorField, box: Box) -> float:
    """Largest error that a random search finds, drawn together around the best position again and again."""
    random = np.random.default_rng(0)
    middle, spread = ((box.upper + box.lower) / 2)[:, None], ((box.upper - box.lower) / 2)[:, None]
    best = 0.0
    for round_ in range(_ROUNDS):
        q = np.clip(
            middle + spread * random.uniform(-1.0, 1.0, (len(spread), _SAMPLES)),
            box.lower[:, None],
            box.upper[:, None],
        )
        errors = _errors_at(field, q, box)
        if errors.max() > best:
            best, middle = float(errors.max()), q[:, [errors.argmax()]]
        if round_:
            spread = 0.6 * spread
    return best


def _errors_at(field: ErrorField, q: FloatArray, box: Box) -> FloatArray:
    """Largest error at positions (n, K) over vertices of the box of rates, accelerations chosen best."""
    values = field(q)[0]
    n = len(box.rate)
    # e is even in the rates: half of the vertices do, and as many as there is time for.
    count = min(2 ** (n - 1), _VERTICES)
    signs = 1.0 - 2.0 * ((np.arange(count)[:, None] >> np.arange(n)) & 1)
    still, moving, pushed = np.zeros(q.shape[1]), np.zeros((count, q.shape[1])), np.zeros(q.shape[1])
    for (kind, joints), value in zip(field.factors, values, strict=True):
        if kind == "qdd":
            pushed += np.abs(value) * box.acceleration[joints[0]]
        elif kind == "1":
            still += value
        else:
            a, b = joints
            moving += np.outer(signs[:, a] * signs[:, b] * box.rate[a] * box.rate[b], value)
    reached = np.maximum(np.abs(still), np.abs(still + moving).max(axis=0))
    return np.asarray(reached + pushed)
