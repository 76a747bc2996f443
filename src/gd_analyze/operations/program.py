"""Straight-line programs: counted, run on arrays, differentiated, and written down as plain values."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from gd_analyze.arrays import CHUNK, FloatArray
from gd_analyze.motions.states import States
from gd_analyze.operations.trace import Expression, Operation, Trace, reached
from gd_analyze.text import LARGEST_COEFFICIENT

UFUNCS: dict[Operation, Any] = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
    "negative": np.negative,
    "sign": np.sign,
    "cos": np.cos,
    "sin": np.sin,
}
# Operations of torque programs in files, without division and sign.
_ARGUMENTS: dict[str, int] = {"input": 1} | {
    name: ufunc.nin for name, ufunc in UFUNCS.items() if name not in ("divide", "sign")
}

# Bytes that vector instructions load at once; loads across such a boundary take twice as long.
_ALIGNED_BYTES = 64

# Times in exported C, gcc -O2, are fitted to the ten programs of analysis/exported_c.md. The estimated time
# of each program is within 22 % of its measured time.
# Time of a multiplication or addition, ns.
_OPERATION_NANOSECONDS = 0.19
# Time of a sine or cosine, ns.
_SINE_NANOSECONDS = 3.4


@dataclass(frozen=True)
class OperationCount:
    """Arithmetic of one evaluation.

    A subtraction counts as an addition, a division as a multiplication, a change of sign is free.
    """

    multiplications: int
    additions: int
    sines_cosines: int

    @classmethod
    def of(cls, kinds: Counter[Operation]) -> OperationCount:
        """Count operations by their kinds."""
        additions, functions = kinds["add"] + kinds["subtract"], kinds["cos"] + kinds["sin"]
        return cls(kinds["multiply"] + kinds["divide"], additions, functions)

    @property
    def total(self) -> int:
        """Multiplications plus additions."""
        return self.multiplications + self.additions

    @property
    def pair(self) -> str:
        """Both numbers that count, operations, and sines and cosines: "66 and 20"."""
        return f"{self.total} and {self.sines_cosines}"

    @property
    def in_words(self) -> str:
        """The same in words: "66 operations and 20 sines and cosines"."""
        return f"{self.total} operations and {self.sines_cosines} sines and cosines"

    @property
    def nanoseconds(self) -> float:
        """Estimated time of one evaluation in exported C, ns, see docs/simplification.md."""
        return _OPERATION_NANOSECONDS * self.total + _SINE_NANOSECONDS * self.sines_cosines

    def __str__(self) -> str:
        return (
            f"{self.total} ({self.multiplications} mult + {self.additions} add), "
            f"{self.sines_cosines} sin and cos"
        )


@dataclass(frozen=True)
class Program:
    """The part of a trace that its outputs need, in an order that can be evaluated."""

    steps: tuple[Expression, ...]  # expressions, each after its arguments
    outputs: tuple[Any, ...]  # expressions or constants

    def __repr__(self) -> str:
        return f"Program({len(self.outputs)} outputs, {self.count})"

    @classmethod
    def of(cls, trace: Trace, outputs: Sequence[Any]) -> Program:
        """Keep the part of a trace that the outputs need."""
        return cls(tuple(trace.expressions[k] for k in reached(outputs)), tuple(outputs))

    @property
    def count(self) -> OperationCount:
        """Operations of one evaluation."""
        return OperationCount.of(Counter(step.operation for step in self.steps))

    def with_values(self, values: Mapping[str, float]) -> Program:
        """Set some inputs to numbers and fold the constants that follow."""
        trace = Trace()
        of = self.folded(trace, values)
        return Program.of(trace, [of(output) for output in self.outputs])

    def folded(self, trace: Trace, values: Mapping[str, float]) -> Callable[[Any], Any]:
        """Evaluate it on a trace with some inputs set to numbers; returns as `carried_out`."""
        return self.carried_out(
            lambda name: values[name] if name in values else trace.record("input", name), trace.apply
        )

    def carried_out(
        self, input_value: Callable[[str], Any], apply: Callable[..., Any]
    ) -> Callable[[Any], Any]:
        """Evaluate it with any kind of value.

        `input_value` returns the value of an input by name, `apply` that of an operation on its arguments.
        The function returned gives the value of an expression, and returns constants unchanged.
        """
        values: dict[int, Any] = {}

        def of(x: Any) -> Any:
            return values[x.order] if isinstance(x, Expression) else x

        for step in self.steps:
            if step.operation == "input":
                values[step.order] = input_value(step.arguments[0])
            else:
                values[step.order] = apply(step.operation, *map(of, step.arguments))
        return of

    def run(self, inputs: Mapping[str, FloatArray]) -> FloatArray:
        """Outputs on many set points at once, shape (outputs, N), from an array (N,) per input such as q1."""
        return self.runner(min(len(next(iter(inputs.values()))), CHUNK))(inputs)

    def runner(self, at_once: int) -> Callable[..., FloatArray]:
        """A function like `run` that keeps its memory: each step is one array operation on `at_once` states.

        Its second argument, if given, are rows to write the outputs into. Rows of intermediate results are
        reused as soon as possible, so that they stay in the cache.
        """
        of_inputs: dict[str, FloatArray] = {}
        calls: list[tuple[Any, tuple[Any, ...]]] = []
        rows: dict[int, FloatArray] = {}
        free: list[FloatArray] = []
        last = {x.order: k for k, step in enumerate(self.steps) for x in _expressions(step.arguments)}
        last |= {x.order: len(self.steps) for x in _expressions(self.outputs)}

        def of(x: Any) -> FloatArray:
            # An array of one number is faster than the number.
            return rows[x.order] if isinstance(x, Expression) else np.array(float(x))

        for k, step in enumerate(self.steps):
            if step.operation == "input":
                rows[step.order] = of_inputs[step.arguments[0]] = _row(at_once)
                continue
            arguments = [*map(of, step.arguments)]
            orders = {x.order for x in _expressions(step.arguments)}
            free += [rows[order] for order in orders if last[order] == k]
            row = rows[step.order] = free.pop() if free else _row(at_once)
            calls.append((UFUNCS[step.operation], (*arguments, row)))
        outputs = [np.broadcast_to(of(output), at_once) for output in self.outputs]

        def run(inputs: Mapping[str, FloatArray], out: Any = None) -> FloatArray:
            count = len(next(iter(inputs.values())))
            out = np.empty((len(outputs), count)) if out is None else out
            for start in range(0, count, max(at_once, 1)):
                # The last block may be smaller: the rows' ends then keep other states, and are not read.
                stop = min(start + at_once, count)
                for name, row in of_inputs.items():
                    row[: stop - start] = inputs[name][start:stop]
                for function, arguments in calls:
                    function(*arguments)
                for row, output in zip(out, outputs, strict=True):
                    row[start:stop] = output[: stop - start]
            return cast("FloatArray", out)

        return run


def fewest(programs: Iterable[Program]) -> Program:
    """The program of the fewest operations."""
    return min(programs, key=lambda program: program.count.total)


def _expressions(values: Sequence[Any]) -> Iterator[Expression]:
    return (x for x in values if isinstance(x, Expression))


def _row(count: int) -> FloatArray:
    """Memory for `count` numbers, aligned for vector instructions."""
    whole = np.zeros(count + _ALIGNED_BYTES // 8)
    begin = -whole.ctypes.data % _ALIGNED_BYTES // 8
    return whole[begin : begin + count]


def program_slopes(
    program: Program, along: Mapping[str, float | str], value: Callable[[Any], Any], trace: Trace
) -> list[Any]:
    """Differentiate a program's outputs along a direction in its inputs (forward differentiation).

    The direction is a number by input, or another input's name; `value` is what `folded` returned on the
    same trace.
    """
    slopes: dict[int, Any] = {}  # of the steps that depend on the direction

    def slope(x: Any) -> Any:
        return slopes.get(x.order, 0.0) if isinstance(x, Expression) else 0.0

    for step in program.steps:
        if step.operation == "input":
            direction = along.get(step.arguments[0])
            if isinstance(direction, str):
                slopes[step.order] = trace.record("input", direction)
            elif direction is not None:
                slopes[step.order] = direction
            continue
        argument_slopes = [slope(x) for x in step.arguments]
        if not any(isinstance(x, Expression) or x != 0.0 for x in argument_slopes):
            continue
        if step.operation in ("cos", "sin"):
            (x,) = step.arguments
            partner = trace.apply("sin" if step.operation == "cos" else "cos", value(x))
            outer = trace.negative(partner) if step.operation == "cos" else partner
            slopes[step.order] = trace.multiply(outer, argument_slopes[0])
        elif step.operation == "multiply":
            x, y = step.arguments
            slopes[step.order] = trace.add(
                trace.multiply(argument_slopes[0], value(y)), trace.multiply(value(x), argument_slopes[1])
            )
        else:
            slopes[step.order] = trace.apply(step.operation, *argument_slopes)
    return [slope(output) for output in program.outputs]


def plain_program(program: Program) -> tuple[list[list[str | float]], list[str | float]]:
    """Steps and outputs as plain values, for files.

    A step is its operation and its arguments: "s0", "s1" .. for earlier steps, numbers for constants, the
    name of an input.
    """
    number = {step.order: f"s{k}" for k, step in enumerate(program.steps)}

    def value(x: Any) -> str | float:
        if isinstance(x, Expression):
            return number[x.order]
        return x if isinstance(x, str) else float(x)

    return [[step.operation, *map(value, step.arguments)] for step in program.steps], [
        *map(value, program.outputs)
    ]


def read_back(
    steps: Sequence[Sequence[str | float]], outputs: Sequence[str | float], inputs: Collection[str]
) -> Program:
    """Rebuild a program from the result of `plain_program`; operations are recorded, not carried out.

    ValueError if a step is not an operation, refers to a later one, occurs twice, or has an invalid input.
    """
    trace = Trace()
    expressions: dict[str, Expression] = {}

    def value(x: str | float) -> Any:
        if not isinstance(x, str):
            if not abs(x) <= LARGEST_COEFFICIENT:
                raise ValueError(f"{x} is not a number of a torque")
            return float(x)
        if x not in expressions:
            raise ValueError(f"{x!r} is not an earlier step")
        return expressions[x]

    for k, (operation, *arguments) in enumerate(steps):
        if _ARGUMENTS.get(str(operation)) != len(arguments):
            raise ValueError(f"step s{k}, {operation} of {len(arguments)}, is not an operation")
        if operation == "input":
            if arguments[0] not in inputs:
                raise ValueError(f"step s{k}: there is no input {arguments[0]!r}")
            expressions[f"s{k}"] = trace.record("input", arguments[0])
        else:
            expressions[f"s{k}"] = trace.record(cast("Operation", operation), *(value(x) for x in arguments))
        if len(trace.expressions) != len(expressions):
            raise ValueError(f"step s{k} occurs twice")
    return Program(tuple(expressions.values()), tuple(value(output) for output in outputs))


def program_inputs(states: States) -> dict[str, FloatArray]:
    """Inputs of a program at states (N, n)."""
    named = zip(("q", "qd", "qdd"), states.last, strict=True)
    return {f"{name}{j + 1}": row for name, rows in named for j, row in enumerate(rows)}
