"""The certificate: no state exceeds it, it is tight where the truth is known, it scales as the error does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import Certificate, certify
from gd_analyze.certification.error_field import harmonics_slack
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.transform import harmonics_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify, simplify_exact
from gd_analyze.simplification.term import TERM
from made_models import model_of
from strategies import arms, examples, two_link_of


def model_with(arm: RobotArm, torques: Torques) -> SimplifiedModel:
    """A model that keeps just these torque terms; what it promises does not matter here."""
    return model_of(ExactForm(arm), TERM, torques)


def exact_torques(arm: RobotArm) -> Torques:
    return ExactForm(arm).torques


def box_of(arm: RobotArm, rng: np.random.Generator) -> Box:
    """Ranges from none over narrow ones to more than a turn."""
    n = arm.n_joints
    middle, half = rng.uniform(-1.0, 1.0, n), rng.choice([0.0, 0.3, 1.5, 4.0], n)
    return Box(middle - half, middle + half, rng.uniform(0.0, 2.0, n), rng.uniform(0.0, 5.0, n))


def errors_at(model: SimplifiedModel, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    exact = decompose_states(model.arm, States(q, qd, qdd), christoffel=False, drives=model.drives)["torque"]
    return np.abs(model.torque(q, qd, qdd) - exact)


def drawn_states(box: Box, count: int, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """States of the box, most of them with velocities, accelerations and some positions at their limits."""
    n = box.n_joints
    signs = np.where(rng.random((2, count, n)) < 0.5, 1.0, -1.0)
    q = rng.uniform(box.lower, box.upper, (count, n))
    q = np.where(rng.random((count, n)) < 0.2, np.where(signs[0] > 0, box.lower, box.upper), q)
    shares = rng.choice([1.0, 0.5, 0.0], (count, n), p=[0.8, 0.1, 0.1])
    return q, signs[0] * shares * box.velocity, signs[1] * box.acceleration


def round_off(model: SimplifiedModel, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> float:
    """The two torques compared have a round-off of their own: some hundred eps of the largest torque.

    Terms may be larger than the torques they add up to, prismatic variables of up to 5 m to the second power.
    """
    return 1e-12 * float(np.abs(model.torque(q, qd, qdd)).max() + errors_at(model, q, qd, qdd).max())


@examples(40)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1), st.sampled_from([1, 200, 20_000]))
def test_no_state_exceeds_it(arm: RobotArm, seed: int, effort: int) -> None:
    rng = np.random.default_rng(seed)
    torques = {t: w * (0.9 if rng.random() < 0.3 else 1.0) for t, w in exact_torques(arm).items()}
    model = model_with(arm, {t: w for t, w in torques.items() if rng.random() < 0.7})
    box = box_of(arm, rng)
    certificate = certify(model, box, effort=effort)
    states = drawn_states(box, 2000, rng)
    found = errors_at(model, *states).max(axis=0)
    assert (found <= certificate.certified + round_off(model, *states)).all()
    assert (certificate.worst_found <= certificate.certified).all()
    assert (certificate.ratio >= 1.0).all()


@examples(20)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1))
def test_the_worst_found_is_an_error_of_the_box(arm: RobotArm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = model_with(arm, {t: w for t, w in exact_torques(arm).items() if rng.random() < 0.7})
    box = box_of(arm, rng)
    certificate = certify(model, box, effort=500)
    q, qd, qdd = certificate.worst_states
    assert ((box.lower <= q) & (q <= box.upper)).all()
    assert (np.abs(qd) <= box.velocity).all()
    assert (np.abs(qdd) <= box.acceleration).all()
    there = np.diag(errors_at(model, q, qd, qdd))
    assert certificate.worst_found == pytest.approx(there, rel=0, abs=round_off(model, q, qd, qdd))
    # It beats drawing at random, or finds the same.
    drawn = drawn_states(box, 300, rng)
    assert (
        errors_at(model, *drawn).max(axis=0) <= 1.5 * certificate.worst_found + round_off(model, *drawn)
    ).all()


@examples(15)
@given(arms(max_joints=5), st.integers(0, 2**32 - 1))
def test_an_exact_model_has_no_error_but_the_identifications(arm: RobotArm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    model, box = model_with(arm, exact_torques(arm)), box_of(arm, rng)
    certificate = certify(model, box, effort=100)
    states = drawn_states(box, 300, rng)
    assert (certificate.worst_found == 0.0).all()
    assert (errors_at(model, *states).max(axis=0) <= certificate.certified + round_off(model, *states)).all()


@examples(20)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1))
def test_noise_of_any_size_is_in_it(arm: RobotArm, seed: int) -> None:
    """Waves off by all that the transform may be off by; 1e-5 here, far above round-off."""
    rng = np.random.default_rng(seed)
    known = harmonics_of(arm)
    cut = 1e-5

    def off(waves: TrigonometricPolynomial) -> TrigonometricPolynomial:
        there = waves.coefficients != 0.0
        return dataclasses.replace(
            waves, coefficients=waves.coefficients + cut * rng.choice([-1.0, 1.0], there.shape) * there
        )

    noisy = dataclasses.replace(
        known,
        inertia_by_link={key: off(parts) for key, parts in known.inertia_by_link.items()},
        potential_by_link=off(known.potential_by_link),
        cut=(cut, cut),
    )
    box = box_of(arm, rng)
    # Written with the cut of the true form, so that rewriting changes nothing.
    written = dataclasses.replace(noisy, cut=known.cut)
    model = model_with(arm, torques_of_energies(energy_terms(written), known.velocities))
    states = drawn_states(box, 1000, rng)
    found = errors_at(model, *states).max(axis=0)
    slack = harmonics_slack(noisy, box)
    assert (found <= slack + round_off(model, *states)).all()


def test_the_identifications_noise_is_small(puma: RobotArm) -> None:
    model = model_with(puma, exact_torques(puma))
    certified = certify(model).certified
    peak = np.abs(model.torque(*drawn_states(Box.of(puma), 2000, np.random.default_rng(0)))).max()
    assert (certified > 0.0).all()
    # Noise of 1e-11 kg m^2 in each of some hundred coefficients of D and in their slopes, times velocities
    # of up to 8 rad/s squared, beside a torque of some ten N m.
    assert (certified < 1e-7 * peak).all()


def test_a_known_largest_error_is_met() -> None:
    """Without gravity's C1 and C12 the two-link arm errs by c itself, most where both rods lie level."""
    arm = load_arm("two_link")
    kept = {t: w for t, w in exact_torques(arm).items() if t.quantity != "gravity_loading"}
    certificate = certify(model_with(arm, kept))
    (m1, m2), g = arm.mass, 9.8062
    largest = np.array([m1 * g / 2 + 1.5 * m2 * g, m2 * g / 2])
    assert (certificate.certified >= largest).all()
    # 500 nodes per angle lose h^2 / 2 < 1e-4 per angle at half a spacing h of 2 pi / 500.
    assert certificate.certified == pytest.approx(largest, rel=5e-4)
    # The search's last step is 2^-14 of the range, and its loss the square of that.
    assert certificate.worst_found == pytest.approx(largest, rel=1e-6)


