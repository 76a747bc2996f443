"""Equations: read exactly, told apart by effect and link, written in four languages."""

from __future__ import annotations

import dataclasses
import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from harmonic_arms import arm_of, arms_with_runs, states_of
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import UsageError
from gd_analyze.harmonics import AbsoluteRates, Waves, harmonics_of
from gd_analyze.harmonics.conversion import to_terms, to_waves
from gd_analyze.harmonics.equations import Equation, Term, equations
from gd_analyze.harmonics.rendering import legend, number, rounded, to_latex, to_mathml, to_sympy, to_text
from gd_analyze.harmonics.terms import Factor, Monomial
from gd_analyze.robots import load_arm
from gd_analyze.vectors import FloatArray
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
            parts, noise = harmonics.coupling(*indices), 2 * harmonics.noise[0]
        else:
            parts, noise = harmonics.gravity_loading[indices[0]], harmonics.noise[1]
        values = parts(q)
        written = sum(term.coefficient * value(term.factors, q) for term in equation.terms)
        # Weights within twice the noise are taken for equal, and products below it left out: once per
        # product, of which a wave makes at most 2^(runs - 1), and run. The rest is a rounding per operation.
        count = 2 ** len(harmonics.rates.runs) * len(parts)
        size = float(np.abs(parts.coefficients).sum())
        allowed = 2 * noise * count * len(harmonics.rates.runs) + 10 * count * np.finfo(float).eps * size
        assert np.abs(values.sum(axis=0) - written).max() <= allowed, equation.symbol
        # By effect as well, where a term may have nothing left in the whole.
        rows = to_terms(Waves.stacked([parts.total(), parts]), harmonics.rates, noise, deciding=3)
        for k, exact in enumerate(values):
            written = sum(row[1 + k] * value(factors, q) for factors, row in rows.items())
            assert np.abs(exact - written).max() <= allowed, (equation.symbol, k)


@examples(40)
@given(arms(max_joints=4, massive=True), st.integers(0, 2**32 - 1))
def test_reading_is_exact_for_arms_of_every_make(arm, seed):
    assert_read_exactly(arm, seed)


@examples(40)
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
    rows = to_terms(to_waves([polynomial], [False, False]), AbsoluteRates.of(arm), noise=1e-14)
    written = sum(row[0] * value(factors, q) for factors, row in rows.items())
    exact = sum(weight * value(factors, q) for factors, weight in polynomial.items())
    # Twenty roundings of values near 6.
    assert np.abs(written - exact).max() < 20 * np.finfo(float).eps * 6


def test_effects_and_shares_add_up(puma_harmonics):
    for equation in equations(puma_harmonics, EVERYTHING):
        assert equation.terms
        assert equation.terms[0].share == 1.0
        shares = [term.share for term in equation.terms]
        assert shares == sorted(shares, reverse=True)
        for term in equation.terms:
            # One rounding of the sum, one of what was turned into products.
            assert term.coefficient == pytest.approx(term.translation + term.rotation, rel=1e-9)
            assert term.links
            assert {"translation": (True, False), "rotation": (False, True), "both": (True, True)}[
                term.effect
            ] == tuple(abs(part) > 1e-9 for part in (term.translation, term.rotation))


def test_links_are_those_whose_removal_changes_the_term(puma, puma_harmonics):
    """Without mass and inertia of a link exactly the terms that name it change."""
    for s in (1, 2, 5):
        weightless = dataclasses.replace(
            puma.links[s], mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))
        )
        links = (*puma.links[:s], weightless, *puma.links[s + 1 :])
        without = {
            (equation.symbol, term.factors): term.coefficient
            for equation in equations(dataclasses.replace(puma, links=links), EVERYTHING)
            for term in equation.terms
        }
        for equation in equations(puma_harmonics, ("D22", "D44", "c2", "c3", "h112")):
            for term in equation.terms:
                changed = abs(term.coefficient - without.get((equation.symbol, term.factors), 0.0)) > 1e-9
                assert changed == (s + 1 in term.links), (equation.symbol, term, s)


GOLDEN = {
    "puma560": {
        "D11": "D11 = 1.87 + 1.6 C2² + 0.771 C2 S23 - 0.325 C23² - 0.0226 C23 S23 - 0.022 C2 C23",
        "D12": "D12 = 0.687 S2 - 0.138 C23 + 0.0237 C2",
        "D23": "D23 = 0.386 S3 + 0.361 - 0.011 C3",
        "D66": "D66 = 4e-5",
        "D45": "D45 = 0",
        "c2": "c2 = -37.2 C2 - 8.76 S23 + 1.02 S2",
        "h223": "h223 = 0.386 C3 + 0.011 S3",
        "h112": "h112 = -1.6 C2 S2 + 0.386 cos(2 q2 + q3) + 0.325 C23 S23",
    },
    "stanford": {
        "D11": "D11 = 6.47 S2² d3² - 5.5 S2² d3 + 2.99 - 2.5 C2²",
        "c2": "c2 = -63.4 S2 d3 + 27 S2",
        "c3": "c3 = 63.4 C2",
        "c1": "c1 = 0",
    },
    "two_link": {
        "D11": "D11 = 2 + C2",
        "D12": "D12 = 0.5 C2 + 0.333",
        "h112": "h112 = -0.5 S2",
        "c1": "c1 = 19.6 C1 + 4.9 C12",
    },
}


