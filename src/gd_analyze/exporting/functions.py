"""Functions that are taken away: what they are given and give, and the program between."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gd_analyze.dynamics import composite_moments
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.model import (
    coriolis_centrifugal_program,
    gravity_loading_program,
    inertia_program,
)


@dataclass(frozen=True)
class Result:
    """What a function gives.

    Parameters
    ----------
    name
        As [FGL87] has it: tau, D, h, c.
    shape
        Its lengths; rows one after another.
    """

    name: str
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        """How many numbers it is."""
        return math.prod(self.shape)


@dataclass(frozen=True)
class Function:
    """One function of positions, rates and accelerations.

    Parameters
    ----------
    name, meaning
        What it is called, and what it gives, in words.
    arguments
        Of q, qd and qdd those that it is given.
    results
        What it gives, in the order of the program's outputs.
    program
        The arithmetic.
    """

    name: str
    meaning: str
    arguments: tuple[str, ...]
    results: tuple[Result, ...]
    program: Program

    @property
    def count(self) -> OperationCount:
        """Operations of one evaluation."""
        return self.program.count

    @property
    def joints(self) -> int:
        """Number of joints."""
        return self.results[0].shape[0]

    @property
    def used(self) -> frozenset[str]:
        """Inputs that the program needs, such as q2."""
        return frozenset(step.arguments[0] for step in self.program.steps if step.operation == "input")


def torque_functions(torque: Program, n: int, symmetric: bool) -> tuple[Function, ...]:
    """Torque, D, h and c, from the program of the torque of n joints; D is mirrored where it is symmetric."""
    return (
        Function(
            "torque",
            "generalized torque tau = D(q) qdd + h(q, qd) + c(q)",
            ("q", "qd", "qdd"),
            (Result("tau", (n,)),),
            torque,
        ),
        Function(
            "inertia",
            "inertia matrix D(q), its rows one after another",
            ("q",),
            (Result("D", (n, n)),),
            inertia_program(torque, n, symmetric),
        ),
        Function(
            "coriolis_centrifugal",
            "Coriolis and centrifugal torque h(q, qd)",
            ("q", "qd"),
            (Result("h", (n,)),),
            coriolis_centrifugal_program(torque, n),
        ),
        Function(
            "gravity_loading",
            "gravity loading c(q)",
            ("q",),
            (Result("c", (n,)),),
            gravity_loading_program(torque, n),
        ),
    )


def decomposition_function(arm: RobotArm) -> Function:
    """D and h by effect, and c, of the links alone. [FGL87] Eqs. (3.4-25) to (3.4-28)."""
    n, trace = arm.n_joints, Trace()
    q, qd = trace.inputs("q", n), trace.inputs("qd", n)
    moments = composite_moments.composite_moments(arm, solve_kinematics(arm, q))
    inertia = composite_moments.inertia(moments)
    h, _ = composite_moments.coriolis_centrifugal(moments, composite_moments.brackets(moments), qd)
    values: Mapping[str, np.ndarray] = {
        "D_tran": inertia[0],
        "D_rot": inertia[1],
        "h_tran": h[0],
        "h_rot": h[1],
        "c": composite_moments.gravity_loading(arm, moments),
    }
    results = tuple(Result(name, value.shape[:-1]) for name, value in values.items())
    outputs = [x for value in values.values() for x in value[..., 0].ravel().tolist()]
    return Function(
        "decomposition",
        "D(q) and h(q, qd) by effect, translation and rotation, and c(q), of the links without drives",
        ("q", "qd"),
        results,
        Program.of(trace, outputs),
    )
