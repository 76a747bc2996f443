"""Programs changed without a search: summands dropped, numbers rounded, steps gone; and their errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import Program, program_inputs
from gd_analyze.operations.trace import Expression, Trace
from gd_analyze.simplification.fast import FAST
from gd_analyze.simplification.fast_search import FastSearch, FastSettings
from gd_analyze.types import Box, ExactDynamics, ExactForm, RobotArm, SimplifiedModel, States
from made_models import promising_nothing


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


def without_first(program: Program, places: Sequence[int]) -> Program:
    """The program without the first summand of the sums and differences at some places."""
    kinds = {"add": _second, "subtract": _minus_second}
    return changed(program, {place: kinds[program.steps[place].operation] for place in places})


def _second(a: Any, b: Any) -> Any:
    return b


def _minus_second(a: Any, b: Any) -> Any:
    return -b


def _number(value: float, *_: Any) -> float:
    return value


def sums_of(program: Program) -> list[int]:
    """Places of the sums and differences of two steps."""
    return [
        place
        for place, step in enumerate(program.steps)
        if step.operation in ("add", "subtract") and all(isinstance(x, Expression) for x in step.arguments)
    ]


def summands_dropped(exact: ExactDynamics, allowed: FloatArray) -> Program:
    """As many summands dropped as the errors allow, those first that alone cost least."""
    program, some = exact.form.program, exact.thinned(200)

    def share(places: Sequence[int], over: ExactDynamics) -> float:
        inputs, weights = program_inputs(over.states), over.states.weights
        off = np.abs(without_first(program, places).run(inputs) - program.run(inputs))
        off = off if weights is None else off * weights.T
        with np.errstate(divide="ignore"):  # nothing may be off at a joint without torque
            return float(np.divide(off, allowed[:, None], out=np.zeros_like(off), where=off > 0.0).max())

    ordered = sorted(sums_of(program), key=lambda place: (share([place], some), place))
    few, many = 0, len(ordered) + 1
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (middle, many) if share(ordered[:middle], exact) <= 1.0 else (few, middle)
    return without_first(program, ordered[:few])


class WithoutSearch(FastSearch):
    """Stands in for a search where only what comes of it matters: summands are dropped, without Numba."""

    def __init__(self, exact: ExactDynamics, allowed: FloatArray, *_: Any, **__: Any) -> None:
        self.exact, self.given, self.allowed, self.stopped = exact, allowed, allowed, ""
        self.settings = FastSettings(searches=1)

    def program(self, turn: int) -> Program:
        return summands_dropped(self.exact, self.allowed)

    def is_best(self) -> bool:
        return True

    def learn(self, further: ExactDynamics, share: FloatArray) -> None:
        q, qd, qdd = further.states.arrays
        if len(q):
            self.exact = self.exact.joined_by(np.stack([q, qd, qdd]), further.states.weights)
        self.allowed = self.given * share


def skip_searches(patch: pytest.MonkeyPatch) -> None:
    """Let level fast drop summands: what follows a search is tested without the minute it compiles."""
    for place in ("simplification.fast_search", "certification.program_holding"):
        patch.setattr(f"gd_analyze.{place}.FastSearch", WithoutSearch)


def skip_proofs(patch: pytest.MonkeyPatch) -> None:
    """Let every program be too long for a proof, so that states are tried."""
    patch.setattr("gd_analyze.certification.program_holding.usual_effort", lambda *_: None)


def fast_model(exact: ExactDynamics, budget: str, program: Program | None = None) -> SimplifiedModel:
    """A program, by default that of dropped summands, stated as a search states what it found."""
    search = WithoutSearch(exact, exact.allowed(budget))
    return search.model(search.program(0) if program is None else program, budget, exact)


def model_of(arm: RobotArm, program: Program) -> SimplifiedModel:
    """A model that is this program and promises nothing."""
    return promising_nothing(ExactForm(arm), FAST, {}, program)


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