@pytest.mark.parametrize(("arm", "label"), [(arm, label) for arm in GOLDEN for label in GOLDEN[arm]])
def test_as_a_person_would_write_it(arm, label):
    (equation,) = equations(load_arm(arm), (label,))
    assert to_text(equation).startswith(GOLDEN[arm][label])


def test_labels(puma_harmonics):
    def symbols(*labels: str) -> list[str]:
        return [equation.symbol for equation in equations(puma_harmonics, labels)]

    assert symbols("D21") == symbols("D12") == ["D12"]
    assert symbols("D54") == ["D45"], "zero, but asked for"
    assert symbols("h131") == ["h113"]
    assert symbols("c") == ["c2", "c3", "c4", "c5"]
    assert symbols() == symbols("D") + symbols("c")
    assert all(re.fullmatch(r"h1[1-6][1-6]", symbol) for symbol in symbols("h1"))
    assert set(symbols("h1")) < set(symbols("h"))
    assert symbols("c2", "D11") == ["c2", "D11"]
    assert [e.symbol for e in equations(puma_harmonics, "D11")] == ["D11"]


@pytest.mark.parametrize(
    "label",
    [
        "",
        "x",
        "D1",
        "D17",
        "D01",
        "D123",
        "c11",
        "c7",
        "h12",
        "h117",
        "d11",
        "D1,,2",
        "D,1",
        "D1,2,",
        "D¹¹",
    ],
)
def test_labels_that_name_nothing(puma_harmonics, label):
    with pytest.raises(UsageError) as raised:
        equations(puma_harmonics, (label,))
    message = str(raised.value)
    assert f"there is no element {label!r}" in message
    assert "D11 to D66" in message
    assert "next:" in message


def test_ten_joints_need_commas(rng):
    arm = arm_of(["slides"] * 8 + ["askew", "same"], rng)
    harmonics = harmonics_of(arm)
    (equation,) = equations(harmonics, ("D9,10",))
    assert equation.symbol == "D9,10"
    (gravity,) = equations(harmonics, ("c9",))
    assert gravity.symbol == "c9"
    assert "C9,10" in to_text(gravity)
    assert "C_{9,10}" in to_latex(gravity)
    assert legend([gravity])[0] == "C9,10 = cos(q9 + q10)"
    with pytest.raises(UsageError, match="parted by commas"):
        equations(harmonics, ("D910",))


def test_min_share_leaves_small_terms_out(puma_harmonics):
    (whole,) = equations(puma_harmonics, ("D11",))
    (cut,) = equations(puma_harmonics, ("D11",), min_share=0.01)
    assert cut.terms == tuple(term for term in whole.terms if term.share >= 0.01)
    assert 0 < len(cut.terms) < len(whole.terms)


def test_a_share_counts_how_far_a_joint_slides(stanford_harmonics):
    arm = stanford_harmonics.arm
    farthest = max(abs(arm.joints[2].lower), abs(arm.joints[2].upper))
    (equation,) = equations(stanford_harmonics, ("D22",))
    sizes = {
        term.factors: abs(term.coefficient) * farthest ** sum(f.kind == "power" for f in term.factors)
        for term in equation.terms
    }
    for term in equation.terms:
        assert term.share == pytest.approx(sizes[term.factors] / max(sizes.values()), rel=1e-15)


def test_units(stanford_harmonics):
    units = {equation.symbol: equation.unit for equation in equations(stanford_harmonics, EVERYTHING)}
    assert (units["D11"], units["D13"], units["D33"]) == ("kg m^2", "kg m", "kg")
    assert (units["c2"], units["c3"]) == ("N m", "N")
    assert (units["h112"], units["h113"], units["h311"]) == ("kg m^2", "kg m", "kg m")


def test_an_arm_is_identified_on_the_way(two_link):
    assert gd.equations(two_link) == equations(gd.harmonics_of(two_link))


PLAIN = Factor("cos", (0, 1, 1))
SUM = Factor("sin", (0, 2, -1))
SLIDE = Factor("power", (1, 0, 0))


def term(coefficient: float, *factors: Factor) -> Term:
    return Term(coefficient, factors, "translation", coefficient, 0.0, (1,), 1.0)


