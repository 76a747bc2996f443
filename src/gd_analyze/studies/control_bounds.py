"""What tracking error a controller's torque error can cause.

With u = M (K_d e' + K_p e) + b on the arm D qdd + h + c = u follows

    e'' + K_d e' + K_p e = M^-1 (D qdd + h + c + M e'' - b).

Of computed torque b is M qdd_d + ..., so that the bracket is minus the model's torque error at the states
and accelerations that the arm really takes. What the right side is at most, times `Gains`'s integral, bounds
the error. `expected` takes D qdd_d + h + c - b at the motion's own states. That is right to first order, and
for a constant M where the error changes slowly beside the loop. `certified` takes what is proven of the
torque error within margins around the motion that the error cannot leave.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray
from gd_analyze.certification.certificate import certify
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Program
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.control_law import Bank, Controller
from gd_analyze.studies.control_loop import World
from gd_analyze.studies.control_plant import Dynamics, Plant, Reference, at_speed

# Margins beyond which a bound says nothing, rad (m) and per s and s^2; positions that a certificate looks at.
_FARTHEST, _EFFORT = 10.0, 25_000
# A large part: of inertia, of feedback.
_MUCH = 0.5
# Instants at which the motion is looked at; how often margins are widened, and by how much more than needed.
_INSTANTS, _ROUNDS, _WIDER = 500, 6, 1.25


@dataclass(frozen=True, eq=False)
class CertifiedTracking:
    """What is proven of computed torque with a simplified model.

    Parameters
    ----------
    torque_error
        No state within the margins of the motion has a larger one, N m (N), shape (n,).
    error
        A continuous loop within its torque limits, begun on the motion, tracks no worse, rad (m), shape (n,).
    """

    torque_error: FloatArray
    error: FloatArray


@dataclass(frozen=True)
class FeedbackLeft:
    """What computed torque with a simplified model leaves of the feedback where that is least.

    Parameters
    ----------
    share
        Of the feedback that the gains ask for; of 0 or less an error in some direction stays, or grows.
    joints
        Which ones move in that direction, or have less than half of their inertia in the model, from 1.
    """

    share: float
    joints: tuple[int, ...]

    @property
    def is_enough(self) -> bool:
        """Whether at least half of it is left."""
        return self.share >= _MUCH


def instants(reference: Reference) -> FloatArray:
    """Instants at which a motion is looked at, s as planned: evenly spaced ones and all set points."""
    return np.unique(np.concatenate([np.linspace(0.0, reference.duration, _INSTANTS), reference.time]))


def feedback_left(model: SimplifiedModel, reference: Reference) -> FeedbackLeft:
    """Find what computed torque with a model leaves of the feedback along the motion.

    Its feedback accelerates the arm by D^-1 M (K_d e' + K_p e), M being the model's D: in the direction of an
    eigenvector of D^-1 M with as much as the eigenvalue of what it should be.
    """
    q, _, _ = reference.at(instants(reference))
    exact, own = (_inertia(program, q) for program in (model.form.program, model.program))
    values, vectors = np.linalg.eig(np.linalg.solve(exact, own))
    at, which = np.unravel_index(int(values.real.argmin()), values.shape)
    diagonal = np.einsum("kii->ki", exact)
    # In units in which every joint takes as much to accelerate.
    direction = np.abs(vectors[at, :, which]) * np.sqrt(diagonal[at])
    moves = direction >= _MUCH * direction.max()
    lacks = (np.einsum("kii->ki", own) / diagonal).min(axis=0) < _MUCH
    joints = tuple((1 + np.flatnonzero(moves | lacks)).tolist())
    return FeedbackLeft(float(values.real.min()), joints)


def fixed_excess(world: World) -> float:
    """How many times what the gains ask for fixed gains are where they are most along the motion.

    Feedback accelerates the arm by D^-1 M (K_d e' + K_p e), M being the constants: at most by the largest
    eigenvalue of D^-1 M times what was asked for.
    """
    q, _, _ = world.reference.at(instants(world.reference))
    excess = np.linalg.solve(_inertia(world.plant.program, q), np.diag(world.knowledge.diagonal))
    return float(np.linalg.eigvals(excess).real.max())


def mean_diagonal(form: ExactForm, reference: Reference) -> FloatArray:
    """Mean of D's diagonal along the motion, kg m^2 (kg), shape (n,)."""
    q, _, _ = reference.at(np.linspace(0.0, reference.duration, _INSTANTS))
    return np.asarray(np.einsum("kii->i", _inertia(form.program, q)) / q.shape[1])


def expected(world: World, controller: Controller, speed: float) -> FloatArray:
    """Tracking error that what a controller lacks along the motion causes at most, rad (m), shape (n,).

    Infinite where the D that it uses is singular.
    """
    missing, inertia = _missing(world, controller, speed)
    try:
        unexpected = np.linalg.solve(inertia, missing.T[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return np.full(len(missing), np.inf)
    return np.asarray(np.abs(unexpected).max(axis=0) * world.gains.error_per_acceleration)


def at_rest(world: World, controller: Controller) -> FloatArray:
    """Largest error with which PD rests at positions of the motion, rad (m), shape (n,).

    It is the gravity not made up for, over the stiffness K_p M of each joint.
    """
    q, _, _ = world.reference.at(instants(world.reference))
    still = np.zeros_like(q)
    bank = Bank([controller] * q.shape[1], world.knowledge, world.gains)
    needed = _torque(world.plant.program, q, still, still)
    missing = np.abs(needed - bank.torque(q, still, (q, still, still))).max(axis=1)
    missing[missing <= ROUND_OFF_SHARE * np.abs(needed).max()] = 0.0
    stiffness = world.gains.stiffness * world.knowledge.diagonal
    return np.asarray(missing / stiffness)


def certified(
    model: SimplifiedModel, world: World, motion: Trajectory, speed: float
) -> CertifiedTracking | None:
    """Bound the error of computed torque with the model; None where no margins close, or M is not definite.

    Margins begin with those between the set points and are widened until they hold the error that they
    allow. M is looked at where the tube's pieces begin, in their middle and where they end.
    """
    run = at_speed(motion, speed)
    bare = Tube.along(model.arm, run, "0deg,0mm,qd=0%,qdd=0%")
    times = np.linspace(bare.begin, bare.end, 3) - run.time[0]
    q, _, _ = world.reference.at(times, speed)
    n = model.arm.n_joints
    inertia = _inertia(model.program, q.reshape(n, -1))
    if np.linalg.eigvalsh(inertia + np.swapaxes(inertia, 1, 2)).min() <= 0.0:
        return None
    answers = np.abs(np.linalg.inv(inertia)).reshape(*times.shape, n, n)
    sizes = np.array(world.gains.margins)[:, None]
    margins = np.zeros((3, n))
    for _ in range(_ROUNDS):
        if not (margins <= _FARTHEST).all():
            return None
        tube = replace(bare, lower=bare.lower - margins, upper=bare.upper + margins)
        try:
            along = certify(model, tube, effort=_EFFORT).along
        except GdAnalyzeError:  # its program is too long to be written out
            return None
        assert along is not None  # of a tube
        unexpected = np.einsum("kpij,pj->kpi", answers, along).max(axis=(0, 1))
        needed = sizes * unexpected
        if (needed <= margins).all():
            return CertifiedTracking(along.max(axis=0), needed[0])
        margins = _WIDER * np.maximum(needed, margins)
    return None


def _missing(world: World, controller: Controller, speed: float) -> tuple[FloatArray, FloatArray]:
    """Torque (n, K) that a controller lacks on the motion, and its M there, shape (K, n, n)."""
    q, qd, qdd = world.reference.at(instants(world.reference) / speed, speed)
    count = q.shape[1]
    bank = Bank([controller] * count, world.knowledge, world.gains)
    needed = _torque(world.plant.program, q, qd, qdd)
    if world.friction:
        needed = needed + Plant(world.plant, True, count).resistance(qd)
    if controller.multiplies:
        simplified = controller.knows == "simplified"
        program = world.knowledge.simplified if simplified else world.knowledge.exact
        inertia = _inertia(program, q)
    else:
        inertia = np.broadcast_to(np.diag(world.knowledge.diagonal), (count, len(q), len(q)))
    return needed - bank.torque(q, qd, (q, qd, qdd)), inertia


def _inertia(program: Program, q: FloatArray) -> FloatArray:
    """D at positions (n, K), shape (K, n, n)."""
    return Dynamics(program, *q.shape).at(q, np.zeros_like(q))[0]


def _torque(program: Program, *states: FloatArray) -> FloatArray:
    """Torque (n, K) at states of that shape."""
    inputs = zip(("q", "qd", "qdd"), states, strict=True)
    return program.run({f"{name}{i + 1}": row for name, rows in inputs for i, row in enumerate(rows)})
