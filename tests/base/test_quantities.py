"""One parser of quantities, for options, files and Python."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.units import KINDS, UNITS, Quantity, unit_named

NUMBERS = st.floats(min_value=-1e6, max_value=1e6, allow_nan=False)


@given(NUMBERS, st.sampled_from(sorted(KINDS)), st.sampled_from(["", " ", "  "]))
def test_every_unit_is_read_with_and_without_a_blank(number, unit, blank):
    quantity = Quantity.parse(f"{number!r}{blank}{unit}")
    assert quantity is not None
    assert quantity.kind == KINDS[unit]
    # Both products are rounded once; 1 % is a division, which differs from the product by one more rounding.
    assert quantity.si == pytest.approx(number * UNITS[KINDS[unit]][unit], rel=4e-16, abs=0.0)


@pytest.mark.parametrize(
    ("text", "quantity"),
    [
        ("1%", Quantity(0.01, "share")),
        ("7 %", Quantity(0.07, "share")),
        ("10% friction", Quantity(0.1, "share", "friction")),
        ("10 % of Friction", Quantity(0.1, "share", "friction")),
        ("2 mm", Quantity(0.002, "length")),
        ("5 N m", Quantity(5.0, "torque")),
        ("5Nm", Quantity(5.0, "torque")),
        ("180°", Quantity(180.0 * UNITS["angle"]["deg"], "angle")),
        ("2 kg m²", Quantity(2.0, "inertia")),
        ("-.5e1", Quantity(-5.0)),
    ],
)
def test_a_text_is_a_quantity(text, quantity):
    assert Quantity.parse(text) == quantity


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        *(("mN m", "mN m"), ("MN m", None), ("MNm", None), ("MNM", None), ("mN*m", "mN m"), ("NM", "N m")),
        *(("mm", "mm"), ("MM", "mm"), ("Mm", None), ("ms", "ms"), ("TIME", None), ("MS", "ms"), ("Ms", None)),
        *(("ns", "ns"), ("Ns", None), ("mrad", "mrad"), ("Mrad", None), ("mA", "mA"), ("Deg", "deg")),
    ],
)
def test_a_capital_prefix_is_another_unit(text, unit):
    """M is mega and m milli; only where all is in capitals the case says nothing."""
    assert unit_named(text) == unit
    quantity = Quantity.parse(f"5 {text}")
    assert (quantity is None) == (unit is None)
    if quantity is not None:
        assert quantity.si == pytest.approx(5.0 * UNITS[KINDS[unit]][unit], rel=4e-16)


@given(NUMBERS, st.sampled_from(sorted(KINDS)), st.booleans())
def test_a_joint_takes_its_own_kind_and_bare_numbers_of_usual_size(number, unit, revolute):
    own = "angle" if revolute else "length"
    quantity = Quantity.parse(f"{number!r} {unit}")
    assert quantity is not None
    assert quantity.of_joint(revolute) == (quantity.si if KINDS[unit] == own else None)
    usual = abs(number) <= (2 * math.pi if revolute else 10.0)
    assert Quantity(number).of_joint(revolute) == (number if usual else None)


@pytest.mark.parametrize("text", ["", "deg", "1 furlong", "1_000", "nan", "inf", "1%%", "1, 2", "٣ m"])
def test_other_texts_are_none(text):
    assert Quantity.parse(text) is None


@pytest.mark.parametrize(
    ("read", "alike"),
    [
        (lambda length: gd.types.Margin.parse(length).prismatic, "20mm"),
        (lambda length: gd.types.Reading.of(offset=[f"3={length}"]).corrections.offset[0][1].si, "0.02 m"),
    ],
)
def test_margins_and_offsets_read_the_same_units(read, alike):
    # Each product is rounded once.
    assert read(alike) == pytest.approx(0.02, rel=4e-16)
    for text in ("1 kg", "1 ms", "20 mmm"):
        with pytest.raises(GdAnalyzeError):
            read(text)