HAND_MADE = Equation(
    "h112",
    "kg m^2",
    (
        term(-1.0, PLAIN),
        term(5.849e-5, SUM, SUM, SLIDE, SLIDE),
        term(-1.0),
        term(123456.0, SLIDE, SLIDE),
    ),
)


def test_text():
    assert to_text(HAND_MADE) == "h112 = -C23 + 5.85e-5 d1² sin²(2 q2 - q3) - 1 + 123000 d1²"
    assert to_text(HAND_MADE, digits=1) == "h112 = -C23 + 6e-5 d1² sin²(2 q2 - q3) - 1 + 100000 d1²"
    assert to_text(Equation("D12", "kg", ())) == "D12 = 0"


def test_text_breaks_between_terms_with_a_hanging_indent(puma_harmonics):
    for equation in equations(puma_harmonics, EVERYTHING):
        lines = to_text(equation, width=80).splitlines()
        assert max(map(len, lines)) <= 80
        start = " " * len(f"{equation.symbol} = ")
        assert all(re.match(start + "[+-] ", line) for line in lines[1:])
        assert " ".join(line.strip() for line in lines) == to_text(equation)
    assert len(to_text(HAND_MADE, width=10).splitlines()) == 4


def test_latex():
    assert to_latex(HAND_MADE) == (
        r"h_{112} = -C_{23} + 5.85 \cdot 10^{-5} \, d_{1}^{2} \, \sin^{2}(2 q_{2} - q_{3})"
        r" - 1 + 123000 \, d_{1}^{2}"
    )
    assert to_latex(Equation("c1", "N m", ())) == "c_{1} = 0"


def test_latex_and_mathml_of_everything_are_well_formed(puma_harmonics, stanford_harmonics):
    for harmonics in (puma_harmonics, stanford_harmonics):
        for equation in equations(harmonics, EVERYTHING):
            text = to_latex(equation)
            depth = 0
            for letter in text:
                depth += {"{": 1, "}": -1}.get(letter, 0)
                assert depth >= 0
            assert depth == 0
            assert text.isascii()
            assert set(re.findall(r"\\[a-z]+", text)) <= {r"\cdot", r"\cos", r"\sin"}
            tree = ET.fromstring(to_mathml(equation))
            assert tree.tag == "math"
            assert len(tree.findall("./mrow/mo")) >= len(equation.terms)
            for node in tree.iter():
                # MathML fixes how many children these have.
                wanted = {"msub": 2, "msup": 2, "msubsup": 3}.get(node.tag)
                assert wanted is None or len(node) == wanted


def test_mathml_reads_as_the_text_does():
    shown = "".join(ET.fromstring(to_mathml(HAND_MADE)).itertext())
    assert shown == "h112=−C23+5.85·10−5d12sin2\u2061(2q2−q3)−1+123000d12"


@pytest.mark.parametrize("name", ["two_link", "stanford", "puma560"])
def test_sympy_is_the_waves(name):
    sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install 'gd-analyze[symbolic]'")
    arm = load_arm(name)
    harmonics = harmonics_of(arm)
    q = states_of(arm, 20, 7).q.T
    symbols = sympy.symbols([f"q{j + 1}" for j in range(arm.n_joints)], real=True)
    for equation in equations(harmonics, ("D", "c")):
        indices = [int(digit) - 1 for digit in equation.symbol[1:]]
        parts = (
            harmonics.inertia[tuple(indices)]
            if equation.symbol[0] == "D"
            else harmonics.gravity_loading[indices[0]]
        )
        found = sympy.lambdify(symbols, to_sympy(equation), "numpy")(*q)
        # Both sum the same some 20 terms in another form.
        allowed = 100 * np.finfo(float).eps * np.abs(parts.coefficients).sum() + 10 * max(harmonics.noise)
        assert np.abs(found - parts(q).sum(axis=0)).max() <= allowed


def test_sympy_missing_is_said(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "sympy", None)
    with pytest.raises(UsageError, match="gd-analyze\\[symbolic\\]"):
        to_sympy(HAND_MADE)


def test_legend(puma_harmonics, stanford_harmonics):
    assert legend(equations(puma_harmonics)) == ("C23 = cos(q2 + q3)", "S23 = sin(q2 + q3)")
    assert legend(equations(stanford_harmonics, ("c2",)))[-1] == "d3 = q3 in m"
    assert legend([Equation("D66", "kg m^2", (term(1.0),))]) == ()


@examples(200)
@given(st.floats(1e-12, 1e12), st.integers(1, 17))
def test_rounded_numbers(value, digits):
    mantissa, exponent = rounded(value, digits)
    shown = float(f"{mantissa}e{exponent}")
    # Half a unit in the last digit shown.
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    assert abs(shown - value) <= 0.5 * unit * (1 + 1e-9) + np.finfo(float).eps * value
    assert float(number(-value, digits)) == -shown
    assert not (mantissa.endswith("0") and "." in mantissa)
