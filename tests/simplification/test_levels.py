"""What every level says of itself, and the one whose models are changed programs and no sums of terms."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics import newton_euler_link
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.motions.states import states_in_box
from gd_analyze.operations.tape import Tape
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.effort import ROUGH, THOROUGH
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import LEVELS, level_named
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Change, Recursion, restated
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.term import TERM
from strategies import arms, examples, random_states


def test_a_level_is_known_by_its_name_or_as_itself():
    assert list(LEVELS) == ["element", "term", "recursive", "energy"]
    for name, level in LEVELS.items():
        assert str(level) == level.name == name
        assert level_named(name) is level_named(level) is level
    with pytest.raises(UsageError, match="no such level") as caught:
        level_named("atom")
    assert caught.value.details["expected"] == "element, term, recursive, energy"


@pytest.mark.parametrize("level", [ELEMENT, TERM, ENERGY], ids=str)
def test_terms_come_back_from_their_entries(level, puma):
    form = ExactForm(puma)
    terms = level.terms(form)
    assert len(terms) > 50
    again = level.from_entries(form, json.loads(json.dumps(level.to_entries(terms))))
    assert list(again.items()) == list(terms.items())


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


def _small() -> Recursion:
    trace = Trace()
    x, y, z = trace.inputs("x", 3)[:, 0]
    inner = 2.0 * (x * y)
    outer = 3.0 * inner + z
    outputs = outer, inner * z
    return Recursion(tuple(trace.expressions), outputs)


def _place(recursion: Recursion, operation: str, which: int) -> int:
    return [k for k, step in enumerate(recursion.steps) if step.operation == operation][which]


@examples(20)
@given(arm=arms(max_joints=5, massive=True), seed=st.integers(0, 2**16))
def test_unchanged_it_is_the_exact_torque(arm: RobotArm, seed: int) -> None:
    states = random_states(arm.n_joints, 5, seed)
    got = ExactForm(arm).recursion.program.run(inputs_of(states))
    wanted = newton_euler_link.torque(arm, *states.last)
    # Two formulations of one torque, each off by what explains the difference from Pinocchio.
    assert np.abs(got - wanted).max() <= 2.0 * round_off_bounds(arm, *states.arrays)["torque"]


INPUTS = {"x1": np.array([1.5, -2.0]), "x2": np.array([0.5, 3.0]), "x3": np.array([2.0, 0.25])}


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({}, lambda x, y, z: (6 * x * y + z, 2 * x * y * z)),
        ({("multiply", 0, "input", 0): 0.5}, lambda x, y, z: (3 * x + z, x * z)),
        ({("multiply", 1, None, NUMBER): 4.0}, lambda x, y, z: (12 + z, 4 * z)),
        ({("multiply", 1, None, CONSTANT): 5.0}, lambda x, y, z: (15 * x * y + z, 5 * x * y * z)),
        (
            {("multiply", 0, "input", 0): 0.5, ("multiply", 0, "input", 2): 2.0},
            lambda x, y, z: (3 * x + 12 * z + z, (x + 4 * z) * z),
        ),
    ],
    ids=["none", "a step stands in", "a number stands in", "another constant", "two steps stand in"],
)
def test_what_changes_mean(changes: Any, wanted: Any) -> None:
    recursion = _small()
    stated = {
        Change(
            _place(recursion, operation, which), last if source is None else _place(recursion, source, last)
        ): c
        for (operation, which, source, last), c in changes.items()
    }
    got = recursion.changed(stated).run(INPUTS)
    # A handful of exact small numbers.
    np.testing.assert_allclose(got, wanted(*INPUTS.values()), rtol=1e-15)


def test_constants_in_a_row_are_one() -> None:
    recursion = _small()
    # 3 * (2 * x) is 6 * x where the product x * y is x alone; 2 * x remains for the other output.
    program = recursion.changed(
        {Change(_place(recursion, "multiply", 0), _place(recursion, "input", 0)): 1.0}
    )
    assert program.count.multiplications == 3


def test_a_circle_is_refused() -> None:
    recursion = _small()
    first, second = _place(recursion, "multiply", 0), _place(recursion, "multiply", 1)
    with pytest.raises(ValueError, match="in a circle"):
        recursion.changed({Change(first, second): 1.0})


@examples(20)
@given(arm=arms(max_joints=4, massive=True), seed=st.integers(0, 2**16))
def test_numbers_are_stated_again(arm: RobotArm, seed: int) -> None:
    """Other numbers, stated as changes, make the program that the tape runs with them."""
    rng, recursion = np.random.default_rng(seed), ExactForm(arm).recursion
    steps = [k for k, step in enumerate(recursion.steps) if step.operation in ("add", "subtract")]
    chosen = rng.choice(steps, min(3, len(steps)), replace=False) if steps else []
    changes = {
        Change(int(k), x): float(rng.uniform(0.5, 2.0))
        for k in chosen
        for x in recursion.arguments[k][:1]
        if isinstance(x, int) and recursion.steps[x].operation != "input"
    }
    before = recursion.carried_out(changes)
    tape = Tape(before.program, before.scales)
    numbers = tape.numbers.copy()
    numbers[tape.scaled] *= rng.uniform(0.5, 2.0, len(tape.scaled))
    stated = restated(changes, {tape.steps[k].order: float(numbers[k]) for k in tape.scaled}, before)
    inputs = inputs_of(random_states(arm.n_joints, 3, seed))
    again = recursion.changed(stated)
    wanted = tape.results(tape.values(inputs, numbers))
    # Numbers are divided by nothing on the way: both round each operation once.
    size = np.abs(tape.values(inputs, numbers)).max(initial=1.0)
    np.testing.assert_allclose(again.run(inputs), wanted, atol=1e-12 * size)
    assert again.count.total <= before.program.count.total
