"""Bounds on the tracking error that a controller's torque error can cause.

With u = M (K_d e' + K_p e) + b on the arm D qdd + h + c = u follows

    e'' + K_d e' + K_p e = M^-1 (D qdd + h + c + M e'' - b).

With computed torque b is M qdd_d + ..., so that the bracket is minus the model's torque error at the actual
states and accelerations of the arm. The largest right side, times the integral of `Gains`, bounds the error.
`expected` evaluates D qdd_d + h + c - b at the motion's own states: correct to first order, and for a
constant M if the error changes slowly compared with the loop. `certified` uses the proven torque error within
margins around the motion that the error cannot leave.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray
from gd_analyze.certification.certificate import certify
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Program
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.control_law import PD, SIMPLIFIED, Bank, Controller, Gains, Reference, World
from gd_analyze.studies.control_loop import ProgramDynamics


@dataclass(frozen=True, kw_only=True)
class _BoundSettings:
    """The margins around a motion within which a bound on the tracking error holds."""

    largest_margin: float = 10.0  # margin beyond which a bound is useless, rad (m) and per s and s^2
    certificate_positions: int = 25_000  # positions at which a certificate is evaluated
    most_widenings: int = 6  # how often margins are widened
    widening_factor: float = 1.25  # ratio of widened margins to those needed
    large_share: float = 0.5  # of inertia, or of feedback: what is large, and below which it lacks


_SETTINGS = _BoundSettings()


@dataclass(frozen=True, eq=False)
class CertifiedTracking:
    """Bound for a continuous loop that starts on the motion, within its torque limits; D is sampled."""

    torque_error: FloatArray  # bound for the model at any state within the margins, N m (N), (n,)
    error: FloatArray  # bound on the tracking error, rad (m), (n,)


@dataclass(frozen=True)
class FeedbackLeft:
    """Smallest share of the feedback that computed torque with a simplified model leaves."""

    share: float  # of the intended feedback; at 0 or less an error in some direction stays or grows
    joints: tuple[int, ...]  # joints that move in that direction or lack half of their inertia, from 1

    @property
    def is_enough(self) -> bool:
        """Whether at least half of the feedback is left."""
        return self.share >= _SETTINGS.large_share


def feedback_left(model: SimplifiedModel, reference: Reference) -> FeedbackLeft:
    """Find the share of the feedback that computed torque with a model leaves along the motion.

    Feedback accelerates the arm by D^-1 M (K_d e' + K_p e), where M is the model's D. Along an eigenvector of
    D^-1 M the eigenvalue is the ratio to the intended acceleration.
    """
    q, _, _ = reference.sampled()
    exact, simplified = (_inertia(program, q) for program in (model.form.program, model.program))
    values, vectors = np.linalg.eig(np.linalg.solve(exact, simplified))
    k, mode = np.unravel_index(int(values.real.argmin()), values.shape)
    diagonal = np.einsum("kii->ki", exact)
    # In units in which every joint takes as much to accelerate.
    direction = np.abs(vectors[k, :, mode]) * np.sqrt(diagonal[k])
    is_moving = direction >= _SETTINGS.large_share * direction.max()
    lacks_inertia = (np.einsum("kii->ki", simplified) / diagonal).min(axis=0) < _SETTINGS.large_share
    joints = 1 + np.flatnonzero(is_moving | lacks_inertia)
    return FeedbackLeft(float(values.real.min()), tuple(joints.tolist()))


def fixed_excess(world: World) -> float:
    """Largest ratio of fixed gains to the intended ones along the motion.

    They accelerate the arm by D^-1 M (K_d e' + K_p e), where M is the constants: by at most the largest
    eigenvalue of D^-1 M times the intended acceleration.
    """
    q, _, _ = world.reference.sampled()
    excess = np.linalg.solve(_inertia(world.plant.program, q), np.diag(world.diagonal))
    return float(np.linalg.eigvals(excess).real.max())


def mean_diagonal(exact: Program, reference: Reference) -> FloatArray:
    """Mean of D's diagonal along the motion, kg m^2 (kg), shape (n,)."""
    q, _, _ = reference.at(reference.instants)
    return np.asarray(np.einsum("kii->i", _inertia(exact, q)) / q.shape[1])


def expected(world: World, controller: Controller, speed: float) -> FloatArray:
    """Largest tracking error from the torque a controller lacks, rad (m), (n,); infinite if D is singular."""
    q, qd, qdd = world.reference.sampled(speed)
    bank = Bank([controller] * q.shape[1], world)
    missing = _needed(world, q, qd, qdd) - bank.torque(q, qd, (q, qd, qdd))
    if controller.law == "computed_torque":
        inertia = _inertia(world.simplified if controller == SIMPLIFIED else world.exact, q)
    else:
        inertia = np.diag(world.diagonal)
    try:
        unexpected = np.linalg.solve(inertia, missing.T[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return np.full(len(q), np.inf)
    return np.asarray(np.abs(unexpected).max(axis=0) * world.gains.error_per_acceleration)


def needed_torque(world: World, speed: float) -> FloatArray:
    """Largest torque that the motion needs, N m (N), (n,)."""
    return np.asarray(np.abs(_needed(world, *world.reference.sampled(speed))).max(axis=1))


def torque_for(
    exact: Program, reference: Reference, gains: Gains, tolerance: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Torque errors, in D's proportions, that keep fixed gains within a tracking error, N m (N), (n,).

    To first order, from the largest acceleration that simultaneous errors of any signs cause along the
    motion. `tolerance` returns the allowed errors, rad (m), (n,), for errors in these proportions.
    """
    q, _, _ = reference.sampled()
    diagonal = mean_diagonal(exact, reference)
    unexpected = np.max(np.abs(np.linalg.inv(_inertia(exact, q))) @ diagonal, axis=0)
    share = tolerance(unexpected) / (gains.error_per_acceleration * unexpected)
    return np.asarray(share.min() * diagonal)


def at_rest(world: World) -> FloatArray:
    """Largest error of PD at rest, rad (m), (n,): uncompensated gravity over the stiffness K_p M."""
    q, _, _ = world.reference.sampled()
    zero = np.zeros_like(q)
    needed = _torque(world.plant.program, q, zero, zero)
    commanded = Bank([PD] * q.shape[1], world).torque(q, zero, (q, zero, zero))
    missing = np.abs(needed - commanded).max(axis=1)
    missing[missing <= ROUND_OFF_SHARE * np.abs(needed).max()] = 0.0
    return np.asarray(missing / (world.gains.stiffness * world.diagonal))


def certified(
    model: SimplifiedModel, world: World, motion: Trajectory, speed: float
) -> CertifiedTracking | None:
    """Bound the error of computed torque with the model; None if no margins hold it, or M is not definite.

    Margins start from those between the set points and are widened until they hold the error that they allow.
    M is evaluated at the beginning, middle and end of the tube's pieces.
    """
    n, time, qd, qdd = model.arm.n_joints, motion.time / speed, motion.qd * speed, motion.qdd * speed**2
    run = replace(motion, time=time, qd=qd, qdd=qdd, recording=None, motions=())
    motion_tube = Tube.along(model.arm, run, "0deg,0mm,qd=0%,qdd=0%")
    times = np.linspace(motion_tube.begin, motion_tube.end, 3) - time[0]
    q, _, _ = world.reference.at(times, speed)
    inertia = _inertia(model.program, q.reshape(n, -1))
    if np.linalg.eigvalsh(inertia + np.swapaxes(inertia, 1, 2)).min() <= 0.0:
        return None
    inverse = np.abs(np.linalg.inv(inertia)).reshape(*times.shape, n, n)
    margins = np.zeros((3, n))
    for _ in range(_SETTINGS.most_widenings):
        if not (margins <= _SETTINGS.largest_margin).all():
            break
        tube = replace(motion_tube, lower=motion_tube.lower - margins, upper=motion_tube.upper + margins)
        try:
            along = certify(model, tube, effort=_SETTINGS.certificate_positions).along
        except GdAnalyzeError:  # its program is too long to be written out
            break
        assert along is not None  # of a tube
        unexpected = np.einsum("kpij,pj->kpi", inverse, along).max(axis=(0, 1))
        needed = np.outer(world.gains.margins, unexpected)
        if (needed <= margins).all():
            return CertifiedTracking(along.max(axis=0), needed[0])
        margins = _SETTINGS.widening_factor * np.maximum(needed, margins)
    return None


def _needed(world: World, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
    """Torque of the arm that moves, with its friction, (n, K)."""
    return np.asarray(_torque(world.plant.program, q, qd, qdd) + world.resistance(qd.T).T)


def _inertia(program: Program, q: FloatArray) -> FloatArray:
    """D at positions (n, K), shape (K, n, n)."""
    return ProgramDynamics(program, *q.shape).at(q, np.zeros_like(q))[0]


def _torque(program: Program, *states: FloatArray) -> FloatArray:
    """Torque (n, K) at states of that shape."""
    inputs = zip(("q", "qd", "qdd"), states, strict=True)
    return program.run({f"{name}{i + 1}": row for name, rows in inputs for i, row in enumerate(rows)})
