"""Errors of models by the formulation in closed form, and adversaries that look for large ones."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_model
from gd_analyze.harmonics.terms import Torques
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.types import ExactForm
from made_models import model_of


def model_with(arm: gd.types.RobotArm, torques: Torques) -> gd.types.SimplifiedModel:
    """A model of torque terms; of those of D' the upper triangle stands for both."""
    form = ExactForm(arm)
    upper = {t: w for t, w in torques.items() if t.quantity != "inertia" or t.row <= t.velocities[0].joint}
    return model_of(form, TERM, upper)


def damaged(arm: gd.types.RobotArm, rng: np.random.Generator) -> gd.types.SimplifiedModel:
    """A model that lacks some torque terms and has others with wrong coefficients."""
    every = TERM.terms(ExactForm(arm))
    torques = {t: w * (0.9 if rng.random() < 0.3 else 1.0) for t, w in every.items()}
    return model_with(arm, {t: w for t, w in torques.items() if rng.random() < 0.7})


def errors_at(model: gd.types.SimplifiedModel, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """Shape (N, n)."""
    states = gd.types.States(q, qd, qdd)
    exact = gd.tables.decompose_states(model.arm, states, christoffel=False, drives=model.drives)["torque"]
    return np.abs(model.torque(q, qd, qdd) - exact)


def round_off(model: gd.types.SimplifiedModel, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> float:
    """Round-off of two programs of one torque: some hundred eps of the largest, or of its larger terms."""
    return 1e-12 * float(np.abs(model.torque(q, qd, qdd)).max() + errors_at(model, q, qd, qdd).max())


def round_off_in(model: gd.types.SimplifiedModel, tube: gd.types.Tube) -> float:
    box = tube.enclosing
    farthest = (box.farthest[None], box.velocity[None], box.acceleration[None])
    return round_off(model, *farthest) * (1.0 + float(box.farthest.max())) ** 2


def drawn_box(arm: gd.types.RobotArm, rng: np.random.Generator) -> gd.types.Box:
    """Ranges from none to more than a turn."""
    n = arm.n_joints
    middle, half = rng.uniform(-1.0, 1.0, n), rng.choice([0.0, 0.3, 1.5, 4.0], n)
    return gd.types.Box(middle - half, middle + half, rng.uniform(0.0, 2.0, n), rng.uniform(0.0, 5.0, n))


def drawn_states(box: gd.types.Box, count: int, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """States of a box, most of them with velocities, accelerations and some positions at their limits."""
    n = box.n_joints
    signs = np.where(rng.random((2, count, n)) < 0.5, 1.0, -1.0)
    q = rng.uniform(box.lower, box.upper, (count, n))
    q = np.where(rng.random((count, n)) < 0.2, np.where(signs[0] > 0, box.lower, box.upper), q)
    shares = rng.choice([1.0, 0.5, 0.0], (count, n), p=[0.8, 0.1, 0.1])
    return q, signs[0] * shares * box.velocity, signs[1] * box.acceleration


def largest_excess(
    model: gd.types.SimplifiedModel,
    tube: gd.types.Tube,
    along: np.ndarray,
    rng: np.random.Generator,
    rounds: int = 1,
) -> float:
    """Largest error above the bounds of the pieces (pieces, n) that an adversary finds.

    From corners and drawn states of every piece it climbs: variable after variable goes to the end where the
    error of one joint, another in every run, is larger.
    """
    pieces = np.concatenate([np.arange(len(tube)), rng.integers(0, len(tube), 100)])
    lower, upper = tube.lower[pieces], tube.upper[pieces]
    states = np.where(rng.random(lower.shape) < 0.5, lower, upper)
    inside = rng.random(len(pieces)) < 0.3
    states[inside] = rng.uniform(lower[inside], upper[inside])
    joints, rows = rng.integers(0, tube.n_joints, len(pieces)), np.arange(len(pieces))
    excess = -np.inf
    for turn in range(rounds * 3 * tube.n_joints):
        kind, k = (turn // tube.n_joints) % 3, turn % tube.n_joints
        tried = np.stack([states, states, states])
        tried[1][:, kind, k], tried[2][:, kind, k] = lower[:, kind, k], upper[:, kind, k]
        errors = errors_at(model, *tried.reshape(-1, 3, tube.n_joints).transpose(1, 0, 2))
        errors = errors.reshape(3, len(pieces), -1)
        excess = max(excess, float((errors - along[pieces]).max()))
        states = tried[errors[:, rows, joints].argmax(axis=0), rows]
    return excess


def drawn_motion(arm: gd.types.RobotArm, rng: np.random.Generator) -> gd.Trajectory:
    """Smooth and finely sampled, smooth and coarse, or set points that contradict one another."""
    n, count = arm.n_joints, int(rng.choice([2, 4, 25]))
    time = np.linspace(0.0, 1.5, count)
    speed, size, phase = rng.uniform(0.5, 4.0, n), rng.choice([0.0, 0.2, 1.0], n), rng.uniform(0.0, 6.0, n)
    angle = np.outer(time, speed) + phase
    q, qd, qdd = size * np.sin(angle), size * speed * np.cos(angle), -size * speed**2 * np.sin(angle)
    if rng.random() < 0.25:
        qd, qdd = rng.uniform(-2.0, 2.0, (2, count, n))
    return gd.Trajectory(time, q, qd, qdd)


def ascended(
    model: gd.types.SimplifiedModel, box: gd.types.Box, rng: np.random.Generator, restarts: int
) -> np.ndarray:
    """Largest error of every joint (n,) by quasi-Newton ascents over q, qd, qdd; exact torque by Pinocchio.

    Every second start is the worst of some hundred random states, the others are one of these.
    """
    robot, n, slope = pinocchio_model(model.arm), model.arm.n_joints, 1e-6
    data, drives = robot.createData(), model.arm.drive_inertia if model.drives else np.zeros(n)
    middle = np.concatenate([box.centre, np.zeros(2 * n)])
    half = np.concatenate([(box.upper - box.lower) / 2, box.velocity, box.acceleration])
    allowed, moves = model.accuracy.allowed, slope * np.vstack([np.eye(3 * n), -np.eye(3 * n)])

    def errors(shares: np.ndarray) -> np.ndarray:
        q, qd, qdd = np.split(middle + half * shares, 3, axis=1)
        exact = [pin.rnea(robot, data, *state) for state in zip(q, qd, qdd, strict=True)]
        return model.torque(q, qd, qdd) - exact - drives * qdd

    def descent(x: np.ndarray, joint: int, sign: float) -> tuple[float, np.ndarray]:
        value, *around = -sign * errors(np.vstack([x, x + moves]))[:, joint] / allowed[joint]
        ahead, behind = np.split(np.array(around), 2)
        return value, (ahead - behind) / (2 * slope)

    largest = np.zeros(n)
    for joint in range(n):
        for turn in range(restarts):
            drawn = rng.uniform(-1.0, 1.0, (300, 3 * n))
            drawn[:, n:] = np.sign(drawn[:, n:])
            there = errors(drawn)[:, joint]
            start = int(np.abs(there).argmax()) if turn % 2 == 0 else 0
            options = {"args": (joint, np.sign(there[start])), "bounds": [(-1.0, 1.0)] * (3 * n)}
            end = minimize(descent, drawn[start], jac=True, method="L-BFGS-B", **options)
            largest = np.maximum(largest, np.abs(errors(end.x[None])[0]))
    return largest