def test_it_scales_with_the_error() -> None:
    arm = load_arm("two_link")
    exact = exact_torques(arm)
    term = next(t for t in exact if t.quantity == "coriolis_centrifugal")
    bounds = [
        certify(model_with(arm, {**exact, term: exact[term] + change})).certified for change in (0.01, 0.02)
    ]
    # The error is linear in the change; beside it stands the identification's noise, some 1e-9 N m.
    assert bounds[1] == pytest.approx(2 * bounds[0], rel=1e-6, abs=1e-8)


@pytest.fixture(scope="module")
def puma_model(puma: RobotArm) -> SimplifiedModel:
    return simplify(puma, states_in_box(puma, 500), Budget.parse("5%"), level="energy", drives=True)


def test_it_is_tight_for_the_puma(puma_model: SimplifiedModel) -> None:
    certificate = certify(puma_model)
    assert (certificate.certified >= puma_model.accuracy.errors.largest).all()
    assert (certificate.worst_found >= puma_model.accuracy.errors.largest).all()
    assert certificate.ratio.max() < 1.1


def test_more_effort_is_tighter(puma_model: SimplifiedModel) -> None:
    bounds = [certify(puma_model, effort=effort).certified for effort in (100, 3000, 100_000)]
    assert (bounds[0] > bounds[1]).all()
    assert (bounds[1] > bounds[2]).all()


