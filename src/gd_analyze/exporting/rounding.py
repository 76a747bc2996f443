"""What single precision costs: the program's own roundings, measured."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import UFUNCS, Program
from gd_analyze.text import number, rounded_up

_STATES = 1000
# Other compilers and libraries of sines round otherwise, each as often.
_OTHERS = 2.0


def float_errors_told(subject: ExportInput) -> list[str]:
    """Say how far single precision is from double, joint by joint."""
    if subject.torque is None:
        return []
    errors = float_errors(subject.torque.program, states_in_box(subject.arm, _STATES))
    told = ", ".join(number(rounded_up(_OTHERS * float(error))) for error in errors)
    return [
        f"Single precision: over {_STATES} states drawn from the arm's limits the torque is off",
        f"by at most {told} (joint by joint), on top of the above.",
    ]


def float_errors(program: Program, states: States) -> FloatArray:
    """Largest difference of the torque between single and double precision, N m, shape (n,)."""
    inputs = {
        f"{kind}{j + 1}": values[:, j]
        for kind, values in zip(("q", "qd", "qdd"), states.arrays, strict=True)
        for j in range(values.shape[1])
    }
    single = {name: values.astype(np.float32) for name, values in inputs.items()}
    value = program.carried_out(single.__getitem__, lambda operation, *x: UFUNCS[operation](*x))
    exact = program.run(inputs)
    rough = np.array([np.broadcast_to(np.float32(value(x)), exact.shape[1:]) for x in program.outputs])
    return np.asarray(np.abs(rough - exact).max(axis=1))
