"""Simulated motions: the books of energy balance, and known motions come out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import ellipk

from gd_analyze import decompose, load_arm
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.tables import decompose_states, simulate
from gd_analyze.types import Drivetrain, Integration, Joint, Link, Placement, RobotArm, Simulation, States
from long_cases import long
from strategies import arms_with_states, examples

DRIVEN, NO_DRIVES = Drivetrain(inertia=True), Drivetrain()


def limp(n: int):
    return lambda t, q, qd: np.zeros(n)


def undriven(arm: RobotArm, duration: float, drivetrain: Drivetrain = NO_DRIVES, **integration) -> Simulation:
    n = arm.n_joints
    start, velocities = np.linspace(0.4, 0.9, n), np.linspace(-0.5, 0.5, n)
    return simulate(arm, limp(n), start, velocities, duration, drivetrain, Integration(41, **integration))


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
    local, how = per_step(simulation), simulation.integration
    books = np.sqrt(local.shape[1] + 2) * (
        2 * how.atol + how.rtol * (np.abs(simulation.work) + np.abs(simulation.dissipated))
    )
    return 2 * simulation.steps * float(((slopes * local).sum(axis=1) + books).max())


# The bare wrist of the PUMA has inertias down to 4e-5 kg m^2, and D is all but singular where axes 4 and 6
# line up; with the drives' inertia, as in the real arm, it takes half as many steps.
@pytest.mark.parametrize(
    ("name", "duration", "drivetrain"),
    [("puma560", 0.5, DRIVEN), long("puma560", 0.2, NO_DRIVES), long("stanford", 0.5, NO_DRIVES)],
)
def test_energy_is_conserved_without_torque_and_friction(name, duration, drivetrain):
    arm = load_arm(name)
    found = undriven(arm, duration, drivetrain, rtol=1e-12, atol=1e-12)
    assert np.ptp(found.kinetic) > 1.0  # joules: it does fall
    assert not found.work.any()
    assert not found.dissipated.any()
    bound = energy_bound(arm, found, drives=drivetrain.inertia)
    assert np.abs(found.energy_residual).max() <= bound
    assert bound < 1e-6  # far below the joules that change hands


@pytest.mark.parametrize("integrator", ["RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA"])
def test_every_integrator_conserves_energy_within_its_tolerance(two_link, integrator):
    # Low orders take the square or the cube of the steps: ask for less.
    found = undriven(two_link, 0.5, integrator=integrator, rtol=1e-6, atol=1e-6)
    assert np.abs(found.energy_residual).max() <= energy_bound(two_link, found)


@examples(4)
@given(arms_with_states(max_joints=3, massive=True), st.integers(0, 2**32 - 1))
def test_work_is_the_energy_gained_less_what_was_dissipated(case, seed):
    arm, states = case
    rng = np.random.default_rng(seed)
    n = arm.n_joints
    history = np.linspace(0, 0.1, 5), rng.uniform(-20, 20, (5, n))
    drivetrain = Drivetrain(damping=rng.uniform(0, 1, n))
    found = simulate(arm, history, states.q[0], states.qd[0], 0.1, drivetrain, Integration(31))
    assert np.abs(found.work).max() > 0
    assert (np.diff(found.dissipated) >= -energy_bound(arm, found)).all()
    assert found.dissipated[-1] > 0
    assert np.abs(found.energy_residual).max() <= energy_bound(arm, found)


LENGTH, GRAVITY = 0.7, 9.8062


def pendulum(gravity: float = GRAVITY) -> RobotArm:
    """A point mass on a massless rod, hanging down at q = 0."""
    down = Placement(np.eye(3), np.array([0.0, -LENGTH, 0.0]))
    bob = Link("bob", 2.0, np.zeros(3), np.zeros((3, 3)), down)
    return RobotArm("pendulum", (Joint("pivot"),), (bob,), np.array([0.0, -gravity, 0.0]))


def period(swing: float) -> float:
    """Exact period of a swing up to an angle: 4 sqrt(l/g) K(sin^2(angle / 2))."""
    return 4 * np.sqrt(LENGTH / GRAVITY) * ellipk(np.sin(swing / 2) ** 2)


@pytest.mark.parametrize("swing", [0.1, 2.5, long(3.1)])
def test_a_pendulum_keeps_its_exact_period(swing):
    turns = 2
    how = Integration(4 * turns + 1)
    found = simulate(pendulum(), limp(1), [swing], [0.0], turns * period(swing), integration=how)
    expected = swing * np.array([1, 0, -1, 0] * turns + [1])
    # An error of the state is one of the swing and of the phase. Of the swing: d = l qd dqd / (g sin swing)
    # at the bottom, where it is fastest. Of the phase: the period changes with the swing, per turn.
    fastest = 2 * np.sqrt(GRAVITY / LENGTH) * np.sin(swing / 2)
    to_swing = 1 + LENGTH * fastest / (GRAVITY * np.sin(swing))
    slope = abs(period(swing + 1e-6) - period(swing - 1e-6)) / 2e-6
    growth = to_swing * (1 + fastest * (turns * slope + 1 / np.sqrt(GRAVITY / LENGTH)))
    allowed = 2 * found.steps * per_step(found).max() * growth
    assert np.abs(found.q[:, 0] - expected).max() <= allowed
    assert allowed < 0.01 * swing


def test_a_torque_history_is_followed_between_its_instants(two_link):
    """A cubic spline goes through a cubic exactly, so that it is the function."""

    def cubic(t, *state):
        return np.multiply.outer(t**3 - 0.6 * t**2, [40.0, -10.0]) + np.array([20.0, 5.0])

    time, start = np.linspace(0.0, 1.0, 6), [0.2, -0.1]
    history, function = (simulate(two_link, x, start, [0, 0], 0.9) for x in ((time, cubic(time)), cubic))
    # Round-off of the spline's torques: 1e-14 of some 20 N m, over inertias of some 0.1 kg m^2.
    np.testing.assert_allclose(history.torque, function.torque, rtol=0, atol=1e-12)
    np.testing.assert_allclose(history.q, function.q, rtol=0, atol=1e-10)
    assert np.ptp(history.q) > 0.5


def test_the_motion_is_a_trajectory(two_link):
    found = undriven(two_link, 0.2)
    # Inverse dynamics of what forward dynamics gave: no torque, to round-off of some tens of N m.
    assert np.abs(decompose(two_link, found.as_trajectory("fall")).torque.values).max() <= 1e-12
    assert not found.torque.any()
    assert found.time[[0, -1]].tolist() == [0.0, 0.2]


TIME, VALUES = [0.0, 0.5, 1.0], np.zeros((3, 2))


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"q0": np.zeros((2, 2)), "qd0": np.zeros((2, 2))}, "q0"),
        ({"qd0": [0.0, np.nan]}, "qd0[1]"),
        ({"duration": np.inf}, "duration"),
        ({"set_points": 2.5}, "set_points"),
        ({"method": "lagrange"}, "method"),
        ({"integrator": "Euler"}, "integrator"),
        ({"rtol": 1e-15}, "rtol"),
        ({"atol": np.nan}, "atol"),
        ({"torque": 3.0}, "torque"),
        ({"torque": (TIME, np.zeros((3, 3)))}, "torque"),
        ({"torque": ([0.0, 1.0, 1.0], VALUES)}, "torque"),
        ({"torque": (TIME, VALUES + np.inf)}, "torque"),
        ({"torque": (TIME, VALUES), "duration": 1.5}, "torque"),
    ],
)
def test_bad_input(two_link, change, where):
    arguments = {"torque": limp(2), "q0": [0.0, 0.0], "qd0": [0.0, 0.0], "duration": 0.5} | change
    options = {name: arguments.pop(name) for name in vars(Integration()) if name in arguments}
    with pytest.raises(UsageError) as caught:
        simulate(two_link, **arguments, integration=Integration(**options))
    assert caught.value.details["where"] == where
    assert caught.value.details["expected"]


def test_motions_that_cannot_be_followed(two_link):
    for torque in (lambda t, q, qd: [1.0], lambda t, q, qd: [np.nan, 0]):
        with pytest.raises(GdAnalyzeError) as caught:
            simulate(two_link, torque, [0, 0], [0, 0], 0.1)
        assert caught.value.details["expected"] == "2 finite numbers"
    # qdd grows with the square of the velocity: infinite at t = 1, and no step is small enough there.
    inertia, rough = 2.0 * LENGTH**2, Integration(rtol=1e-6, atol=1e-6)
    with pytest.raises(GdAnalyzeError) as caught:
        simulate(pendulum(0.0), lambda t, q, qd: inertia * qd**2, [0.0], [1.0], 2.0, integration=rough)
    assert caught.value.details["where"].startswith(("t = 1 ", "t = 1.0", "t = 0.99"))
