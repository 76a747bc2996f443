"""A model of harmonic terms as JSON values: its equations in Typst's mathematics, and how much it keeps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.languages import Typst
from gd_analyze.formulas.writing import energy_formulas, torque_legend
from gd_analyze.harmonics.terms import EnergyTerm, TorqueTerm, Velocity
from gd_analyze.report.terms import tallies
from gd_analyze.simplification.model import SimplifiedModel

_TYPST = Typst()


def harmonic_data(model: SimplifiedModel) -> dict[str, Any] | None:
    """Describe a model for the template; None for one that has no harmonic terms."""
    if not model.level.has_torque_terms:
        return None
    form, rates = model.form, model.form.velocities
    if model.level.is_mechanical:
        return {
            "equations": [equation_data(formula) for formula in energy_formulas(model.terms)],
            "legend": _TYPST.legend(torque_legend(rates, map(_with_rates, model.terms))),
            "kept": _energy_kept(form.energies, model.terms, rates.n_joints),
        }
    return {
        "equations": [equation_data(formula) for formula in model.formulas],
        "legend": _TYPST.legend(model.legend),
        "kept": [
            [{"kept": tally.kept, "of": tally.total} for tally in row]
            for row in tallies(form.torques, model.torques, rates.n_joints)
        ],
        "carried": [
            {"joint": joint + 1, "by": outer.joint + 1, "negative": outer.sign < 0}
            for joint, outer in enumerate(rates.carried)
            if outer
        ],
    }


def _with_rates(term: EnergyTerm) -> TorqueTerm:
    """Put an energy term as a torque term, whose names the legend explains."""
    rates = () if term.is_potential else (Velocity(1, term.i), Velocity(1, term.j))
    return TorqueTerm(0, rates, term.monomial)


def equation_data(formula: Formula) -> dict[str, Any]:
    """Left-hand side and pieces; one group each for what a joint carries and D, for h and for c."""
    groups: dict[str, list[dict[str, str]]] = {}
    for piece in formula.pieces:
        group = groups.setdefault("inertia" if piece.quantity == "carried" else piece.quantity, [])
        group.append({"sign": "−" if piece.negative else "+", "math": _TYPST.body(piece)})
    return {"left": _TYPST.symbol(formula.left), "groups": [*groups.values()]}


def _energy_kept(
    exact: Iterable[EnergyTerm], kept: Iterable[EnergyTerm], n: int
) -> list[list[dict[str, int] | None]]:
    """Terms of every element of D' (upper triangle) and of the potential."""
    places: list[list[tuple[int, int] | None]] = [
        [*((i, j) if i <= j else None for j in range(n)), (-1, -1) if i == 0 else None] for i in range(n)
    ]
    every, left = (Counter((term.i, term.j) for term in terms) for terms in (exact, kept))
    return [[None if key is None else {"kept": left[key], "of": every[key]} for key in row] for row in places]
