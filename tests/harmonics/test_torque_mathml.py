"""MathML read back as text says what the text form says."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from gd_analyze.harmonics import Harmonics, harmonics_of
from gd_analyze.harmonics.equations import equations
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.rendering import to_text
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.torque_mathml import (
    element_mathml,
    energy_term_mathml,
    torque_legend_mathml,
    torque_term_mathml,
    torques_to_mathml,
)
from gd_analyze.harmonics.torque_rendering import energy_term_text, torque_term_text, torques_to_text
from gd_analyze.robots import load_arm

ARMS = ("puma560", "stanford", "two_link")
DOTTED = {("p", "˙"): "p", ("p", "¨"): "pd", ("q", "˙"): "qd", ("q", "¨"): "qdd"}


def read(node: ElementTree.Element) -> str:
    """One formula as the text form has it, without spaces."""
    children = [read(child) for child in node]
    if node.tag == "mover":
        return DOTTED[children[0], children[1]]
    if node.tag == "msubsup":
        assert children[2] == "2"
        return f"{children[0]}{children[1]}²"
    if node.tag == "msup":
        return f"e{children[1]}" if children[0] == "10" else f"{children[0]}²"
    shown = (node.text or "") + "".join(children)
    return {"−": "-", "·": "", "τ": "tau", "\u2061": ""}.get(shown, shown)


def text(mathml: str) -> str:
    return re.sub(r"\s", "", read(ElementTree.fromstring(mathml)))


def squeezed(line: str) -> str:
    return re.sub(r"\s", "", line)


@pytest.fixture(scope="module", params=ARMS)
def harmonics(request: pytest.FixtureRequest) -> Harmonics:
    return harmonics_of(load_arm(request.param))


@pytest.fixture(scope="module")
def torques(harmonics: Harmonics) -> Torques:
    return torques_of_energies(energy_terms(harmonics), harmonics.rates)


def test_torques_read_as_their_text(harmonics: Harmonics, torques: Torques) -> None:
    written = torques_to_mathml(harmonics.rates, torques)
    plain = torques_to_text(harmonics.rates, torques)
    for joint, line in zip(written, plain, strict=True):
        pieces = [text(piece) for share in joint.shares for piece in share.pieces]
        assert text(joint.left) + "".join(pieces) == squeezed(line)
    assert [share.quantity for share in written[0].shares][-1] in ("coriolis_centrifugal", "gravity_loading")


def test_no_terms_are_a_zero(harmonics: Harmonics) -> None:
    last = torques_to_mathml(harmonics.rates, {})[-1]
    assert [text(piece) for share in last.shares for piece in share.pieces] == ["0"]


def test_single_terms_read_as_their_text(harmonics: Harmonics, torques: Torques) -> None:
    for term, weight in torques.items():
        assert text(torque_term_mathml(term, weight)) == squeezed(torque_term_text(term, weight))
    for energy, weight in energy_terms(harmonics).items():
        assert text(energy_term_mathml(energy, weight)) == squeezed(energy_term_text(energy, weight))


def test_elements_read_as_their_text(harmonics: Harmonics) -> None:
    for equation in equations(harmonics, ("D", "c", "h")):
        left, terms = element_mathml(equation)
        assert text(left) + "".join(map(text, terms)) == squeezed(to_text(equation))
        assert len(terms) == len(equation.terms)


def test_the_legend_names_every_shared_rate(harmonics: Harmonics, torques: Torques) -> None:
    legend = [text(meaning) for meaning in torque_legend_mathml(harmonics.rates, torques)]
    for run in harmonics.rates.runs:
        for place, joint in enumerate(run[1:], start=2):
            parts = "+".join(f"qdd{j + 1}" for j in run[:place])
            assert f"pdd{joint + 1}={parts}".replace("pdd", "pd") in legend
    assert any(meaning.startswith("C") and "=cos(" in meaning for meaning in legend)
