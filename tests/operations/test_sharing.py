"""Polynomials nested and sharing sums: the same values, never more operations, what a person would share."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.operations.extraction import extract
from gd_analyze.operations.program import Program
from gd_analyze.operations.sharing import factored, rewritten, shared_sums
from gd_analyze.operations.sums import Sums
from gd_analyze.operations.trace import Trace
from strategies import examples

# C and S are of one angle, so that rearranging may write either square with the other.
NAMES = ("a", "b", "d", "C", "S")
VALUES = {"a": 2.0, "b": -3.0, "d": 0.5, "C": math.cos(0.7), "S": math.sin(0.7)}
INPUTS = {"qd1": VALUES["a"], "qd2": VALUES["b"], "qd3": VALUES["d"], "q1": 0.7}

# Ratios of coefficients count as equal within 1e-12, and a term passes through a few of them.
ROUND_OFF = 1e-11

polynomials = st.lists(
    st.dictionaries(
        st.lists(st.sampled_from(NAMES), max_size=4).map(lambda names: tuple(sorted(names))),
        st.sampled_from([1.0, -1.0, 2.0, -2.0, 3.0, 0.1, -0.7, 0.7, 1e-3]),
        max_size=7,
    ),
    min_size=1,
    max_size=3,
)


def program_of(values) -> Program:
    """The program that some values of the variables make."""
    trace = Trace()
    angle, *moving = (trace.record("input", name) for name in ("q1", "qd1", "qd2", "qd3"))
    variables = dict(zip(NAMES[:3], moving, strict=True)) | {"C": angle.cos(), "S": angle.sin()}
    return Program.of(trace, values(variables.__getitem__))


def rearranged(given_polynomials) -> Program:
    return rewritten(program_of(shared_sums(given_polynomials).values))


def naive_operations(polynomial) -> int:
    """Multiplications and additions of the sum as written; by 1 and -1 nothing is multiplied."""
    products = sum(max(len(names) - (abs(c) == 1.0), 0) for names, c in polynomial.items())
    return products + max(len(polynomial) - 1, 0)


def traced(values) -> int:
    """Operations of the program that some values of the variables make."""
    return program_of(values).count.total


def operations(*given_polynomials) -> int:
    return rearranged(given_polynomials).count.total


@examples(60)
@given(polynomials)
def test_the_values_are_those_of_the_sums(given_polynomials):
    nested = [factored(polynomial, VALUES.__getitem__) for polynomial in given_polynomials]
    shared = shared_sums(given_polynomials).values(VALUES.__getitem__)
    inputs = {name: np.array([value]) for name, value in INPUTS.items()}
    run = rearranged(given_polynomials).run(inputs)[:, 0]
    for values in (nested, shared, run):
        for found, polynomial in zip(values, given_polynomials, strict=True):
            parts = [c * math.prod(VALUES[name] for name in names) for names, c in polynomial.items()]
            assert abs(found - math.fsum(parts)) <= ROUND_OFF * math.fsum(map(abs, parts))


@examples(60)
@given(polynomials)
def test_rearranged_is_no_more_than_extracted_is_no_more_than_written(given_polynomials):
    extracted = shared_sums(given_polynomials)
    assert operations(*given_polynomials) <= traced(extracted.values)
    assert extracted.operations <= sum(map(naive_operations, given_polynomials))
    for polynomial in given_polynomials:
        assert traced(lambda value, p=polynomial: [factored(p, value)]) <= naive_operations(polynomial)
    # A trace may know still more to be equal; turning a difference round can cost it one operation.
    turned = {
        product
        for terms in extracted.terms.values()
        for product, c in terms.items()
        if c == -1.0 and len(product) == 1 and product[0] in extracted.terms
    }
    assert traced(extracted.values) <= extracted.operations + len(turned)


@pytest.mark.parametrize(
    ("polynomial", "fewest"),
    [
        ({}, 0),
        ({("a",): 0.0}, 0),
        # 1 + 2 a + 3 a^2 + 4 a^3: three multiplications and three additions.
        ({("a",) * k: k + 1.0 for k in range(4)}, 6),
        # 3 (a - b + C S): a shared coefficient is multiplied once.
        ({("a",): 3.0, ("b",): -3.0, ("C", "S"): 3.0}, 4),
    ],
)
def test_nested_polynomials(polynomial, fewest):
    assert traced(lambda value: [factored(polynomial, value)]) == fewest
    assert operations(polynomial) == fewest


@pytest.mark.parametrize(
    ("given_polynomials", "fewest"),
    [
        # x = 0.7 a; b x, d x.
        ([{("a", "b"): 0.7}, {("a", "d"): 0.7}], 3),
        # x = 2 a + 3 b; b x, and d x with the opposite sign.
        ([{("a", "b"): 2.0, ("b", "b"): 3.0}, {("a", "d"): -2.0, ("b", "d"): -3.0}], 5),
        # x = a + 7 b; x + d, 3 x + C: part of a sum, up to a factor.
        ([{("a",): 1.0, ("b",): 7.0, ("d",): 1.0}, {("a",): 3.0, ("b",): 21.0, ("C",): 1.0}], 5),
        # a (2 a + 3 b): a quadratic form.
        ([{("a", "a"): 2.0, ("a", "b"): 3.0}], 4),
        # x = 5 a b, y = -3 x: a product up to a factor.
        ([{("a", "b"): 5.0}, {("a", "b"): -15.0}], 3),
        # A row that is another one's multiple, with a term of its own.
        ([{("a",): 1.0, ("b", "d"): 1.0}, {("a",): 3.0, ("b", "d"): 3.0, ("S",): 1.0}], 4),
        # (a + b) (C + S), four products as written.
        ([{(x, y): 1.0 for x in "CS" for y in "ab"}], 3),
        # 2 C^2 + 2 S^2 is no more than a number.
        ([{("C", "C"): 2.0, ("S", "S"): 2.0}], 0),
        # x = 5 C + S, y = C + a S; C x + S y, where 2 C S is to be parted and a - a C^2 is a S^2.
        (
            [
                {("C", "C"): 5.0, ("C", "S"): 2.0, ("C", "C", "a"): -1.0, ("a",): 1.0},
                {("S", "a"): 1.0, ("C",): 1.0},
                {("C",): 5.0, ("S",): 1.0},
            ],
            7,
        ),
    ],
)
def test_what_a_person_would_share(given_polynomials, fewest):
    assert operations(*given_polynomials) == fewest


def test_coefficients_that_differ_by_round_off_are_shared():
    assert operations({("a",): 0.7, ("b",): 0.7 * (1 + 1e-12)}) == 2
    assert operations({("a",): 0.7, ("b",): 0.7 * (1 + 1e-6)}) == 3


def indexed(sums: Sums) -> tuple[object, ...]:
    """Everything kept beside the terms, in no order."""
    return (
        sums.operations,
        {v: {k: count for k, count in users.items() if count} for v, users in sums.users.items() if +users},
        {pair: set(places) for pair, places in sums.pairs.items() if places},
        {two: set(places) for two, places in sums.products.items() if places},
    )


@examples(25)
@given(polynomials, st.integers(0, 99))
def test_undone_is_as_before(given_polynomials, seed):
    sums = shared_sums(given_polynomials)
    before, index = {v: dict(terms) for v, terms in sums.terms.items()}, indexed(sums)
    sums.mark()
    for v in sums.defined[:2]:
        sums.inline(v)
    extract(sums, Random(seed), 2.0)
    sums.undo()
    assert sums.terms == before
    assert indexed(sums) == index
