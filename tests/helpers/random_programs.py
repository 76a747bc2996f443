"""Random programs as trees: a leaf is an input or a constant, a node an operation on earlier ones."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from hypothesis import strategies as st

from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace

INPUTS = 3
OPERATORS = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "negative": operator.neg,
}


def trees_of(most: float, leaves: int) -> st.SearchStrategy[Any]:
    """Trees of so many leaves at most, and constants between -most and most."""
    constants = st.sampled_from([0.0, 1.0, -1.0, 2.0, -0.5]) | st.floats(-most, most, allow_subnormal=False)
    return st.recursive(
        st.integers(0, INPUTS - 1) | constants,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(["add", "subtract", "multiply"]), inner, inner),
            st.tuples(st.sampled_from(["negative", "cos", "sin"]), inner),
        ),
        max_leaves=leaves,
    )


trees = trees_of(3.0, 25)


def program_of(*roots: Any, names: Sequence[str] = ("x1", "x2", "x3")) -> Program:
    """Trace some trees of the inputs of these names."""
    trace = Trace()
    symbols = [trace.record("input", name) for name in names]
    functions = {name: partial(trace.apply, name) for name in ("cos", "sin")}
    return Program.of(trace, [_built(root, symbols, OPERATORS | functions) for root in roots])


def evaluated(root: Any, inputs: Sequence[Any]) -> Any:
    """Value of a tree; inputs are arrays, or plain numbers, which are then constants."""
    return _built(root, inputs, OPERATORS | {"cos": _cos, "sin": _sin})


def _built(tree: Any, inputs: Sequence[Any], functions: dict[str, Any]) -> Any:
    if isinstance(tree, int):
        return inputs[tree]
    if isinstance(tree, float):
        return tree
    operation, *arguments = tree
    return functions[operation](*(_built(argument, inputs, functions) for argument in arguments))


def _cos(x: Any) -> Any:
    # The cosine of a constant is taken by the C library when tracing, of an array by NumPy.
    return math.cos(x) if isinstance(x, float) else np.cos(x)


def _sin(x: Any) -> Any:
    return math.sin(x) if isinstance(x, float) else np.sin(x)
