from __future__ import annotations

from collections import Counter

import pytest
import typst

from gd_analyze.harmonics import harmonics_of
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.torque_rendering import energy_term_text, torque_term_text
from gd_analyze.harmonics.torque_typst import energy_to_typst, legend_to_typst, to_typst, torques_to_typst
from gd_analyze.robots import load_arm

ARMS = ("two_link", "puma560", "stanford")


@pytest.mark.parametrize(
    ("text", "math"),
    [
        ("1.75 pd2", "1.75 thin dot.double(p)_(2)"),
        ("-3.2 C2 S23² p1 p2", "- 3.2 thin C_(2) thin S_(23)^2 thin dot(p)_(1) thin dot(p)_(2)"),
        ("4e-5 C9,10", "4 times 10^(-5) thin C_(9,10)"),
        ("cos²(2 q2 - q3) d3 p1²", "cos^2(2 thin q_(2) - q_(3)) thin d_(3) thin dot(p)_(1)^2"),
        ("tau3", "tau_(3)"),
        ("D'12", "D'_(12)"),
        ("pd3 = qdd2 + qdd3", "dot.double(p)_(3) = dot.double(q)_(2) + dot.double(q)_(3)"),
        ("any other p_j is qd_j", '"any other" dot(p)_(j) "is" dot(q)_(j)'),
        ("d3 = q3 in m", 'd_(3) = q_(3) "in m"'),
        ("(0.5 S2 + C2) p1", "paren.l 0.5 thin S_(2) + C_(2) paren.r thin dot(p)_(1)"),
    ],
)
def test_fragments(text: str, math: str) -> None:
    assert to_typst(text) == math


@pytest.mark.parametrize("text", ["#panic()", "x3", "C", "3 \\ 4", "tau", "1e"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="not the text form"):
        to_typst(text)


@pytest.mark.parametrize("name", ARMS)
def test_every_term_is_written_under_its_quantity(name: str) -> None:
    arm = load_arm(name)
    harmonics = harmonics_of(arm)
    torques = torques_of_energies(energy_terms(harmonics), harmonics.rates)
    written = Counter(
        (row, piece.quantity)
        for row, pieces in enumerate(torques_to_typst(harmonics.rates, torques))
        for piece in pieces
        if piece.quantity
    )
    assert written == Counter((term.row, term.quantity) for term in torques)


@pytest.mark.parametrize("name", ARMS)
def test_signs_and_brackets_are_those_of_the_text(name: str) -> None:
    arm = load_arm(name)
    harmonics = harmonics_of(arm)
    torques = torques_of_energies(energy_terms(harmonics), harmonics.rates)
    for pieces in torques_to_typst(harmonics.rates, torques):
        assert {piece.sign for piece in pieces} <= {"+", "-"}
        assert not any(piece.math.startswith(("-", "+")) for piece in pieces)
        whole = " ".join(piece.math for piece in pieces)
        assert whole.count("paren.l") == whole.count("paren.r")
    carried = {joint: joint + 2 for run in harmonics.rates.runs for joint in run[:-1]}
    for joint, by in carried.items():
        first = torques_to_typst(harmonics.rates, torques)[joint][0]
        assert (first.math, first.quantity) == (f"tau_({by})", "")


@pytest.mark.parametrize("name", ARMS)
def test_typst_takes_all_of_it(name: str) -> None:
    arm = load_arm(name)
    harmonics = harmonics_of(arm)
    energy = energy_terms(harmonics)
    torques = torques_of_energies(energy, harmonics.rates)
    pieces = [piece.math for row in torques_to_typst(harmonics.rates, torques) for piece in row]
    pieces += list(energy_to_typst(energy))
    pieces += [piece.math for row in energy_to_typst(energy).values() for piece in row]
    pieces += legend_to_typst(harmonics.rates, torques)
    pieces += [to_typst(torque_term_text(term, weight)) for term, weight in torques.items()]
    source = "\n\n".join(f"${piece}$" for piece in pieces).encode()
    _, warnings = typst.compile_with_warnings(source, ignore_system_fonts=True)
    assert warnings == []


def test_energy_is_gathered_by_element_with_the_potential_last() -> None:
    arm = load_arm("puma560")
    energy = energy_terms(harmonics_of(arm))
    written = energy_to_typst(energy)
    assert sum(len(pieces) for pieces in written.values()) == len(energy)
    assert next(iter(written)) == "D'_(11)"
    assert [*written][-1] == "U"
    first = max((t for t in energy if t.is_potential), key=lambda t: abs(energy[t]))
    piece = written["U"][0]
    assert first.monomial
    assert (piece.sign == "-") == (energy[first] < 0)
    assert to_typst(energy_term_text(first, energy[first]).removeprefix("-")) == piece.math


def test_nothing_is_written_as_zero() -> None:
    rates = harmonics_of(load_arm("two_link")).rates
    second = torques_to_typst(rates, {})[1]
    assert [(piece.sign, piece.math) for piece in second] == [("+", "0")]
