"""A model of harmonic terms as JSON values: its equations in Typst's mathematics, and how much it keeps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable
from typing import Any

from gd_analyze.findings import Findings
from gd_analyze.harmonics.lagrangian import energy_terms, torques_of_energies
from gd_analyze.harmonics.terms import EnergyTerm, Rate, TorqueTerm
from gd_analyze.harmonics.torque_typst import Piece, energy_to_typst, legend_to_typst, torques_to_typst
from gd_analyze.models import HarmonicModel


def harmonic_data(findings: Findings) -> dict[str, Any] | None:
    """Describe the model for the template; None for a model that keeps parts of elements."""
    model, harmonics = findings.model, findings.harmonics
    if not isinstance(model, HarmonicModel) or harmonics is None:
        return None
    basis = harmonics.rates
    energy = energy_terms(harmonics, model.arm.drive_inertia if model.drives else None)
    if model.level == "energy":
        written = [
            {"left": symbol, "groups": [_signed(pieces)]}
            for symbol, pieces in energy_to_typst(model.energy).items()
        ]
        return {
            "equations": written,
            "legend": legend_to_typst(basis, dict.fromkeys(map(_with_rates, model.energy), 1.0)),
            "kept": _energy_kept(energy, model.energy, basis.n_joints),
        }
    return {
        "equations": [
            {"left": f"tau_({i + 1})", "groups": _grouped(pieces)}
            for i, pieces in enumerate(torques_to_typst(basis, model.torques))
        ],
        "legend": legend_to_typst(basis, model.torques),
        "kept": _torques_kept(torques_of_energies(energy, basis), model.torques, basis.n_joints),
        "carried": [{"joint": joint + 1, "by": joint + 2} for run in basis.runs for joint in run[:-1]],
    }


def _with_rates(term: EnergyTerm) -> TorqueTerm:
    """Put an energy term as a torque term, whose names the legend explains."""
    rates = () if term.is_potential else (Rate(1, term.i), Rate(1, term.j))
    return TorqueTerm(0, rates, term.monomial)


def _grouped(pieces: Iterable[Piece]) -> list[list[dict[str, str]]]:
    """One group each for what a joint carries and D, for h and for c, where there are any."""
    kinds = (("", "inertia"), ("coriolis_centrifugal",), ("gravity_loading",))
    groups = [[piece for piece in pieces if piece.quantity in kind] for kind in kinds]
    return [_signed(group) for group in groups if group]


def _signed(pieces: Iterable[Piece]) -> list[dict[str, str]]:
    return [{"sign": piece.sign.replace("-", "−"), "math": piece.math} for piece in pieces]


def _torques_kept(exact: Iterable[TorqueTerm], kept: Iterable[TorqueTerm], n: int) -> dict[str, Any]:
    """Terms of every joint's torque by what they are multiplied with: accelerations, rates, nothing."""

    def place(term: TorqueTerm) -> tuple[int, int]:
        column = {"coriolis_centrifugal": n, "gravity_loading": n + 1}
        return term.row, column.get(term.quantity, term.rates[0].joint if term.rates else n + 1)

    rows = _counted(map(place, exact), map(place, kept), [[(i, j) for j in range(n + 2)] for i in range(n)])
    return {"what": "torque", "rows": rows}


def _energy_kept(exact: Iterable[EnergyTerm], kept: Iterable[EnergyTerm], n: int) -> dict[str, Any]:
    """Terms of every element of D' (upper triangle) and of the potential."""
    places: list[list[Hashable]] = [
        [*((i, j) if i <= j else None for j in range(n)), (-1, -1) if i == 0 else None] for i in range(n)
    ]
    rows = _counted(((t.i, t.j) for t in exact), ((t.i, t.j) for t in kept), places)
    return {"what": "energy", "rows": rows}


def _counted(
    exact: Iterable[Hashable], kept: Iterable[Hashable], places: Iterable[Iterable[Hashable]]
) -> list[list[dict[str, int] | None]]:
    every, left = Counter(exact), Counter(kept)
    return [
        [None if key is None else {"kept": left[key], "of": max(every[key], left[key])} for key in row]
        for row in places
    ]
