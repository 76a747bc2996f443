"""What every level says of itself, and a level whose models are pruned programs and no lists of terms."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from gd_analyze.certification import certify, certify_positive_definite
from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.formulas.formula import Formula
from gd_analyze.levels import (
    ELEMENT,
    ENERGY,
    LEVELS,
    TERM,
    Budget,
    ErrorTable,
    ExactDynamics,
    ExactForm,
    Level,
    Promise,
    SimplifiedModel,
    evaluate,
    level_named,
    payload_effect,
)
from gd_analyze.levels.effort import ROUGH, Effort
from gd_analyze.levels.level import Checked, Costs, Terms
from gd_analyze.operations import Expression, Program
from gd_analyze.operations.derivative import derivative
from gd_analyze.search import How, simplify_exact
from gd_analyze.states import States, states_in_box
from gd_analyze.vectors import FloatArray
from made_models import ROUND_OFF


def test_a_level_is_known_by_its_name_or_as_itself():
    assert list(LEVELS) == ["element", "term", "energy"]
    for name, level in LEVELS.items():
        assert str(level) == level.name == name
        assert level_named(name) is level_named(level) is level
    with pytest.raises(UsageError, match="no such level") as caught:
        level_named("atom")
    assert caught.value.details["expected"] == "element, term, energy"


def test_what_each_level_is():
    assert {level for level in LEVELS.values() if level.is_mechanical} == {ENERGY}
    assert {level for level in LEVELS.values() if level.has_torque_terms} == {TERM, ENERGY}
    assert {level for level in LEVELS.values() if level.is_priced_exactly} == {ELEMENT}


@pytest.mark.parametrize("level", LEVELS.values(), ids=str)
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


class PrunedLevel(Level):
    """The exact program with some additions left out: one of the two summands goes."""

    name = "pruned"
    keeps = "steps"
    entries = TypeAdapter(list[Checked])

    def __init__(self, forgotten: Sequence[int]) -> None:
        self.forgotten = forgotten

    def terms(self, form: ExactForm) -> Terms:
        return {}

    def effects(self, exact: ExactDynamics, terms: Terms) -> FloatArray:
        return np.zeros((0, exact.arm.n_joints, len(exact.states)))

    def costs(self, form: ExactForm, terms: Sequence[Any]) -> Costs:
        return {}

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        whole = TERM.write(form, form.torques, effort)
        sums = [step for step in whole.steps if step.operation in ("add", "subtract")]
        return pruned(whole, {sums[k].order for k in self.forgotten})

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        return ()

    def to_entry(self, term: Any, weight: float) -> Checked:
        raise AssertionError("there are no terms")

    def from_entry(self, form: ExactForm, entry: Any) -> tuple[Any, float]:
        raise AssertionError("there are no terms")


def pruned(program: Program, forgotten: set[int]) -> Program:
    """Let sums be their first summand alone."""
    replaced: dict[int, Any] = {}

    def of(x: Any) -> Any:
        while isinstance(x, Expression) and x.order in forgotten:
            x = x.arguments[0]
        return replaced.get(x.order, x) if isinstance(x, Expression) else x

    trace = program.steps[0].trace
    for step in program.steps:
        if step.operation != "input" and step.order not in forgotten:
            replaced[step.order] = trace.record(step.operation, *map(of, step.arguments))
    return Program.of(trace, [of(output) for output in program.outputs])


def pruned_model(exact: ExactDynamics, forgotten: Sequence[int]) -> SimplifiedModel:
    level = PrunedLevel(forgotten)
    program = level.write(exact.form, {}, ROUGH)
    n = exact.arm.n_joints
    inputs = {
        f"{name}{i + 1}": array[:, i]
        for name, array in zip(("q", "qd", "qdd"), exact.states.arrays, strict=True)
        for i in range(n)
    }
    errors = ErrorTable.of(exact.torque, program.run(inputs).T)
    return SimplifiedModel(
        level=level,
        form=exact.form,
        terms=level.terms(exact.form),
        program=program,
        operations_full=exact.form.operations,
        promise=Promise(errors.largest, "1%", errors, exact.states.described),
    )


@pytest.fixture(scope="module")
def exact(two_link) -> ExactDynamics:
    return ExactDynamics.of(two_link, states_in_box(two_link, 60))


@pytest.fixture(scope="module")
def model(exact) -> SimplifiedModel:
    return pruned_model(exact, (4,))


def test_a_pruned_program_is_a_model(model, exact):
    assert model.terms == {}
    assert model.operations.total > 0
    found = evaluate(model, exact.states)
    assert found.errors.largest.max() > 0.0
    np.testing.assert_array_equal(found.errors.largest, model.promise.errors.largest)
    assert found.within(model.promise.allowed).all()
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
    assert not whole.promise.errors.largest.any()
    states = states_in_box(two_link, 40, 3)
    numeric = decompose_states(two_link, states, coupling=False)
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


def test_the_search_keeps_it_as_it_is(exact):
    """It has nothing to drop, and measures what the program gives."""
    made = simplify_exact(exact, Budget.parse("1%"), How(PrunedLevel(()), thorough=False))
    assert made.terms == {}
    assert made.operations.total > 0
    assert not made.promise.errors.largest.any()
