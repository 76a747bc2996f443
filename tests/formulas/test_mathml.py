"""MathML read back says what the plain form says."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.languages import MathML, PageMathML, Plain
from gd_analyze.formulas.writing import (
    element_formula,
    energy_formulas,
    part_symbol,
    parts_formulas,
    term_formula,
    torque_formulas,
    torque_legend,
)
from gd_analyze.harmonics.equations import equations
from gd_analyze.harmonics.lagrangian import energy_terms
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.transform import Harmonics

DOTTED = {("p", "˙"): "p", ("p", "¨"): "pd", ("q", "˙"): "qd", ("q", "¨"): "qdd"}
PAGE, PLAIN = PageMathML(), Plain()


def read(node: ElementTree.Element) -> str:
    """One formula as the plain form has it, without spaces."""
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


def plainly(mathml: str) -> str:
    return squeezed(read(ElementTree.fromstring(mathml)))


def squeezed(line: str) -> str:
    return re.sub(r"\s", "", line)


def assert_reads_as_plain(formula: Formula) -> None:
    assert plainly(PAGE.left(formula)) + "".join(map(plainly, PAGE.elements(formula))) == squeezed(
        PLAIN.line(formula)
    )
    assert plainly(PAGE.line(formula)) == plainly(MathML().line(formula)) == squeezed(PLAIN.line(formula))


def test_torques_read_as_their_plain_form(harmonics: Harmonics, torques: Torques) -> None:
    for formula in torque_formulas(harmonics.velocities, torques):
        assert_reads_as_plain(formula)


def test_no_terms_are_a_zero(harmonics: Harmonics) -> None:
    last = torque_formulas(harmonics.velocities, {})[-1]
    assert [*map(plainly, PAGE.elements(last))] == ["0"]


def test_single_terms_and_energies_read_as_their_plain_form(harmonics: Harmonics, torques: Torques) -> None:
    energies = energy_terms(harmonics)
    for term, weight in (*torques.items(), *energies.items()):
        assert_reads_as_plain(term_formula(term, weight))
    for formula in energy_formulas(energies):
        assert_reads_as_plain(formula)


def test_elements_read_as_their_plain_form(harmonics: Harmonics) -> None:
    for equation in equations(harmonics, ("D", "c", "h")):
        assert_reads_as_plain(element_formula(equation))
        assert len(PAGE.elements(element_formula(equation))) == len(equation.terms)


def test_the_legend_names_every_shared_rate(harmonics: Harmonics, torques: Torques) -> None:
    legend = [*map(plainly, PAGE.legend(torque_legend(harmonics.velocities, torques)))]
    for run in harmonics.velocities.runs:
        for place, joint in enumerate(run[1:], start=2):
            same = {
                j: harmonics.velocities.signs[j] == harmonics.velocities.signs[joint] for j in run[:place]
            }
            parts = "".join(f"{'+' if same[j] else '-'}qdd{j + 1}" for j in run[:place])
            assert f"pd{joint + 1}={parts.removeprefix('+')}" in legend
    assert any(meaning.startswith("C") and "=cos(" in meaning for meaning in legend)


def test_parts_of_elements_with_drives() -> None:
    kept = {"D11": "both", "D12": "translation", "D22": "neither", "h1": "neither", "h2": "rotation"}
    kept |= {"c1": "translation", "c2": "neither"}
    first, second = (PLAIN.line(formula) for formula in parts_formulas(kept, 2, drives=True))
    assert first == "tau1 = (D11 + J1) qdd1 + D12^tran qdd2 + c1"
    assert second == "tau2 = D12^tran qdd1 + J2 qdd2 + h2^rot"
    assert PLAIN.right(parts_formulas(dict.fromkeys(kept, "neither"), 2, drives=False)[0]) == "0"
    assert "<mtext>tran</mtext>" in PAGE.symbol(part_symbol("D12", "translation"))
    assert "<mtext>" not in PAGE.symbol(part_symbol("c1", "translation"))
