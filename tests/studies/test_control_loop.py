"""Closed loops against what mechanics and control say of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.integrate import trapezoid

from gd_analyze.dynamics.decomposition import decompose_states, torque_of
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.energy import kinetic_energy, potential_energy
from gd_analyze.dynamics.simulation import Integration, joint_accelerations, simulate
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.studies.control_law import CONTINUOUS, CONTROLLERS, Bank, Controller, Gains, Knowledge
from gd_analyze.studies.control_loop import Loop, World, follow
from gd_analyze.studies.control_plant import Plant, Reference
from gd_analyze.studies.control_result import EXACT, SIMPLIFIED

PD = Controller("pd", "gravity")


def scaled(program: Program, factor: float) -> Program:
    """A program whose outputs are so many times another's."""
    trace = Trace()
    of = program.folded(trace, {})
    return Program.of(trace, [trace.multiply(factor, of(output)) for output in program.outputs])


def test_the_plant_is_the_simulation(puma, rng):
    """Two ways to D, h and c: a program's differences here, composite moments there."""
    states = states_in_box(puma, 40, 3)
    torque = rng.normal(size=(40, 6)) * [50.0, 80.0, 40.0, 5.0, 5.0, 5.0]
    drivetrain = Drivetrain(inertia=True, friction=True)
    plant = Plant(ExactForm(puma, True), friction=True, count=40)
    q, qd, driving = states.q.T, states.qd.T, torque.T
    found = plant.accelerations(q, qd, driving - plant.resistance(qd)).T
    expected = joint_accelerations(puma, states.q, states.qd, torque, drivetrain=drivetrain)
    # Torques of 1e2 N m to 1e-14, over the smallest inertia, 0.2 kg m^2; D's condition is below 100.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_the_exact_model_in_continuous_time_errs_by_the_integrator(swing_world):
    course = follow(swing_world, [Loop(EXACT, CONTINUOUS, 1.0)])
    # Runge-Kutta of fourth order: (2e-3 s)^4 times the fifth derivative of q, some 1e3, over 1.5 s and
    # divided by 120: 1e-10; feedback only makes it smaller.
    assert course.peak_error.max() < 1e-9


def test_a_held_torque_errs_by_the_period(swing_world):
    """What is held lags by half a period: halving it halves the error, up to terms of second order."""
    course = follow(swing_world, [Loop(EXACT, rate, 1.0) for rate in (250.0, 500.0, 1000.0)])
    slow, middle, fast = course.peak_error.T
    np.testing.assert_allclose(slow / middle, 2.0, rtol=0.05)
    np.testing.assert_allclose(middle / fast, 2.0, rtol=0.05)


def test_continuous_pd_is_what_another_integrator_makes_of_it(swing_world, two_link, swing):
    course = follow(swing_world, [Loop(PD, CONTINUOUS, 3.0)])
    reference, diagonal = Reference.of(swing), swing_world.knowledge.diagonal

    def torque(t, q, qd):
        wanted, rate, _ = reference.at(np.array(t), 3.0)
        gravity = torque_of(two_link, States(q, np.zeros(2), np.zeros(2)))
        return diagonal * (400.0 * (wanted - q) + 40.0 * (rate - qd)) + gravity

    other = simulate(
        two_link, torque, swing.q[0], 3.0 * swing.qd[0], 0.5, integration=Integration(set_points=2, rtol=1e-8)
    )
    # 1e-9 per step of the other integrator, in some hundred steps.
    np.testing.assert_allclose(course.end[0, :, 0], other.q[-1], rtol=0, atol=1e-7)
    np.testing.assert_allclose(course.end[1, :, 0], other.qd[-1], rtol=0, atol=1e-6)


