"""Equations: read exactly, told apart by effect and link, found by their labels."""

from __future__ import annotations

import dataclasses
import re
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze import equations, load_arm
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.products import to_products
from gd_analyze.harmonics.terms import Factor, Monomial
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from gd_analyze.tables import harmonics_of
from harmonic_arms import states_of, to_polynomial
from parallel_axes import arm_of, arms_with_runs, of_every_turn
from strategies import arms, examples

EVERYTHING = ("D", "h", "c")
FUNCTIONS = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}


@pytest.fixture(scope="module")
def puma_harmonics():
    return harmonics_of(load_arm("puma560"))


@pytest.fixture(scope="module")
def stanford_harmonics():
    return harmonics_of(load_arm("stanford"))


def value(factors: Monomial, q: FloatArray) -> FloatArray:
    """Evaluate a product from its definition."""
    out = np.ones(q.shape[1])
    for factor in factors:
        out *= FUNCTIONS[factor.kind](np.array(factor.multiples) @ q)
    return out


def assert_read_exactly(arm, seed: int) -> None:
    harmonics = harmonics_of(arm)
    q = states_of(arm, 4, seed).q.T
    for equation in equations(harmonics, EVERYTHING):
        indices = tuple(int(digit) - 1 for digit in equation.symbol[1:])
        if equation.symbol[0] == "D":
            parts, noise = harmonics.inertia[indices], harmonics.noise[0]
        elif equation.symbol[0] == "h":
            parts, noise = harmonics.christoffel(*indices), 2 * harmonics.noise[0]
        else:
            parts, noise = harmonics.gravity_loading[indices[0]], harmonics.noise[1]
        values = parts(q)
        written = sum(term.coefficient * value(term.factors, q) for term in equation.terms)
        # Weights within twice the noise are taken for equal, and products below it left out: once per
        # product, of which a harmonic makes at most 2^(runs - 1), and run. The rest is a rounding per
        # operation.
        count = 2 ** len(harmonics.velocities.runs) * len(parts)
        size = float(np.abs(parts.coefficients).sum())
        allowed = 2 * noise * count * len(harmonics.velocities.runs) + 10 * count * np.finfo(float).eps * size
        assert np.abs(values.sum(axis=0) - written).max() <= allowed, equation.symbol
        # By effect as well, where a term may have nothing left in the whole.
        stacked = TrigonometricPolynomial.stacked([parts.total(), parts])
        rows = to_products(stacked, harmonics.velocities, noise, deciding=3)
        for k, exact in enumerate(values):
            written = sum(row[1 + k] * value(factors, q) for factors, row in rows.items())
            assert np.abs(exact - written).max() <= allowed, (equation.symbol, k)


@of_every_turn(seed=1)
@examples(20)
@given(arms_with_runs(max_joints=4), st.integers(0, 2**32 - 1))
def test_reading_is_exact_for_arms_with_parallel_axes(arm, seed):
    assert_read_exactly(arm, seed)


@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_reading_is_exact_for_built_in_arms(name):
    assert_read_exactly(load_arm(name), 5)


def test_reading_loses_nothing_small(rng):
    """Weights that differ by more than noise are not equal, however small the difference."""
    arm = arm_of(["askew", "same"], rng)
    q = rng.uniform(-3, 3, (2, 50))
    multiples = [(0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 1)]
    polynomial = {(Factor("cos", m),): 1.0 + 1e-11 * (k == 3) for k, m in enumerate(multiples)}
    whole = to_polynomial([polynomial], [False, False])
    rows = to_products(whole, AbsoluteVelocities.of(arm), noise=1e-14)
    written = sum(row[0] * value(factors, q) for factors, row in rows.items())
    exact = sum(weight * value(factors, q) for factors, weight in polynomial.items())
    # Twenty roundings of values near 6.
    assert np.abs(written - exact).max() < 20 * np.finfo(float).eps * 6


def test_effects_and_shares_add_up(puma_harmonics):
    for equation in equations(puma_harmonics, EVERYTHING):
        assert equation.terms
        shares = [term.share for term in equation.terms]
        assert max(shares) == 1.0
        # Terms that only round-off tells apart stand in the order of their factors.
        assert (np.diff(shares) <= 1e-9).all()
        for term in equation.terms:
            # One rounding of the sum, one of what was turned into products.
            assert term.coefficient == pytest.approx(term.translation + term.rotation, rel=1e-9)
            assert term.links
            assert {"translation": (True, False), "rotation": (False, True), "both": (True, True)}[
                term.effect
            ] == tuple(abs(part) > 1e-9 for part in (term.translation, term.rotation))


