"""Arms let go of, a pendulum, and what the integrator's tolerance can make of a motion and its energy."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.simulation import Integration, Simulation, simulate
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint, Link, Placement

DRIVEN = Drivetrain(inertia=True)


def limp(n: int):
    return lambda t, q, qd: np.zeros(n)


def undriven(arm: RobotArm, duration: float, drivetrain: Drivetrain = NO_DRIVES, **integration) -> Simulation:
    n = arm.n_joints
    start, velocities = np.linspace(0.4, 0.9, n), np.linspace(-0.5, 0.5, n)
    how = Integration(set_points=41, **integration)
    return simulate(arm, limp(n), start, velocities, duration, drivetrain, how)


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


def per_step(simulation: Simulation) -> FloatArray:
    """Largest local error of q and qd in one step, shape (N, 2n).

    SciPy accepts a step when the root mean square of the errors over atol + rtol |y| is at most 1, over all
    2n + 2 states; a single one may therefore have sqrt(2n + 2) of it.
    """
    states = np.concatenate([simulation.q, simulation.qd], axis=1)
    count, how = states.shape[1] + 2, simulation.integration
    return np.sqrt(count) * (how.atol + how.rtol * np.abs(states))


def energy_bound(arm: RobotArm, simulation: Simulation, *, drives: bool = False) -> float:
    """How large the energy residual may be.

    Energy less work plus dissipation is constant along every exact motion, so nothing amplifies what a step
    adds: its local errors times the slopes of energy, dE/dqd = (D + J) qd and
    dE/dq_i = sum_jk h_jki qd_j qd_k + c_i, and the local errors of work and dissipation themselves. All steps
    add up, and reading between the steps, by a polynomial of an order less, counts as much again.
    """
    q, qd = simulation.q, simulation.qd
    found = decompose_states(arm, States(q, qd, 0 * q))
    momentum = np.einsum("Neij,Nj->Ni", found["inertia"], qd)
    if drives:
        momentum = momentum + arm.drive_inertia * qd
    of_q = np.einsum("Nj,Nejki,Nk->Ni", qd, found["christoffel"], qd) + found["gravity_loading"]
    slopes = np.abs(np.concatenate([of_q, momentum], axis=1))
    local = per_step(simulation)
    how = simulation.integration
    books = np.sqrt(local.shape[1] + 2) * (
        2 * how.atol + how.rtol * (np.abs(simulation.work) + np.abs(simulation.dissipated))
    )
    each = (slopes * local).sum(axis=1) + books
    return 2 * simulation.steps * float(each.max())
