"""What a model costs, in the first line: what it saves is said, what it does not save is said as well."""

from __future__ import annotations

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Trace
from gd_analyze.results.model_facts import apart_text, headline, operation_facts
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.simplify import stated
from gd_analyze.tables import states_of
from gd_analyze.types import ExactDynamics, SimplifiedModel
from made_models import model_of


def longer(program: Program) -> Program:
    """The same in many more operations."""
    trace = Trace()
    of, wave = program.folded(trace, {}), trace.record("input", "q1")
    for k in range(60):
        wave = wave * (wave + float(k))
    return Program.of(trace, [of(output) + 1e-300 * wave for output in program.outputs])


@pytest.fixture(scope="module")
def exact(two_link, swing) -> ExactDynamics:
    return ExactDynamics.of(two_link, states_of(swing))


def saving(exact: ExactDynamics, torque: bool, functions: bool) -> SimplifiedModel:
    """A model of three terms that saves in its torque, in its D, h and c, in both or neither."""
    terms = dict(sorted(exact.form.upper_torques.items(), key=lambda item: -abs(item[1]))[:3])
    model = model_of(exact.form, TERM, terms)
    if not torque:
        vars(model)["program"] = longer(model.program)
    if not functions:
        dear = model.functions._replace(inertia=longer(model.functions.inertia))
        vars(model)["functions"] = dear
    return model


@pytest.mark.parametrize("torque", [True, False])
@pytest.mark.parametrize("functions", [True, False])
def test_it_says_what_is_cheaper_and_what_is_not(exact, torque, functions):
    model = saving(exact, torque, functions)
    full, apart = exact.form.operations, exact.form.functions.operations
    assert (model.saves_torque, model.saves_functions) == (torque, functions)
    assert (model.operations.total < full.total, model.functions.operations.total < apart.total) == (
        torque,
        functions,
    )
    assert model.saves == (torque or functions)
    if not model.saves:
        kept = stated(exact, model)
        assert kept.terms == TERM.terms(exact.form)
        assert kept.is_exact
        assert f"{full.in_words}" in headline(kept)
        return
    text = headline(model, "Torque error")
    assert model.operations.pair in text or model.operations.in_words in text
    assert full.pair in text
    assert apart.pair in text
    assert ("take the exact" in text) == (not torque or not functions)


def test_sines_and_cosines_stand_beside_operations_everywhere(exact):
    model = saving(exact, True, True)
    facts = {fact.key: fact.value for fact in operation_facts(model)}
    for key, functions in (
        ("operations_apart", model.functions),
        ("operations_apart_full", model.form.functions),
    ):
        assert {name: row["sines_cosines"] for name, row in facts[key].items()} == {
            name: program.count.sines_cosines for name, program in functions._asdict().items()
        }
        assert f"{functions.operations.sines_cosines} sin and cos" in apart_text(model)
    assert str(model.operations.sines_cosines) in repr(model)


def test_a_budget_that_verdicts_miss_is_told(two_link, swing):
    model, wide = (gd.simplify(two_link, swing, budget, level="element") for budget in ("1%", "90%"))
    missed = 1 + np.flatnonzero(model.accuracy.errors.largest > model.accuracy.allowed)
    assert missed.tolist() == [1, 2]
    assert headline(model).endswith("It misses the budget of 1% at every joint.")
    assert "misses" not in headline(wide)
