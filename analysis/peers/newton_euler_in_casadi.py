"""Newton and Euler's recursion in CasADi's symbols, as its users write it by hand, and the C that CasADi prints of it.

Pinocchio's wheel comes without `pinocchio.casadi`, which would put the same recursion together. CasADi leaves out what a
constant 0 or 1 makes idle, and shares common expressions where it is told to.
"""

from __future__ import annotations

from collections import Counter
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.robots.arm import RobotArm

CALLED = """
int exact(const double **, double **, long long *, double *, int);
void all(long passes, long count, const double *q, const double *qd, const double *qdd, double *tau)
{{
    for (long p = 0; p < passes; p++)
        for (long s = 0; s < count; s++) {{
            const double *given[3] = {{q + {n} * s, qd + {n} * s, qdd + {n} * s}};
            double *taken[1] = {{tau + {n} * s}};
            exact(given, taken, 0, 0, 0);
        }}
}}
"""


class Printed(NamedTuple):
    """C by CasADi, what calls it for many states, and its multiplications and additions."""

    source: str
    driver: str
    operations: int


def in_casadi(arm: RobotArm, drives: bool) -> Printed:
    """Print the exact torque of an arm whose joints all turn."""
    import casadi as ca

    q, qd, qdd = (ca.SX.sym(name, arm.n_joints) for name in ("q", "qd", "qdd"))
    torque = newton_euler(arm, q, qd, qdd)
    if drives:
        torque += ca.DM(arm.drive_inertia) * qdd
    exact = ca.Function("exact", [q, qd, qdd], [torque], {"cse": True})
    if exact.sz_iw():
        raise ValueError("CasADi's C needs memory that nobody gives it")
    generator = ca.CodeGenerator("exact", {"casadi_int": "long long"})
    generator.add(exact)
    done = Counter(exact.instruction_id(k) for k in range(exact.n_instructions()))
    counted = (ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_SQ, ca.OP_TWICE)
    return Printed(generator.dump(), CALLED.format(n=arm.n_joints), sum(done[kind] for kind in counted))


def newton_euler(arm: RobotArm, q: Any, qd: Any, qdd: Any) -> Any:
    """Outwards velocities and accelerations, inwards forces and moments, in link coordinates. [FGL87] Table 3.3."""
    import casadi as ca

    cross = ca.cross
    w, dw, dv = ca.SX(3, 1), ca.SX(3, 1), ca.SX(ca.DM(-arm.gravity_vector))
    steps = []
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        before, behind = (constant(each.rotation) for each in (joint.placement, link.frame))
        turn = before @ turned(joint.axis, q[i]) @ behind
        to_joint = constant(joint.placement.translation)
        axis, lever = behind.T @ constant(joint.axis), behind.T @ constant(link.frame.translation)
        dv = turn.T @ (dv + cross(dw, to_joint) + cross(w, cross(w, to_joint)))
        w, dw = turn.T @ w, turn.T @ dw
        dw = dw + axis * qdd[i] + cross(w, axis * qd[i])
        w = w + axis * qd[i]
        dv = dv + cross(dw, lever) + cross(w, cross(w, lever))
        com, tensor = constant(link.com), constant(link.inertia_com)
        force = link.mass * (dv + cross(dw, com) + cross(w, cross(w, com)))
        moment = tensor @ dw + cross(w, tensor @ w) + cross(com, force)
        steps.append((turn, to_joint, axis, lever, force, moment))
    torque: list[Any] = []
    force, moment = ca.SX(3, 1), ca.SX(3, 1)
    for turn, to_joint, axis, lever, own_force, own_moment in reversed(steps):
        force = force + own_force
        moment = moment + own_moment + cross(lever, force)
        torque.insert(0, ca.dot(axis, moment))
        force, moment = turn @ force, turn @ moment
        moment = moment + cross(to_joint, force)
    return ca.vertcat(*torque)


def constant(values: Any) -> Any:
    """Numbers as symbols, their zeros left out."""
    import casadi as ca

    return ca.SX(ca.sparsify(ca.DM(np.array(values))))


def turned(axis: Any, angle: Any) -> Any:
    """Rotation about a constant axis, by Rodrigues' formula; about z the textbook's sines and cosines."""
    import casadi as ca

    along = constant(np.outer(axis, axis))
    return (
        along + ca.cos(angle) * (ca.SX.eye(3) - along) + ca.sin(angle) * ca.sparsify(ca.skew(constant(axis)))
    )
