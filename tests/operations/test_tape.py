"""Tapes: values and slopes against the program run and differentiated otherwise, needs against the graph."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from random_programs import INPUTS, program_of, trees

from gd_analyze.operations.program import UFUNCS, Program
from gd_analyze.operations.tape import Tape
from gd_analyze.operations.trace import Expression, Trace, reached
from strategies import examples

EPS = float(np.finfo(float).eps)


def drawn(seed: int) -> dict[str, np.ndarray]:
    return {f"x{k + 1}": row for k, row in enumerate(np.random.default_rng(seed).uniform(-1, 1, (INPUTS, 5)))}


@examples(25)
@given(roots=st.lists(trees, min_size=1, max_size=3), seed=st.integers(0, 2**16))
def test_values_are_those_of_the_program(roots, seed):
    program, inputs = program_of(*roots), drawn(seed)
    tape = Tape(program)
    with np.errstate(over="ignore", invalid="ignore"):
        # The same operations in the same order.
        np.testing.assert_array_equal(tape.results(tape.values(inputs)), program.run(inputs))


def bilinear() -> Program:
    trace = Trace()
    x, y, z = trace.inputs("x", 3)[:, 0]
    turned = 2.5 * (np.cos(x) * y) - z
    return Program.of(trace, [turned * y + 0.5 * z, 3.0 * turned, -(y * z)])


def test_slopes_are_what_a_step_makes_of_the_outputs():
    program, inputs, weights = bilinear(), drawn(1), np.array([1.0, 2.0, 1.0])
    tape = Tape(program)
    slopes = tape.slopes(tape.values(inputs), tape.numbers, weights)

    def outputs_with(changed: int, added: float) -> np.ndarray:
        known: dict[int, np.ndarray] = {}
        for place, step in enumerate(program.steps):
            if step.operation == "input":
                value = inputs[step.arguments[0]]
            else:
                values = [known[x.order] if isinstance(x, Expression) else x for x in step.arguments]
                value = UFUNCS[step.operation](*values)
            known[step.order] = value + (added if place == changed else 0.0)
        return np.array([known[output.order] for output in program.outputs])

    for k, step in enumerate(tape.steps):
        if step.arguments[0] != "x1":  # it only goes into a cosine
            # Every output is at most quadratic in a step, so central differences err by rounding alone.
            wanted = (outputs_with(k, 1e-6) - outputs_with(k, -1e-6)) / 2e-6 * weights[:, None]
            np.testing.assert_allclose(slopes[k], wanted, atol=100 * EPS / 1e-6)


def test_numbers_can_be_others():
    tape, inputs = Tape(bilinear()), drawn(2)
    numbers = tape.numbers.copy()
    numbers[tape.scaled] *= 2.0
    values = tape.values(inputs, numbers)
    wanted = 2.0 * tape.numbers[tape.scaled][:, None] * values[tape.multiplied]
    np.testing.assert_allclose(values[tape.scaled], wanted, rtol=4 * EPS)


@examples(25)
@given(roots=st.lists(trees, min_size=1, max_size=3))
def test_what_is_alone_for_a_step_goes_with_it(roots):
    program = program_of(*roots)
    tape = Tape(program)
    for k, step in enumerate(tape.steps):
        # What outputs still reach when this step is a leaf, and is not itself an output's.
        left: set[int] = set()
        waiting = [x for x in program.outputs if isinstance(x, Expression)]
        while waiting:
            other = waiting.pop()
            if other is not step and other.order not in left:
                left.add(other.order)
                waiting += [x for x in other.arguments if isinstance(x, Expression)]
        gone = {other.order for other in program.steps} - left
        assert gone == {tape.steps[j].order for j in np.flatnonzero(tape.alone_for[k])}
        assert {tape.steps[j].order for j in np.flatnonzero(tape.needs[k])} == set(reached([step]))
