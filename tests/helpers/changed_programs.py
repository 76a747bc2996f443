"""Programs changed without a search: numbers rounded, steps gone; and their errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.operations.trace import Expression, Trace
from gd_analyze.types import Box, ExactForm, RobotArm, SimplifiedModel, States
from made_models import running


def changed(program: Program, instead: Mapping[int, Callable[..., Any]]) -> Program:
    """The program with other operations at some places, each of which takes the arguments of its step."""
    trace = Trace()
    known: dict[int, Any] = {}

    def of(x: Any) -> Any:
        return known[x.order] if isinstance(x, Expression) else x

    for place, step in enumerate(program.steps):
        if step.operation == "input":
            known[step.order] = trace.record("input", *step.arguments)
        else:
            own = instead.get(place, partial(trace.apply, step.operation))
            known[step.order] = own(*map(of, step.arguments))
    return Program.of(trace, [of(output) for output in program.outputs])


def rounded(program: Program, digits: int = 3) -> Program:
    """The program with numbers of so many digits, the same on every machine."""
    trace = Trace()

    def apply(operation: Any, *arguments: Any) -> Any:
        own = [float(f"{x:.{digits}g}") if isinstance(x, float) else x for x in arguments]
        return trace.apply(operation, *own)

    of = program.carried_out(partial(trace.record, "input"), apply)
    return Program.of(trace, [of(output) for output in program.outputs])


def _number(value: float, *_: Any) -> float:
    return value


def model_of(arm: RobotArm, program: Program) -> SimplifiedModel:
    """A model that is this program and promises nothing."""
    return running(program, ExactForm(arm))


def pruned(arm: RobotArm, share: float, rng: np.random.Generator) -> SimplifiedModel:
    """The recursion with products replaced by nothing, and sines and cosines by numbers."""
    program = ExactForm(arm).recursion
    instead = {
        place: partial(_number, 0.0 if step.operation == "multiply" else float(rng.normal()))
        for place, step in enumerate(program.steps)
        if rng.random() < share and step.operation in ("multiply", "cos", "sin")
    }
    return model_of(arm, changed(program, instead))


def errors_at(model: SimplifiedModel, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
    """Differences from the recursion, shape (N, n)."""
    inputs = program_inputs(States(q, qd, qdd))
    return np.abs(model.program.run(inputs) - model.form.recursion.run(inputs)).T


def round_off(model: SimplifiedModel, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> float:
    """Some thousand operations' eps of the largest torques, whose parts may be some ten times larger."""
    inputs = program_inputs(States(q, qd, qdd))
    largest = np.abs(model.program.run(inputs)).max() + np.abs(model.form.recursion.run(inputs)).max()
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
