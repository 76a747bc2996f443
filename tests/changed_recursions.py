"""Recursions changed at random: as a search changes them, or with something left out; and their errors."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.motions.states import States
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.exact import ExactDynamics, ExactForm
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Change, Changes, Recursion
from gd_analyze.simplification.recursion_losses import torque_alone
from made_models import promising_nothing


def random_changes(recursion: Recursion, share: float, seed: int) -> dict[Change, float]:
    """Change a share of the steps: summands dropped, sines taken as constant, numbers changed, steps gone.

    What comes out is a torque: of degree two in the velocities, one in the accelerations.
    """
    rng = np.random.default_rng(seed)
    place = {step.order: k for k, step in enumerate(recursion.steps)}
    changes: dict[Change, float] = {}
    for k in recursion.carried_out({}).images:
        step = recursion.steps[k]
        operands = [place[x.order] for x in step.arguments if isinstance(x, Expression)]
        if step.operation not in ("add", "subtract", "multiply") or rng.random() > share:
            continue
        gone, which = rng.random() < 0.2, int(rng.integers(len(operands)))
        if gone:
            changes[Change(k, NUMBER)] = 0.0
        elif len(operands) < 2 and step.operation == "multiply":
            changes[Change(k, CONSTANT)] = float(step.arguments[0] * rng.uniform(0.5, 1.5))
        elif step.operation == "multiply":
            functions = [x for x in operands if recursion.steps[x].operation in ("cos", "sin")]
            if len(functions) != 1:
                continue
            (which,) = (place for place, x in enumerate(operands) if x not in functions)
            changes[Change(k, operands[which])] = float(rng.uniform(-1.0, 1.0))
        elif len(operands) == 2:
            second = step.arguments[1]
            negative = step.operation == "subtract" and place[second.order] == operands[which]
            changes[Change(k, operands[which])] = -1.0 if negative else 1.0
    return changes


def summands_dropped(
    exact: ExactDynamics, allowed: FloatArray, *, start: Changes | None = None, **_: object
) -> dict[Change, float]:
    """Stand in for a search where only what it leads to matters: summands go, the least missed first."""
    recursion = exact.form.recursion
    candidates = [
        {k: {recursion.arguments[k][0]: 1.0}}
        for k in recursion.carried_out({}).images
        if recursion.steps[k].operation in ("add", "subtract")
        and all(isinstance(x, int) for x in recursion.arguments[k])
    ]
    torque, _peak = torque_alone(recursion, candidates, exact.states)
    shares = (torque / np.maximum(allowed, 1e-9)).max(axis=1)
    ordered = [candidates[k] for k in np.argsort(shares, kind="stable")]
    inputs = inputs_of(exact.states)
    wanted = recursion.program.run(inputs)

    def first(count: int) -> dict[Change, float]:
        return {Change(k, a): c for one in ordered[:count] for k, to in one.items() for a, c in to.items()}

    def fits(count: int) -> bool:
        error = np.abs(recursion.changed(first(count)).run(inputs) - wanted).max(axis=1)
        return bool((error <= allowed).all())

    few, many = 0, len(ordered) + 1
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (middle, many) if fits(middle) else (few, middle)
    return first(few)


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
