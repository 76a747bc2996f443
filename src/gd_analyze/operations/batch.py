"""A program on a fixed number of states, called again and again: every step has its row once and for all."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import UFUNCS, Program
from gd_analyze.operations.trace import Expression


class Batch:
    """A program laid out for so many states; a call costs one vector operation per step and nothing else.

    Parameters
    ----------
    program
        The program.
    count
        States of one call.
    """

    def __init__(self, program: Program, count: int) -> None:
        self.count = count
        self._inputs: dict[str, FloatArray] = {}
        self._calls: list[tuple[Any, tuple[Any, ...]]] = []
        rows: dict[int, FloatArray] = {}

        def of(x: Any) -> Any:
            return rows[x.order] if isinstance(x, Expression) else float(x)

        for step in program.steps:
            row = rows[step.order] = np.zeros(count)
            if step.operation == "input":
                self._inputs[step.arguments[0]] = row
            else:
                self._calls.append((UFUNCS[step.operation], (*map(of, step.arguments), row)))
        self._outputs = [of(output) for output in program.outputs]

    def rows(self, name: str, joints: int, *shape: int) -> list[tuple[int, FloatArray]]:
        """Where values of an input by joint are put, with the joint, from 0; what is not needed has none."""
        return [
            (i, self._inputs[f"{name}{i + 1}"].reshape(*shape or (self.count,)))
            for i in range(joints)
            if f"{name}{i + 1}" in self._inputs
        ]

    def run(self) -> FloatArray:
        """Outputs of what stands in the rows, shape (outputs, count)."""
        for function, arguments in self._calls:
            function(*arguments)
        out = np.empty((len(self._outputs), self.count))
        for row, output in zip(out, self._outputs, strict=True):
            row[:] = output
        return out
