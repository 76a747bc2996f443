"""The model of the main job: formulas, terms kept, operations saved, and errors elsewhere."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.reach import reach_figure
from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.languages import equation_part
from gd_analyze.formulas.writing import energy_formulas, torque_legend, torque_symbol
from gd_analyze.harmonics.terms import TorqueTerm, Velocity
from gd_analyze.result import (
    Column,
    Drawing,
    Equations,
    Mark,
    Part,
    Section,
    Shown,
    Table,
    Value,
    joint_values,
)
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import operations_table, structure_note
from gd_analyze.results.rows import dropped_parts
from gd_analyze.results.shown_tables import dropped_table, far_errors_table, near_errors_table, payload_table
from gd_analyze.schema import declared_columns
from gd_analyze.simplification.element import kept_effects
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import inertia_label, joined, percent

# Most lines of equations in a terminal.
_MOST_LINES = 25
_PARTS = "A superscript names the part of an element that is kept; an element without one is kept whole."
_TERMS = (
    "Elements in joint velocities (J: drives, if any); those not listed are zero. SI units; three digits are "
    "shown, `model.json` has all."
)
_ENERGY = (
    "Kinetic and potential energy; D' is the symmetric mass matrix of absolute velocities; elements not "
    "listed are zero. Torques follow from Lagrange's equations, so energy is conserved."
)


def made_of(findings: Findings) -> str:
    """Kind of the model: "terms", "parts" of elements, or "exact" where no model can be read."""
    if findings.is_unreadable:
        return "exact"
    return "terms" if findings.model.has_terms else "parts"


def equations_by_element(findings: Findings) -> Iterator[Equations]:
    """D, h and c of a model of terms."""
    model = findings.model
    if model.has_terms and not model.is_exact:
        written = model.equations
        yield equation_part(
            "equations_by_element",
            "",
            written.formulas,
            written.legend,
            structure_note(model),
            most_lines=_MOST_LINES,
        )


def model_equations(findings: Findings) -> Equations:
    """The model as a report writes it, with explanations."""
    model, kind = findings.model, made_of(findings)
    if kind != "terms":
        note = _PARTS if kind == "parts" else f"{_substitute_note(findings)}\n{_PARTS}"
        return equation_part("model", "", findings.element_model.formulas, note=note)
    if model.level is ENERGY:
        with_velocities = (
            TorqueTerm(0, () if t.is_potential else (Velocity(1, t.i), Velocity(1, t.j)), t.monomial)
            for t in model.terms
        )
        legend = torque_legend(model.form.velocities, with_velocities)
        return equation_part("model", "", energy_formulas(model.terms), legend, _ENERGY)
    note = f"{structure_note(model)}\n{_TERMS}".lstrip()
    return equation_part("model", "", model.equations.formulas, model.equations.legend, note)


def _substitute_note(findings: Findings) -> str:
    """What stands for a model: the dominant parts of the elements, and the exact torque."""
    share = percent(_largest_share(findings.element_model))
    return (
        f"{findings.substitute_reason} These are the dominant parts of the elements, with an error of up to "
        f"{share} of peak torque at the set points. The exact torque takes "
        f"{findings.model.operations_full.in_words}; `model.json` has it."
    )


def _largest_share(model: SimplifiedModel) -> float:
    shares = model.accuracy.errors.largest_share
    return float(shares[np.isfinite(shares)].max(initial=0.0))


def savings_appendix(findings: Findings) -> Section:
    """Terms of the exact equations that the model keeps, and the operations saved."""
    model, kind = findings.model, made_of(findings)
    parts: list[Part] = []
    if kind == "terms":
        parts.append(_tallies(model))
    elif kind == "parts":
        parts += [_kept_matrix(findings), *_dropped(findings)]
    if kind != "parts" or not model.is_exact:
        parts.append(operations_table(model.operations, model.operations_full))
    parts.append(_steps(model))
    note = (
        "Operations are counted in the program that computes only what the model needs: factored, common "
        "subexpressions computed once, changes of sign free. The exact program is the cheapest known of any "
        "formulation."
    )
    return Section("model", "Terms kept and operations saved", tuple(parts), note)


def _steps(model: SimplifiedModel) -> Table:
    """Operations after each step of the search, and what they compute."""
    searched, exact, final = "torque", model.operations_full, {"torque": model.operations}
    if model.level is TERM:
        searched, exact = "D, h and c", model.form.functions.operations
        final = {searched: model.functions.operations, **final}
    rows: list[tuple[str, str, int, int | None]] = [
        ("exact model", searched, exact.total, exact.sines_cosines),
        *((step.name, searched, step.operations, None) for step in model.accuracy.steps),
        *(("final program", name, count.total, count.sines_cosines) for name, count in final.items()),
    ]
    names, quantities, counts, angles = zip(*rows, strict=True)
    columns = (
        Column("step", names, shown="text"),
        Column("computes", quantities, shown="text"),
        Column("operations", counts, shown="count"),
        Column("sines and cosines", angles, shown="count"),
    )
    return Table("steps", "Operations after each step of the search", columns)


def _tallies(model: SimplifiedModel) -> Table:
    """Terms kept, of all: torque terms by row and acceleration, h and c; or energy terms by element."""
    n = model.form.velocities.n_joints
    letter = "p̈" if model.form.velocities.before else "q̈"
    heads = [f"{letter}{joined((j,))}" for j in range(n)]
    if model.level is ENERGY:
        energy_totals, energy_kept = (
            Counter((t.i, t.j) for t in terms) for terms in (model.form.energies, model.terms)
        )
        cells = [
            [_tally(energy_kept[i, j], energy_totals[i, j]) if i <= j else None for j in range(n)]
            + [_tally(energy_kept[-1, -1], energy_totals[-1, -1]) if i == 0 else None]
            for i in range(n)
        ]
        title = (
            "Energy terms kept, of all: inertia in absolute velocities (upper triangle), and the potential U"
        )
        names = [Symbol("D'", f"{i + 1}") for i in range(n)]
        return _matrix("kept", title, names, [*map(str, range(1, n + 1)), "U"], cells)
    torque_totals, torque_kept = (
        Counter(map(_place, terms)) for terms in (model.form.torques, model.torques)
    )
    places = [("inertia", j) for j in range(n)] + [("coriolis_centrifugal", -1), ("gravity_loading", -1)]
    cells = [
        [_tally(torque_kept[i, quantity, j], torque_totals[i, quantity, j]) for quantity, j in places]
        for i in range(n)
    ]
    title = "Torque terms kept, of all, by joint (row): with each acceleration, in h, and in c"
    return _matrix("kept", title, [torque_symbol(i) for i in range(n)], [*heads, "h", "c"], cells)


def _place(term: TorqueTerm) -> tuple[int, str, int]:
    """Row, quantity and the acceleration's joint, -1 without one."""
    return term.row, term.quantity, term.velocities[0].joint if term.quantity == "inertia" else -1