@pytest.mark.parametrize("friction", [False, True])
def test_energy_is_accounted_for(puma, pick_and_place, puma_study, friction):
    """Work of the torque is energy gained and what friction took, both read off other code."""
    model = puma_study.model
    world = World(
        model.form,
        Knowledge(model.form.program, model.program, puma_study.diagonal),
        Gains(20.0, 0.7),
        Reference.of(pick_and_place),
        np.full(6, np.inf),
        friction,
    )
    course = follow(world, [Loop(c, 200.0, 2.0) for c in (EXACT, SIMPLIFIED, PD)])

    def energy(state):
        return kinetic_energy(puma, *state.transpose(0, 2, 1), drives=True) + potential_energy(
            puma, state[0].T
        )

    residual = energy(course.end) - energy(course.start) - course.work + course.dissipated
    # Some 10 J go to and fro. Without friction the integrator leaves 1e-6 of it; Coulomb friction goes
    # through zero within 0.01 rad/s, which some steps are too long for.
    assert np.abs(residual).max() < (1e-2 if friction else 1e-5)
    assert (course.dissipated > 1.0).all() if friction else (course.dissipated == 0.0).all()


def test_a_torque_limit_holds(swing_world):
    limits = np.array([10.0, 2.0])
    loops = [Loop(c, rate, 1.0) for c in (EXACT, PD) for rate in (CONTINUOUS, 200.0)]
    free = follow(swing_world, loops)
    assert (free.peak_torque > limits[:, None]).any(axis=0).all()
    assert (free.saturated == 0.0).all()
    course = follow(dataclasses.replace(swing_world, limits=limits), loops)
    assert (course.peak_torque <= limits[:, None]).all()
    assert ((course.saturated > 0.0).any(axis=0) & (course.saturated <= 1.0).all(axis=0)).all()
    assert (course.peak_error.max(axis=0) > free.peak_error.max(axis=0)).all()


def test_the_error_grows_with_the_models(swing_world):
    """Of a model whose torque is (1 + x) times the exact one: in proportion to a small x."""
    peaks = []
    for excess in (0.01, 0.02, 0.04):
        program = scaled(swing_world.knowledge.exact, 1.0 + excess)
        knowledge = dataclasses.replace(swing_world.knowledge, simplified=program)
        world = dataclasses.replace(swing_world, knowledge=knowledge)
        peaks.append(follow(world, [Loop(SIMPLIFIED, CONTINUOUS, 1.0)]).peak_error[:, 0])
    # e'' + K_d e' + K_p e = - x / (1 + x) D^-1 tau: to a few percent at these x.
    np.testing.assert_allclose(peaks[1] / peaks[0], 2.0, rtol=0.05)
    np.testing.assert_allclose(peaks[2] / peaks[1], 2.0, rtol=0.06)


def test_a_loop_is_the_same_alone_and_in_any_company(swing_world):
    loops = [
        Loop(c, rate, speed) for speed in (1.0, 2.0) for rate in (CONTINUOUS, 100.0) for c in CONTROLLERS
    ]
    together, again = (follow(swing_world, loops) for _ in range(2))
    np.testing.assert_array_equal(together.end, again.end)
    np.testing.assert_array_equal(together.peak_error, again.peak_error)
    for k in (0, 4, 11, len(loops) - 1):
        alone = follow(swing_world, [loops[k]])
        # The same operations, but for the order in which a solver of small systems may take them.
        np.testing.assert_allclose(alone.end[..., 0], together.end[..., k], rtol=0, atol=1e-11)
        time, error = together.histories[k]
        assert len(time) == len(error)
        assert np.abs(error).max() <= together.peak_error[:, k].max() * (1 + 1e-6)


def test_a_loop_that_loses_the_motion_ends_there(swing_world):
    """Feedback of the wrong sign, beside one that tracks."""
    knowledge = dataclasses.replace(
        swing_world.knowledge, simplified=scaled(swing_world.knowledge.exact, -1.0)
    )
    world = dataclasses.replace(swing_world, knowledge=knowledge)
    course = follow(world, [Loop(SIMPLIFIED, 200.0, 1.0), Loop(EXACT, 200.0, 1.0)])
    assert 0.0 < course.lost_at[0] < 1.5
    assert np.isfinite(course.end).all()
    assert course.lost_at[1] == np.inf
    assert course.peak_error[:, 1].max() < 1e-2
    time, error = course.histories[0]
    assert np.isnan(error[time >= course.lost_at[0]]).all()
    assert np.isfinite(error[time < course.lost_at[0] - 0.01]).all()


