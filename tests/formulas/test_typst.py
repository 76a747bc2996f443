from __future__ import annotations

from collections import Counter

import pytest
import typst

from gd_analyze.formulas.formula import NOTHING, Function, Piece, Power, Product, Symbol, one
from gd_analyze.formulas.languages import Plain, Typst
from gd_analyze.formulas.writing import (
    energy_formulas,
    term_formula,
    torque_formulas,
    torque_legend,
)
from gd_analyze.harmonics.lagrangian import energy_terms
from gd_analyze.harmonics.terms import Torques
from gd_analyze.harmonics.transform import Harmonics

TYPST, PLAIN = Typst(), Plain()

C2, S23, D3 = Symbol("C", "2"), Symbol("S", "23"), Symbol("d", "3")
P1, P2, PD2 = Symbol("p", "1", dots=1), Symbol("p", "2", dots=1), Symbol("p", "2", dots=2)
DIFFERENCE = Function(
    "cos", (Product(2.0, (Power(Symbol("q", "2")),)), Product(-1.0, (Power(Symbol("q", "3")),)))
)


@pytest.mark.parametrize(
    ("piece", "plain", "math"),
    [
        (Piece(Product(1.75, (Power(PD2),))), "1.75 pd2", "1.75 thin dot.double(p)_(2)"),
        (
            Piece(Product(3.2, (Power(C2), Power(S23, 2), Power(P1), Power(P2)))),
            "3.2 C2 S23² p1 p2",
            "3.2 thin C_(2) thin S_(23)^2 thin dot(p)_(1) thin dot(p)_(2)",
        ),
        (Piece(Product(4e-5, (Power(Symbol("C", "9,10")),))), "4e-5 C9,10", "4 times 10^(-5) thin C_(9,10)"),
        (
            Piece(Product(1.0, (Power(DIFFERENCE, 2), Power(D3), Power(P1, 2)))),
            "cos²(2 q2 - q3) d3 p1²",
            "cos^2(2 thin q_(2) - q_(3)) thin d_(3) thin dot(p)_(1)^2",
        ),
        (Piece(one(Symbol("tau", "3"))), "tau3", "tau_(3)"),
        (Piece(one(Symbol("D'", "12"))), "D'12", "D'_(12)"),
        (Piece(Product(-0.5, (Power(C2),)), opens=True), "(0.5 C2", "paren.l 0.5 thin C_(2)"),
        (Piece(one(C2), behind=(Power(P1),)), "C2) p1", "C_(2) paren.r thin dot(p)_(1)"),
        (NOTHING[0], "0", "0"),
    ],
)
def test_pieces(piece: Piece, plain: str, math: str) -> None:
    assert PLAIN.body(piece) == plain
    assert TYPST.body(piece) == math


def test_every_term_is_written_under_its_quantity(harmonics: Harmonics, torques: Torques) -> None:
    written = Counter(
        (row, piece.quantity)
        for row, formula in enumerate(torque_formulas(harmonics.velocities, torques))
        for piece in formula.pieces
        if piece.quantity != "carried"
    )
    assert written == Counter((term.row, term.quantity) for term in torques)


def test_brackets_multiply_out_to_the_terms(harmonics: Harmonics, torques: Torques) -> None:
    """With its bracket's sign and factors restored, every piece is one term with its weight."""
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
                found += [(weight, powers + piece.behind) for weight, powers in inside]
                outer, inside = 1.0, []
        expected = [term_formula(t, w).pieces[0].product for t, w in torques.items() if t.row == row]
        assert not inside
        assert Counter(found) == Counter(map(tuple, expected))


def test_typst_takes_all_of_it(harmonics: Harmonics, torques: Torques) -> None:
    energies = energy_terms(harmonics)
    formulas = [*torque_formulas(harmonics.velocities, torques), *energy_formulas(energies)]
    formulas += [term_formula(term, weight) for term, weight in torques.items()]
    written = [part for f in formulas for part in (TYPST.symbol(f.left), *map(TYPST.body, f.pieces))]
    written += [*map(TYPST.line, formulas), *TYPST.legend(torque_legend(harmonics.velocities, torques))]
    source = "\n\n".join(f"${piece}$" for piece in written).encode()
    _, warnings = typst.compile_with_warnings(source, ignore_system_fonts=True)
    assert warnings == []
