"""How far two evaluations of one program may be apart by rounding: every operation's, carried to the end."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import UFUNCS, Program, program_inputs
from gd_analyze.types import States

# Mass, centre of mass and inertia, as every function that takes a payload is given it.
PAYLOAD = (2.0, 0.1, -0.05, 0.2, 0.02, 0.03, 0.04, 0.001, 0.002, -0.003)
# More than any of the arms here has.
_MOST_PARAMETERS = 60
# Libraries of sines are off by an ulp or two of the result, which is at most eps each.
_SINE = 4.0


def parameters_given(count: int) -> list[float]:
    """Base parameters, as every function that takes them is given them: none is 1 or like its neighbours."""
    return [0.3 * (k % 5) - 0.7 for k in range(count)]


def given_of(states: States) -> dict[str, FloatArray]:
    """Inputs by name; torques are taken for accelerations, which makes no difference to a program."""
    inputs = program_inputs(states) | {f"tau{i + 1}": row for i, row in enumerate(states.last[2])}
    inputs |= {f"payload{i + 1}": np.full(len(states.q), x) for i, x in enumerate(PAYLOAD)}
    parameters = parameters_given(_MOST_PARAMETERS)
    return inputs | {f"parameters{i + 1}": np.full(len(states.q), x) for i, x in enumerate(parameters)}


def evaluated(
    program: Program, states: States, eps: float = float(np.finfo(float).eps)
) -> tuple[FloatArray, FloatArray]:
    """Outputs (outputs, states), and how much two evaluations may differ there.

    An operation is off by eps / 2 of its result; with eps, products of errors are paid for. Either evaluation
    may be off by as much.
    """
    inputs = given_of(states)
    zero = np.zeros(len(states.q))

    def given(name: str) -> Any:
        return inputs[name], zero

    def apply(operation: Any, *arguments: Any) -> Any:
        pairs = [x if isinstance(x, tuple) else (x + zero, zero) for x in arguments]
        values, errors = zip(*pairs, strict=True)
        value = UFUNCS[operation](*values)
        if operation == "multiply":
            error = abs(values[0]) * errors[1] + abs(values[1]) * errors[0] + eps * abs(value)
        elif operation == "divide":
            error = errors[0] / abs(values[1]) + abs(value / values[1]) * errors[1] + eps * abs(value)
        elif operation in ("sin", "cos"):
            error = errors[0] + _SINE * eps
        else:
            error = sum(errors) + (eps * abs(value) if operation != "negative" else 0.0)
        return value, error

    of = program.carried_out(given, apply)
    outputs = [x if isinstance(x, tuple) else (x + zero, zero) for x in map(of, program.outputs)]
    values, errors = (np.array(each) for each in zip(*outputs, strict=True))
    return values, 2.0 * errors


def assert_same(found: FloatArray, program: Program, states: States, eps: float | None = None) -> None:
    """Outputs (outputs, states) of what was printed, against the program."""
    values, bound = evaluated(program, states, *([] if eps is None else [eps]))
    assert found.shape == values.shape
    assert np.isfinite(found).all()
    excess = np.abs(found - values) - bound
    assert excess.max(initial=0.0) <= 0.0, f"{np.abs(found - values).max()} where {bound.max()} is round-off"


def slope(program: Program, states: States, along: str) -> FloatArray:
    """Derivative of the outputs by an input (outputs, states): the complex step, which cancels nothing."""
    step = 1e-30
    inputs: dict[str, Any] = {name: row.astype(complex) for name, row in given_of(states).items()}
    inputs[along] = inputs[along] + 1j * step
    of = program.carried_out(inputs.__getitem__, lambda operation, *x: UFUNCS[operation](*x))
    zero = np.zeros(len(states.q))
    return np.array([np.imag(of(x) + zero) / step for x in program.outputs])
