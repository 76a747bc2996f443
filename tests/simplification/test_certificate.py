"""The certificate: no state exceeds it, it is tight where the truth is known, it scales as the error does."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import UsageError
from gd_analyze.harmonics import identify
from gd_analyze.harmonics.lagrangian import TorqueTerm, energy_terms
from gd_analyze.models.harmonic import HarmonicModel, torques_of_energy
from gd_analyze.models.simplified import ErrorTable
from gd_analyze.operations import OperationCount
from gd_analyze.robots import RobotArm, load_arm
from gd_analyze.simplification import Box, Budget, certify, simplify_harmonics, states_in_box
from strategies import arms, examples, two_link_of


def model_with(arm: RobotArm, torques: dict[TorqueTerm, float]) -> HarmonicModel:
    """A model that keeps just these torque terms; what it promises does not matter here."""
    nothing = np.zeros(arm.n_joints)
    table = ErrorTable(nothing, nothing, nothing)
    return HarmonicModel(
        arm, "term", (), torques, False, False, nothing, "0%", table, {}, OperationCount(0, 0, 0)
    )


def exact_torques(arm: RobotArm) -> dict[TorqueTerm, float]:
    return torques_of_energy(arm, energy_terms(identify(arm)))


def box_of(arm: RobotArm, rng: np.random.Generator) -> Box:
    n = arm.n_joints
    middle = rng.uniform(-1.0, 1.0, n)
    return Box(
        middle - rng.uniform(0.1, 2.0, n),
        middle + rng.uniform(0.1, 2.0, n),
        rng.uniform(0.1, 2.0, n),
        rng.uniform(0.1, 5.0, n),
    )


def errors_at(model: HarmonicModel, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    exact = decompose_states(model.arm, q, qd, qdd, coupling=False, drives=model.drives)["torque"]
    return np.abs(model.torque(q, qd, qdd) - exact)


@examples(25)
@given(arms(max_joints=4), st.integers(0, 2**32 - 1))
def test_no_state_exceeds_it(arm: RobotArm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = arm.n_joints
    torques = {term: w for term, w in exact_torques(arm).items() if rng.random() < 0.7}
    model, box = model_with(arm, torques), box_of(arm, rng)
    certificate = certify(model, box, seconds=0.02)
    count = 400
    corners = rng.random((2, count, n)) < 0.5
    q = rng.uniform(box.lower, box.upper, (count, n))
    qd = np.where(corners[0], box.rate, -box.rate) * rng.choice([1.0, rng.random()], (count, 1))
    qdd = np.where(corners[1], box.acceleration, -box.acceleration)
    found = errors_at(model, q, qd, qdd).max(axis=0)
    # The two torques compared here have a round-off of their own, some hundred eps of the largest torque.
    scale = np.abs(model.torque(q, qd, qdd)).max() + found.max()
    assert (found <= certificate.certified + 1e-12 * scale).all()
    assert (certificate.worst_found <= certificate.certified).all()


def test_an_exact_model_has_no_error() -> None:
    arm = load_arm("puma560")
    certificate = certify(model_with(arm, exact_torques(arm)))
    assert (certificate.certified == 0.0).all()
    assert (certificate.ratio == 1.0).all()


def test_a_known_largest_error_is_met() -> None:
    """Without gravity's C1 and C12 the two-link arm errs by c itself, most where both rods lie level."""
    arm = load_arm("two_link")
    kept = {t: w for t, w in exact_torques(arm).items() if t.quantity != "gravity_loading"}
    certificate = certify(model_with(arm, kept), seconds=2.0)
    (m1, m2), g = arm.mass, 9.8062
    largest = np.array([m1 * g / 2 + 1.5 * m2 * g, m2 * g / 2])
    assert (certificate.certified >= largest).all()
    assert certificate.certified == pytest.approx(largest, rel=0.025)  # halving stops at 2 %
    assert certificate.worst_found == pytest.approx(largest, rel=1e-3)


def test_it_scales_with_the_error() -> None:
    arm = load_arm("two_link")
    exact = exact_torques(arm)
    term = next(t for t in exact if t.quantity == "coriolis_centrifugal")
    bounds = [
        certify(model_with(arm, {**exact, term: exact[term] + change}), seconds=0.3).certified
        for change in (0.01, 0.02)
    ]
    # Beside round-off (1e-12 of the bound) and where the halving stopped (2 %) the error is linear.
    assert bounds[1] == pytest.approx(2 * bounds[0], rel=0.02)


def test_a_smaller_box_has_a_smaller_bound() -> None:
    arm = load_arm("puma560")
    model = simplify_harmonics(arm, states_in_box(arm, 500), Budget.parse("5%"), level="energy", drives=True)
    box = Box.of(arm)
    slower = dataclasses.replace(box, rate=0.5 * box.rate, acceleration=0.5 * box.acceleration)
    wide, narrow = (certify(model, b, seconds=0.2) for b in (box, slower))
    assert (narrow.certified < wide.certified).all()
    assert (wide.certified >= model.promise.largest).all()


def test_an_arm_without_limits_needs_a_box() -> None:
    bare = two_link_of(1.0, 1.0, 1.0)
    with pytest.raises(UsageError, match="does not state all its limits"):
        certify(model_with(bare, exact_torques(bare)))
