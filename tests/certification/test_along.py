"""The bound along a tube: an adversary finds no state that exceeds it, and it is close to the worst state."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.certification.certificate import certify
from gd_analyze.certification.certified_model import simplify_certified
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.motion import Motion
from gd_analyze.certification.taylor import TaylorForm
from gd_analyze.certification.tube import Margin, Tube
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import UsageError
from gd_analyze.harmonics.expansion import velocity_factors
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.motions.csv_file import read_trajectory
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term import TERM
from made_models import model_of
from strategies import arms, examples

PUMA_TRAJECTORIES = ("pick-and-place", "large-slew", "wrist-move")


def errors_at(model: SimplifiedModel, states: np.ndarray) -> np.ndarray:
    """Errors at states of shape (K, 3, n), by the formulation in closed form, shape (K, n)."""
    q, qd, qdd = states.transpose(1, 0, 2)
    exact = decompose_states(model.arm, States(q, qd, qdd), christoffel=False, drives=model.drives)["torque"]
    return np.abs(model.torque(q, qd, qdd) - exact)


def round_off(model: SimplifiedModel, tube: Tube) -> float:
    """Two programs of one torque: some hundred eps of the largest, whose terms may be larger than it."""
    box = tube.enclosing
    farthest = np.stack([box.farthest, box.velocity, box.acceleration])[None]
    torque = np.abs(model.torque(*farthest.transpose(1, 0, 2))).max() + errors_at(model, farthest).max()
    return 1e-12 * float(torque) * (1.0 + float(box.farthest.max())) ** 2


def largest_excess(
    model: SimplifiedModel, tube: Tube, along: np.ndarray, rng: np.random.Generator, rounds: int = 2
) -> float:
    """How far an adversary gets above the bounds of the pieces (pieces, n), at most.

    From corners and drawn states of every piece it climbs: variable after variable goes to the end where the
    error of one joint, another in every run, is larger.
    """
    pieces = np.concatenate([np.arange(len(tube)), rng.integers(0, len(tube), 100)])
    lower, upper = tube.lower[pieces], tube.upper[pieces]
    states = np.where(rng.random(lower.shape) < 0.5, lower, upper)
    inside = rng.random(len(pieces)) < 0.3
    states[inside] = rng.uniform(lower[inside], upper[inside])
    joints, rows = rng.integers(0, tube.n_joints, len(pieces)), np.arange(len(pieces))
    excess = -np.inf
    for turn in range(rounds * 3 * tube.n_joints):
        kind, k = (turn // tube.n_joints) % 3, turn % tube.n_joints
        tried = np.stack([states, states, states])
        tried[1][:, kind, k], tried[2][:, kind, k] = lower[:, kind, k], upper[:, kind, k]
        errors = errors_at(model, tried.reshape(-1, 3, tube.n_joints)).reshape(3, len(pieces), -1)
        excess = max(excess, float((errors - along[pieces]).max()))
        states = tried[errors[:, rows, joints].argmax(axis=0), rows]
    return excess


def motion_of(arm: RobotArm, rng: np.random.Generator) -> Trajectory:
    """Smooth and finely sampled, smooth and coarse, or set points that contradict one another."""
    n, count = arm.n_joints, int(rng.choice([2, 4, 25]))
    time = np.linspace(0.0, 1.5, count)
    speed, size, phase = rng.uniform(0.5, 4.0, n), rng.choice([0.0, 0.2, 1.0], n), rng.uniform(0.0, 6.0, n)
    angle = np.outer(time, speed) + phase
    q, qd, qdd = size * np.sin(angle), size * speed * np.cos(angle), -size * speed**2 * np.sin(angle)
    if rng.random() < 0.25:
        qd, qdd = rng.uniform(-2.0, 2.0, (2, count, n))
    return Trajectory(time, q, qd, qdd)


@examples(40)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1), st.sampled_from([1, 1200, 60_000]))
def test_no_state_of_the_tube_exceeds_it(arm: RobotArm, seed: int, effort: int) -> None:
    rng = np.random.default_rng(seed)
    torques = {t: w * (0.9 if rng.random() < 0.3 else 1.0) for t, w in ExactForm(arm).torques.items()}
    model = model_of(ExactForm(arm), TERM, {t: w for t, w in torques.items() if rng.random() < 0.7})
    margin = Margin(*rng.choice([[0.02, 1e-3, 0.02, 0.05], [0.0, 0.0, 0.0, 0.0], [0.3, 0.1, 0.3, 0.5]]))
    tube = Tube.along(arm, motion_of(arm, rng), margin, most=int(rng.choice([5, 60])))
    certificate = certify(model, tube, effort=effort)
    assert certificate.along is not None
    np.testing.assert_array_equal(certificate.along.max(axis=0), certificate.certified)
    assert largest_excess(model, tube, certificate.along, rng) <= round_off(model, tube)
    assert (certificate.worst_found <= certificate.certified).all()


@examples(15)
@given(arms(max_joints=3), st.integers(0, 2**32 - 1))
def test_the_worst_found_is_an_error_at_a_state_of_the_tube(arm: RobotArm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = model_of(
        ExactForm(arm), TERM, {t: w for t, w in ExactForm(arm).torques.items() if rng.random() < 0.5}
    )
    tube = Tube.along(arm, motion_of(arm, rng))
    certificate = certify(model, tube)
    states = np.stack(certificate.worst_states, axis=1)
    slack = round_off(model, tube) + 1e-9 * certificate.certified
    np.testing.assert_array_less(
        np.abs(errors_at(model, states).diagonal() - certificate.worst_found),
        slack + certificate.certified * 1e-9 + 1e-300,
    )
    for state in states:
        inside = ((tube.lower <= state) & (state <= tube.upper)).all(axis=(1, 2))
        assert inside.any()


@examples(30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_taylor_bounds_hold_in_boxes_of_any_size(seed: int, n: int) -> None:
    """Of polynomials of any waves, with prismatic variables of up to the third power."""
    rng = np.random.default_rng(seed)
    prismatic = tuple(bool(x) for x in rng.random(n) < 0.4)
    multiples = np.unique(
        np.where(prismatic, rng.integers(0, 4, (12, n)), rng.integers(-2, 3, (12, n))), axis=0
    )
    factors = velocity_factors(n)
    shape = (len(factors), len(multiples))
    waves = TrigonometricPolynomial(
        prismatic, multiples, rng.normal(size=shape) + 1j * rng.normal(size=shape)
    )
    field = ErrorField(waves, Motion(n, factors), 0.0, 0.0)
    form = TaylorForm(field)
    centre = rng.uniform(-1.0, 1.0, (3 * n, 20))
    half = 10.0 ** rng.uniform(-4.0, 0.0, (3 * n, 20)) * rng.choice([0.0, 1.0], (3 * n, 20), p=[0.1, 0.9])
    known = form.bounds(centre, half)
    for _ in range(60):
        x = centre + half * rng.choice([-1.0, 1.0, rng.uniform(-1.0, 1.0)], centre.shape)
        # Some thousand products of numbers of size 1 are summed.
        assert (np.abs(form(x)) <= known.bound + 1e-11).all()
    np.testing.assert_allclose(np.abs(form(known.state)), known.found)
    assert (np.abs(known.state - centre) <= half * (1 + 1e-12) + 1e-15).all()
    small = form.bounds(centre, 1e-4 * half)
    assert (small.bound - small.found <= 1e-6 * (1.0 + small.found)).all()


def puma_model(puma: RobotArm, motion: Trajectory, drives: bool) -> SimplifiedModel:
    exact = ExactDynamics.of(puma, gd.decompose(puma, motion, drives=drives))
    return simplify_exact(exact, Budget(), SearchOptions(TERM, effort=0.2))


@pytest.mark.parametrize("drives", [False, True])
@pytest.mark.parametrize("name", PUMA_TRAJECTORIES)
def test_it_is_tight_along_the_pumas_trajectories(puma: RobotArm, name: str, drives: bool) -> None:
    motion = read_trajectory(name, puma)
    model = puma_model(puma, motion, drives)
    certificate = certify(model, Tube.along(puma, motion), effort=100_000)
    assert (certificate.ratio <= 1.1).all()
    # The set points are in the tube.
    assert (certificate.certified >= model.accuracy.errors.largest).all()


def test_every_piece_has_its_own_bound(puma: RobotArm, pick_and_place: Trajectory) -> None:
    model = puma_model(puma, pick_and_place, drives=True)
    tube = Tube.along(puma, pick_and_place)
    certificate = certify(model, tube)
    errors = np.abs(
        errors_at(model, np.stack([pick_and_place.q, pick_and_place.qd, pick_and_place.qdd], axis=1))
    )
    for time, error in zip(pick_and_place.time, errors, strict=True):
        there = (tube.begin <= time) & (tube.end >= time)
        assert (certificate.along[there].max(axis=0) >= error).all()
    assert certificate.along.shape == (len(tube), 6)
    assert (certificate.along.min(axis=0) < 0.5 * certificate.certified).all()


def test_a_smaller_margin_has_a_smaller_bound(puma: RobotArm, pick_and_place: Trajectory) -> None:
    model = puma_model(puma, pick_and_place, drives=True)
    bounds = [
        certify(model, Tube.along(puma, pick_and_place, Margin.parse(text))).certified
        for text in ("0.2deg,qd=0.5%,qdd=1%", "1deg", "4deg,qd=8%,qdd=20%")
    ]
    assert (bounds[0] < bounds[1]).all()
    assert (bounds[1] < bounds[2]).all()


def test_the_tube_is_within_the_box_around_it(puma: RobotArm, pick_and_place: Trajectory) -> None:
    model = puma_model(puma, pick_and_place, drives=True)
    tube = Tube.along(puma, pick_and_place)
    inner, outer = certify(model, tube), certify(model, tube.enclosing)
    assert (inner.certified <= 1.001 * outer.certified).all()
    assert inner.box.n_joints == outer.box.n_joints == 6
    np.testing.assert_array_equal(inner.box.lower, outer.box.lower)


def test_the_same_input_gives_the_same_certificate(puma: RobotArm, pick_and_place: Trajectory) -> None:
    model = puma_model(puma, pick_and_place, drives=True)
    first, second = (certify(model, Tube.along(puma, pick_and_place)) for _ in range(2))
    np.testing.assert_array_equal(first.along, second.along)
    np.testing.assert_array_equal(first.worst_states, second.worst_states)


def test_a_model_by_elements_is_certified_too(puma: RobotArm, pick_and_place: Trajectory) -> None:
    exact = ExactDynamics.of(puma, gd.decompose(puma, pick_and_place))
    model = simplify_exact(exact, Budget.parse("3%"), SearchOptions(ELEMENT, dearer=True))
    tube = Tube.along(puma, pick_and_place)
    certificate = certify(model, tube, effort=100_000)
    assert (certificate.certified >= model.accuracy.errors.largest).all()
    assert (certificate.ratio[certificate.worst_found > 1e-9] <= 1.1).all()
    assert largest_excess(model, tube, certificate.along, np.random.default_rng(1), 1) <= round_off(
        model, tube
    )


def test_an_exact_model_has_no_error_but_the_identifications(
    puma: RobotArm, pick_and_place: Trajectory
) -> None:
    """Its bound is round-off, which no halving of boxes makes smaller: none is looked at twice."""
    exact = ExactDynamics.of(puma, gd.decompose(puma, pick_and_place))
    model = simplify_exact(exact, Budget.parse("0%"), SearchOptions(TERM))
    certificate = certify(model, Tube.along(puma, pick_and_place))
    assert (certificate.certified <= 1e-6 * exact.peak_torque.max()).all()
    assert not certificate.within(np.zeros(6)).any()


def test_one_look_at_every_piece_whatever_the_effort(two_link: RobotArm, swing: Trajectory) -> None:
    tube = Tube.along(two_link, swing)
    torques = dict(list(ExactForm(two_link).torques.items())[:2])
    model = model_of(ExactForm(two_link), TERM, torques)
    one, many = (certify(model, tube, effort=effort).certified for effort in (1, 100_000))
    assert (many <= one).all()
    assert (one <= 1.2 * many).all()


@pytest.mark.parametrize("level", [TERM, ENERGY, ELEMENT])
def test_a_certified_budget_holds_in_the_whole_tube(puma, pick_and_place, level) -> None:
    exact = ExactDynamics.of(puma, pick_and_place, drives=True)
    tube = Tube.along(puma, pick_and_place)
    model, certificate = simplify_certified(exact, Budget.parse("2%"), tube, level=level)
    allowed = exact.allowed(Budget.parse("2%"))
    assert certificate.region is tube
    assert (certificate.certified <= allowed).all()
    assert largest_excess(
        model, tube, np.broadcast_to(allowed, certificate.along.shape), np.random.default_rng(2), 1
    ) <= round_off(model, tube)
    assert model.accuracy.budget == "2%, certified"


def test_a_budget_that_holds_at_the_set_points_may_break_between_and_beside_them(
    puma, pick_and_place
) -> None:
    sampled = puma_model(puma, pick_and_place, drives=True)
    tube = Tube.along(puma, pick_and_place)
    assert sampled.accuracy.errors.largest_share.max() <= 0.01
    assert not certify(sampled, tube).within(sampled.accuracy.allowed).all()


@examples(6)
@given(arms(max_joints=2, massive=True), st.floats(0.02, 0.3), st.integers(0, 2**32 - 1))
def test_certified_budgets_of_random_arms_hold_along_coarse_motions_too(arm, share, seed) -> None:
    rng = np.random.default_rng(seed)
    motion = motion_of(arm, rng)
    exact = ExactDynamics.of(arm, States(motion.q, motion.qd, motion.qdd))
    if not exact.peak_torque.all():
        return
    tube = Tube.along(arm, motion)
    budget = Budget.parse(f"{100 * share}%")
    model, certificate = simplify_certified(exact, budget, tube)
    assert (certificate.certified <= exact.allowed(budget)).all()
    assert largest_excess(model, tube, certificate.along, rng, 1) <= round_off(model, tube)


def test_a_tube_of_another_arm_is_refused(puma: RobotArm, two_link: RobotArm, swing: Trajectory) -> None:
    model = model_of(ExactForm(puma), TERM, ExactForm(puma).torques)
    with pytest.raises(UsageError, match="does not fit the arm"):
        certify(model, Tube.along(two_link, swing))


def test_the_stanford_arms_sliding_joint(stanford_motion: Trajectory) -> None:
    arm = load_arm("stanford")
    exact = ExactDynamics.of(arm, gd.decompose(arm, stanford_motion))
    model = simplify_exact(exact, Budget.parse("5%"), SearchOptions(TERM, effort=0.2, dearer=True))
    tube = Tube.along(arm, stanford_motion)
    certificate = certify(model, tube)
    assert (certificate.ratio <= 1.1).all()
    excess = largest_excess(model, tube, certificate.along, np.random.default_rng(3), 1)
    assert excess <= round_off(model, tube)


@pytest.fixture
def stanford_motion() -> Trajectory:
    time = np.linspace(0.0, 3.0, 40)
    speed, size, middle = np.array([1, 0.7, 1.2, 1, 0.8, 1.5]), np.array([1, 0.6, 0.1, 1, 0.8, 1]), 0.4
    angle = np.outer(time, speed)
    return Trajectory(
        time, middle + size * np.sin(angle), size * speed * np.cos(angle), -size * speed**2 * np.sin(angle)
    )
