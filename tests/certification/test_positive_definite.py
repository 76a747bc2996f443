"""The smallest eigenvalue of a model's D: no position falls below the bound, and known cases are met."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from attacks import drawn_box
from gd_analyze.certification import positive_definite as module
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.types import ExactForm
from long_cases import long
from made_models import exact_model, model_of
from recordings import swinging
from strategies import arms, examples, motions


def eigenvalues(model, q):
    return np.linalg.eigvalsh(model.inertia(q))


def damaged(arm, level, rng):
    """A model that lacks some terms, which makes D indefinite here and there."""
    form = ExactForm(arm)
    return model_of(form, level, {t: c for t, c in level.terms(form).items() if rng.random() < 0.8})


@pytest.mark.parametrize("effort", [1, 100, 3000])
@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
@pytest.mark.parametrize("whole", [True, False])
@examples(2)
@given(arm=arms(max_joints=4), seed=st.integers(0, 2**32 - 1))
def test_no_position_falls_below_it(arm, seed, effort, level, whole):
    rng = np.random.default_rng(seed)
    model = exact_model(arm, level=level) if whole else damaged(arm, level, rng)
    box = drawn_box(arm, rng)
    shown = gd.certify_positive_definite(model, box, effort=effort)
    values = eigenvalues(model, rng.uniform(box.lower, box.upper, (2000, arm.n_joints)))
    # Eigenvalues are off by some n eps of the largest.
    slack = 1e-13 * max(1.0, float(np.abs(values).max()))
    assert shown.proven <= min(values.min(), shown.smallest_found) + slack
    assert ((box.lower <= shown.position) & (shown.position <= box.upper)).all()
    assert eigenvalues(model, shown.position)[0] == pytest.approx(shown.smallest_found, rel=0, abs=slack)


def in_pieces(tube, rng, count=2000):
    """Positions of a tube."""
    lower, upper, _ = tube.pieces(count, rng)
    return rng.uniform(lower[0], upper[0])


@pytest.mark.slow
@pytest.mark.parametrize("effort", [1, 8000])
@pytest.mark.parametrize("most", [1, 3, 200])
@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
@examples(2)
@given(case=motions(count=5), seed=st.integers(0, 2**32 - 1))
def test_no_position_of_a_tube_falls_below_it(case, seed, effort, most, level):
    arm, motion = case
    rng, tube = np.random.default_rng(seed), gd.types.Tube.along(arm, motion, most=most)
    model = damaged(arm, level, rng) if seed % 2 else exact_model(arm, level=level)
    shown = gd.certify_positive_definite(model, tube, effort=effort)
    values = eigenvalues(model, in_pieces(tube, rng))
    # Eigenvalues are off by some n eps of the largest.
    slack = 1e-13 * max(1.0, float(np.abs(values).max()))
    assert shown.proven <= min(values.min(), shown.smallest_found) + slack
    inside = (tube.lower[:, 0] <= shown.position) & (shown.position <= tube.upper[:, 0])
    assert inside.all(axis=1).any()
    assert eigenvalues(model, shown.position)[0] == pytest.approx(shown.smallest_found, rel=0, abs=slack)


@pytest.mark.parametrize("motion", ["pick-and-place", long("large-slew"), long("wrist-move")])
def test_along_a_motion_it_is_below_pinocchios_and_close(puma, motion):
    tube = gd.types.Tube.along(puma, gd.read_trajectory(motion, puma))
    shown = gd.certify_positive_definite(exact_model(puma, True, TERM), tube)
    q = in_pieces(tube, np.random.default_rng(0), 5000)
    values = np.linalg.eigvalsh(pinocchio_dynamics(puma, q, q, q)["inertia"] + np.diag(puma.drive_inertia))
    # No draw comes near the end of every piece, where D is smallest; the proof is within 0.1 % of that.
    assert shown.proven <= values.min() <= 1.001 * shown.smallest_found
    assert shown.proven > 0.999 * shown.smallest_found


def test_a_long_motion_takes_few_boxes(two_link, monkeypatch):
    tube = gd.types.Tube.along(two_link, swinging(two_link, 20_000))
    assert len(tube) > 1000
    count, of = [], module._GriddedInertia.of
    monkeypatch.setattr(module._GriddedInertia, "of", lambda *given: count.append(1) or of(*given))
    model = exact_model(two_link, level=TERM)
    shown = gd.certify_positive_definite(model, tube)
    assert len(count) <= 32
    assert 0.98 * shown.smallest_found < shown.proven <= eigenvalues(model, tube.lower[:, 0]).min()


def test_positions_between_two_stretches_of_a_motion_do_not_count(two_link):
    """With three times D12 the rods' D is indefinite where they are nearly parallel, as halfway between."""
    form = ExactForm(two_link)
    terms = {t: c * (3.0 if (t.i, t.j) == (0, 1) else 1.0) for t, c in form.energies.items()}
    model = model_of(form, ENERGY, terms)
    q, still = np.outer(np.radians([80.0, 100.0, 260.0, 280.0]), [0.0, 1.0]), np.zeros((4, 2))
    motion = gd.Trajectory(np.arange(4.0), q, still, still, gaps=(2,))
    assert gd.certify_positive_definite(model, gd.types.Tube.along(two_link, motion)).is_proven
    whole = gd.certify_positive_definite(model, gd.types.Tube.along(two_link, replace(motion, gaps=())))
    assert not whole.is_proven
    assert whole.smallest_found < 0.0


