"""Programs for D, h and c, from that of the torque tau = D(q) qdd + h(q, qd) + c(q)."""

from __future__ import annotations

from gd_analyze.operations.derivative import derivative
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace


def inertia_program(program: Program, n: int, symmetric: bool = False) -> Program:
    """D, its rows one after another: torque is linear in accelerations, column j its derivative by qdd_j.

    Parameters
    ----------
    program
        Of the torque of n joints.
    n
        Number of joints.
    symmetric
        Whether D is known to be: then what is above the diagonal is taken for what is below it.
    """
    still, trace = _zeros(n, "qd", "qdd"), Trace()
    columns = []
    for j in range(n):
        column = derivative(program, {f"qdd{j + 1}": 1.0}, still)
        of = column.folded(trace, {})
        columns.append([of(output) for output in column.outputs])
    places = [(min(i, j), max(i, j)) if symmetric else (i, j) for i in range(n) for j in range(n)]
    return Program.of(trace, [columns[j][i] for i, j in places])


def coriolis_centrifugal_program(program: Program, n: int) -> Program:
    """H, homogeneous of degree 2 in the rates: half its derivative along them (Euler)."""
    along: dict[str, float | str] = {f"qd{j + 1}": f"qd{j + 1}" for j in range(n)}
    twice = derivative(program, along, _zeros(n, "qdd"))
    trace = Trace()
    of = twice.folded(trace, {})
    return Program.of(trace, [trace.multiply(0.5, of(output)) for output in twice.outputs])


def gravity_loading_program(program: Program, n: int) -> Program:
    """Torque at rest."""
    return program.with_values(_zeros(n, "qd", "qdd"))


def _zeros(n: int, *names: str) -> dict[str, float]:
    return {f"{name}{j + 1}": 0.0 for name in names for j in range(n)}
