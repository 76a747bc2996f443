"""A straight-line program: counted, and run on arrays of set points."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.trace import Expression, Operation, Trace, reached

UFUNCS: dict[Operation, Any] = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "negative": np.negative,
    "cos": np.cos,
    "sin": np.sin,
}

# Set points per pass: a program of a thousand intermediates then stays within a few megabytes.
_CHUNK = 1024


@dataclass(frozen=True)
class OperationCount:
    """Arithmetic of one evaluation; a subtraction counts as an addition, a change of sign is free."""

    multiplications: int
    additions: int
    sines_cosines: int

    @property
    def total(self) -> int:
        """Multiplications plus additions."""
        return self.multiplications + self.additions

    def __str__(self) -> str:
        return (
            f"{self.total} ({self.multiplications} mult + {self.additions} add), "
            f"{self.sines_cosines} sin and cos"
        )


@dataclass(frozen=True)
class Program:
    """What the outputs need of a trace, in an order that can be evaluated.

    Parameters
    ----------
    steps
        Expressions, each after its arguments.
    outputs
        Expressions or constants.
    """

    steps: tuple[Expression, ...]
    outputs: tuple[Any, ...]

    def __repr__(self) -> str:
        return f"Program({len(self.outputs)} outputs, {self.count})"

    @classmethod
    def of(cls, trace: Trace, outputs: Sequence[Any]) -> Program:
        """Keep what the outputs need; the rest of the trace is dead."""
        return cls(tuple(trace.expressions[k] for k in reached(outputs)), tuple(outputs))

    @property
    def count(self) -> OperationCount:
        """Operations of one evaluation."""
        kinds = Counter(step.operation for step in self.steps)
        return OperationCount(
            kinds["multiply"], kinds["add"] + kinds["subtract"], kinds["cos"] + kinds["sin"]
        )

    def with_values(self, values: Mapping[str, float]) -> Program:
        """Give some inputs a number, and fold what follows from it."""
        trace = Trace()
        of = self.folded(trace, values)
        return Program.of(trace, [of(output) for output in self.outputs])

    def folded(self, trace: Trace, values: Mapping[str, float]) -> Callable[[Any], Any]:
        """Carry it out on a trace, where some inputs have a number; what it gives for each expression."""

        def given(name: str) -> Any:
            return values[name] if name in values else trace.record("input", name)

        return self.carried_out(given, trace.apply)

    def carried_out(self, given: Callable[[str], Any], apply: Callable[..., Any]) -> Callable[[Any], Any]:
        """Carry it out on whatever `given` makes of an input's name and `apply` of operation and arguments.

        Returns what came of each expression; constants come back as they are.
        """
        known: dict[int, Any] = {}

        def of(x: Any) -> Any:
            return known[x.order] if isinstance(x, Expression) else x

        for step in self.steps:
            if step.operation == "input":
                known[step.order] = given(step.arguments[0])
            else:
                known[step.order] = apply(step.operation, *map(of, step.arguments))
        return of

    def run(self, inputs: Mapping[str, FloatArray]) -> FloatArray:
        """Evaluate on many set points at once.

        Parameters
        ----------
        inputs
            One array of shape (N,) per named input, e.g. "q1".

        Returns
        -------
        numpy.ndarray
            The outputs, shape (number of outputs, N).
        """
        count = len(next(iter(inputs.values())))
        out = np.empty((len(self.outputs), count))
        for start in range(0, count, _CHUNK):
            chunk = {name: values[start : start + _CHUNK] for name, values in inputs.items()}
            value = self.carried_out(chunk.__getitem__, lambda operation, *x: UFUNCS[operation](*x))
            for row, output in zip(out, self.outputs, strict=True):
                row[start : start + _CHUNK] = value(output)
        return out
