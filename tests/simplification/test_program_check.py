"""The program in a file computes its terms everywhere, not only where somebody looks."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from changed_files import Document, Steps, changed, refused
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_checks import require_terms_computed
from gd_analyze.simplification.model_file import load_model
from made_models import exact_model, model_of
from strategies import arms, examples


@pytest.fixture(scope="module", params=LEVELS)
def model(request, two_link) -> SimplifiedModel:
    return exact_model(two_link, level=LEVELS[request.param])


def a_high_power(document: Document) -> None:
    step = Steps(document)
    x = step("input", "q1")
    for _ in range(12):
        x = step("multiply", x, x)
    step.add_to_output(x)


def nothing_at_known_states(document: Document) -> None:
    """What the first output is off by is zero at the states of a seed, and large elsewhere."""
    step = Steps(document)
    product: str | float = 1.0
    for known in np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5, 2))[0, :, 1]:
        product = step("multiply", product, step("subtract", step("input", "q2"), float(known)))
    step.add_to_output(product)


def nothing_at_known_angles(document: Document) -> None:
    """The same of sines, so that no angle stands alone."""
    step = Steps(document)
    product: str | float = 1e-3
    for known in np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5, 2))[0, :, 1]:
        sine = step("sin", step("input", "q2"))
        product = step("multiply", product, step("subtract", sine, float(np.sin(known))))
    step.add_to_output(product)


def a_small_term(document: Document) -> None:
    step = Steps(document)
    step.add_to_output(step("multiply", 1e-5, step("sin", step("input", "q1"))))


def a_term_lost_in_rounding(document: Document) -> None:
    """1e20 cos q1 - (1e20 cos q1 - 1e-3): what is left is rounded away."""
    step = Steps(document)
    large = step("multiply", 1e20, step("cos", step("input", "q1")))
    step.add_to_output(step("subtract", large, step("subtract", large, 1e-3)))


def an_overflow(document: Document) -> None:
    step = Steps(document)
    x = step("cos", step("input", "q1"))
    for _ in range(4):
        x = step("multiply", 1e99, x)
    step.add_to_output(x)


def numbers_beyond_a_torque(document: Document) -> None:
    """They do not overflow yet: what is made of them does."""
    step = Steps(document)
    x = step("multiply", 1e99, step("multiply", 1e99, step("cos", step("input", "q1"))))
    step.add_to_output(step("multiply", 1e99, x))


ELSE = [
    a_high_power,
    nothing_at_known_states,
    nothing_at_known_angles,
    a_small_term,
    a_term_lost_in_rounding,
    an_overflow,
    numbers_beyond_a_torque,
]


@pytest.mark.parametrize("change", ELSE)
def test_what_computes_anything_else_is_refused(model, tmp_path, change):
    error = refused(model, tmp_path / "model.json", change)
    assert error.what in (
        "the program does not compute the terms",
        "the program computes no torque of an arm: it uses an angle outside of sines and cosines",
        "the program computes no torque of an arm: its numbers overflow",
    )


def test_what_is_zero_everywhere_may_be_added(model, tmp_path: Path) -> None:
    """c (sin^2 + cos^2 - 1) is nothing, however it is written."""

    def change(document: Document) -> None:
        step = Steps(document)
        squares = [
            step("multiply", x, x) for x in (step(kind, step("input", "q1")) for kind in ("sin", "cos"))
        ]
        nothing = step("subtract", step("add", *squares), 1.0)
        step.add_to_output(step("multiply", 1e-6, nothing))

    again = load_model(changed(model, tmp_path / "model.json", change))
    assert again.operations.total > model.operations.total


@examples(25)
@given(
    arms(max_joints=4),
    st.sampled_from([LEVELS["term"], LEVELS["energy"]]),
    st.sampled_from([ROUGH, COUNTING, THOROUGH]),
    st.integers(0, 2**32 - 1),
)
def test_what_the_tool_writes_fits_however_it_is_written(arm, level, effort, seed):
    random = np.random.default_rng(seed)
    form = ExactForm(arm)
    kept = {term: number for term, number in level.terms(form).items() if random.random() < 0.8}
    require_terms_computed(model_of(form, level, kept, effort))


def test_a_program_of_a_sample_is_written_out_quickly(puma):
    """A hundredth of a second here, for the exact PUMA's 600 operations two; loading must not be felt."""
    model = exact_model(puma)
    started = time.process_time()
    require_terms_computed(model)
    assert time.process_time() - started < 1.0
