"""Formulas of a model that keeps effects of elements; [FGL87] Eq. (3.4-24)."""

from __future__ import annotations

from collections.abc import Mapping

from gd_analyze.formulas.formula import NOTHING, Formula, Piece, Power, Symbol, bracketed, one
from gd_analyze.text import inertia_label, joined

_WORDS = {"translation": "tran", "rotation": "rot"}


def part_symbol(label: str, effect: str = "both") -> Symbol:
    """Symbol of an element such as "D12", with the effect as superscript where only one is meant.

    Gravity has no effects: it goes without.
    """
    return Symbol(label[0], label[1:], word="" if label.startswith("c") else _WORDS.get(effect, ""))


def parts_formulas(kept: Mapping[str, str], n_joints: int, drives: bool) -> tuple[Formula, ...]:
    """Formulas of all joints' torques with only what is kept.

    Parameters
    ----------
    kept
        "translation", "rotation", "both" or "neither" by the element's label.
    n_joints
        Joints of the arm.
    drives
        Whether the drives' inertia J is in them.
    """
    out = []
    for i in range(n_joints):
        own = joined((i,))
        pieces: list[Piece] = []
        for j in range(n_joints):
            label = inertia_label(i, j)
            symbols = [] if kept[label] == "neither" else [part_symbol(label, kept[label])]
            symbols += [Symbol("J", own)] if drives and i == j else []
            acceleration = (Power(Symbol("q", joined((j,)), dots=2)),)
            pieces += bracketed("inertia", tuple(map(one, symbols)), acceleration)
        for label, quantity in ((f"h{own}", "coriolis_centrifugal"), (f"c{own}", "gravity_loading")):
            if kept[label] != "neither":
                pieces.append(Piece(one(part_symbol(label, kept[label])), quantity))
        out.append(Formula(Symbol("tau", own), tuple(pieces) or NOTHING))
    return tuple(out)
