"""The smallest eigenvalue of a model's D: no position falls below the bound, and known cases are met."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.box import Box
from gd_analyze.certification.positive_definite import certify_positive_definite
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.harmonics.terms import Energies
from gd_analyze.motions.states import states_in_box
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.simplify import simplify
from gd_analyze.simplification.term import TERM
from made_models import exact_model, model_of
from strategies import arms, examples


def energy_model(arm: RobotArm, energy: Energies) -> SimplifiedModel:
    return model_of(ExactForm(arm), ENERGY, energy)


def positions_of(low: np.ndarray, high: np.ndarray) -> Box:
    nothing = np.zeros(len(low))
    return Box(low, high, nothing, nothing)


def eigenvalues(model: SimplifiedModel, q: np.ndarray) -> np.ndarray:
    return np.linalg.eigvalsh(model.inertia(q))


@examples(40)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1), st.sampled_from([1, 100, 3000]), st.booleans())
def test_no_position_falls_below_it(arm: RobotArm, seed: int, effort: int, whole: bool) -> None:
    rng = np.random.default_rng(seed)
    energy = ExactForm(arm).energies
    # Dropped terms make D indefinite here and there.
    model = energy_model(arm, energy if whole else {t: c for t, c in energy.items() if rng.random() < 0.8})
    middle, half = rng.uniform(-1.0, 1.0, arm.n_joints), rng.choice([0.0, 0.3, 1.5, 4.0], arm.n_joints)
    box = positions_of(middle - half, middle + half)
    shown = certify_positive_definite(model, box, effort=effort)
    values = eigenvalues(model, rng.uniform(box.lower, box.upper, (2000, arm.n_joints)))
    # Eigenvalues are off by some n eps of the largest.
    slack = 1e-13 * max(1.0, float(np.abs(values).max()))
    assert shown.proven <= values.min() + slack
    assert shown.proven <= shown.smallest_found + slack
    assert ((box.lower <= shown.position) & (shown.position <= box.upper)).all()
    assert eigenvalues(model, shown.position)[0] == pytest.approx(shown.smallest_found, rel=0, abs=slack)


def test_the_two_rods_have_the_eigenvalue_of_their_stretched_pose() -> None:
    """D of two equal rods has its smallest eigenvalue where the arm is stretched, or close by."""
    arm = load_arm("two_link")
    model = exact_model(arm)
    shown = certify_positive_definite(model)
    q = np.zeros((20_001, 2))
    q[:, 1] = np.linspace(arm.joints[1].lower, arm.joints[1].upper, 20_001)
    smallest = eigenvalues(model, q)[:, 0].min()
    assert shown.is_proven
    # The search's last step is 2^-14 of the range.
    assert shown.smallest_found == pytest.approx(smallest, rel=1e-6)
    assert 0.98 * smallest < shown.proven <= smallest


@pytest.mark.parametrize("drives", [False, True])
def test_the_exact_puma_is_positive_definite(puma: RobotArm, drives: bool) -> None:
    shown = certify_positive_definite(exact_model(puma, drives))
    assert shown.is_proven
    assert shown.proven <= shown.smallest_found


def test_the_simplified_puma_is_positive_definite(puma: RobotArm) -> None:
    model = simplify(puma, states_in_box(puma, 500), Budget.parse("1%"), level="energy", drives=True)
    shown = certify_positive_definite(model)
    assert shown.is_proven
    assert shown.proven == pytest.approx(shown.smallest_found, rel=0.01)
    again = certify_positive_definite(model)
    assert (again.proven, again.smallest_found) == (shown.proven, shown.smallest_found)


def test_an_indefinite_model_is_not_shown_to_be_definite(two_link: RobotArm) -> None:
    """Without the constant part of D11 its quadratic form takes both signs."""
    energy = ExactForm(two_link).energies
    model = energy_model(two_link, {t: c for t, c in energy.items() if (t.i, t.j) != (0, 0) or t.monomial})
    shown = certify_positive_definite(model)
    assert shown.smallest_found < 0.0
    assert shown.proven <= shown.smallest_found
    assert not shown.is_proven


def test_a_model_without_inertia_is_not(two_link: RobotArm) -> None:
    shown = certify_positive_definite(energy_model(two_link, {}))
    assert not shown.is_proven
    assert shown.smallest_found == 0.0


def test_bad_arguments_are_refused(two_link: RobotArm, puma: RobotArm) -> None:
    with pytest.raises(ModelError, match="symmetric D"):
        certify_positive_definite(model_of(ExactForm(two_link), TERM, {}))
    with pytest.raises(UsageError, match="does not fit the arm"):
        certify_positive_definite(exact_model(two_link), Box.of(puma))
    with pytest.raises(UsageError, match="effort"):
        certify_positive_definite(exact_model(two_link), effort=0)


@pytest.mark.parametrize("joint", range(6))
def test_a_joint_without_inertia_makes_d_singular(puma: RobotArm, joint: int) -> None:
    """The eigenvalue is zero, and the bound no worse than the grid makes of the largest elements of D."""
    kept = {t: c for t, c in ExactForm(puma).energies.items() if joint not in (t.i, t.j)}
    shown = certify_positive_definite(energy_model(puma, kept))
    assert shown.is_singular
    assert not shown.is_proven
    assert abs(shown.smallest_found) < 1e-12
    largest = max(abs(c) for t, c in kept.items() if not t.is_potential)
    assert -largest < shown.proven <= 0.0


def test_an_eigenvalue_far_from_zero_is_not_singular(two_link: RobotArm) -> None:
    energy = ExactForm(two_link).energies
    negative = energy_model(two_link, {t: c for t, c in energy.items() if (t.i, t.j) != (0, 0) or t.monomial})
    assert not certify_positive_definite(negative).is_singular
    assert not certify_positive_definite(exact_model(two_link)).is_singular
