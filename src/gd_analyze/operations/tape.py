"""A program whose numbers may change: values of its steps, derivatives of its outputs, dependencies.

The factors of steps are separate from the program, so that fitting changes them without rewriting it.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import UFUNCS, Program
from gd_analyze.operations.trace import Expression, Operation


class Tape:
    """A program's steps by number; `free` are the orders of those whose factors may change.

    By default these are all steps with a numeric factor.
    """

    def __init__(self, program: Program, free: Container[int] | None = None, sine_price: int = 0) -> None:
        self.program, self.steps, self._sine_price = program, program.steps, sine_price
        self.place = {step.order: k for k, step in enumerate(self.steps)}
        self._code: list[tuple[Operation, int, int]] = []
        numbers, scaled = np.full(len(self.steps), np.nan), []
        for k, step in enumerate(self.steps):
            operands = [self._operand(x) for x in step.arguments] if step.operation != "input" else []
            if step.operation == "multiply" and operands[0] < 0:
                numbers[k] = step.arguments[0]
                if free is None or step.order in free:
                    scaled.append(k)
            first, second = (*operands, -1, -1)[:2]
            self._code.append((step.operation, first, second))
        self.numbers: FloatArray = numbers
        # Steps with a factor that may change, and the step that each multiplies.
        self.scaled: NDArray[np.intp] = np.array(scaled, dtype=np.intp)
        self.multiplied: NDArray[np.intp] = np.array([self._code[k][2] for k in scaled], dtype=np.intp)
        self.outputs = tuple(self._operand(x) for x in program.outputs)

    def _operand(self, x: object) -> int:
        return self.place[x.order] if isinstance(x, Expression) else -1

    def __len__(self) -> int:
        return len(self.steps)

    def values(self, inputs: Mapping[str, FloatArray], numbers: FloatArray | None = None) -> FloatArray:
        """Value of every step, shape (steps, N), with other numbers if given, shape (steps,)."""
        given = self.numbers if numbers is None else numbers
        out = np.empty((len(self), len(next(iter(inputs.values())))))
        for k, (operation, a, b) in enumerate(self._code):
            row, arguments = out[k], self.steps[k].arguments
            if operation == "multiply":
                np.multiply(out[a] if a >= 0 else given[k], out[b], out=row)
            elif operation == "input":
                row[:] = inputs[arguments[0]]
            else:
                given_by = zip((a, b), arguments, strict=False)
                UFUNCS[operation](*(out[x] if x >= 0 else constant for x, constant in given_by), out=row)
        return out

    def results(self, values: FloatArray) -> FloatArray:
        """Outputs, shape (outputs, N)."""
        out = np.empty((len(self.outputs), values.shape[1]))
        for row, k, output in zip(out, self.outputs, self.program.outputs, strict=True):
            row[:] = values[k] if k >= 0 else float(output)
        return out

    def slopes(self, values: FloatArray, numbers: FloatArray, weights: FloatArray) -> FloatArray:
        """Weighted outputs' derivatives by every step, (steps, outputs, N); zero inside sines and cosines."""
        out = np.zeros((len(self), len(self.outputs), values.shape[1]))
        for row, k in enumerate(self.outputs):
            if k >= 0:
                out[k, row] += weights[row]
        for k in range(len(self) - 1, -1, -1):
            operation, a, b = self._code[k]
            slope = out[k]
            if operation == "multiply":
                out[b] += slope * (values[a] if a >= 0 else numbers[k])
                if a >= 0:
                    out[a] += slope * values[b]
            elif operation == "negative":
                out[a] -= slope
            elif operation in ("add", "subtract"):
                if a >= 0:
                    out[a] += slope
                if b >= 0:
                    (np.add if operation == "add" else np.subtract)(out[b], slope, out=out[b])
        return out

    @cached_property
    def operations(self) -> NDArray[np.float32]:
        """1 for steps that count as operations, the price for sines and cosines, 0 for others, (steps,)."""
        price = {"add": 1, "subtract": 1, "multiply": 1, "sin": self._sine_price, "cos": self._sine_price}
        return np.array([price.get(code[0], 0) for code in self._code], dtype=np.float32)

    @cached_property
    def is_angle(self) -> NDArray[np.bool_]:
        """Whether a step is a joint variable, or computed from some outside of sines and cosines."""
        out = np.zeros(len(self), dtype=bool)
        for k, (operation, a, b) in enumerate(self._code):
            if operation == "input":
                out[k] = not self.steps[k].arguments[0].startswith("qd")
            elif operation not in ("cos", "sin"):
                out[k] = any(x >= 0 and out[x] for x in (a, b))
        return out

    @cached_property
    def degree(self) -> NDArray[np.intp]:
        """Degree in the motion: 1 for velocities, 2 for their products and for accelerations."""
        out = np.zeros(len(self), dtype=np.intp)
        for k, (operation, a, b) in enumerate(self._code):
            degrees = [int(out[x]) if x >= 0 else 0 for x in (a, b)]
            if operation == "input":
                out[k] = self.steps[k].arguments[0].count("d")
            elif operation not in ("cos", "sin"):
                out[k] = sum(degrees) if operation == "multiply" else max(degrees)
        return out

    @cached_property
    def needs(self) -> NDArray[np.bool_]:
        """Whether a step (row) needs another (column), itself included, shape (steps, steps)."""
        out = np.eye(len(self), dtype=bool)
        for k, (_, a, b) in enumerate(self._code):
            for x in (a, b):
                if x >= 0:
                    out[k] |= out[x]
        return out

    @cached_property
    def alone_for(self) -> NDArray[np.bool_]:
        """Whether every use of a step (column) passes through another (row), shape (steps, steps)."""
        users: list[list[int]] = [[] for _ in self.steps]
        for k, (_, a, b) in enumerate(self._code):
            for x in {a, b} - {-1}:
                users[x].append(k)
        out = np.zeros((len(self), len(self)), dtype=bool)
        for k in range(len(self) - 1, -1, -1):
            if k not in self.outputs and users[k]:
                out[k] = np.logical_and.reduce(out[users[k]])
            out[k, k] = True
        return out.T
