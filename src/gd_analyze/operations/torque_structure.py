"""Whether a program is a torque: linear in accelerations and quadratic in velocities, or free of both."""

from __future__ import annotations

from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression

# Degree of an input in the motion: 1 for a velocity, 2 for an acceleration.
_DEGREES = {"q": 0, "qd": 1, "qdd": 2}


def structure_fault(program: Program) -> str:
    """Why D, h and c do not follow from a program: "step s12 is of degree 3 in the motion"; "" if they do.

    Velocities count as degree 1, accelerations as degree 2. A step is of degree 0, 1 or 2; sums are of steps
    of equal degree, or of degree 0 and 2, as torques are of gravity and motion.
    """
    degree: dict[int, int] = {}
    for number, step in enumerate(program.steps):
        if step.operation == "input":
            degree[step.order] = _DEGREES[step.arguments[0].rstrip("0123456789")]
            continue
        degrees = [degree[x.order] if isinstance(x, Expression) else 0 for x in step.arguments]
        if step.operation in ("cos", "sin"):
            if degrees[0]:
                return f"step s{number} is a {step.operation} of the motion"
            step_degree = 0
        elif step.operation == "multiply":
            step_degree = sum(degrees)
        else:
            step_degree = max(degrees)
            if step_degree == 1 and min(degrees) == 0:
                return f"step s{number} adds degrees 0 and 1 in the motion"
            if step_degree == 2 and min(degrees) == 1:
                return f"step s{number} adds degrees 1 and 2 in the motion"
        if step_degree > 2:
            return f"step s{number} is of degree {step_degree} in the motion"
        degree[step.order] = step_degree
    for joint, output in enumerate(program.outputs, start=1):
        if isinstance(output, Expression) and degree[output.order] == 1:
            return f"the torque of joint {joint} is linear in velocities"
    return ""
