"""Formulas of every kind of arm: every term is there once, and all languages say what the plain form says."""

from __future__ import annotations

import re
from collections import Counter
from xml.etree import ElementTree

import pytest
import typst

import gd_analyze as gd
from gd_analyze import equations
from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.languages import LatexPrinter, MathML, PageMathML, Plain, Typst
from gd_analyze.formulas.writing import (
    element_formula,
    energy_formulas,
    part_symbol,
    parts_formulas,
    term_formula,
    torque_formulas,
    torque_legend,
)
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.transform import Harmonics
from parallel_axes import scara

DOTTED = {("p", "˙"): "pd", ("p", "¨"): "pdd", ("q", "˙"): "qd", ("q", "¨"): "qdd"}
PAGE, PLAIN, LATEX, TYPST = PageMathML(), Plain(), LatexPrinter(), Typst()


@pytest.fixture(scope="module", params=("two_link", "puma560", "stanford", "scara"))
def harmonics(request: pytest.FixtureRequest) -> Harmonics:
    return gd.tables.harmonics_of(scara() if request.param == "scara" else gd.load_arm(request.param))


@pytest.fixture(scope="module")
def torques(harmonics: Harmonics) -> Torques:
    return torques_of_energies(energy_terms(harmonics), harmonics.velocities)


@pytest.fixture(scope="module")
def formulas(harmonics: Harmonics, torques: Torques) -> list[Formula]:
    energies = energy_terms(harmonics)
    single = [term_formula(term, weight) for term, weight in (*torques.items(), *energies.items())]
    of_elements = map(element_formula, equations(harmonics, ("D", "c", "h")))
    nothing = torque_formulas(harmonics.velocities, {})
    whole = (*torque_formulas(harmonics.velocities, torques), *energy_formulas(energies))
    return [*whole, *single, *of_elements, *nothing]


def read(node: ElementTree.Element) -> str:
    """One formula as the plain form has it, without spaces."""
    children = [read(child) for child in node]
    # MathML fixes how many children these have.
    assert len(children) == {"msub": 2, "msup": 2, "msubsup": 3, "mover": 2}.get(node.tag, len(children))
    if node.tag == "mover":
        return DOTTED[children[0], children[1]]
    if node.tag == "msubsup":
        assert children[2] == "2"
        return f"{children[0]}{children[1]}²"
    if node.tag == "msup":
        return f"e{children[1]}" if children[0] == "10" else f"{children[0]}²"
    shown = (node.text or "") + "".join(children)
    return {"−": "-", "·": "", "τ": "tau", "\u2061": ""}.get(shown, shown)


def squeezed(line: str) -> str:
    return re.sub(r"\s", "", line)


def plainly(mathml: str) -> str:
    return squeezed(read(ElementTree.fromstring(mathml)))


def test_mathml_reads_as_the_plain_form(formulas):
    for formula in formulas:
        plain = squeezed(PLAIN.line(formula))
        assert plainly(PAGE.left(formula)) + "".join(map(plainly, PAGE.elements(formula))) == plain
        assert plainly(PAGE.line(formula)) == plainly(MathML().line(formula)) == plain


def test_latex_is_closed_as_it_was_opened(formulas):
    for text in map(LATEX.line, formulas):
        depth = 0
        for letter in text:
            depth += {"{": 1, "}": -1}.get(letter, 0)
            assert depth >= 0
        assert depth == 0
        assert text.isascii()
        assert set(re.findall(r"\\[a-z]+", text)) <= {
            rf"\{x}" for x in ("cdot", "cos", "sin", "dot", "ddot", "tau")
        }


def test_typst_takes_all_of_it(harmonics, torques, formulas):
    written = [part for f in formulas for part in (TYPST.symbol(f.left), *map(TYPST.body, f.pieces))]
    written += [*map(TYPST.line, formulas), *TYPST.legend(torque_legend(harmonics.velocities, torques))]
    source = "\n\n".join(f"${piece}$" for piece in dict.fromkeys(written)).encode()
    _, warnings = typst.compile_with_warnings(source, ignore_system_fonts=True)
    assert warnings == []


def test_typst_side_by_side_with_the_plain_form():
    """Numbers, powers, indices and dots."""
    (inertia,) = map(element_formula, equations(gd.load_arm("stanford"), ("D11",)))
    assert TYPST.line(inertia).startswith("D_(11) = 6.47 thin S_(2)^2 thin d_(3)^2 - 5.5 thin S_(2)^2 thin")
    harmonics = gd.tables.harmonics_of(gd.load_arm("two_link"))
    torques = torques_of_energies(energy_terms(harmonics), harmonics.velocities)
    _, torque = torque_formulas(harmonics.velocities, torques)
    assert PLAIN.line(torque).startswith("tau2 = 0.5 C2 pdd1 + 0.333 pdd2 + 0.5 S2 pd1²")
    assert TYPST.line(torque).startswith("tau_(2) = 0.5 thin C_(2) thin dot.double(p)_(1) + 0.333 thin")


def test_brackets_multiply_out_to_the_terms(harmonics, torques):
    """With its bracket's sign and factors restored, every piece is one term with its weight and quantity."""
    for row, formula in enumerate(torque_formulas(harmonics.velocities, torques)):
        found, outer, inside = [], 1.0, []
        for piece in formula.pieces:
            if piece.quantity == "carried":
                continue
            weight, powers = piece.product
            if piece.opens:
                outer = 1.0 if weight > 0 else -1.0
            inside.append((weight if piece.opens or outer == 1.0 else -weight, powers))
            if piece.behind or not (piece.opens or len(inside) > 1):
                found += [(piece.quantity, weight, powers + piece.behind) for weight, powers in inside]
                outer, inside = 1.0, []
        own = [
            (term, term_formula(term, w).pieces[0].product) for term, w in torques.items() if term.row == row
        ]
        assert not inside
        assert Counter(found) == Counter((t.quantity, *product) for t, product in own)


def test_the_legend_names_every_shared_velocity(harmonics, torques):
    legend = [*map(plainly, PAGE.legend(torque_legend(harmonics.velocities, torques)))]
    signs = harmonics.velocities.signs
    for run in harmonics.velocities.runs:
        for place, joint in enumerate(run[1:], start=2):
            parts = "".join(f"{'+' if signs[j] == signs[joint] else '-'}qdd{j + 1}" for j in run[:place])
            assert f"pdd{joint + 1}={parts.removeprefix('+')}" in legend
    assert any(meaning.startswith("C") and "=cos(" in meaning for meaning in legend)


def test_parts_of_elements_with_drives():
    kept = {"D11": "both", "D12": "translation", "D22": "nothing", "h1": "nothing", "h2": "rotation"}
    kept |= {"c1": "translation", "c2": "nothing"}
    first, second = map(PLAIN.line, parts_formulas(kept, 2, drives=True))
    assert first == "tau1 = (D11 + J1) qdd1 + D12^tran qdd2 + c1"
    assert second == "tau2 = D12^tran qdd1 + J2 qdd2 + h2^rot"
    assert PLAIN.right(parts_formulas(dict.fromkeys(kept, "nothing"), 2, drives=False)[0]) == "0"
    assert "<mtext>tran</mtext>" in PAGE.symbol(part_symbol("D12", "translation"))
    assert "<mtext>" not in PAGE.symbol(part_symbol("c1", "translation"))
