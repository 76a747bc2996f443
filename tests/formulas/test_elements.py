"""Exact elements: as a person would write them, and with the values they have."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze import equations
from gd_analyze.formulas.languages import LatexPrinter, Plain, formatted, rounded
from gd_analyze.formulas.results import sympy_head, sympy_line
from gd_analyze.formulas.writing import element_formula, factor_legend
from gd_analyze.harmonics.equations import Equation, EquationTerm
from gd_analyze.harmonics.terms import Factor
from strategies import examples

GOLDEN = {
    "puma560": (
        "D11 = 1.84 + 1.6 C2² + 0.744 C2 S23 - 0.298 C23² - 0.022 C2 C23 - 0.0214 C23 S23",
        "D23 = 0.372 S3 + 0.334 - 0.011 C3",
        "D66 = 4e-5",
        "D45 = 0",
        "c2 = -37.2 C2 - 8.45 S23 + 1.02 S2",
        "h112 = -1.6 C2 S2 + 0.372 C2 C23 - 0.372 S2 S23 + 0.298 C23 S23",
    ),
    "stanford": ("D11 = 6.47 S2² d3² - 5.5 S2² d3 + 2.99 - 2.5 C2²", "c3 = 63.4 C2", "c1 = 0"),
    "two_link": ("D11 = 2 + C2", "D12 = 0.5 C2 + 0.333", "h112 = -0.5 S2", "c1 = 19.6 C1 + 4.9 C12"),
}


def plain_of(equation: Equation) -> str:
    return Plain().line(element_formula(equation))


def legend_of(*found: Equation) -> tuple[str, ...]:
    factors = {factor for equation in found for term in equation.terms for factor in term.factors}
    return Plain().legend(factor_legend(factors))


@pytest.mark.parametrize("name", GOLDEN)
def test_as_a_person_would_write_it(name):
    arm = gd.load_arm(name)
    labels = [line.partition(" ")[0] for line in GOLDEN[name]]
    found = {equation.symbol: equation for equation in equations(arm, labels)}
    for label, line in zip(labels, GOLDEN[name], strict=True):
        assert plain_of(found[label]).startswith(line)
    expected = {"puma560": "C23 = cos(q2 + q3)", "stanford": "d3 = q3 in m", "two_link": "C12 = cos(q1 + q2)"}
    assert expected[name] in legend_of(*found.values())


def term(coefficient: float, *factors: Factor) -> EquationTerm:
    return EquationTerm(coefficient, factors, "translation", coefficient, 0.0, (1,), 1.0)


PLAIN, SUM, SLIDE = Factor("cos", (0, 1, 1)), Factor("sin", (0, 2, -1)), Factor("power", (1, 0, 0))
FAR = Factor("cos", (0,) * 8 + (1, 1))


def test_plain_and_latex():
    terms = (term(-1.0, PLAIN), term(5.849e-5, SLIDE, SLIDE, SUM, SUM), term(-1.0), term(123456.0, SLIDE))
    equation, far = Equation("h112", "kg m^2", terms), Equation("D1,10", "kg m^2", (term(2.0, FAR),))
    assert plain_of(equation) == "h112 = -C23 + 5.85e-5 d1² sin²(2 q2 - q3) - 1 + 123000 d1"
    powers = r"5.85 \cdot 10^{-5} \, d_{1}^{2} \, \sin^{2}(2 q_{2} - q_{3})"
    assert (
        LatexPrinter().line(element_formula(equation))
        == rf"h_{{112}} = -C_{{23}} + {powers} - 1 + 123000 \, d_{{1}}"
    )
    assert (plain_of(far), *legend_of(far)) == ("D1,10 = 2 C9,10", "C9,10 = cos(q9 + q10)")


@pytest.mark.parametrize("name", ["two_link", "stanford", "puma560"])
def test_a_script_of_sympy_is_the_exact_form(name, rng):
    sympy = pytest.importorskip("sympy", reason="needs SymPy: pip install sympy")
    arm = gd.load_arm(name)
    harmonics = gd.tables.harmonics_of(arm)
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


def test_a_script_of_sympy_may_be_long():
    """A plain sum of so many terms would overflow Python's parser."""
    many = tuple(term(float(k), Factor("cos", (k, -1, 1)), Factor("sin", (1, 1, 0))) for k in range(5_000))
    compile(sympy_head(3) + sympy_line(Equation("D2,11", "kg m^2", many)), "script", "exec")


@examples(60)
@given(st.floats(1e-12, 1e12), st.integers(1, 17))
def test_rounded_numbers(value, digits):
    mantissa, exponent = rounded(value, digits)
    shown = float(f"{mantissa}e{exponent}")
    # Half a unit in the last digit shown.
    unit = 10.0 ** (math.floor(math.log10(value)) - digits + 1)
    assert abs(shown - value) <= 0.5 * unit * (1 + 1e-9) + np.finfo(float).eps * value
    assert float(formatted(-value, digits)) == -shown
    assert not (mantissa.endswith("0") and "." in mantissa)