@pytest.mark.slow
def test_links_are_those_whose_removal_changes_the_term(puma, puma_harmonics):
    """Without mass and inertia of a link exactly the terms that name it change."""
    for s in (1, 2, 5):
        empty = {"mass": 0.0, "com": np.zeros(3), "inertia_com": np.zeros((3, 3))}
        links = (*puma.links[:s], dataclasses.replace(puma.links[s], **empty), *puma.links[s + 1 :])
        without = {
            (equation.symbol, term.factors): term.coefficient
            for equation in equations(dataclasses.replace(puma, links=links), EVERYTHING)
            for term in equation.terms
        }
        for equation in equations(puma_harmonics, ("D22", "D44", "c2", "c3", "h112")):
            for term in equation.terms:
                changed = abs(term.coefficient - without.get((equation.symbol, term.factors), 0.0)) > 1e-9
                assert changed == (s + 1 in term.links), (equation.symbol, term, s)


def symbols_of(harmonics: Harmonics, *labels: str) -> list[str]:
    return [equation.symbol for equation in equations(harmonics, labels)]


def test_labels(puma_harmonics):
    symbols = partial(symbols_of, puma_harmonics)
    assert symbols("D21") == symbols("D12") == ["D12"]
    assert symbols("D54") == ["D45"], "zero, but asked for"
    assert symbols("h131") == ["h113"]
    assert symbols("c") == ["c2", "c3", "c4", "c5"]
    assert symbols() == symbols("D") + symbols("h") + symbols("c")
    assert all(re.fullmatch(r"h1[1-6][1-6]", symbol) for symbol in symbols("h1"))
    assert set(symbols("h1")) < set(symbols("h"))
    assert symbols("c2", "D11") == ["c2", "D11"]
    assert [e.symbol for e in equations(puma_harmonics, "D11")] == ["D11"]


@pytest.mark.parametrize("label", ["", "D17", "D123", "d11", "D1,,2", "D¹¹"])
def test_labels_that_name_nothing(puma_harmonics, label):
    with pytest.raises(UsageError) as raised:
        equations(puma_harmonics, (label,))
    message = str(raised.value)
    assert repr(label) in message
    assert "D11 to D66" in message
    assert "next:" in message


def test_commas_part_indices_of_two_digits(rng):
    harmonics = harmonics_of(arm_of(["slides"] * 8 + ["askew", "same"], rng))
    symbols = partial(symbols_of, harmonics)
    assert symbols("D9,10") == ["D9,10"]
    assert symbols("D10,9") == ["D9,10"]
    assert symbols("D12") == symbols("D1,2") == symbols("D2,1") == ["D12"]
    assert symbols("c9", "c10") == ["c9", "c10"]
    assert symbols("h123") == symbols("h1,3,2") == ["h123"]
    assert {*symbols("h10")} <= {f"h10,{j},{k}" for j in range(1, 11) for k in range(j, 11)}
    assert len({*symbols("D")}) == len(symbols("D"))
    for label in ("D910", "D19,1", "h1110", "c1,0"):
        with pytest.raises(UsageError, match="commas separate indices of two digits"):
            equations(harmonics, (label,))


def test_units(stanford_harmonics):
    units = {equation.symbol: equation.unit for equation in equations(stanford_harmonics, EVERYTHING)}
    assert (units["D11"], units["D13"], units["D33"]) == ("kg m^2", "kg m", "kg")
    assert (units["c2"], units["c3"]) == ("N m", "N")
    assert (units["h112"], units["h113"], units["h311"]) == ("kg m^2", "kg m", "kg m")


@of_every_turn(chosen=(0, 3, 6))
@examples(15)
@given(
    (arms(max_joints=4) | arms_with_runs(max_joints=5)).filter(lambda arm: arm.mass.any()),
    st.tuples(*[st.integers(0, 7)] * 3),
)
def test_single_elements_are_those_of_the_whole(arm, chosen):
    i, j, k = (1 + joint % arm.n_joints for joint in chosen)
    harmonics = harmonics_of(arm)
    for label in (f"D{i}{j}", f"h{i}{j}{k}", f"c{i}"):
        (one,), (other,) = equations(arm, [label]), equations(harmonics, [label])
        assert one.symbol == other.symbol
        weights = {term.factors: term.coefficient for term in other.terms}
        assert {term.factors for term in one.terms} == {*weights}
        # On a grid of another size numbers are rounded in another order, by far less than counts as noise.
        apart = [abs(term.coefficient - weights[term.factors]) for term in one.terms]
        assert max(apart, default=0.0) <= max(harmonics.noise)


@pytest.mark.slow
def test_outer_elements_of_an_arm_whose_whole_takes_too_much_memory(rng):
    arm = arm_of(["askew"] * 12, rng)
    with pytest.raises(ArmError, match=r"takes too much memory") as raised:
        equations(arm, ["D12"])
    # D33 depends on nine angles, 5^9 positions, and D22 on ten: 20 and 22 numbers at each are 0.3 and 1.7 GB.
    assert "found: 12 joints: values on a grid of 9.38 GB" in str(raised.value)
    assert "next: elements from D33 on, and c, are possible;" in str(raised.value)
    (equation,) = equations(arm, ["D10,11"])
    # Of the angles of joints 11 and 12 only: at most 25 products.
    assert 0 < len(equation.terms) <= 25
