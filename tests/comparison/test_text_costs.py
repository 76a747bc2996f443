"""What the text says of costs, and polynomials."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.studies.polynomial import Polynomial, exact_polynomial
from gd_analyze.studies.text_costs import text_costs
from strategies import examples


@pytest.mark.parametrize(("table", "method"), [("3.1", "lagrange_euler"), ("3.4", "newton_euler_link")])
def test_the_rows_add_up_to_the_total(table, method):
    rows, total = text_costs().rows_of(table), text_costs().of(method, table)
    assert total is not None
    for n in range(1, 13):  # twelve values fix polynomials of the fourth degree
        assert sum(row.multiplications(n) for row in rows) == total.multiplications(n)
        assert sum(row.additions(n) for row in rows) == total.additions(n)


def test_counts_the_text_prints_for_six_joints():
    dalembert = text_costs().of("generalized_dalembert")
    assert dalembert is not None
    assert (dalembert.multiplications(6), dalembert.additions(6)) == (2963, 2209)
    assert "reconstructed" in dalembert.remark
    assert dalembert.at(6).total == 2963 + 2209


def test_every_total_is_of_a_method_and_a_whole_number():
    for cost in text_costs().totals:
        assert cost.name in METHODS
        assert all(cost.at(n).total > 0 for n in range(1, 13))
    assert text_costs().of("composite_moments") is None


def test_a_trace_of_the_text_is_four_products_of_4x4_matrices():
    rows = {row.name: row for row in text_costs().rows_of("3.1")}
    for n in range(1, 13):
        traces = n * (n + 1) * (n + 2) // 6
        row = rows["Tr(U_jk J_j U_ji^T)"]
        assert (row.multiplications(n), row.additions(n)) == (256 * traces, (4 * 48 + 3) * traces)
        row = rows["Tr(U_jkm J_j U_ji^T)"]
        assert (row.multiplications(n), row.additions(n)) == (256 * n * traces, (4 * 48 + 3) * n * traces)


def test_polynomials_as_text():
    assert str(Polynomial((Fraction(-7), Fraction(), Fraction(128, 3)))) == "128/3 n^2 - 7"
    assert str(Polynomial((Fraction(), Fraction(-1)))) == "-n"
    assert str(Polynomial((Fraction(),))) == "0"


@examples(50)
@given(
    st.lists(st.fractions(-50, 50, max_denominator=6), min_size=1, max_size=5).filter(lambda c: c[-1] != 0)
)
def test_a_polynomial_is_found_from_its_values(coefficients):
    wanted = Polynomial(tuple(coefficients))
    sizes = range(3, 13)
    # Denominators up to 6: sixty times the values are whole, as counts are.
    values = [int(60 * sum(c * n**k for k, c in enumerate(coefficients))) for n in sizes]
    found = exact_polynomial(sizes, values)
    assert found is not None
    scaled = [60 * c for c in wanted.coefficients]
    assert found.coefficients == tuple(scaled)


def test_values_of_no_polynomial_are_refused():
    assert exact_polynomial(range(1, 9), [2**n for n in range(1, 9)]) is None
    values = [n**2 for n in range(1, 9)]
    values[4] += 1
    assert exact_polynomial(range(1, 9), values) is None
