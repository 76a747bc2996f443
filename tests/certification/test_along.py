"""Certificates along a tube: an adversary finds no state that exceeds them, and they are tight."""

from __future__ import annotations

import numpy as np
import pytest
from attacks import damaged, drawn_motion, errors_at, largest_excess, model_with, round_off_in
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
import pruned_recursions as pruning
from gd_analyze.certification.certificate import certify
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.motion import Motion
from gd_analyze.certification.taylor import TaylorForm
from gd_analyze.certification.tube import Margin, Tube
from gd_analyze.harmonics.expansion import velocity_factors
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.simplify import simplify_exact
from made_models import exact_model
from strategies import arms, examples


@examples(25)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1), st.sampled_from([1, 1200, 60_000]))
def test_no_state_of_the_tube_exceeds_it_and_the_worst_found_is_one(arm, seed, effort):
    rng = np.random.default_rng(seed)
    model = damaged(arm, rng)
    margin = Margin(*rng.choice([[0.02, 1e-3, 0.02, 0.05], [0.0, 0.0, 0.0, 0.0], [0.3, 0.1, 0.3, 0.5]]))
    tube = Tube.along(arm, drawn_motion(arm, rng), margin, most=int(rng.choice([5, 60])))
    certificate = certify(model, tube, effort=effort)
    slack = round_off_in(model, tube)
    np.testing.assert_array_equal(certificate.along.max(axis=0), certificate.certified)
    assert largest_excess(model, tube, certificate.along, rng, 2) <= slack
    assert (certificate.worst_found <= certificate.certified).all()
    found = np.diag(errors_at(model, *certificate.worst_states))
    assert (np.abs(found - certificate.worst_found) <= slack + 2e-9 * certificate.certified + 1e-300).all()
    for state in np.stack(certificate.worst_states, axis=1):
        assert ((tube.lower <= state) & (state <= tube.upper)).all(axis=(1, 2)).any()


