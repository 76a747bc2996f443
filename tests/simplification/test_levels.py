"""What every level says of itself, and the one whose models are changed programs and no sums of terms."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gd_analyze.certification.certificate import certify
from gd_analyze.certification.positive_definite import certify_positive_definite
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.operations.program import derivative
from gd_analyze.operations.trace import Expression
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.evaluation import evaluate, payload_effect
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.level import CandidateLevel
from gd_analyze.simplification.levels import LEVELS, level_named
from gd_analyze.simplification.model import SimplifiedModel, exactly
from gd_analyze.simplification.recursion import Change
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.term import TERM
from made_models import ROUND_OFF


def test_a_level_is_known_by_its_name_or_as_itself():
    assert list(LEVELS) == ["element", "term", "recursive", "energy"]
    for name, level in LEVELS.items():
        assert str(level) == level.name == name
        assert level_named(name) is level_named(level) is level
    with pytest.raises(UsageError, match="no such level") as caught:
        level_named("atom")
    assert caught.value.details["expected"] == "element, term, recursive, energy"


def test_what_each_level_is():
    assert {level for level in LEVELS.values() if level.is_mechanical} == {ENERGY}
    assert {level for level in LEVELS.values() if level.has_torque_terms} == {TERM, ENERGY}
    candidates = {level for level in LEVELS.values() if isinstance(level, CandidateLevel)}
    assert candidates == {ELEMENT, TERM, ENERGY}
    assert {level for level in candidates if level.is_priced_exactly} == {ELEMENT}
    assert {level for level in LEVELS.values() if level.always_refits} == {RECURSIVE}


@pytest.mark.parametrize("level", [ELEMENT, TERM, ENERGY], ids=str)
def test_terms_come_back_from_their_entries(level, puma):
    form = ExactForm(puma)
    terms = level.terms(form)
    assert len(terms) > 50
    again = level.from_entries(form, json.loads(json.dumps(level.to_entries(terms))))
    assert list(again.items()) == list(terms.items())


def test_parts_have_no_harmonic_terms(two_link):
    with pytest.raises(ModelError, match="level element has no harmonic terms") as caught:
        ELEMENT.torques(ExactForm(two_link), ELEMENT.terms(ExactForm(two_link)))
    assert "gd-analyze simplify" in caught.value.details["next"]


def pruned_model(exact: ExactDynamics, forgotten: Sequence[int]) -> SimplifiedModel:
    """Let some sums of the recursion be one of their summands alone."""
    recursion = exact.form.recursion
    sums = [k for k, step in enumerate(recursion.steps) if step.operation in ("add", "subtract")]
    changes = {}
    for k in (sums[which] for which in forgotten):
        summand = next(x for x in recursion.steps[k].arguments if isinstance(x, Expression))
        changes[Change(k, recursion.steps.index(summand))] = 1.0
    model = SimplifiedModel(
        level=RECURSIVE,
        form=exact.form,
        terms=changes,
        program=RECURSIVE.write(exact.form, changes, ROUGH),
        operations_full=exact.form.operations,
        accuracy=exactly(exact, RECURSIVE, np.zeros(exact.arm.n_joints), "1%").accuracy,
    )
    errors = exact.errors_of(model.torque(*exact.states.arrays))
    return replace(model, accuracy=replace(model.accuracy, allowed=errors.largest, errors=errors))


@pytest.fixture(scope="module")
def exact(two_link) -> ExactDynamics:
    return ExactDynamics.of(two_link, states_in_box(two_link, 60))


@pytest.fixture(scope="module")
def model(exact) -> SimplifiedModel:
    return pruned_model(exact, (4,))


def test_a_pruned_program_is_a_model(model, exact):
    assert len(model.terms) == 1
    assert model.operations.total > 0
    found = evaluate(model, exact.states)
    assert found.errors.largest.max() > 0.0
    np.testing.assert_array_equal(found.errors.largest, model.accuracy.errors.largest)
    assert found.within(model.accuracy.allowed).all()
    effect = payload_effect(model, exact.states)
    assert effect.torque_per_kg.min() > 0.0


def test_it_has_d_h_and_c(model, two_link):
    states = states_in_box(two_link, 40, 3)
    inertia = model.inertia(states.q)
    h, c = model.coriolis_centrifugal(states.q, states.qd), model.gravity_loading(states.q)
    assert inertia.shape == (40, 2, 2)
    torque = model.torque(*states.arrays)
    together = np.einsum("tij,tj->ti", inertia, states.qdd) + h + c
    assert np.abs(together - torque).max() <= ROUND_OFF * np.abs(torque).max()


def test_unpruned_it_is_exact(exact, two_link):
    whole = pruned_model(exact, ())
    assert not whole.accuracy.errors.largest.any()
    states = states_in_box(two_link, 40, 3)
    numeric = decompose_states(two_link, states, christoffel=False)
    pairs = (
        (whole.inertia(states.q), numeric["inertia"].sum(axis=1)),
        (whole.coriolis_centrifugal(states.q, states.qd), numeric["coriolis_centrifugal"].sum(axis=1)),
        (whole.gravity_loading(states.q), numeric["gravity_loading"]),
    )
    for found, wanted in pairs:
        assert np.abs(found - wanted).max() <= ROUND_OFF * np.abs(numeric["torque"]).max()


def test_what_is_certified_is_its_program(model):
    certificate = certify(model, effort=1000)
    exact = ExactDynamics.of(model.arm, states_in_box(model.arm, 500))
    errors = exact.errors_of(model.torque(*exact.states.arrays)).largest
    assert (certificate.worst_found <= certificate.certified).all()
    assert (errors <= certificate.certified).all()
    with pytest.raises(ModelError, match="symmetric D"):
        certify_positive_definite(model)


def test_a_derivative_of_it_is_a_program_as_any(model):
    still = {f"{name}{i}": 0.0 for name in ("qd", "qdd") for i in (1, 2)}
    columns = [derivative(model.program, {f"qdd{j}": 1.0}, still) for j in (1, 2)]
    states = States(*(np.zeros((1, 2)) for _ in range(3)))
    inputs = {f"q{i + 1}": states.q[:, i] for i in range(2)}
    found = np.stack([column.run(inputs)[:, 0] for column in columns], axis=1)
    np.testing.assert_array_equal(found, model.inertia(states.q)[0])