def test_a_smaller_box_has_a_smaller_bound(puma: RobotArm, puma_model: SimplifiedModel) -> None:
    box = Box.of(puma)
    slower = dataclasses.replace(box, velocity=0.5 * box.velocity, acceleration=0.5 * box.acceleration)
    wide, narrow = (certify(puma_model, b, effort=20_000) for b in (box, slower))
    assert (narrow.certified < wide.certified).all()


def test_the_same_input_gives_the_same_certificate(puma_model: SimplifiedModel) -> None:
    def figures(certificate: Certificate) -> list[bytes]:
        arrays = (certificate.certified, certificate.worst_found, *certificate.worst_states)
        return [array.tobytes() for array in arrays]

    assert figures(certify(puma_model)) == figures(certify(puma_model))


def test_the_box_of_a_trajectory_bounds_all_between_its_extremes(
    puma_model: SimplifiedModel, pick_and_place: Trajectory
) -> None:
    states = (pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    box = Box.around(*states)
    certificate = certify(puma_model, box)
    assert (errors_at(puma_model, *states).max(axis=0) <= certificate.certified).all()
    drawn = drawn_states(box, 3000, np.random.default_rng(3))
    assert (errors_at(puma_model, *drawn).max(axis=0) <= certificate.certified).all()
    assert certificate.ratio.max() < 1.05


def test_what_is_within_the_allowed_error(puma_model: SimplifiedModel) -> None:
    certificate = certify(puma_model, effort=3000)
    assert certificate.within(certificate.certified).all()
    assert not certificate.within(0.999 * certificate.certified).any()


def test_harmonics_at_hand_are_used(puma: RobotArm, puma_model: SimplifiedModel) -> None:
    given_, made = (certify(puma_model, effort=500, harmonics=h) for h in (harmonics_of(puma), None))
    assert given_.certified.tobytes() == made.certified.tobytes()


def test_an_arm_of_many_joints_is_bounded_too() -> None:
    """Seven joints with axes in turn: too many for one grid, so groups and amplitudes share the work."""
    base = load_arm("puma560")
    arm = dataclasses.replace(
        base,
        joints=(*base.joints, dataclasses.replace(base.joints[4], name="extra")),
        links=(*base.links, dataclasses.replace(base.links[3], name="extra")),
        drives=(),
        dh_table=(),
    )
    exact = ExactDynamics.of(arm, states_in_box(arm, 300))
    model = simplify_exact(exact, Budget.parse("2%"), SearchOptions(ENERGY, dearer=True))
    certificate = certify(model, effort=30_000)
    states = drawn_states(certificate.box, 3000, np.random.default_rng(5))
    assert (errors_at(model, *states).max(axis=0) <= certificate.certified).all()
    erring = certificate.worst_found > 0.0
    assert erring.sum() >= 6
    assert certificate.ratio[erring].max() < 1.5


def test_limits_that_are_not_stated_are_stood_in_for() -> None:
    bare = two_link_of(1.0, 1.0, 1.0)
    with pytest.warns(GdAnalyzeWarning, match="does not state all limits"):
        found = certify(model_with(bare, exact_torques(bare)))
    assert "assumed" in found.box.where


def test_bad_arguments_are_refused(two_link: RobotArm, puma: RobotArm) -> None:
    model = model_with(two_link, {})
    with pytest.raises(UsageError, match="does not fit the arm"):
        certify(model, Box.of(puma))
    with pytest.raises(UsageError, match="effort"):
        certify(model, effort=0)