def _tally(count: int, total: int) -> Mark:
    return Mark("some" if count else "none", f"{count}/{total}" if total else "·")


def _matrix(
    key: str,
    title: str,
    names: Sequence[Symbol],
    heads: Sequence[str],
    cells: Sequence[Sequence[Mark | None]],
) -> Table:
    columns = [Column("row", range(len(names)), shown="count", drawn=names)]
    for k, head in enumerate(heads):
        marks = [row[k] for row in cells]
        texts = ["" if mark is None else mark.text for mark in marks]
        columns.append(Column(head, texts, shown="text", drawn=marks))
    return Table(key, title, tuple(columns))


def _kept_matrix(findings: Findings) -> Table:
    """Parts of D, h and c that the model by [FGL87]'s own method keeps."""
    n = findings.arm.n_joints
    effects = kept_effects(n, findings.element_model.terms)
    effects |= {f"c{joined((i,))}": "gravity" for i in range(n) if effects[f"c{joined((i,))}"] != "nothing"}
    labels = [
        [*(inertia_label(i, j) for j in range(n)), f"h{joined((i,))}", f"c{joined((i,))}"] for i in range(n)
    ]
    cells = [[Mark(effects[label], LETTERS.get(effects[label], "0")) for label in row] for row in labels]
    title = "Parts kept of D (symmetric), h and c: T translation, R rotation, ✓ gravity, 0 nothing"
    heads = [*map(str, range(1, n + 1)), "h", "c"]
    return _matrix("kept_parts", title, [torque_symbol(i) for i in range(n)], heads, cells)


