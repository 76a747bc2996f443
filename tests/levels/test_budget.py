from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import UsageError
from gd_analyze.levels import Budget
from strategies import examples


@pytest.mark.parametrize(
    ("text", "amounts", "is_share"),
    [
        ("1%", (0.01,), (True,)),
        (" 2.5 % ", (0.025,), (True,)),
        ("0.5", (0.5,), (False,)),
        ("0.5 N m", (0.5,), (False,)),
        ("0.5Nm", (0.5,), (False,)),
        ("3 N", (3.0,), (False,)),
        ("1e-3", (1e-3,), (False,)),
        ("0", (0.0,), (False,)),
        ("0%", (0.0,), (True,)),
        ("1%,0.2,5%", (0.01, 0.2, 0.05), (True, False, True)),
        (".5%", (0.005,), (True,)),
    ],
)
def test_what_is_understood(text, amounts, is_share):
    budget = Budget.parse(text)
    assert budget.amounts == amounts
    assert budget.is_share == is_share


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "%",
        "one",
        "-1%",
        "-0.5",
        "nan",
        "inf",
        "1e999",
        "1..2",
        "1%%",
        "1% 2%",
        "1 kg",
        "1%,",
        "1;2",
        "0x1",
    ],
)
def test_what_is_refused(text):
    with pytest.raises(UsageError, match="budget is not understood") as caught:
        Budget.parse(text)
    assert caught.value.details["where"].startswith("--budget, entry")
    assert "1%" in caught.value.details["expected"]


def test_the_entry_to_blame_is_named():
    with pytest.raises(UsageError) as caught:
        Budget.parse("1%,2%,x")
    assert caught.value.details["where"] == "--budget, entry 3"
    assert caught.value.details["found"] == "'x'"


@pytest.mark.parametrize(
    ("amounts", "is_share"), [((-0.1,), (True,)), ((float("nan"),), (True,)), ((float("inf"),), (False,))]
)
def test_an_impossible_budget_is_refused(amounts, is_share):
    with pytest.raises(UsageError, match="cannot be that"):
        Budget(amounts, is_share)


@pytest.mark.parametrize(("amounts", "is_share"), [((), ()), ((0.1, 0.2), (True,))])
def test_a_lopsided_budget_is_refused(amounts, is_share):
    with pytest.raises(UsageError, match="one mark"):
        Budget(amounts, is_share)


def test_allowed_error_of_each_joint():
    peak = np.array([10.0, 20.0, 0.0])
    assert Budget.parse("10%").allowed(peak).tolist() == [1.0, 2.0, 0.0]
    assert Budget.parse("0.5").allowed(peak).tolist() == [0.5, 0.5, 0.5]
    assert Budget.parse("10%,0.5,1").allowed(peak).tolist() == [1.0, 0.5, 1.0]


def test_one_entry_or_one_per_joint():
    with pytest.raises(UsageError, match="wrong number of entries") as caught:
        Budget.parse("1%,2%").allowed(np.ones(3))
    assert caught.value.details["expected"] == "1 or 3"


@examples(100)
@given(st.lists(st.tuples(st.floats(0, 1e6), st.booleans()), min_size=1, max_size=6))
def test_what_is_printed_can_be_read_back(entries):
    budget = Budget(tuple(a for a, _ in entries), tuple(s for _, s in entries))
    again = Budget.parse(str(budget))
    assert again.is_share == budget.is_share
    # Printed to 6 significant digits, for the eye: half a unit of the sixth.
    np.testing.assert_allclose(again.amounts, budget.amounts, rtol=5.1e-6)
