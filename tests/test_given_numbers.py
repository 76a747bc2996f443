"""Numbers as people write them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import are_possible
from gd_analyze.text import LARGEST, number_in
from strategies import examples


@given(st.floats(allow_nan=False, allow_infinity=False))
@examples(200)
def test_every_number_that_python_writes_is_read(number: float) -> None:
    assert number_in(repr(number)) == number
    assert number_in(f" {number:+.17e} ") == number


@pytest.mark.parametrize(
    "text", ["1_000", "0.3_1", "\uff11", "\u0661", "inf", "nan", "infinity", "0x1", "1e", "1,5", ""]
)
def test_what_only_programs_take_for_a_number_is_not_read(text: str) -> None:
    assert number_in(text) is None


def test_the_limit() -> None:
    assert are_possible([[LARGEST, -LARGEST], [0.0, 1.0]])
    for wrong in (math.nan, math.inf, -math.inf, np.nextafter(LARGEST, math.inf)):
        assert not are_possible([0.0, wrong])
