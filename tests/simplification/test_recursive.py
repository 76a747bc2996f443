"""Models of the level "recursive" in files, and what no recursion has."""

from __future__ import annotations

import json

import numpy as np
import pytest

from gd_analyze.errors import ModelError
from gd_analyze.motions.states import states_in_box
from gd_analyze.simplification.effort import ROUGH, THOROUGH
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Change
from gd_analyze.simplification.recursive import RECURSIVE


@pytest.fixture(scope="module")
def form(two_link) -> ExactForm:
    return ExactForm(two_link)


def places(form: ExactForm, operation: str) -> list[int]:
    return [k for k, step in enumerate(form.recursion.steps) if step.operation == operation]


def test_changes_come_back_from_their_entries(form):
    sums = places(form, "add")
    changes = {Change(sums[0], NUMBER): 0.0, Change(sums[1], sums[0]): -1.5}
    entries = json.loads(json.dumps(RECURSIVE.to_entries(changes)))
    assert entries[1] == {"step": sums[1], "source": sums[0], "number": -1.5}
    assert RECURSIVE.from_entries(form, entries) == changes


def test_without_a_change_it_is_exact(form, two_link):
    """Rewritten, too, but for some roundings of sums as large as the torque."""
    assert RECURSIVE.terms(form) == {}
    inputs = inputs_of(states_in_box(two_link, 20))
    rough, thorough = (RECURSIVE.write(form, {}, effort) for effort in (ROUGH, THOROUGH))
    assert thorough.count.total <= rough.count.total
    torque = rough.run(inputs)
    assert np.abs(thorough.run(inputs) - torque).max() <= 1e-13 * np.abs(torque).max()


@pytest.mark.parametrize(
    ("step", "source", "what"),
    [
        (-1, NUMBER, "has no step -1"),
        (10_000, NUMBER, "has no step 10000"),
        (20, 10_000, "has no step 10000"),
        (20, -3, "has no step -3"),
        (0, CONSTANT, "step 0 of the recursion has no constant"),
        (20, 20, "in a circle"),
    ],
)
def test_what_no_recursion_has(form, step, source, what):
    with pytest.raises(ModelError, match=what):
        RECURSIVE.from_entries(form, [{"step": step, "source": source, "number": 1.0}])
