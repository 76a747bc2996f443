"""Squares in one form: the same numbers, no two forms side by side, and a part is written as the whole is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.harmonics.squares import Squares
from gd_analyze.harmonics.terms import Factor, Monomial, TorqueTerm, Velocity
from printed_equations import without_form
from strategies import examples

FUNCTIONS = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
ANGLES = [(1, 0, 0), (0, 1, 0), (1, 1, 0)]


def value(monomial: Monomial, q: np.ndarray) -> np.ndarray:
    return np.prod([FUNCTIONS[kind](np.array(m) @ q) for kind, m in monomial], axis=0) * np.ones(q.shape[1])


@st.composite
def sums(draw: st.DrawFn) -> dict[TorqueTerm, float]:
    """Terms of one row with squares and double angles, and a slide; up to two angles in each."""
    out = {}
    for _ in range(draw(st.integers(1, 12))):
        factors: list[Factor] = [Factor("power", (0, 0, 1))] * draw(st.integers(0, 1))
        for angle in draw(st.lists(st.sampled_from(ANGLES), max_size=2, unique=True)):
            doubled = tuple(2 * multiple for multiple in angle)
            cosine, sine = Factor("cos", angle), Factor("sin", angle)
            forms = [(cosine,), (sine,), (cosine, cosine), (sine, sine), (cosine, sine)]
            forms += [(Factor("cos", doubled),), (Factor("sin", doubled),)]
            factors += draw(st.sampled_from(forms))
        moving = draw(st.sampled_from([(), (Velocity(1, 0), Velocity(1, 0))]))
        out[TorqueTerm(0, moving, tuple(sorted(factors)))] = draw(
            st.sampled_from([-2.0, -1.0, 0.5, 1.0, 3.0])
        )
    return out


@examples(200)
@given(sums(), st.integers(0, 2**32 - 1))
def test_the_form_has_the_same_values_and_no_squares_side_by_side(torques, seed):
    squares, rng = Squares.of(torques), np.random.default_rng(seed)
    written, q = squares.sum(torques), rng.uniform(-3.0, 3.0, (3, 20))
    for moving in {term.velocities for term in torques}:
        there, here = (
            sum(
                weight * value(term.monomial, q)
                for term, weight in terms.items()
                if term.velocities == moving
            )
            for terms in (torques, written)
        )
        # A dozen terms of size up to 3 * 3, each written as up to four.
        assert np.abs(there - here).max() < 1e-12
        assert not without_form({term.monomial for term in written if term.velocities == moving})
    # Written once more nothing changes.
    again = squares.sum(written)
    assert again.keys() == written.keys()
    # A part is written with terms that parts of the whole have.
    part = {term: weight for term, weight in torques.items() if rng.random() < 0.5}
    possible = {new for term in torques for new in squares.written(term)}
    assert squares.sum(part).keys() <= possible


def test_squares_that_stand_alone_stay():
    sine, cosine = Factor("sin", (1,)), Factor("cos", (1,))
    double = Factor("cos", (2,))

    def written(*monomials: Monomial) -> dict[Monomial, float]:
        terms = {TorqueTerm(0, (), monomial): 1.0 for monomial in monomials}
        return {term.monomial: weight for term, weight in Squares.of(terms).sum(terms).items()}

    assert written((sine, sine)) == {(sine, sine): 1.0}
    assert written((double,)) == {(double,): 1.0}
    assert written((Factor("sin", (2,)),)) == {(cosine, sine): 2.0}
    assert written((sine, sine), ()) == {(): 2.0, (cosine, cosine): -1.0}
    assert written((double,), (cosine, cosine)) == {(): -1.0, (cosine, cosine): 3.0}
    assert written((sine, sine), (cosine, cosine)) == {(): 1.0}


@pytest.mark.parametrize("name", ["puma560", "stanford", "scara"])
def test_equations_have_one_form_of_squares(name):
    for equation in gd.equations(name):
        assert not without_form({term.factors for term in equation.terms}), equation.symbol
