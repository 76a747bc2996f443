"""Recursions with something left out, their errors, and a search for the largest."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link, Placement
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursion import NUMBER, Change
from made_models import promising_nothing
from strategies import random_inertia, random_rotation


def model_of(arm: RobotArm, program: Program) -> SimplifiedModel:
    """A model that is this program and promises nothing."""
    return promising_nothing(ExactForm(arm), TERM, {}, program)


def pruned(arm: RobotArm, share: float, rng: np.random.Generator) -> SimplifiedModel:
    """The exact recursion with products replaced by nothing, and sines and cosines by numbers."""
    recursion = ExactForm(arm).recursion
    changes = {}
    for place, step in enumerate(recursion.steps):
        if rng.random() < share and step.operation in ("multiply", "cos", "sin"):
            changes[Change(place, NUMBER)] = 0.0 if step.operation == "multiply" else float(rng.normal())
    return model_of(arm, recursion.changed(changes))


def errors_at(model: SimplifiedModel, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
    """Differences from the exact recursion, shape (N, n)."""
    inputs = inputs_of(States(q, qd, qdd))
    return np.abs(model.program.run(inputs) - model.form.recursion.program.run(inputs)).T


def round_off(model: SimplifiedModel, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> float:
    """Some thousand operations' eps of the largest torques, whose parts may be some ten times larger."""
    inputs = inputs_of(States(q, qd, qdd))
    largest = np.abs(model.program.run(inputs)).max() + np.abs(model.form.recursion.program.run(inputs)).max()
    return 1e4 * float(np.finfo(float).eps) * float(largest)


def searched(model: SimplifiedModel, box: Box, joint: int, rng: np.random.Generator) -> FloatArray:
    """State (3, n) that climbing in all its numbers finds, from the best of many drawn."""
    lower = np.stack([box.lower, -box.velocity, -box.acceleration])
    upper = np.stack([box.upper, box.velocity, box.acceleration])

    def value(states: FloatArray) -> FloatArray:
        return errors_at(model, *states.transpose(1, 0, 2))[:, joint]

    drawn = rng.uniform(lower, upper, (2000, *lower.shape))
    drawn[::2, 1:] = np.sign(drawn[::2, 1:]) * upper[1:]
    best = drawn[value(drawn).argmax()]
    for step in (0.2, 0.1, 0.05, 0.02, 0.01):
        for _ in range(4):
            moves = step * rng.normal(size=(300, *lower.shape)) * (rng.random((300, *lower.shape)) < 0.3)
            tried = np.clip(best + moves * (upper - lower), lower, upper)
            tried[0] = best
            best = tried[value(tried).argmax()]
    return best


def general_arm(joints: int, rng: np.random.Generator, slides: bool) -> RobotArm:
    """Axes in any direction, full inertias; perhaps the third joint slides."""
    made, links = [], []
    for i in range(joints):
        placement = Placement(random_rotation(rng), rng.uniform(-0.3, 0.3, 3))
        made.append(Joint(f"joint {i}", "prismatic" if slides and i == 2 else "revolute", placement))
        com = rng.uniform(-0.1, 0.1, 3)
        links.append(Link(f"link {i}", rng.uniform(0.5, 3.0), com, random_inertia(rng), Placement()))
    return RobotArm("general", tuple(made), tuple(links), np.array([0.0, 0.0, -9.81]))
