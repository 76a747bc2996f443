"""Functions that follow from the program of a torque: D, h and c, derivatives, C, and forward dynamics."""

from __future__ import annotations

from typing import Any, NamedTuple

from gd_analyze.operations.program import OperationCount, Program, fewest, program_slopes
from gd_analyze.operations.trace import Expression, Trace, is_constant


class Functions(NamedTuple):
    """Programs of D (row by row), h and c, each a function of its own."""

    inertia: Program
    coriolis_centrifugal: Program
    gravity_loading: Program

    @property
    def operations(self) -> OperationCount:
        """Operations of all three; what they share is counted in each."""
        counts = [program.count for program in self]
        return OperationCount(
            sum(count.multiplications for count in counts),
            sum(count.additions for count in counts),
            sum(count.sines_cosines for count in counts),
        )

    def cheapest(self, other: Functions) -> Functions:
        """The program with fewer operations of each function."""
        return Functions(*map(fewest, zip(self, other, strict=True)))


def functions_of(program: Program, n: int, symmetric: bool = False) -> Functions:
    """D, h and c that follow from a torque program; of a `symmetric` D the upper half is computed."""
    return Functions(
        inertia_program(program, n, symmetric),
        coriolis_centrifugal_program(program, n),
        gravity_loading_program(program, n),
    )


def inertia_program(program: Program, n: int, symmetric: bool = False) -> Program:
    """D, row by row, as torque is linear in accelerations; for a `symmetric` D the upper half is computed."""
    trace, at_rest = Trace(), program.with_values(_zeros(n, "qd"))
    value = at_rest.folded(trace, _zeros(n, "qdd"))
    columns = [program_slopes(at_rest, {f"qdd{j + 1}": 1.0}, value, trace) for j in range(n)]
    places = [(min(i, j), max(i, j)) if symmetric else (i, j) for i in range(n) for j in range(n)]
    return Program.of(trace, [columns[j][i] for i, j in places])


def bias_program(program: Program, n: int) -> Program:
    """H and c together: the torque without acceleration."""
    return program.with_values(_zeros(n, "qdd"))


def coriolis_centrifugal_program(program: Program, n: int) -> Program:
    """h: the part of the bias that is of degree 2 in the velocities, so without gravity."""
    return motion_program(bias_program(program, n))


def motion_program(program: Program) -> Program:
    """The part of a torque that motion takes, D qdd + h: all but gravity.

    A velocity counts 1, an acceleration 2: the parts of degree 2 remain. Every step is split by degree.
    """
    trace, by_step = Trace(), dict[int, dict[int, Any]]()

    def parts(x: Any) -> dict[int, Any]:
        return by_step[x.order] if isinstance(x, Expression) else {0: x}

    for step in program.steps:
        if step.operation == "input":
            name = step.arguments[0]
            degree = name.count("d")  # q1, qd1, qdd1
            by_step[step.order] = {degree: trace.record("input", name)}
            continue
        first, second = parts(step.arguments[0]), parts(step.arguments[-1])
        if step.operation == "multiply":
            products: dict[int, Any] = {}
            for a, x in first.items():
                for b, y in second.items():
                    if a + b <= 2:
                        products[a + b] = trace.add(products.get(a + b, 0.0), trace.multiply(x, y))
            by_step[step.order] = products
        elif len(step.arguments) == 1:
            by_step[step.order] = {a: trace.apply(step.operation, x) for a, x in first.items()}
        else:
            by_step[step.order] = {
                a: trace.apply(step.operation, first.get(a, 0.0), second.get(a, 0.0))
                for a in sorted({*first, *second})
            }
    return Program.of(trace, [parts(output).get(2, 0.0) for output in program.outputs])


def gravity_loading_program(program: Program, n: int) -> Program:
    """Torque at rest."""
    return program.with_values(_zeros(n, "qd", "qdd"))


def torque_derivatives_program(program: Program, n: int) -> Program:
    """Derivatives of the torques by q, then by qd, each row by row; those by qdd are D."""
    trace = Trace()
    value = program.folded(trace, {})
    columns = [
        [program_slopes(program, {f"{name}{j + 1}": 1.0}, value, trace) for j in range(n)]
        for name in ("q", "qd")
    ]
    return Program.of(trace, [by[j][i] for by in columns for i in range(n) for j in range(n)])


def coriolis_matrix_program(program: Program, n: int) -> Program:
    """C with C qd = h, row by row: half the derivative of h by qd, C_ij = sum_k h_ijk qd_k."""
    trace, h = Trace(), coriolis_centrifugal_program(program, n)
    value = h.folded(trace, {})
    columns = [program_slopes(h, {f"qd{j + 1}": 0.5}, value, trace) for j in range(n)]
    return Program.of(trace, [columns[j][i] for i in range(n) for j in range(n)])


def forward_dynamics_program(program: Program, n: int, symmetric: bool) -> Program:
    """Accelerations from torques tau1, tau2, ...: D qdd = tau - h - c, by elimination without pivoting.

    D of an arm is positive definite, so that no pivot is zero; a symmetric D is factored as L d L^T.
    """
    trace = Trace()
    at_rest = program.with_values(_zeros(n, "qdd"))
    value, inertia = at_rest.folded(trace, {}), inertia_program(program, n, symmetric).folded(trace, {})
    rows = inertia_program(program, n, symmetric).outputs
    matrix = [[inertia(rows[n * i + j]) for j in range(n)] for i in range(n)]
    right = [
        trace.subtract(trace.record("input", f"tau{i + 1}"), value(at_rest.outputs[i])) for i in range(n)
    ]
    for k in range(n):
        for i in range(k + 1, n):
            if is_constant(matrix[i][k], 0.0):
                continue
            factor = trace.divide(matrix[i][k], matrix[k][k])
            # A symmetric matrix has equal entries below and above the diagonal.
            for j in range(i if symmetric else k + 1, n):
                matrix[i][j] = trace.subtract(matrix[i][j], trace.multiply(factor, matrix[k][j]))
            right[i] = trace.subtract(right[i], trace.multiply(factor, right[k]))
        if symmetric:
            for i in range(k + 1, n):
                for j in range(k + 1, i):
                    matrix[i][j] = matrix[j][i]
    accelerations: list[object] = [0.0] * n
    for i in reversed(range(n)):
        for j in range(i + 1, n):
            right[i] = trace.subtract(right[i], trace.multiply(matrix[i][j], accelerations[j]))
        accelerations[i] = trace.divide(right[i], matrix[i][i])
    return Program.of(trace, accelerations)


def _zeros(n: int, *names: str) -> dict[str, float]:
    return {f"{name}{j + 1}": 0.0 for name in names for j in range(n)}
