"""Programs as plain values: what comes back computes the same bits."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_programs import program_of, trees

from gd_analyze.operations.program import read_back, written
from strategies import examples


@examples(60)
@given(st.lists(trees, min_size=1, max_size=3))
def test_round_trip_is_exact(roots):
    program = program_of(*roots)
    again = read_back(*json.loads(json.dumps(written(program))), {"x1", "x2", "x3"})
    inputs = dict(zip(("x1", "x2", "x3"), np.linspace([-2.0, 1.0, 0.3], [2.0, 0.1, -3.0], 9).T, strict=True))
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
