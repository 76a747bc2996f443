"""Nested polynomials: the same value, no more operations."""

from __future__ import annotations

from collections.abc import Callable

from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.operations.program import Program
from gd_analyze.operations.sharing import factored
from gd_analyze.operations.trace import Trace
from strategies import examples

NAMES = ("a", "b", "c", "d")
VALUES = {"a": 2.0, "b": -3.0, "c": 5.0, "d": 7.0}

# Small whole numbers: every intermediate result is exact in floating point, in any order.
polynomials = st.dictionaries(
    st.lists(st.sampled_from(NAMES), max_size=4).map(lambda names: tuple(sorted(names))),
    st.integers(-6, 6).map(float),
    max_size=8,
)


def naive(polynomial: dict[tuple[str, ...], float], value: Callable[[str], float]) -> float:
    total = 0.0
    for variables, coefficient in polynomial.items():
        product = coefficient
        for variable in variables:
            product *= value(variable)
        total += product
    return total


def naive_operations(polynomial: dict[tuple[str, ...], float]) -> int:
    """Multiplications and additions of the sum as written; by 1 and -1 nothing is multiplied."""
    kept = {variables: c for variables, c in polynomial.items() if c != 0.0}
    products = sum(max(len(variables) - (abs(c) == 1.0), 0) for variables, c in kept.items())
    return products + max(len(kept) - 1, 0)


def operations(polynomial: dict[tuple[str, ...], float]) -> int:
    trace = Trace()
    inputs = {name: trace.inputs(name, 1)[0, 0] for name in NAMES}
    return Program.of(trace, [factored(polynomial, inputs.__getitem__)]).count.total


@examples(80)
@given(polynomials)
def test_the_value_is_that_of_the_sum(polynomial):
    assert factored(polynomial, VALUES.__getitem__) == naive(polynomial, VALUES.__getitem__)


@examples(80)
@given(polynomials)
def test_no_more_operations_than_the_sum(polynomial):
    assert operations(polynomial) <= naive_operations(polynomial)


def test_nothing_is_zero():
    assert factored({}, VALUES.__getitem__) == 0.0
    assert factored({("a",): 0.0}, VALUES.__getitem__) == 0.0


def test_horner_of_one_variable():
    """1 + 2 a + 3 a^2 + 4 a^3: three multiplications and three additions."""
    polynomial = {("a",) * k: k + 1.0 for k in range(4)}
    assert operations(polynomial) == 6
    assert naive_operations(polynomial) == 9


def test_a_shared_coefficient_is_multiplied_once():
    """3 a - 3 b + 3 c d = 3 (a - b + c d)."""
    assert operations({("a",): 3.0, ("b",): -3.0, ("c", "d"): 3.0}) == 4