def test_the_two_rods_have_the_eigenvalue_of_their_stretched_pose(two_link):
    model = exact_model(two_link)
    shown = gd.certify_positive_definite(model)
    q = np.zeros((20_001, 2))
    q[:, 1] = np.linspace(two_link.joints[1].lower, two_link.joints[1].upper, 20_001)
    smallest = eigenvalues(model, q)[:, 0].min()
    assert shown.is_proven
    assert not shown.is_singular
    assert shown.smallest_found == pytest.approx(smallest, rel=1e-6)
    assert 0.98 * smallest < shown.proven <= smallest


@pytest.mark.slow
def test_the_puma_is_positive_definite(puma):
    for drives in (False, True):
        exact = gd.certify_positive_definite(exact_model(puma, drives))
        assert 0.0 < exact.proven <= exact.smallest_found
    model = gd.simplify(puma, gd.tables.states_in_box(puma, 500), "1%", level="energy", drives=True)
    shown, again = gd.certify_positive_definite(model), gd.certify_positive_definite(model)
    assert shown.is_proven
    assert shown.proven == pytest.approx(shown.smallest_found, rel=0.01)
    assert (again.proven, again.smallest_found) == (shown.proven, shown.smallest_found)


def test_an_indefinite_model_is_not_proven_definite(two_link):
    """Without the constant part of D11 its quadratic form takes both signs."""
    energy = ExactForm(two_link).energies
    kept = {t: c for t, c in energy.items() if (t.i, t.j) != (0, 0) or t.monomial}
    shown = gd.certify_positive_definite(model_of(ExactForm(two_link), ENERGY, kept))
    assert shown.proven <= shown.smallest_found < 0.0
    assert not shown.is_proven
    assert not shown.is_singular
    nothing = gd.certify_positive_definite(model_of(ExactForm(two_link), ENERGY, {}))
    assert (nothing.is_proven, nothing.smallest_found) == (False, 0.0)


@pytest.mark.parametrize("joint", [0, 5])
def test_a_joint_without_inertia_makes_d_singular(puma, joint):
    kept = {t: c for t, c in ExactForm(puma).energies.items() if joint not in (t.i, t.j)}
    shown = gd.certify_positive_definite(model_of(ExactForm(puma), ENERGY, kept))
    assert shown.is_singular
    assert not shown.is_proven
    assert abs(shown.smallest_found) < 1e-12
    largest = max(abs(c) for t, c in kept.items() if not t.is_potential)
    assert -largest < shown.proven <= 0.0


def test_bad_arguments_are_refused(two_link, puma, pick_and_place):
    with pytest.raises(ModelError, match="symmetric D"):
        gd.certify_positive_definite(exact_model(two_link, level=ELEMENT))
    others = gd.types.Box.of(puma), gd.types.Tube.along(puma, pick_and_place)
    for where, wrong in (*(("box", {"region": other}) for other in others), ("effort", {"effort": 0})):
        with pytest.raises(UsageError) as caught:
            gd.certify_positive_definite(exact_model(two_link), **wrong)
        assert caught.value.details["where"] == where
