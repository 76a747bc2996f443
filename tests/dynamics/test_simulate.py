"""Simulated motions: the books of energy balance, and known motions come out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.special import ellipk
from simulated import DRIVEN, GRAVITY, LENGTH, energy_bound, limp, pendulum, per_step, undriven

from gd_analyze.dynamics.decomposition import decompose, decompose_states
from gd_analyze.dynamics.drivetrain import NO_DRIVES, Drivetrain
from gd_analyze.dynamics.simulation import Integration, simulate
from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from strategies import arms_with_states, examples

RUBBING = Drivetrain(inertia=True, friction=True)


# The bare wrist of the PUMA has inertias down to 4e-5 kg m^2, and D is all but singular where axes 4 and 6
# line up; with the drives' inertia, as in the real arm, it takes half as many steps.
PASSIVE = [
    ("puma560", 1.0, DRIVEN),
    ("puma560", 0.2, NO_DRIVES),
    ("stanford", 1.0, NO_DRIVES),
    ("stanford", 1.0, DRIVEN),
    ("two_link", 2.0, NO_DRIVES),
]


@pytest.mark.parametrize(("name", "duration", "drivetrain"), PASSIVE)
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
    assert found.integration.integrator == integrator


@examples(4)
@given(arms_with_states(max_joints=3, massive=True), st.integers(0, 2**32 - 1))
def test_work_is_the_energy_gained_less_what_was_dissipated(case, seed):
    arm, states = case
    rng = np.random.default_rng(seed)
    n = arm.n_joints
    time = np.linspace(0, 0.3, 13)
    history = rng.uniform(-20, 20, (13, n))
    damping = rng.uniform(0, 1, n)
    start = (states.q[0], states.qd[0], 0.3)
    found = simulate(arm, (time, history), *start, Drivetrain(damping=damping), Integration(31))
    assert np.abs(found.work).max() > 0
    assert (np.diff(found.dissipated) >= -energy_bound(arm, found)).all()
    assert found.dissipated[-1] > 0
    assert np.abs(found.energy_residual).max() <= energy_bound(arm, found)


def test_friction_only_takes_energy(puma):
    found = undriven(puma, 0.2, RUBBING)
    slack = energy_bound(puma, found, drives=True)
    assert (np.diff(found.dissipated) >= -slack).all()
    assert (np.diff(found.energy) <= slack).all()
    assert found.dissipated[-1] > 0.1
    assert found.energy[-1] < found.energy[0] - 0.1
    assert np.abs(found.energy_residual).max() <= slack


@pytest.mark.slow
def test_a_stiff_integrator_agrees_when_friction_holds_the_arm(puma):
    explicit, implicit = (
        undriven(puma, 0.3, RUBBING, integrator=name, rtol=1e-8, atol=1e-8) for name in ("DOP853", "LSODA")
    )
    # Friction contracts, so no error grows: each motion is within its steps' local errors, the others' too.
    allowed = sum(2 * s.steps * per_step(s).max() for s in (explicit, implicit))
    assert np.abs(explicit.q - implicit.q).max() <= allowed


def period(swing: float) -> float:
    """Exact period of a swing up to an angle: 4 sqrt(l/g) K(sin^2(angle / 2))."""
    return 4 * np.sqrt(LENGTH / GRAVITY) * ellipk(np.sin(swing / 2) ** 2)


@pytest.mark.parametrize("swing", [0.1, 1.0, 2.5, 3.1])
def test_a_pendulum_keeps_its_exact_period(swing):
    turns = 2
    found = simulate(
        pendulum(), limp(1), [swing], [0.0], turns * period(swing), integration=Integration(4 * turns + 1)
    )
    expected = swing * np.array([1, 0, -1, 0] * turns + [1])
    # An error of the state is one of the swing and of the phase. Of the swing: d = l qd dqd / (g sin swing)
    # at the bottom, where the rate is largest. Of the phase: the period changes with the swing, per turn.
    fastest = 2 * np.sqrt(GRAVITY / LENGTH) * np.sin(swing / 2)
    to_swing = 1 + LENGTH * fastest / (GRAVITY * np.sin(swing))
    slope = abs(period(swing + 1e-6) - period(swing - 1e-6)) / 2e-6
    growth = to_swing * (1 + fastest * (turns * slope + 1 / np.sqrt(GRAVITY / LENGTH)))
    allowed = 2 * found.steps * per_step(found).max() * growth
    assert np.abs(found.q[:, 0] - expected).max() <= allowed
    assert allowed < 0.01 * swing


class Quintic:
    """A planned motion from rest to rest: s = 10 x^3 - 15 x^4 + 6 x^5, exact at any time."""

    def __init__(self, start, end, duration) -> None:
        self.start, self.travel = np.array(start), np.array(end) - np.array(start)
        self.duration = duration

    def __call__(self, t):
        x = np.asarray(t)[..., None] / self.duration
        s = 10 * x**3 - 15 * x**4 + 6 * x**5
        v = (30 * x**2 - 60 * x**3 + 30 * x**4) / self.duration
        a = (60 * x - 180 * x**2 + 120 * x**3) / self.duration**2
        return self.start + s * self.travel, v * self.travel, a * self.travel


# The Stanford arm with its drives: without, a joint of 3e-4 kg m^2 follows the smallest error of its torque.
PLANS = {
    "two_link": (Quintic([0.0, 0.0], [1.0, -0.8], 1.0), False),
    "stanford": (Quintic([0.0, 0.5, 0.4, 0.0, 0.3, 0.0], [1.0, 1.2, 0.8, 0.5, -0.5, 1.0], 1.0), True),
}


def sensitivity(arm: RobotArm, history, begin, duration: float, drives: bool) -> float:
    """How much a small error of any state at the start grows on the way, by trying."""
    n, nudge = arm.n_joints, 1e-5

    def motion(state):
        how = Integration(rtol=1e-8, atol=1e-8)
        found = simulate(arm, history, state[:n], state[n:], duration, Drivetrain(inertia=drives), how)
        return np.concatenate([found.q, found.qd], axis=1)

    reference = motion(begin)
    moved = [motion(begin + nudge * direction) - reference for direction in np.eye(2 * n)]
    return float(np.abs(np.array(moved)).sum(axis=0).max() / nudge)


@pytest.mark.parametrize("name", ["two_link", pytest.param("stanford", marks=pytest.mark.slow)])
def test_a_torque_history_reproduces_the_planned_trajectory(name):
    arm, (plan, drives) = load_arm(name), PLANS[name]
    time = np.linspace(0, plan.duration, 201)
    motion = Trajectory(time, *plan(time), "plan")
    torque = decompose(arm, motion, christoffel=False, drives=drives).torque.values
    begin = np.concatenate([plan.start, 0 * plan.start])
    found = simulate(
        arm, (time, torque), plan.start, 0 * plan.start, plan.duration, Drivetrain(drives), Integration(101)
    )
    q, qd, qdd = plan(found.time)
    fine = np.linspace(0, plan.duration, 4001)
    exact = decompose_states(arm, States(*plan(fine)), christoffel=False, drives=drives)
    off = CubicSpline(time, torque)(fine) - exact["torque"]
    inertia = exact["inertia"].sum(axis=1) + (np.diag(arm.drive_inertia) if drives else 0.0)
    pushed = np.abs(np.linalg.solve(inertia, off[..., None])).max(axis=(1, 2)).mean() * plan.duration
    # Open loop an error grows; twice what it grows from the start covers errors that come later. What comes
    # in: local errors of all steps, and the spline's torque error as an acceleration, added up over time.
    growth = 2 * sensitivity(arm, (time, torque), begin, plan.duration, drives)
    allowed = growth * (2 * found.steps * per_step(found).max() + pushed)
    assert np.abs(found.q - q).max() <= allowed
    assert np.abs(found.qd - qd).max() <= allowed
    assert allowed < 1e-3  # of moves of about 1 rad: the bound says something
    np.testing.assert_allclose(found.qdd, qdd, atol=100 * allowed)


def test_the_motion_is_a_trajectory(two_link):
    found = undriven(two_link, 0.2)
    trajectory = found.as_trajectory("fall")
    assert trajectory.name == "fall"
    assert trajectory.origin == "simulated: composite_moments, DOP853, rtol 1e-09, atol 1e-09"
    torque = decompose(two_link, trajectory).torque.values
    # Inverse dynamics of what forward dynamics gave: no torque, to round-off of some tens of N m.
    assert np.abs(torque).max() <= 1e-12
    np.testing.assert_array_equal(found.torque, np.zeros((41, 2)))
    assert found.time[[0, -1]].tolist() == [0.0, 0.2]
    np.testing.assert_array_equal(found.energy, found.kinetic + found.potential)


TIME, VALUES = [0.0, 0.5, 1.0], np.zeros((3, 2))


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"q0": [0.0]}, "q0"),
        ({"q0": np.zeros((2, 2)), "qd0": np.zeros((2, 2))}, "q0"),
        ({"qd0": [0.0, np.nan]}, "qd0[1]"),
        ({"duration": 0.0}, "duration"),
        ({"duration": np.inf}, "duration"),
        ({"set_points": 2.5}, "set_points"),
        ({"method": "lagrange"}, "method"),
        ({"integrator": "Euler"}, "integrator"),
        ({"rtol": 1e-15}, "rtol"),
        ({"atol": np.nan}, "atol"),
        ({"torque": 3.0}, "torque"),
        ({"torque": (TIME, "abc")}, "torque"),
        ({"torque": (TIME, np.zeros((3, 3)))}, "torque"),
        ({"torque": ([0.0], np.zeros((1, 2)))}, "torque"),
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


def test_a_torque_function_that_misbehaves(two_link):
    for torque, found in (
        (lambda t, q, qd: [1.0], "shape (1,)"),
        (lambda t, q, qd: [np.nan, 0], "[nan, 0.0]"),
    ):
        with pytest.raises(GdAnalyzeError, match="torque function does not give") as caught:
            simulate(two_link, torque, [0, 0], [0, 0], 0.1)
        assert caught.value.details["found"] == found
        assert caught.value.details["where"] == "t = 0 s"


def test_an_integrator_that_gives_up():
    """qdd grows with the square of the rate: infinite at t = 1, and no step is small enough there."""
    arm = dataclasses.replace(pendulum(), gravity=np.zeros(3))
    inertia = 2.0 * LENGTH**2
    rough = Integration(rtol=1e-6, atol=1e-6)
    with pytest.raises(GdAnalyzeError, match=r"gives up|grows without bounds") as caught:
        simulate(arm, lambda t, q, qd: inertia * qd**2, [0.0], [1.0], 2.0, integration=rough)
    assert caught.value.details["where"].startswith(("t = 1 ", "t = 1.0", "t = 0.99"))
