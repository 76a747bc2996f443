"""Programs as plain values: what comes back computes the same bits."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.operations.program import Program, read_back, written
from gd_analyze.operations.trace import Trace
from strategies import examples


def drawn_program(seed: int, steps: int) -> Program:
    """Random sums, differences, products, sines and signs of two inputs and constants."""
    rng = np.random.default_rng(seed)
    trace = Trace()
    values = [*trace.inputs("q", 2)[:, 0], 0.7, -2.5]
    for _ in range(steps):
        a, b = (values[k] for k in rng.integers(0, len(values), 2))
        kind = rng.integers(0, 5)
        if kind == 3:
            values.append(-a)
        elif kind == 4:
            values.append(trace.apply("sin", a))
        else:
            values.append((a + b, a - b, a * b)[kind])
    return Program.of(trace, values[-3:])


@examples(60)
@given(st.integers(0, 2**32 - 1), st.integers(0, 25))
def test_round_trip_is_exact(seed, steps):
    program = drawn_program(seed, steps)
    again = read_back(*json.loads(json.dumps(written(program))), {"q1", "q2"})
    inputs = {"q1": np.linspace(-2.0, 2.0, 9), "q2": np.linspace(1.0, 0.1, 9)}
    np.testing.assert_array_equal(again.run(inputs), program.run(inputs))
    assert again.count == program.count
    assert written(again) == written(program)


REFUSED = {
    "no operation": ([["divide", "s0", 1.0]], "is no operation"),
    "a name for a step": ([["input", "q1"], ["cos", "q1"]], "no earlier step"),
    "not a number": ([["input", "q1"], ["add", "s0", float("nan")]], "is no number of a torque"),
    "an unknown input": ([["input", "time"]], "no input"),
    "twice": ([["input", "q1"], ["input", "q1"]], "is there twice"),
}


@pytest.mark.parametrize(("steps", "told"), REFUSED.values(), ids=REFUSED.keys())
def test_refused(steps, told):
    with pytest.raises(ValueError, match=told):
        read_back(steps, [], {"q1"})