def test_controllers_without_an_error_ask_for_what_they_know(swing_world, swing_model, swing):
    """On the motion the exact model asks for the exact torque, and the others for their own."""
    bank = Bank(CONTROLLERS, swing_world.knowledge, swing_world.gains)
    k = 12
    q, qd, qdd = (np.repeat(x[k][:, None], len(CONTROLLERS), axis=1) for x in (swing.q, swing.qd, swing.qdd))
    torque = dict(zip(CONTROLLERS, bank.torque(q, qd, (q, qd, qdd)).T, strict=True))
    state = (swing.q[k], swing.qd[k], swing.qdd[k])
    found = decompose_states(swing_model.arm, States(*state), christoffel=False)
    h = found["coriolis_centrifugal"].reshape(-1, 2).sum(axis=0)
    c = found["gravity_loading"].reshape(-1, 2).sum(axis=0)
    exact = found["torque"].ravel()
    diagonal = swing_world.knowledge.diagonal
    expected = {
        Controller("computed_torque", "exact"): exact,
        Controller("computed_torque", "simplified"): swing_model.torque(*state),
        Controller("fixed_gains", "simplified"): swing_model.torque(*state),
        Controller("computed_torque", "without_h"): exact - h,
        Controller("computed_torque", "gravity"): c + diagonal * swing.qdd[k],
        Controller("computed_torque", "nothing"): diagonal * swing.qdd[k],
        Controller("pd", "gravity"): c,
        Controller("pd", "simplified"): swing_model.gravity_loading(swing.q[k]),
        Controller("pd", "nothing"): np.zeros(2),
    }
    assert set(expected) == set(torque)
    for controller, value in expected.items():
        # Some tens of operations on torques of 1e2.
        np.testing.assert_allclose(torque[controller], value, rtol=0, atol=1e-11, err_msg=controller.title)


def test_a_payload_nobody_knows_of_costs(swing_world, two_link):
    loops = [Loop(EXACT, 200.0, 1.0)]
    heavy = with_payload(two_link, 0.5, [0.0, 0.0, 0.0])
    loaded = dataclasses.replace(swing_world, plant=ExactForm(heavy))
    assert follow(loaded, loops).peak_error.max() > 10 * follow(swing_world, loops).peak_error.max()


def test_too_many_steps_are_refused(swing_world):
    with pytest.raises(UsageError, match="too many steps"):
        follow(swing_world, [Loop(EXACT, 1e5, 0.01)])


# Steps of the sum below; the impulse response has a corner at every zero, and the rule an error of h^2 / 12
# times its slope's jumps: below 1e-6 of the integral.
STEPS = 400_001


def response(gains: Gains) -> tuple[np.ndarray, np.ndarray]:
    """Impulse response of e'' + K_d e' + K_p e, by the roots of its polynomial."""
    first, second = np.roots([1.0, gains.damper, gains.stiffness]).astype(complex)
    slowest = -max(first.real, second.real)
    time = np.linspace(0.0, 40.0 / slowest, STEPS)
    if abs(first - second) < 1e-4 * gains.bandwidth:  # critical: the roots are one
        return time, time * np.exp(-gains.bandwidth * time)
    return time, ((np.exp(first * time) - np.exp(second * time)) / (first - second)).real


@pytest.mark.parametrize("damping", [0.1, 0.5, 0.9, 1.0, 1.5, 4.0])
@pytest.mark.parametrize("bandwidth", [3.0, 20.0])
def test_the_integrals(bandwidth, damping):
    gains = Gains(bandwidth, damping)
    time, g = response(gains)
    assert gains.error_per_acceleration == pytest.approx(trapezoid(np.abs(g), time), rel=1e-5)
    assert gains.velocity_per_acceleration == pytest.approx(np.abs(np.diff(g)).sum(), rel=1e-5)


def test_the_margins_of_critical_damping():
    error, velocity, acceleration = Gains(20.0, 1.0).margins
    # Critical damping: 1 / w^2, 2 / (e w), and 1 + 2 w times the second + 1.
    assert (error, velocity) == pytest.approx((1 / 400, 2 / (np.e * 20)))
    assert acceleration == pytest.approx(2.0 + 4.0 / np.e)