@examples(4)
@given(arms(max_joints=6), st.integers(0, 2**32 - 1))
def test_no_state_exceeds_it_for_programs_with_something_left_out(arm, seed):
    rng = np.random.default_rng(seed)
    model, n = pruning.pruned(arm, 0.05, rng), arm.n_joints
    tube = Tube.along(arm, drawn_motion(arm, rng))
    certificate = certify(model, tube, effort=2000)
    for piece in range(0, len(tube), max(1, len(tube) // 8)):
        states = rng.uniform(tube.lower[piece], tube.upper[piece], (50, 3, n)).transpose(1, 0, 2)
        errors, slack = pruning.errors_at(model, *states), pruning.round_off(model, *states)
        assert (errors <= certificate.along[piece] + slack).all()


@examples(25)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_taylor_bounds_hold_in_boxes_of_any_size(seed, n):
    """For polynomials of any harmonics, with prismatic variables of up to the third power."""
    rng = np.random.default_rng(seed)
    prismatic = tuple(bool(x) for x in rng.random(n) < 0.4)
    drawn = np.where(prismatic, rng.integers(0, 4, (12, n)), rng.integers(-2, 3, (12, n)))
    multiples, factors = np.unique(drawn, axis=0), velocity_factors(n)
    real, imaginary = rng.normal(size=(2, len(factors), len(multiples)))
    polynomial = TrigonometricPolynomial(prismatic, multiples, real + 1j * imaginary)
    box = gd.Box(-np.ones(n), np.ones(n), np.ones(n), np.ones(n))
    form = TaylorForm(ErrorField(box, polynomial, Motion(n, factors), 0.0, 0.0))
    centre = rng.uniform(-1.0, 1.0, (3 * n, 20))
    half = 10.0 ** rng.uniform(-4.0, 0.0, (3 * n, 20)) * rng.choice([0.0, 1.0], (3 * n, 20), p=[0.1, 0.9])
    boxes = form.boxes(centre, half, np.arange(20))
    for _ in range(60):
        x = centre + half * rng.choice([-1.0, 1.0, rng.uniform(-1.0, 1.0)], centre.shape)
        # Some thousand products of numbers of size 1 are summed.
        assert (np.abs(form(x)) <= boxes.bounds + 1e-11).all()
    np.testing.assert_allclose(np.abs(form(boxes.states)), boxes.found)
    assert (np.abs(boxes.states - centre) <= half * (1 + 1e-12) + 1e-15).all()
    small = form.boxes(centre, 1e-4 * half, np.arange(20))
    assert (small.bounds - small.found <= 1e-6 * (1.0 + small.found)).all()


def puma_model(puma, motion: Trajectory, drives: bool = True) -> SimplifiedModel:
    exact = ExactDynamics.of(puma, gd.decompose(puma, motion, drives=drives))
    return simplify_exact(exact, Budget(), SearchOptions(TERM, effort=0.2))


@pytest.mark.parametrize(
    ("name", "drives"), [("pick-and-place", False), ("large-slew", True), ("wrist-move", True)]
)
def test_it_is_tight_along_the_pumas_trajectories(puma, name, drives):
    motion = gd.read_trajectory(name, puma)
    model = puma_model(puma, motion, drives)
    certificate = certify(model, Tube.along(puma, motion), effort=100_000)
    assert (certificate.ratio <= 1.1).all()
    assert (certificate.certified >= model.accuracy.errors.largest).all()


def test_along_pick_and_place(puma, pick_and_place):
    model, tube = puma_model(puma, pick_and_place), Tube.along(puma, pick_and_place)
    certificate, again = certify(model, tube), certify(model, tube)
    np.testing.assert_array_equal(certificate.along, again.along)
    np.testing.assert_array_equal(certificate.worst_states, again.worst_states)
    # Every piece has its own bound.
    assert certificate.along.shape == (len(tube), 6)
    assert (certificate.along.min(axis=0) < 0.5 * certificate.certified).all()
    errors = errors_at(model, pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    for time, error in zip(pick_and_place.time, errors, strict=True):
        there = (tube.begin <= time) & (tube.end >= time)
        assert (certificate.along[there].max(axis=0) >= error).all()
    # Smaller regions have smaller bounds.
    narrow, wide = (
        certify(model, Tube.along(puma, pick_and_place, text)).certified
        for text in ("0.2deg,qd=0.5%,qdd=1%", "4deg,qd=8%,qdd=20%")
    )
    assert (narrow < certificate.certified).all()
    assert (certificate.certified < wide).all()
    assert (certificate.certified <= 1.001 * certify(model, tube.enclosing).certified).all()
    # The budget was kept at the set points only.
    assert not certificate.within(model.accuracy.allowed).all()


def test_a_model_by_elements_is_certified_too(puma, pick_and_place):
    exact = ExactDynamics.of(puma, gd.decompose(puma, pick_and_place))
    model = simplify_exact(exact, Budget.parse("3%"), SearchOptions(ELEMENT, dearer=True))
    tube = Tube.along(puma, pick_and_place)
    certificate = certify(model, tube, effort=100_000)
    assert (certificate.ratio[certificate.worst_found > 1e-9] <= 1.1).all()
    excess = largest_excess(model, tube, certificate.along, np.random.default_rng(1))
    assert excess <= round_off_in(model, tube)


def test_an_exact_model_has_round_off_only(puma, pick_and_place):
    model = exact_model(puma)
    certificate = certify(model, Tube.along(puma, pick_and_place))
    peak = np.abs(model.torque(pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)).max()
    assert (certificate.certified <= 1e-6 * peak).all()
    assert not certificate.within(np.zeros(6)).any()


def test_one_look_at_every_piece_whatever_the_effort(two_link, swing):
    tube = Tube.along(two_link, swing)
    model = model_with(two_link, dict(list(ExactForm(two_link).torques.items())[:2]))
    one, many = (certify(model, tube, effort=effort).certified for effort in (1, 100_000))
    assert (many <= one).all()
    assert (one <= 1.2 * many).all()


def test_the_stanford_arms_prismatic_joint():
    arm, time = gd.load_arm("stanford"), np.linspace(0.0, 3.0, 40)
    speed, size = np.array([1, 0.7, 1.2, 1, 0.8, 1.5]), np.array([1, 0.6, 0.1, 1, 0.8, 1])
    sine, cosine = np.sin(np.outer(time, speed)), np.cos(np.outer(time, speed))
    motion = Trajectory(time, 0.4 + size * sine, size * speed * cosine, -size * speed**2 * sine)
    exact = ExactDynamics.of(arm, gd.decompose(arm, motion))
    model = simplify_exact(exact, Budget.parse("5%"), SearchOptions(TERM, effort=0.2, dearer=True))
    tube = Tube.along(arm, motion)
    certificate = certify(model, tube)
    assert (certificate.ratio <= 1.1).all()
    excess = largest_excess(model, tube, certificate.along, np.random.default_rng(3))
    assert excess <= round_off_in(model, tube)
