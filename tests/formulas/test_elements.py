"""Exact elements in every language: as a person would write them, and with the values they have."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.formulas.equations_result import sympy_head, sympy_line
from gd_analyze.formulas.languages import Latex, MathML, Plain
from gd_analyze.formulas.printer import number, rounded
from gd_analyze.formulas.writing import element_formula, factor_legend, term_formula
from gd_analyze.harmonics.equations import Equation, Term, equations
from gd_analyze.harmonics.terms import EnergyTerm, Factor
from gd_analyze.harmonics.transform import Harmonics, harmonics_of
from gd_analyze.robots.catalogue import load_arm
from strategies import examples

EVERYTHING = ("D", "h", "c")


@pytest.fixture(scope="module")
def puma_harmonics() -> Harmonics:
    return harmonics_of(load_arm("puma560"))


@pytest.fixture(scope="module")
def stanford_harmonics() -> Harmonics:
    return harmonics_of(load_arm("stanford"))


def to_plain(equation: Equation, digits: int = 3, width: int | None = None) -> str:
    formula, plain = element_formula(equation), Plain(digits)
    return plain.line(formula) if width is None else plain.wrapped(formula, width)


def to_latex(equation: Equation) -> str:
    return Latex().line(element_formula(equation))


def to_mathml(equation: Equation) -> str:
    return MathML().line(element_formula(equation))


def legend(found: list[Equation] | tuple[Equation, ...]) -> tuple[str, ...]:
    factors = {factor for equation in found for term in equation.terms for factor in term.factors}
    return Plain().legend(factor_legend(factors))


GOLDEN = {
    "puma560": {
        "D11": "D11 = 1.84 + 1.6 C2² + 0.744 C2 S23 - 0.298 C23² - 0.022 C2 C23 - 0.0214 C23 S23",
        "D12": "D12 = 0.687 S2 - 0.133 C23 + 0.0237 C2",
        "D23": "D23 = 0.372 S3 + 0.334 - 0.011 C3",
        "D66": "D66 = 4e-5",
        "D45": "D45 = 0",
        "c2": "c2 = -37.2 C2 - 8.45 S23 + 1.02 S2",
        "h223": "h223 = 0.372 C3 + 0.011 S3",
        "h112": "h112 = -1.6 C2 S2 + 0.372 cos(2 q2 + q3) + 0.298 C23 S23",
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
    assert to_plain(equation).startswith(GOLDEN[arm][label])


PLAIN = Factor("cos", (0, 1, 1))
SUM = Factor("sin", (0, 2, -1))
SLIDE = Factor("power", (1, 0, 0))


def term(coefficient: float, *factors: Factor) -> Term:
    return Term(coefficient, factors, "translation", coefficient, 0.0, (1,), 1.0)


HAND_MADE = Equation(
    "h112",
    "kg m^2",
    (term(-1.0, PLAIN), term(5.849e-5, SLIDE, SLIDE, SUM, SUM), term(-1.0), term(123456.0, SLIDE, SLIDE)),
)


def test_plain():
    assert to_plain(HAND_MADE) == "h112 = -C23 + 5.85e-5 d1² sin²(2 q2 - q3) - 1 + 123000 d1²"
    assert to_plain(HAND_MADE, digits=1) == "h112 = -C23 + 6e-5 d1² sin²(2 q2 - q3) - 1 + 100000 d1²"
    assert to_plain(Equation("D12", "kg", ())) == "D12 = 0"


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


@pytest.mark.parametrize("name", ["two_link", "stanford", "puma560"])
def test_a_script_of_sympy_is_the_exact_form(name, rng):
    sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install 'gd-analyze[symbolic]'")
    arm = load_arm(name)
    harmonics = harmonics_of(arm)
    q = rng.uniform(-3.0, 3.0, (arm.n_joints, 20))
    symbols = sympy.symbols([f"q{j + 1}" for j in range(arm.n_joints)], real=True)
    for equation in equations(harmonics, ("D", "c")):
        indices = tuple(int(digit) - 1 for digit in equation.symbol[1:])
        is_inertia = equation.symbol[0] == "D"
        parts = harmonics.inertia[indices] if is_inertia else harmonics.gravity_loading[indices[0]]
        scope: dict[str, object] = {}
        exec(sympy_head(arm.n_joints) + sympy_line(equation), scope)
        found = sympy.lambdify(symbols, scope[equation.symbol], "numpy")(*q)
        # Both sum the same some 20 terms in another form.
        allowed = 100 * np.finfo(float).eps * np.abs(parts.coefficients).sum() + 10 * max(harmonics.noise)
        assert np.abs(found - parts(q).sum(axis=0)).max() <= allowed


def test_a_script_of_sympy_may_be_long(rng):
    """A plain sum of so many terms would overflow Python's parser."""
    many = tuple(
        term(float(weight), Factor("cos", (k, -1, 1)), Factor("sin", (1, 1, 0)))
        for k, weight in enumerate(rng.normal(size=20_000))
    )
    compile(sympy_head(3) + sympy_line(Equation("D2,11", "kg m^2", many)), "script", "exec")


def test_legend(puma_harmonics, stanford_harmonics):
    assert legend(equations(puma_harmonics)) == ("C23 = cos(q2 + q3)", "S23 = sin(q2 + q3)")
    assert legend(equations(stanford_harmonics, ("c2",)))[-1] == "d3 = q3 in m"
    assert legend([Equation("D66", "kg m^2", (term(1.0),))]) == ()


def test_indices_of_two_digits_are_parted() -> None:
    far = Factor("cos", (0,) * 8 + (1, 1))
    equation = Equation("D1,10", "kg m^2", (term(2.0, far),))
    assert to_plain(equation) == "D1,10 = 2 C9,10"
    assert to_latex(equation) == r"D_{1,10} = 2 \, C_{9,10}"
    assert legend([equation]) == ("C9,10 = cos(q9 + q10)",)
    labels = [
        Plain().symbol(term_formula(EnergyTerm(i, j, ()), 1.0).left) for i, j in ((0, 11), (10, 1), (0, 1))
    ]
    assert labels == ["D'1,12", "D'11,2", "D'12"]


@examples(60)
@given(st.floats(1e-12, 1e12), st.integers(1, 17))
def test_rounded_numbers(value, digits):
    mantissa, exponent = rounded(value, digits)
    shown = float(f"{mantissa}e{exponent}")
    # Half a unit in the last digit shown.
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    assert abs(shown - value) <= 0.5 * unit * (1 + 1e-9) + np.finfo(float).eps * value
    assert float(number(-value, digits)) == -shown
    assert not (mantissa.endswith("0") and "." in mantissa)
