"""Closed loops against what mechanics and control say of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid

from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.studies import control_law as laws
from gd_analyze.studies.control_bounds import mean_diagonal
from gd_analyze.studies.control_law import CONTINUOUS, CONTROLLERS, EXACT, Bank, Gains, Reference, World
from gd_analyze.studies.control_loop import Loop, ProgramDynamics, accelerations, follow
from gd_analyze.tables import decompose_states, joint_accelerations, simulate, states_in_box, with_payload
from gd_analyze.types import ArmDynamics, Drivetrain, ExactForm, Integration, States


def world_of(model, motion, gains, **more) -> World:
    """No torque limits."""
    reference, exact = Reference.of(motion), model.form.program
    diagonal, limits = mean_diagonal(exact, reference), np.full(motion.n_joints, np.inf)
    return World(model.form, exact, model.program, diagonal, gains, reference, limits, **more)


@pytest.fixture(scope="module")
def swing_world(swing_model, swing) -> World:
    return world_of(swing_model, swing, Gains(20.0, 1.0))


def worst(world: World, *loops: Loop) -> np.ndarray:
    return np.array([loop.peak_error.max() for loop in follow(world, loops)])


def scaled(program: Program, factor: float) -> Program:
    """A program whose outputs are so many times another's."""
    trace = Trace()
    of = program.folded(trace, {})
    return Program.of(trace, [trace.multiply(factor, of(output)) for output in program.outputs])


def test_the_plant_is_the_simulation(puma, rng):
    """Two ways to D, h and c: a program's differences here, composite moments there."""
    states = states_in_box(puma, 40, 3)
    torque = rng.normal(size=(40, 6)) * [50.0, 80.0, 40.0, 5.0, 5.0, 5.0]
    inertia, rest = ProgramDynamics(ExactForm(puma, True).program, 6, 40).at(states.q.T, states.qd.T)
    found = np.linalg.solve(inertia, (torque - rest.T)[..., None])[..., 0]
    expected = joint_accelerations(puma, states.q, states.qd, torque, drivetrain=Drivetrain(inertia=True))
    # Torques of 1e2 N m to 1e-14, over the smallest inertia, 0.2 kg m^2; D's condition is below 100.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_the_exact_model_errs_by_the_integrator_and_by_the_period(swing_world):
    continuous, slow, middle, fast = worst(
        swing_world, *(Loop(EXACT, rate, 1.0) for rate in (CONTINUOUS, 250.0, 500.0, 1000.0))
    )
    # Runge-Kutta of fourth order: (2e-3 s)^4 times the fifth derivative of q, some 1e3, over 1.5 s and
    # divided by 120: 1e-10; feedback only makes it smaller.
    assert continuous < 1e-9
    # What is held lags by half a period: halving it halves the error, up to terms of second order.
    assert (slow / middle, middle / fast) == pytest.approx((2.0, 2.0), rel=0.05)


@pytest.mark.slow
def test_continuous_pd_is_what_another_integrator_makes_of_it(swing_world, two_link, swing):
    world = replace(swing_world, simplified=swing_world.exact)
    (loop,) = follow(world, [Loop(laws.PD, CONTINUOUS, 3.0)])
    reference, diagonal = Reference.of(swing), swing_world.diagonal

    def torque(t, q, qd):
        wanted, velocity, _ = reference.at(np.array(t), 3.0)
        gravity = ArmDynamics(two_link).gravity_loading(q)
        return diagonal * (400.0 * (wanted - q) + 40.0 * (velocity - qd)) + gravity

    how = Integration(set_points=2, rtol=1e-8)
    other = simulate(two_link, torque, swing.q[0], 3.0 * swing.qd[0], 0.5, integration=how)
    # 1e-9 per step of the other integrator, in some hundred steps.
    np.testing.assert_allclose(loop.end[0], other.q[-1], rtol=0, atol=1e-7)
    np.testing.assert_allclose(loop.end[1], other.qd[-1], rtol=0, atol=1e-6)


@pytest.mark.parametrize("friction", [False, True])
def test_energy_is_accounted_for(pick_and_place, puma_study, friction):
    """Work of the torque is energy gained and what friction took, both read off other code."""
    world = world_of(puma_study.model, pick_and_place, Gains(20.0, 0.7), friction=friction)
    for loop in follow(world, [Loop(c, 200.0, 2.0) for c in (EXACT, laws.SIMPLIFIED, laws.PD)]):
        # Some 10 J go to and fro. Without friction the integrator leaves 1e-6 of it; Coulomb friction goes
        # through zero within 0.01 rad/s, which some steps are too long for.
        assert abs(loop.energy_residual) < (1e-2 if friction else 1e-5)
        assert loop.dissipated > 1.0 if friction else loop.dissipated == 0.0


def test_a_torque_limit_holds(swing_world):
    limits = np.array([10.0, 2.0])
    loops = [Loop(c, rate, 1.0) for c in (EXACT, laws.PD) for rate in (CONTINUOUS, 200.0)]
    unlimited, limited = (
        follow(world, loops) for world in (swing_world, replace(swing_world, limits=limits))
    )
    for free, held in zip(unlimited, limited, strict=True):
        assert (free.peak_torque > limits).any()
        assert (free.saturated == 0.0).all()
        assert (held.peak_torque <= limits).all()
        assert 0.0 < held.saturated.max() <= 1.0
        assert held.peak_error.max() > free.peak_error.max()


