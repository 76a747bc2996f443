"""A model of harmonic terms as JSON values: its equations in Typst's mathematics, and how much it keeps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from gd_analyze.findings import Findings
from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.legend import torque_legend
from gd_analyze.formulas.typst import Typst
from gd_analyze.formulas.writing import energy_formulas, torque_formulas
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import EnergyTerm, Rate, TorqueTerm
from gd_analyze.models import HarmonicModel
from gd_analyze.report.terms import tallies

TYPST = Typst()


def harmonic_data(findings: Findings) -> dict[str, Any] | None:
    """Describe the model for the template; None for a model that keeps parts of elements."""
    model, harmonics = findings.model, findings.harmonics
    if not isinstance(model, HarmonicModel) or harmonics is None:
        return None
    basis = harmonics.basis
    energy = energy_terms(harmonics, model.arm.drive_inertia if model.drives else None)
    if model.level == "energy":
        return {
            "equations": [equation_data(formula) for formula in energy_formulas(model.energy)],
            "legend": TYPST.legend(torque_legend(basis, map(_with_rates, model.energy))),
            "kept": _energy_kept(energy, model.energy, basis.n_joints),
        }
    return {
        "equations": [equation_data(formula) for formula in torque_formulas(basis, model.torques)],
        "legend": TYPST.legend(torque_legend(basis, model.torques)),
        "kept": _torques_kept(torques_of_energies(energy, basis), model.torques, basis.n_joints),
        "carried": [{"joint": joint + 1, "by": joint + 2} for run in basis.runs for joint in run.joints[:-1]],
    }


def _with_rates(term: EnergyTerm) -> TorqueTerm:
    """Put an energy term as a torque term, whose names the legend explains."""
    rates = () if term.is_potential else (Rate(1, term.i), Rate(1, term.j))
    return TorqueTerm(0, rates, term.monomial)


def equation_data(formula: Formula) -> dict[str, Any]:
    """Left-hand side and pieces; one group each for what a joint carries and D, for h and for c."""
    groups: dict[str, list[dict[str, str]]] = {}
    for piece in formula.pieces:
        group = groups.setdefault("inertia" if piece.quantity == "carried" else piece.quantity, [])
        group.append({"sign": "−" if piece.negative else "+", "math": TYPST.body(piece)})
    return {"left": TYPST.symbol(formula.left), "groups": [*groups.values()]}


def _torques_kept(exact: Iterable[TorqueTerm], kept: Iterable[TorqueTerm], n: int) -> dict[str, Any]:
    """Terms of every joint's torque by what they are multiplied with: accelerations, rates, nothing."""
    rows = [
        [{"kept": tally.kept, "of": max(tally.total, tally.kept)} for tally in row]
        for row in tallies(exact, kept, n)
    ]
    return {"what": "torque", "rows": rows}


def _energy_kept(exact: Iterable[EnergyTerm], kept: Iterable[EnergyTerm], n: int) -> dict[str, Any]:
    """Terms of every element of D' (upper triangle) and of the potential."""
    places: list[list[tuple[int, int] | None]] = [
        [*((i, j) if i <= j else None for j in range(n)), (-1, -1) if i == 0 else None] for i in range(n)
    ]
    every, left = (Counter((term.i, term.j) for term in terms) for terms in (exact, kept))
    rows = [
        [None if key is None else {"kept": left[key], "of": max(every[key], left[key])} for key in row]
        for row in places
    ]
    return {"what": "energy", "rows": rows}
