"""Whether there are too many terms is told from the outer joints where that is enough."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.simplification.exact_form import ExactForm, has_more_terms
from parallel_axes import arm_of, arms_with_runs
from strategies import arms, examples


@examples(25)
@given(st.one_of(arms(6), arms_with_runs(6)), st.floats(0.0, 1.5))
def test_it_is_what_counting_all_of_them_says(arm, share):
    # Of random numbers, coefficients stand far above round-off, whatever joints are looked at.
    count = len(ExactForm(arm).torques)
    most = int(share * count)
    assert has_more_terms(ExactForm(arm), most) == (count > most)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_general_arm_of_eight_joints_is_never_written_out(seed):
    form = ExactForm(arm_of(["askew"] * 8, np.random.default_rng(seed)))
    assert has_more_terms(form, 2000)
    # Written out it has some million terms, which take a minute and 2 GB.
    assert "torques" not in vars(form)
    assert "harmonics" not in vars(form)
