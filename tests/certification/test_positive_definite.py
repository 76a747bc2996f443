"""The smallest eigenvalue of a model's D: no position falls below the bound, and known cases are met."""

from __future__ import annotations

import numpy as np
import pytest
from attacks import drawn_box
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.harmonic import ENERGY, TERM
from made_models import exact_model, model_of
from strategies import arms, examples


def eigenvalues(model, q):
    return np.linalg.eigvalsh(model.inertia(q))


@examples(20)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1), st.sampled_from([1, 100, 3000]), st.booleans())
def test_no_position_falls_below_it(arm, seed, effort, whole):
    rng = np.random.default_rng(seed)
    energy = ExactForm(arm).energies
    # Dropped terms make D indefinite here and there.
    kept = energy if whole else {t: c for t, c in energy.items() if rng.random() < 0.8}
    model = model_of(ExactForm(arm), ENERGY, kept)
    box = drawn_box(arm, rng)
    shown = gd.certify_positive_definite(model, box, effort=effort)
    values = eigenvalues(model, rng.uniform(box.lower, box.upper, (2000, arm.n_joints)))
    # Eigenvalues are off by some n eps of the largest.
    slack = 1e-13 * max(1.0, float(np.abs(values).max()))
    assert shown.proven <= min(values.min(), shown.smallest_found) + slack
    assert ((box.lower <= shown.position) & (shown.position <= box.upper)).all()
    assert eigenvalues(model, shown.position)[0] == pytest.approx(shown.smallest_found, rel=0, abs=slack)


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


def test_the_puma_is_positive_definite(puma):
    for drives in (False, True):
        exact = gd.certify_positive_definite(exact_model(puma, drives))
        assert 0.0 < exact.proven <= exact.smallest_found
    model = gd.simplify(puma, gd.states_in_box(puma, 500), "1%", level="energy", drives=True, effort=0.1)
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


def test_bad_arguments_are_refused(two_link, puma):
    with pytest.raises(ModelError, match="symmetric D"):
        gd.certify_positive_definite(model_of(ExactForm(two_link), TERM, {}))
    for wrong in ({"box": gd.Box.of(puma)}, {"effort": 0}):
        with pytest.raises(UsageError) as caught:
            gd.certify_positive_definite(exact_model(two_link), **wrong)
        assert caught.value.details["where"] in wrong