def tube_section(findings: Findings) -> Section:
    """Errors near the motion, and how near, for JSON."""
    stated = findings.tables["tube"].attrs
    values = (Value(key, stated[key]) for key in ("coarse", "tried", "note"))
    return Section("tube", "", (near_errors_table(findings), *values))


def beyond_appendix(findings: Findings) -> Section:
    """Errors near the motion and beyond it, and the effect of a payload or uncertain parameters."""
    has_tube = findings.tables["tube"].tube_worst_found.notnull().any()
    near = [near_errors_table(findings)] if has_tube else []
    words = "Errors as multiples of the allowed error, on a logarithmic scale."
    ratios = Drawing("beyond", words, reach_figure(findings))
    parts: tuple[Part, ...] = (*near, ratios, far_errors_table(findings), payload_table(findings))
    return Section("beyond", "Near this motion, and beyond it", parts)


def by_hand_appendix(findings: Findings) -> Section | None:
    """The model by [FGL87]'s own method, where it is not the run's."""
    if made_of(findings) == "parts":
        return None
    model, elements = findings.model, findings.element_model
    share = _largest_share(elements)
    note = (
        "[FGL87] simplifies by hand, element by element: where translation or rotation dominates, the "
        f"other part is dropped. This takes {elements.operations.in_words}, with an error of up to "
        f"{percent(share)} of peak torque; the model above takes {model.operations.pair}, the exact torque "
        f"{model.operations_full.pair}."
    )
    parts = (
        _kept_matrix(findings),
        equation_part("elements", "", elements.formulas, note=_PARTS),
        operations_table(elements.operations, model.operations_full),
        *_dropped(findings),
        *_by_verdicts(findings),
    )
    return Section("elements", "By [FGL87]'s own method", parts, note)


def _by_verdicts(findings: Findings) -> tuple[Table, Table]:
    """Torque error and operations of models that keep only the dominant part of every element."""
    table, source_names = findings.tables["by_verdicts"], {"own": "our verdicts", "text": "[FGL87]"}
    errors = zip(table.verdicts.values.tolist(), table.largest_share.values, strict=True)
    shares = (
        Column(f"by {source_names.get(name, name)}", values.tolist(), shown="percent")
        for name, values in errors
    )
    columns = zip(
        table.quantity.values.tolist(), table.operations.values.T, table.sines_cosines.values.T, strict=True
    )
    operations = (
        Column(name, [f"{total}/{angles}" for total, angles in zip(*counts, strict=True)], shown="text")
        for name, *counts in columns
    )
    joints = declared_columns("by_verdicts", joint_values(findings.arm.joints), ["joint"])
    programs = [source_names.get(name, name) for name in table.program.values.tolist()]
    title = "Largest torque error over peak torque if only the dominant parts of D and h are kept"
    note = (
        "Exact: the cheapest known program of each quantity. By element: D, h and c as [FGL87] writes them, "
        "with shared subexpressions."
    )
    return (
        Table("verdict_errors", title, (*joints, *shares)),
        Table(
            "verdict_operations",
            "Operations/sines and cosines of D, h and c",
            (Column("program", programs, shown="text"), *operations),
            note,
        ),
    )


def _dropped(findings: Findings) -> Iterator[Part]:
    """Parts that [FGL87]'s method drops, by reason."""
    yield dropped_table(findings)
    dropped = dropped_parts(findings)
    reasons = {
        "Dropped parts that are zero here": dropped.zero,
        "Dropped parts without torque here": dropped.idle,
    }
    for label, dropped_rows in reasons.items():
        if dropped_rows:
            names = ", ".join(row["part"] for row in dropped_rows)
            yield Shown(label, f"{len(dropped_rows)}: {names}")
