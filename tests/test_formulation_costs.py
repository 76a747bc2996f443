"""The study of what the formulations cost: counts are exact polynomials, and the text's add up."""

from __future__ import annotations

import dataclasses
import itertools
from fractions import Fraction
from importlib import import_module

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.methods import METHODS
from strategies import examples

study = import_module("formulation_costs")
ORDERS = {"n": 1, "n^2": 2, "n^3": 3, "n^4": 4}


@pytest.fixture(scope="module")
def grown():
    """Six counts from three joints on: five fix a polynomial of the fourth degree, the sixth tests it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "SIZES", tuple(range(1, 9)))
        yield study.growth()


@pytest.mark.slow
@pytest.mark.parametrize("name", list(METHODS))
def test_the_order_is_that_of_the_equations_and_folding_only_saves(grown, name):
    """Exactly: from three joints on the counts are polynomials, and their degree is the stated order."""
    multiplications, additions = grown.polynomials[name]
    order = ORDERS[METHODS[name].growth]
    assert len(multiplications.coefficients) - 1 == len(additions.coefficients) - 1 == order
    for n, cost in zip(study.SIZES, grown.costs[name], strict=True):
        if n >= 3:
            assert multiplications(n) == cost.executed.multiplications
            assert additions(n) == cost.executed.additions
        pairs = zip(dataclasses.astuple(cost.folded), dataclasses.astuple(cost.executed), strict=True)
        assert all(folded <= executed for folded, executed in pairs)


@pytest.mark.slow
def test_the_traces_of_lagrange_euler_are_as_told(grown):
    """One per h_ikm or D_ik and link in ours; in the text one per link and pair for D, n times that for h."""
    n, sentence = study.N_JOINTS, study.explanation("lagrange_euler", grown)
    assert f"takes {sum(j**2 + j**3 for j in range(1, n + 1))} traces" in sentence
    assert f"each of its {n * (n + 1) ** 2 * (n + 2) // 6} traces" in sentence


def test_counts_the_text_prints_and_rows_that_add_up():
    for table, method in (("3.1", "lagrange_euler"), ("3.4", "newton_euler_link")):
        rows, total = (
            [x for x in study.text_costs().rows if x.table == table],
            study.text_costs().of(method, table),
        )
        for n in range(1, 13):  # twelve values fix polynomials of the fourth degree
            assert sum(row.multiplications(n) for row in rows) == total.multiplications(n)
            assert sum(row.additions(n) for row in rows) == total.additions(n)
    dalembert = study.text_costs().of("generalized_dalembert")
    assert (dalembert.multiplications(6), dalembert.additions(6)) == (2963, 2209)
    assert "reconstructed" in dalembert.remark
    for cost in study.text_costs().totals:
        assert cost.name in METHODS
        assert all(cost.at(n).total > 0 for n in range(1, 13))
    rows = {row.name: row for row in study.text_costs().rows if row.table == "3.1"}
    for n, (name, times) in itertools.product(range(1, 13), (("jk", 0), ("jkm", 1))):
        # A trace is four products of 4x4 matrices.
        row, traces = rows[f"Tr(U_{name} J_j U_ji^T)"], n**times * n * (n + 1) * (n + 2) // 6
        assert (row.multiplications(n), row.additions(n)) == (256 * traces, (4 * 48 + 3) * traces)


@examples(30)
@given(
    st.lists(st.fractions(-50, 50, max_denominator=6), min_size=1, max_size=5).filter(lambda c: c[-1] != 0)
)
def test_a_polynomial_is_found_from_its_values(coefficients):
    sizes = range(3, 13)
    # Denominators up to 6: sixty times the values are whole, as counts are.
    values = [int(60 * sum(c * n**k for k, c in enumerate(coefficients))) for n in sizes]
    assert study.exact_polynomial(sizes, values).coefficients == tuple(60 * c for c in coefficients)
    values[4] += 1
    assert study.exact_polynomial(sizes, values) is None
    assert str(study.Polynomial((Fraction(-7), Fraction(), Fraction(128, 3)))) == "128/3 n^2 - 7"
