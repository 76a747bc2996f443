"""One way of counting: the same arm, motion and budget take the same operations wherever they are told."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import trade_off
from gd_analyze.certification.holding import simplify_held
from gd_analyze.results.model_facts import headline
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.torque_program import FINAL
from gd_analyze.studies.formulations import formulations_compared
from gd_analyze.types import LEVELS, Box, ExactDynamics, ExactForm, Settings
from long_cases import long


@pytest.fixture(scope="module")
def findings(two_link, swing):
    return gd.analyze(two_link, swing, settings=Settings(budget=gd.types.Budget.parse("5%")))


def test_exact_is_one_number_in_every_verb(two_link, swing, findings):
    """Main job, simplify at every level, certified, trade-off and compare."""
    full = ExactForm(two_link).operations
    exact = ExactDynamics.of(two_link, swing)
    models = [gd.simplify(two_link, swing, level=level) for level in LEVELS]
    certified, _ = simplify_held(exact, gd.types.Budget.parse("5%"), Box.of(two_link), certified=True)[:2]
    told = [model.operations_full for model in (findings.model, *models, certified) if model.has_terms]
    assert set(told) == {full}
    # Of parts it is at most what is told, and no saving is stated.
    of_parts = [model for model in (findings.element_model, *models) if not model.has_terms]
    assert all(model.operations_full.total >= full.total and not model.saves for model in of_parts)
    assert all("exact at most" in headline(model) for model in of_parts)
    assert formulations_compared(two_link).values()["operations_full"] == asdict(full)
    points = trade_off(exact, factors=(1e-6,), levels=(TERM,))
    assert [point.operations for point in points] == [full]


@pytest.mark.parametrize("level", ["term", "energy"])
def test_a_model_is_written_as_its_terms_are_whoever_asks(puma, pick_and_place, level):
    """Found by a quick search or a long one: the same terms take the same operations."""
    exact = ExactDynamics.of(puma, pick_and_place, drives=True)
    model = simplify_exact(exact, gd.types.Budget.parse("2%"), SearchOptions(level, thorough=False))
    assert model.program.count == model.level.write(model.form, model.terms, FINAL).count
    # Every step of the search is counted so, and the fewest is that of the model.
    assert min(step.operations for step in model.accuracy.steps) == model.operations_minimized.total


SLOW = Settings(drives=True, level="energy", budget=gd.types.Budget.parse("3%"))


@pytest.mark.parametrize(
    ("arm", "motion", "settings"),
    [
        long("puma560", "pick-and-place", Settings(drives=True)),
        ("puma560", "pick-and-place", Settings(level="element")),
        long("puma560", "pick-and-place", SLOW),
        ("two_link", "two-link-swing", Settings(at_set_points=True)),
    ],
)
def test_the_budget_path_leads_through_the_model(arm, motion, settings):
    found = gd.analyze(gd.load_arm(arm), motion, settings=settings)
    model = found.model
    budgets = found.tables["budgets"]
    own, operations = budgets.attrs["asked"], budgets.operations.values
    assert operations[own] == model.operations.total
    np.testing.assert_array_equal(budgets.largest_error[own], model.accuracy.errors.largest)
    # Those of named budgets are searched on their own, and stand between by their number of terms.
    named = found.tables["stops"].position.values if "stops" in found.tables else []
    own_path = np.setdiff1d(np.arange(len(operations)), np.setdiff1d(named, own))
    # What a search minimises falls from budget to budget: at level term that is D, h and c.
    minimised = budgets.operations_apart.values if model.level.name == "term" else operations
    assert (np.diff(minimised[own_path]) <= 0).all()
    # By elements a model may take more operations than the exact torque.
    assert (operations <= max(model.operations_full.total, model.operations.total)).all()
