"""Certificates over a box: no state exceeds them, they are tight, and they are of the program that runs."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import changed_programs as pruning
import gd_analyze as gd
from attacks import damaged, drawn_box, drawn_states, errors_at, model_with, round_off
from gd_analyze.certification.certificate import largest_torque
from gd_analyze.certification.error_field import harmonics_slack
from gd_analyze.errors import GdAnalyzeWarning, ModelError, UsageError
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.types import ExactForm
from made_models import exact_model
from parallel_axes import arm_of
from strategies import arms, examples, two_link_of


@pytest.mark.parametrize("effort", [1, 200, 20_000])
@examples(4)
@given(arm=arms(max_joints=4), seed=st.integers(0, 2**32 - 1))
def test_no_state_exceeds_it_and_the_worst_found_is_an_error_of_the_box(arm, seed, effort):
    rng = np.random.default_rng(seed)
    model, box = damaged(arm, rng), drawn_box(arm, rng)
    certificate = gd.certify(model, box, effort=effort)
    drawn = drawn_states(box, 1500, rng)
    found = errors_at(model, *drawn).max(axis=0)
    assert (found <= certificate.certified + round_off(model, *drawn)).all()
    assert (certificate.worst_found <= certificate.certified).all()
    assert (certificate.ratio >= 1.0).all()
    q, qd, qdd = certificate.worst_states
    assert ((box.lower <= q) & (q <= box.upper)).all()
    assert (np.abs(qd) <= box.velocity).all()
    assert (np.abs(qdd) <= box.acceleration).all()
    there = np.diag(errors_at(model, q, qd, qdd))
    assert certificate.worst_found == pytest.approx(there, rel=0, abs=round_off(model, q, qd, qdd))
    if effort > 1:
        assert (found <= 1.5 * certificate.worst_found + round_off(model, *drawn)).all()


@pytest.mark.parametrize("effort", [1, 300, 10_000])
@examples(3)
@given(arm=arms(max_joints=5), seed=st.integers(0, 2**32 - 1))
def test_no_state_exceeds_it_for_programs_with_something_left_out(arm, seed, effort):
    rng = np.random.default_rng(seed)
    model, box = pruning.pruned(arm, rng.choice([0.02, 0.2]), rng), drawn_box(arm, rng)
    certificate = gd.certify(model, box, effort=effort)
    for joint in range(arm.n_joints):
        state = pruning.searched(model, box, joint, rng)[:, None]
        found = pruning.errors_at(model, *state)[0, joint]
        assert found <= certificate.certified[joint] + pruning.round_off(model, *state)


@pytest.mark.slow
@pytest.mark.parametrize(("joints", "slides"), [(6, False), (7, True)])
def test_no_state_exceeds_it_for_many_joints(joints, slides):
    """Too many for one grid: few positions per angle prove a bound, if no close one."""
    rng = np.random.default_rng(joints)
    arm = arm_of(["slides" if slides and i == 2 else "askew" for i in range(joints)], rng)
    model = pruning.pruned(arm, 0.03, rng)
    middle = rng.uniform(-1.0, 1.0, joints)
    half = np.where(arm.is_revolute, rng.choice([0.1, 1.5, 2.9, 4.0], joints), 0.3)
    box = gd.types.Box(
        middle - half, middle + half, rng.uniform(0.5, 2.0, joints), rng.uniform(0.0, 5.0, joints)
    )
    certificate = gd.certify(model, box, effort=40)
    for joint in range(joints):
        state = pruning.searched(model, box, joint, rng)[:, None]
        found, slack = pruning.errors_at(model, *state)[0, joint], pruning.round_off(model, *state)
        assert found <= certificate.certified[joint] + slack
        assert found <= 1.2 * certificate.worst_found[joint] + slack


@examples(10)
@given(arms(max_joints=5), st.integers(0, 2**32 - 1))
def test_an_exact_model_has_no_error_but_that_of_the_exact_form(arm, seed):
    rng = np.random.default_rng(seed)
    model, box = exact_model(arm), drawn_box(arm, rng)
    certificate = gd.certify(model, box, effort=100)
    states = drawn_states(box, 300, rng)
    assert (certificate.worst_found == 0.0).all()
    assert (errors_at(model, *states).max(axis=0) <= certificate.certified + round_off(model, *states)).all()


@examples(12)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1))
def test_an_exact_form_that_is_off_by_its_cut_is_covered(arm, seed):
    """Harmonics off by 1e-5, far above round-off."""
    rng = np.random.default_rng(seed)
    known, cut = gd.tables.harmonics_of(arm), 1e-5

    def off(polynomial):
        kept = polynomial.coefficients != 0.0
        wrong = polynomial.coefficients + cut * rng.choice([-1.0, 1.0], kept.shape) * kept
        return dataclasses.replace(polynomial, coefficients=wrong)

    noisy = dataclasses.replace(
        known,
        inertia_by_link={key: off(parts) for key, parts in known.inertia_by_link.items()},
        potential_by_link=off(known.potential_by_link),
        cut=(cut, cut),
    )
    # Written with the cut of the true form, so that rewriting changes nothing.
    written = dataclasses.replace(noisy, cut=known.cut)
    model = model_with(arm, torques_of_energies(energy_terms(written), known.velocities))
    box = drawn_box(arm, rng)
    states = drawn_states(box, 1000, rng)
    found = errors_at(model, *states).max(axis=0)
    assert (found <= harmonics_slack(noisy, box) + round_off(model, *states)).all()


def test_the_error_of_the_exact_form_is_small(puma):
    certified = gd.certify(exact_model(puma), effort=3000).certified
    assert (certified > 0.0).all()
    # Noise of 1e-11 kg m^2 in some hundred coefficients of D and their slopes, times velocities of up to
    # 8 rad/s squared, beside a torque of some ten N m.
    assert (certified < 1e-7 * largest_torque(exact_model(puma)).max()).all()


def test_a_known_largest_error_is_met(two_link):
    """Without gravity the two-link arm errs by c itself, most where both rods lie level."""
    exact = TERM.terms(ExactForm(two_link))
    kept = {t: w for t, w in exact.items() if t.quantity != "gravity_loading"}
    certificate = gd.certify(model_with(two_link, kept))
    (m1, m2), g = two_link.mass, 9.8062
    largest = np.array([m1 * g / 2 + 1.5 * m2 * g, m2 * g / 2])
    assert (certificate.certified >= largest).all()
    # 500 nodes per angle lose h^2 / 2 < 1e-4 per angle at half a spacing h of 2 pi / 500.
    assert certificate.certified == pytest.approx(largest, rel=5e-4)
    assert certificate.worst_found == pytest.approx(largest, rel=1e-6)


@pytest.fixture(scope="module")
def puma_model(puma) -> gd.types.SimplifiedModel:
    return gd.simplify(puma, gd.tables.states_in_box(puma, 500), "5%", level="energy", drives=True)


@pytest.mark.slow
def test_it_is_tight_the_same_every_time_and_tighter_with_effort(puma, puma_model):
    certificate, again = (
        gd.certify(puma_model),
        gd.certify(puma_model, harmonics=gd.tables.harmonics_of(puma)),
    )
    assert (certificate.worst_found >= puma_model.accuracy.errors.largest).all()
    assert certificate.ratio.max() < 1.1
    np.testing.assert_array_equal(certificate.certified, again.certified)
    np.testing.assert_array_equal(certificate.worst_states, again.worst_states)
    rough, closer = (gd.certify(puma_model, effort=effort).certified for effort in (100, 3000))
    assert (rough > closer).all()
    assert (closer > certificate.certified).all()
    assert certificate.within(certificate.certified).all()
    assert not certificate.within(0.999 * certificate.certified).any()


def test_the_box_around_a_trajectory_bounds_all_between_its_extremes(puma_model, pick_and_place):
    states = (pick_and_place.q, pick_and_place.qd, pick_and_place.qdd)
    box = gd.types.Box.around(*states)
    certificate = gd.certify(puma_model, box, effort=20_000)
    slower = dataclasses.replace(box, velocity=0.5 * box.velocity, acceleration=0.5 * box.acceleration)
    for attacked in (states, drawn_states(box, 3000, np.random.default_rng(3))):
        assert (errors_at(puma_model, *attacked).max(axis=0) <= certificate.certified).all()
    assert certificate.ratio.max() < 1.05
    assert (gd.certify(puma_model, slower, effort=20_000).certified < certificate.certified).all()


def with_added(model: gd.types.SimplifiedModel, added) -> gd.types.SimplifiedModel:
    """A model whose program adds something to the first torque that its terms do not mention."""
    trace = Trace()
    of = model.program.folded(trace, {})
    q1, q2, velocity = (trace.record("input", name) for name in ("q1", "q2", "qd2"))
    first, *others = (of(output) for output in model.program.outputs)
    program = Program.of(trace, [first + added(q1, q2, velocity), *others])
    other = dataclasses.replace(model)
    vars(other)["program"] = program
    return other


def test_it_is_of_the_program_whatever_terms_and_file_state(two_link):
    model, box = exact_model(two_link), gd.types.Box.of(two_link)
    exact = gd.certify(model, box)
    errors = ErrorTable(np.full(2, 1e9), np.zeros(2), np.zeros(2))
    accuracy = dataclasses.replace(model.accuracy, errors=errors, allowed=np.full(2, 1e7))
    for size in (0.5, 1.0):
        wrong = with_added(model, lambda q1, q2, qd2, size=size: size * np.cos(q1 - q2) * qd2 * qd2)
        lying = wrong.stating(accuracy)
        off = gd.certify(lying, box)
        # The arm's ranges reach q1 = q2.
        most = size * float(box.velocity[1]) ** 2
        assert exact.certified[0] < 1e-9
        assert off.worst_found[0] == pytest.approx(most, rel=1e-3)
        assert most <= off.certified[0] < 1.1 * most
        assert off.certified[1] == exact.certified[1]
        assert largest_torque(lying).tolist() == largest_torque(model).tolist()


def test_a_program_that_computes_no_torque_has_no_certificate(two_link):
    bad = with_added(exact_model(two_link), lambda q1, q2, velocity: q1)
    for prove in (gd.certify, gd.certify_positive_definite):
        with pytest.raises(ModelError) as caught:
            prove(bad)
        assert caught.value.details["where"] == "program"


@pytest.mark.parametrize(("name", "drives"), [("two_link", False), ("puma560", True), ("stanford", False)])
def test_the_largest_torque_beats_drawing_and_is_reached(name, drives):
    arm = gd.load_arm(name)
    found = largest_torque(exact_model(arm, drives))
    drawn = gd.types.ExactDynamics(ExactForm(arm, drives), gd.tables.states_in_box(arm, 20_000)).peak_torque
    assert (found >= drawn).all()
    assert (found <= 3.0 * drawn).all()


def test_without_motion_and_gravity_there_is_no_torque(two_link):
    weightless = dataclasses.replace(two_link, gravity_vector=np.zeros(3))
    still = gd.types.Box(np.zeros(2), np.ones(2), np.zeros(2), np.zeros(2))
    assert largest_torque(exact_model(weightless, level=ENERGY), still).tolist() == [0.0, 0.0]


def test_limits_that_are_not_stated_are_assumed():
    with pytest.warns(GdAnalyzeWarning, match="does not state all limits"):
        found = gd.certify(exact_model(two_link_of(1.0, 1.0, 1.0)), effort=100)
    assert "assumed" in found.where
    assert (found.box.upper == np.pi).all()


def test_bad_arguments_are_refused(two_link, puma, swing):
    model = exact_model(puma)
    for wrong in (gd.types.Box.of(two_link), gd.types.Tube.along(two_link, swing)):
        with pytest.raises(UsageError) as caught:
            gd.certify(model, wrong)
        assert (caught.value.details["where"], caught.value.details["found"]) == ("box", "2")
    with pytest.raises(UsageError, match="effort"):
        gd.certify(model, effort=0)
    with pytest.raises(UsageError, match="region"):
        gd.certify(model, 7)


def test_boxes(puma, rng):
    box = gd.types.Box.of(puma)
    np.testing.assert_array_equal(box.acceleration, [joint.acceleration_limit for joint in puma.joints])
    states = q, qd, qdd = rng.normal(size=(3, 30, 4))
    around = gd.types.Box.around(*states)
    found = [around.lower, around.upper, around.velocity, around.acceleration]
    largest = [np.abs(qd).max(axis=0), np.abs(qdd).max(axis=0)]
    np.testing.assert_array_equal(found, [q.min(axis=0), q.max(axis=0), *largest])
    with pytest.raises(ValueError, match="read-only"):
        box.upper[0] = 7.0


@pytest.mark.parametrize(
    ("place", "value", "where"),
    [
        (0, [2.0, 0.0], "upper, joint 1"),
        (2, [1.0, -0.5], "velocity, joint 2"),
        (1, [1.0, np.inf], "upper, joint 2"),
        (2, [1.0, 2.0, 3.0], "velocity"),
        (1, [[1.0, 0.0]], "upper"),
        (0, [], "lower"),
    ],
)
def test_wrong_boxes_are_refused(place, value, where):
    limits = [np.array(limit) for limit in ([-1.0, 0.0], [1.0, 0.0], [1.0, 2.0], [3.0, 0.0])]
    gd.types.Box(*limits)
    limits[place] = np.array(value)
    with pytest.raises(UsageError) as caught:
        gd.types.Box(*limits)
    assert caught.value.details["where"] == where


@pytest.mark.parametrize("shapes", [((0, 2),) * 3, ((3, 2), (3, 2), (2, 2)), ((3,),) * 3])
def test_a_box_around_wrong_states_is_refused(shapes):
    with pytest.raises(UsageError) as caught:
        gd.types.Box.around(*(np.zeros(shape) for shape in shapes))
    assert caught.value.details["where"] == "q, qd, qdd"
