"""What the integrator's own tolerance can make of a conserved quantity and of a motion."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.simulation import Simulation
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm


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
