"""Harmonic terms in the report: how many the model keeps of how many, and the exact elements."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.writing import element_formula, torque_legend
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.equations import Term, equations
from gd_analyze.harmonics.terms import TorqueTerm, Velocity
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import Row

# A page that writes out more exact terms than this would be for no one to read.
MOST_EXACT_TERMS = 2000


@dataclass(frozen=True)
class Tally:
    """How many of an entry's terms the model keeps, and what the entry is called."""

    quantity: str
    what: str
    kept: int
    total: int


def ranked_rows(findings: Findings, most: int) -> list[Row]:
    """Return the first rows of the ranking of single terms, each with its term."""
    table = findings.tables["terms"].isel(rank=slice(most))
    pairs = zip(rows_of(table, "rank"), findings.ranked_terms, strict=False)
    return [row | {"term": term} for row, term in pairs]


def torque_names(findings: Findings) -> Legend:
    """Meaning of the names in the model's equations, or in the ranking where it has none of terms."""
    model = findings.model
    if model.level.has_torque_terms:
        return model.legend
    return torque_legend(model.form.velocities, findings.ranked_terms)


def shared_accelerations(rates: AbsoluteVelocities) -> Legend:
    """Meaning of the accelerations that add up those of parallel joints."""
    outer = [joint for joint, inner in enumerate(rates.before) if inner]
    return torque_legend(rates, [TorqueTerm(0, (Velocity(2, joint),), ()) for joint in outer])


def tallies(
    exact: Iterable[TorqueTerm], kept: Iterable[TorqueTerm], n_joints: int
) -> tuple[tuple[Tally, ...], ...]:
    """Terms kept and terms there are, by row: one entry per acceleration, then h, then c."""
    left, total = Counter(map(_place, kept)), Counter(map(_place, exact))
    columns = [("inertia", j, f"with acceleration {j + 1}") for j in range(n_joints)]
    columns += [("coriolis_centrifugal", -1, "Coriolis and centrifugal"), ("gravity_loading", -1, "gravity")]
    return tuple(
        tuple(
            Tally(quantity, f"Joint {i + 1}, {what}", left[i, quantity, j], total[i, quantity, j])
            for quantity, j, what in columns
        )
        for i in range(n_joints)
    )


def _place(term: TorqueTerm) -> tuple[int, str, int]:
    """Row, quantity and the acceleration's joint, -1 without one."""
    return term.row, term.quantity, term.velocities[0].joint if term.quantity == "inertia" else -1


def exact_elements(findings: Findings) -> tuple[tuple[Formula, tuple[Term, ...]], ...]:
    """D and c written out, and where their terms come from; nothing where that is too long to read."""
    form = findings.model.form
    if not findings.is_written_out or len(form.torques) > MOST_EXACT_TERMS:
        return ()
    return tuple(
        (element_formula(equation), equation.terms) for equation in equations(form.harmonics, ("D", "c"))
    )
