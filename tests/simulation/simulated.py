"""Arms let go of, and a pendulum."""

from __future__ import annotations

import numpy as np

from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.simulation import Integration, Simulation, simulate
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link, Placement

DRIVEN = Drivetrain(inertia=True)


def limp(n: int):
    return lambda t, q, qd: np.zeros(n)


def undriven(arm: RobotArm, duration: float, drivetrain: Drivetrain = NO_DRIVES, **integration) -> Simulation:
    n = arm.n_joints
    start, rates = np.linspace(0.4, 0.9, n), np.linspace(-0.5, 0.5, n)
    how = Integration(set_points=41, **integration)
    return simulate(arm, limp(n), start, rates, duration, drivetrain, how)


LENGTH, GRAVITY = 0.7, 9.8062


def pendulum() -> RobotArm:
    """A point mass on a massless rod, hanging down at q = 0."""
    return RobotArm(
        "pendulum",
        (Joint("pivot"),),
        (
            Link(
                "bob", 2.0, np.zeros(3), np.zeros((3, 3)), Placement(np.eye(3), np.array([0.0, -LENGTH, 0.0]))
            ),
        ),
        np.array([0.0, -GRAVITY, 0.0]),
    )
