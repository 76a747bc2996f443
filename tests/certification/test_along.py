"""Certificates along a tube: an adversary finds no state that exceeds them, and they are tight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import changed_programs as pruning
import gd_analyze as gd
from attacks import damaged, drawn_motion, errors_at, largest_excess, round_off_in
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.motion import MotionFactors
from gd_analyze.certification.taylor import TaylorForm
from gd_analyze.harmonics.expansion import expansion_factors
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from made_models import by_elements, searched
from strategies import arms, examples


@pytest.mark.parametrize("effort", [1, 1200, 60_000])
@examples(4)
@given(arm=arms(max_joints=4), seed=st.integers(0, 2**32 - 1))
def test_no_state_of_the_tube_exceeds_it_and_the_worst_found_is_one(arm, seed, effort):
    rng = np.random.default_rng(seed)
    model = damaged(arm, rng)
    margin = gd.types.Margin(
        *rng.choice([[0.02, 1e-3, 0.02, 0.05], [0.0, 0.0, 0.0, 0.0], [0.3, 0.1, 0.3, 0.5]])
    )
    tube = gd.types.Tube.along(arm, drawn_motion(arm, rng), margin, most=int(rng.choice([5, 60])))
    certificate = gd.certify(model, tube, effort=effort)
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
    tube = gd.types.Tube.along(arm, drawn_motion(arm, rng))
    certificate = gd.certify(model, tube, effort=2000)
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
    multiples, factors = np.unique(drawn, axis=0), expansion_factors(n)
    real, imaginary = rng.normal(size=(2, len(factors), len(multiples)))
    polynomial = TrigonometricPolynomial(prismatic, multiples, real + 1j * imaginary)
    box = gd.types.Box(-np.ones(n), np.ones(n), np.ones(n), np.ones(n))
    form = TaylorForm(ErrorField(box, polynomial, MotionFactors(n, factors), 0.0, 0.0))
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


@pytest.fixture(scope="module")
def puma_model(puma, pick_and_place) -> gd.types.SimplifiedModel:
    exact = gd.types.ExactDynamics.of(puma, gd.decompose(puma, pick_and_place, drives=True))
    return simplify_exact(exact, "1%", SearchOptions(TERM, effort=0.2))


def test_along_pick_and_place(puma, pick_and_place, puma_model):
    tube = gd.types.Tube.along(puma, pick_and_place)
    certificate, again = gd.certify(puma_model, tube), gd.certify(puma_model, tube)
    np.testing.assert_array_equal(certificate.along, again.along)
    np.testing.assert_array_equal(certificate.worst_states, again.worst_states)
    assert (certificate.ratio <= 1.1).all()
    # Every piece has its own bound.
    assert certificate.along.shape == (len(tube), 6)
    assert (certificate.along.min(axis=0) < 0.5 * certificate.certified).all()
    errors = errors_at(puma_model, pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    for time, error in zip(pick_and_place.time, errors, strict=True):
        there = (tube.begin <= time) & (tube.end >= time)
        assert (certificate.along[there].max(axis=0) >= error).all()
    # Smaller regions have smaller bounds. Margins do not scale a tube where set points are far apart.
    centre, half = (tube.lower + tube.upper) / 2.0, (tube.upper - tube.lower) / 2.0
    scaled = [replace(tube, lower=centre - s * half, upper=centre + s * half) for s in (0.5, 2.0)]
    narrow, wide = (gd.certify(puma_model, region).certified for region in scaled)
    assert (narrow < certificate.certified).all()
    assert (certificate.certified < wide).all()
    assert (certificate.certified <= 1.001 * gd.certify(puma_model, tube.enclosing).certified).all()
    # The budget was kept at the set points only.
    assert not certificate.within(puma_model.accuracy.allowed).all()
    # One look at every piece, whatever the effort.
    one = gd.certify(puma_model, tube, effort=1).certified
    assert (certificate.certified <= one).all()
    assert (one <= 3.0 * certificate.certified).all()


def stanford_motion() -> gd.Trajectory:
    time = np.linspace(0.0, 3.0, 40)
    speed, size = np.array([1, 0.7, 1.2, 1, 0.8, 1.5]), np.array([1, 0.6, 0.1, 1, 0.8, 1])
    sine, cosine = np.sin(np.outer(time, speed)), np.cos(np.outer(time, speed))
    return gd.Trajectory(time, 0.4 + size * sine, size * speed * cosine, -size * speed**2 * sine)


@pytest.mark.parametrize(("arm", "level", "budget"), [("puma560", ELEMENT, None), ("stanford", TERM, "5%")])
def test_models_by_elements_and_prismatic_joints_are_bounded_tightly(arm, level, budget, pick_and_place):
    arm, motion = gd.load_arm(arm), pick_and_place if arm == "puma560" else stanford_motion()
    exact = gd.types.ExactDynamics.of(arm, gd.decompose(arm, motion))
    model = (
        by_elements(arm, motion)
        if level is ELEMENT
        else searched(exact, budget, SearchOptions(level, effort=0.2))
    )
    tube = gd.types.Tube.along(arm, motion)
    certificate = gd.certify(model, tube, effort=100_000)
    assert (certificate.ratio[certificate.worst_found > 1e-9] <= 1.1).all()
    excess = largest_excess(model, tube, certificate.along, np.random.default_rng(1))
    assert excess <= round_off_in(model, tube)