def test_the_error_grows_with_the_models_and_with_a_payload_nobody_knows_of(swing_world, two_link):
    """Of a model whose torque is (1 + x) times the exact one: in proportion to a small x."""
    models = [scaled(swing_world.exact, 1.0 + x) for x in (0.01, 0.02, 0.04)]
    simplified = Loop(laws.SIMPLIFIED, CONTINUOUS, 1.0)
    peaks = [worst(replace(swing_world, simplified=model), simplified) for model in models]
    # e'' + K_d e' + K_p e = - x / (1 + x) D^-1 tau: to a few percent at these x.
    assert (peaks[1] / peaks[0], peaks[2] / peaks[1]) == pytest.approx((2.0, 2.0), rel=0.06)
    loaded = replace(swing_world, plant=ExactForm(with_payload(two_link, 0.5, [0.0, 0.0, 0.0])))
    loop = Loop(EXACT, 200.0, 1.0)
    assert worst(loaded, loop) > 10 * worst(swing_world, loop)


@pytest.mark.slow
def test_a_loop_is_the_same_alone_and_in_any_company(swing_world):
    loops = [
        Loop(c, rate, speed) for speed in (1.0, 2.0) for rate in (CONTINUOUS, 100.0) for c in CONTROLLERS
    ]
    together = follow(swing_world, loops)
    for k in (0, 11, len(loops) - 1):
        (alone,) = follow(swing_world, [loops[k]])
        # The same operations, but for the order in which a solver of small systems may take them.
        np.testing.assert_allclose(alone.end, together[k].end, rtol=0, atol=1e-11)
        assert len(together[k].time) == len(together[k].error)
        assert np.abs(together[k].error).max() <= together[k].peak_error.max() * (1 + 1e-6)


def test_a_loop_that_loses_the_motion_ends_there(swing_world):
    """Feedback of the wrong sign, beside one that tracks."""
    world = replace(swing_world, simplified=scaled(swing_world.exact, -1.0))
    lost, kept = follow(world, [Loop(laws.SIMPLIFIED, 200.0, 1.0), Loop(EXACT, 200.0, 1.0)])
    assert 0.0 < lost.lost_at < 1.5
    assert np.isfinite(lost.end).all()
    assert np.isinf(lost.peak_error).all()
    assert np.isnan(lost.error[lost.time >= lost.lost_at]).all()
    assert np.isfinite(lost.error[lost.time < lost.lost_at - 0.01]).all()
    assert kept.lost_at is None
    assert kept.peak_error.max() < 1e-2


def test_controllers_without_an_error_ask_for_what_they_know(swing_world, swing_model, swing):
    """On the motion the exact model asks for the exact torque, and the others for their own."""
    bank, k = Bank(CONTROLLERS, swing_world), 12
    q, qd, qdd = (np.repeat(x[k][:, None], len(CONTROLLERS), axis=1) for x in (swing.q, swing.qd, swing.qdd))
    torque = dict(zip(CONTROLLERS, bank.torque(q, qd, (q, qd, qdd)).T, strict=True))
    state = (swing.q[k], swing.qd[k], swing.qdd[k])
    found = decompose_states(swing_model.arm, States(*state), christoffel=False)
    h = found["coriolis_centrifugal"].reshape(-1, 2).sum(axis=0)
    exact = found["torque"].ravel()
    expected = {
        EXACT: exact,
        laws.SIMPLIFIED: swing_model.torque(*state),
        laws.FIXED_GAINS: swing_model.torque(*state),
        laws.WITHOUT_H: exact - h,
        laws.PD: swing_model.gravity_loading(swing.q[k]),
    }
    for controller in CONTROLLERS:
        # Some tens of operations on torques of 1e2.
        np.testing.assert_allclose(torque[controller], expected[controller], rtol=0, atol=1e-11)


@pytest.mark.parametrize("damping", [0.1, 0.9, 1.0, 1.5, 4.0])
@pytest.mark.parametrize("bandwidth", [3.0, 20.0])
def test_the_integrals_of_the_impulse_response(bandwidth, damping):
    """Of e'' + K_d e' + K_p e, by the roots of its polynomial."""
    gains = Gains(bandwidth, damping)
    first, second = np.roots([1.0, gains.damper, gains.stiffness]).astype(complex)
    # The response has a corner at every zero, and the rule an error of h^2 / 12 times its slope's jumps: with
    # so many steps below 1e-6 of the integral.
    time = np.linspace(0.0, 40.0 / -max(first.real, second.real), 400_001)
    if damping == 1.0:  # the roots are one
        g = time * np.exp(-bandwidth * time)
    else:
        g = ((np.exp(first * time) - np.exp(second * time)) / (first - second)).real
    error, velocity, acceleration = gains.margins
    assert error == pytest.approx(trapezoid(np.abs(g), time), rel=1e-5)
    assert velocity == pytest.approx(np.abs(np.diff(g)).sum(), rel=1e-5)
    assert acceleration == pytest.approx(1.0 + gains.damper * velocity + gains.stiffness * error)


def test_a_loop_whose_inertia_is_singular_is_lost_alone():
    """A loop that diverges may overflow into a matrix of zeros; the others go on."""
    inertia = np.stack([np.diag([2.0, 4.0]), np.zeros((2, 2)), np.eye(2)])
    found = accelerations(inertia, np.ones((3, 2)))
    np.testing.assert_array_equal(found[[0, 2]], [[0.5, 0.25], [1.0, 1.0]])
    assert np.isnan(found[1]).all()
