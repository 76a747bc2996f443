"""The two-link arm of the text, worked in symbols by every formulation's own code."""

from __future__ import annotations

import dataclasses
import sys

import numpy as np
import pytest
import sympy

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.errors import UsageError
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies.symbolic import same, text_closed_forms, two_link_closed_forms


@pytest.mark.parametrize("method", list(METHODS))
def test_every_formulation_gives_the_texts_closed_forms_exactly(method):
    found, text = two_link_closed_forms(method), text_closed_forms()
    for part in ("inertia", "coriolis_centrifugal", "gravity_loading"):
        difference = (getattr(found, part) - getattr(text, part)).applyfunc(sympy.simplify)
        assert difference == sympy.zeros(*difference.shape)
        assert not getattr(found, part).atoms(sympy.Float)
    assert same(found, text)


def test_another_form_is_not_the_texts():
    text = text_closed_forms()
    assert not same(dataclasses.replace(text, gravity_loading=2 * text.gravity_loading), text)


def test_the_text_is_the_built_in_arm():
    """The closed forms with the arm's numbers put in are its numeric dynamics."""
    arm = load_arm("two_link")
    q, qd = np.array([[0.3], [-0.8]]), np.array([[1.2], [0.7]])
    numeric = METHODS["composite_moments"].dynamics(arm, q, qd)
    values = dict(zip(("theta1", "theta2", "thetad1", "thetad2"), (*q[:, 0], *qd[:, 0]), strict=True))
    values |= {"m1": arm.mass[0], "m2": arm.mass[1], "l": arm.dh_table[0].a, "g": -arm.gravity[1]}
    text = text_closed_forms()
    numbers = {
        symbol: values[symbol.name]
        for part in (text.inertia, text.coriolis_centrifugal, text.gravity_loading)
        for symbol in part.free_symbols
    }
    for wanted, found in (
        (text.inertia, numeric.inertia[..., 0]),
        (text.coriolis_centrifugal, numeric.coriolis_centrifugal),
        (text.gravity_loading, numeric.gravity_loading),
    ):
        expected = np.array(wanted.subs(numbers).tolist(), dtype=float)
        # Some twenty roundings of numbers no larger than the largest element.
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.abs(expected).max())


def test_an_unknown_method_is_refused():
    with pytest.raises(UsageError, match="no formulation 'kane'"):
        two_link_closed_forms("kane")


def test_without_sympy_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(UsageError, match=r"gd-analyze\[symbolic\]"):
        text_closed_forms()
