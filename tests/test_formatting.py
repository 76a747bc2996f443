"""Numbers and units as a reader expects them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.text import aligned, amount, figures, fitting, percent_cell, prefixed


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (41.0, "41.0"),
        (0.0012, "0.00120"),
        (123.4, "123"),
        (2.1e-14, "2.10 × 10⁻¹⁴"),
        (np.inf, "∞"),
    ],
)
def test_figures(value: float, shown: str) -> None:
    assert figures(value) == shown


def test_percent_has_no_more_digits_than_it_means() -> None:
    shares = (0.0, 1e-6, 0.01234, 1.1502, np.inf)
    assert [*map(percent_cell, shares)] == ["0", "< 0.01", "1.2", "115", "∞"]


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (6.56e-5, "N m", "65.6 µN m"),
        (0.0971, "N m", "97.1 mN m"),
        (41.0, "N m", "41 N m"),
        (12_300.0, "N", "12.3 kN"),
        (4e-5, "kg m^2", "40 mg m^2"),
        (0.02, "kg m", "20 g m"),
        (2.1e-14, "N m", "2.10e-14 N m"),  # round-off is no quantity of the arm
        (0.0, "N m", "0 N m"),
        (1e-5, "kg m^2 or kg m", "1.00e-05 kg m^2 or kg m"),
        (0.01, "deg", "0.01 deg"),
    ],
)
def test_prefixes_stand_in_place_of_powers_of_ten(value: float, unit: str, shown: str) -> None:
    assert amount(value, unit) == shown


@given(st.floats(1e-9, 9.9e6), st.sampled_from(["N m", "N"]))
def test_a_prefix_leaves_one_to_four_digits_before_the_point(value: float, unit: str) -> None:
    factor, shown = prefixed(value, unit)
    assert shown.endswith(unit)
    # Units without a prefix go from a tenth to ten thousand; the factor is a power of ten, rounded once.
    assert value / factor * (1 + 1e-12) >= 0.1
    assert value / factor < 1e4


@given(st.lists(st.floats(1e-6, 1e3), min_size=1, max_size=6))
def test_a_row_in_one_unit_needs_no_powers_of_ten_within_seven_decades(values: list[float]) -> None:
    factor, _ = fitting(values, "N m")
    written = [figures(value / factor) for value in values]
    near = [text for text, value in zip(written, values, strict=True) if value > 1.01e-5 * max(values)]
    assert not any("10" in text and "×" in text for text in near)


def test_aligned_numbers_have_the_same_number_of_decimals() -> None:
    column = aligned(["12", "0.5", "1.25"])
    filled = [(entry["text"] + entry["pad"]).partition(".")[2] for entry in column]
    assert {len(decimals) for decimals in filled} == {2}
