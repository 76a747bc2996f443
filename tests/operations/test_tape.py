"""Tapes: values and slopes against the program run and differentiated otherwise, needs against the graph."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from random_programs import INPUTS, program_of, trees

from gd_analyze.operations.program import Program
from gd_analyze.operations.tape import Tape
from gd_analyze.operations.trace import Expression, Trace, reached
from strategies import examples

_EPS = float(np.finfo(float).eps)


def _inputs(seed: int, count: int = 5) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {f"x{k + 1}": rng.uniform(-1.0, 1.0, count) for k in range(INPUTS)}


@examples(25)
@given(roots=st.lists(trees, min_size=1, max_size=3), seed=st.integers(0, 2**16))
def test_values_are_those_of_the_program(roots: list[object], seed: int) -> None:
    program, inputs = program_of(*roots), _inputs(seed)
    tape = Tape(program)
    with np.errstate(over="ignore", invalid="ignore"):
        got, wanted = tape.results(tape.values(inputs)), program.run(inputs)
    # The same operations in the same order.
    np.testing.assert_array_equal(got, wanted)


def _program() -> Program:
    trace = Trace()
    x, y, z = trace.inputs("x", 3)[:, 0]
    turned = 2.5 * (np.cos(x) * y) - z
    return Program.of(trace, [turned * y + 0.5 * z, 3.0 * turned, -(y * z)])


def test_slopes_are_what_a_step_makes_of_the_outputs() -> None:
    program, inputs = _program(), _inputs(1)
    tape = Tape(program)
    values = tape.values(inputs)
    slopes = tape.slopes(values, tape.numbers, np.array([1.0, 2.0, 1.0]))
    for k, step in enumerate(tape.steps):
        if tape.is_angle[k] and step.operation == "input" and step.arguments[0] == "x1":
            continue  # it only goes into a cosine
        moved = _outputs_with(program, inputs, k, 1e-6) - _outputs_with(program, inputs, k, -1e-6)
        # Every output is at most quadratic in a step, so central differences err by rounding alone.
        wanted = moved / 2e-6 * np.array([1.0, 2.0, 1.0])[:, None]
        np.testing.assert_allclose(slopes[k], wanted, atol=100 * _EPS / 1e-6)


def _outputs_with(program: Program, inputs: dict[str, np.ndarray], k: int, added: float) -> np.ndarray:
    """Outputs with something added to the value of one step."""
    known: dict[int, np.ndarray] = {}
    functions = {"add": np.add, "subtract": np.subtract, "multiply": np.multiply}
    single = {"negative": np.negative, "cos": np.cos, "sin": np.sin}
    for place, step in enumerate(program.steps):
        if step.operation == "input":
            value = inputs[step.arguments[0]]
        else:
            values = [known[x.order] if isinstance(x, Expression) else x for x in step.arguments]
            value = (functions | single)[step.operation](*values)
        known[step.order] = value + (added if place == k else 0.0)
    return np.array([known[output.order] for output in program.outputs])


def test_numbers_can_be_others() -> None:
    program, inputs = _program(), _inputs(2)
    tape = Tape(program)
    numbers = tape.numbers.copy()
    numbers[tape.scaled] *= 2.0
    np.testing.assert_allclose(
        tape.values(inputs, numbers)[tape.scaled],
        2.0 * tape.numbers[tape.scaled][:, None] * tape.values(inputs, numbers)[tape.multiplied],
        rtol=4 * _EPS,
    )


@examples(25)
@given(roots=st.lists(trees, min_size=1, max_size=3))
def test_what_is_alone_for_a_step_goes_with_it(roots: list[object]) -> None:
    program = program_of(*roots)
    tape = Tape(program)
    for k, step in enumerate(tape.steps):
        # What outputs still reach when this step is a leaf.
        left = _reached_without(program, step)
        gone = {other.order for other in program.steps} - left
        assert gone == {tape.steps[j].order for j in np.flatnonzero(tape.alone_for[k])}
        assert {tape.steps[j].order for j in np.flatnonzero(tape.needs[k])} == set(reached([step]))


def _reached_without(program: Program, without: Expression) -> set[int]:
    found: set[int] = set()
    waiting = [x for x in program.outputs if isinstance(x, Expression)]
    outputs = {x.order for x in waiting}
    while waiting:
        step = waiting.pop()
        # An output that is the step itself is there whatever stands in for it; so is the step.
        if step.order in found or (step.order == without.order and step.order not in outputs):
            continue
        if step.order == without.order:
            continue
        found.add(step.order)
        waiting += [x for x in step.arguments if isinstance(x, Expression)]
    return found
