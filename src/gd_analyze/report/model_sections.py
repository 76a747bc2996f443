"""The model in the main report: its formulas, what it keeps and saves, and its errors elsewhere."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.motion import motion_unit
from gd_analyze.figures.trade_off import kind_name, reach_figure
from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.languages import equations as equations_part
from gd_analyze.formulas.writing import (
    energy_formulas,
    part_symbol,
    torque_legend,
    torque_symbol,
)
from gd_analyze.harmonics.terms import EnergyTerm, TorqueTerm, Velocity
from gd_analyze.motions.states import states_of
from gd_analyze.result import Column, Drawing, Fact, Part, Section, Table
from gd_analyze.results.findings import Findings
from gd_analyze.results.motion_result import effect_of
from gd_analyze.results.recursion_parts import recursion_parts
from gd_analyze.results.rows import dropped_parts, element_rows, joint_rows, table_of, trade_off_rows
from gd_analyze.results.run_result import bound_ratio, margins, tube_bound
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.text import inertia_label, joined, number, pretty

_CLASSES = {"inertia": "inertia", "coriolis_centrifugal": "velocity", "gravity_loading": "gravity"}


def made_of(findings: Findings) -> str:
    """What the model is made of: "terms", "parts" of elements, a "recursion", or else "formulas"."""
    level = findings.model.level
    if level.has_torque_terms:
        return "terms"
    return {ELEMENT: "parts", RECURSIVE: "recursion"}.get(level, "formulas")


def nothing_to_trade(findings: Findings) -> bool:
    """Whether no budget of the trade-off gives a model of fewer operations than the exact torque."""
    operations = findings.tables["trade_off"].operations.values
    return bool((operations >= findings.model.operations_full.total).all())


def trade_off_table(findings: Findings) -> Table:
    """Operations and error of every kind of model, by budget."""
    rows, table = trade_off_rows(findings), findings.tables["trade_off"]
    columns = [Column("", "budget", [row["budget"] for row in rows], shown="text")]
    for k, (level, refit) in enumerate(zip(table.level.values, table.refit.values, strict=True)):
        counts, shares = ([row[name][k] for row in rows] for name in ("operations", "largest_share"))
        columns.append(Column("", kind_name(level, refit), counts, shown="count"))
        columns.append(Column("", "error", shares, shown="percent"))
    title = f"Operations, and largest error of the {findings.model.accuracy.asked.shares_of}, by budget"
    note = "Choose a point with `--operations N` or `--budget`, a level with `--level` and `--refit`."
    return Table("trade_off", title, tuple(columns), note)


def model_parts(findings: Findings) -> tuple[Part, ...]:
    """The model itself as formulas, with what explains them."""
    model, form = findings.model, findings.model.form
    if made_of(findings) == "recursion":
        return _recursion(findings)[:1]
    if made_of(findings) == "terms" and model.level.is_mechanical:
        velocities = form.velocities
        with_velocities = (
            TorqueTerm(0, () if t.is_potential else (Velocity(1, t.i), Velocity(1, t.j)), t.monomial)
            for t in model.terms
        )
        legend = torque_legend(velocities, with_velocities)
        note = (
            "Kinetic and potential energy; D' is the inertia matrix of absolute velocities, "
            "symmetric, and what "
            "is not listed is zero. Torques follow by Lagrange's equations, so energy is conserved."
        )
        return (equations_part("model", "", energy_formulas(model.terms), legend, note),)
    parts = model if made_of(findings) == "parts" else None
    if parts is not None:
        return (equations_part("model", "", findings.element_model.formulas, note=_PARTS),)
    note = _TERMS_NOTE if made_of(findings) == "terms" else ""
    return (equations_part("model", "", model.formulas, model.legend, note),)


_PARTS = "An exponent names the one part kept of an element; an element without one is kept whole."
_TERMS_NOTE = (
    "Terms of each torque in the order D, h, c: accelerations, products of velocities, gravity. "
    "Velocities are "
    "absolute: those of parallel axes add up. SI units; three digits shown, all of them in `model.json`."
)


def model_section(findings: Findings) -> Section:
    """What the model keeps of the exact equations, and the operations that this saves."""
    model, kind = findings.model, made_of(findings)
    parts: list[Part] = []
    if kind == "terms":
        parts.append(tallies(model))
    elif kind == "parts":
        parts += [kept_matrix(findings), *_dropped(findings)]
    elif kind == "recursion":
        parts += [replace(part, top=None) for part in _recursion(findings)[2:3] if isinstance(part, Table)]
    if model.saves or kind != "parts":
        parts.append(_operations("operations", model))
    steps = [("exact model", model.operations_full.total)]
    steps += [(step.name, step.operations) for step in model.accuracy.steps]
    steps.append(("final program", model.operations.total))
    names, counts = zip(*steps, strict=True)
    columns = (Column("", "step", names, shown="text"), Column("", "operations", counts, shown="count"))
    parts.append(Table("steps", "Operations after each step of the search", columns))
    if kind == "recursion":
        parts += [Section("steps", "The model, link by link", _recursion(findings)[3:])]
    note = (
        "Operations are counted on the program that computes only what the model needs: factored, common "
        "subexpressions once, changes of sign free. The exact program is the cheapest known, "
        "whatever its formulation."
    )
    return Section("model", "What the model keeps and what that saves", tuple(parts), note)


def tallies(model: SimplifiedModel) -> Table:
    """Terms kept of all terms: torque terms by row and acceleration, h and c; or energy terms by element."""
    form, n = model.form, model.form.velocities.n_joints
    if model.level.is_mechanical:
        every, left = (Counter((t.i, t.j) for t in _energy(terms)) for terms in (form.energies, model.terms))
        rows = [
            [(i, j) if i <= j else None for j in range(n)] + [(-1, -1) if i == 0 else None] for i in range(n)
        ]
        cells = [[_tally("inertia", left[p], every[p]) if p else "" for p in row] for row in rows]
        names = [Symbol("D'", f"{i + 1}") for i in range(n)]
        title = (
            "Energy terms kept of all: inertia in absolute velocities (upper triangle), and the potential U"
        )
        return _matrix("kept", title, names, [*map(str, range(1, n + 1)), "U"], cells)
    total, kept = (Counter(map(_place, terms)) for terms in (form.torques, model.torques))
    places = [("inertia", j) for j in range(n)] + [("coriolis_centrifugal", -1), ("gravity_loading", -1)]
    cells = [
        [_tally(_CLASSES[quantity], kept[i, quantity, j], total[i, quantity, j]) for quantity, j in places]
        for i in range(n)
    ]
    heads = [*(f"p̈{joined((j,))}" for j in range(n)), "h", "c"]
    title = "Torque terms kept of all, by joint (row): with each acceleration, in h, and in c"
    return _matrix("kept", title, [torque_symbol(i) for i in range(n)], heads, cells)


def _energy(terms: Iterable[Any]) -> Iterator[EnergyTerm]:
    yield from terms


def _place(term: TorqueTerm) -> tuple[int, str, int]:
    """Row, quantity and the acceleration's joint, -1 without one."""
    return term.row, term.quantity, term.velocities[0].joint if term.quantity == "inertia" else -1


def _tally(kind: str, kept: int, total: int) -> str:
    return f"{kind if kept else 'none'} {kept}/{total}" if total else "none ·"


def _matrix(
    key: str,
    title: str,
    names: Sequence[Symbol],
    heads: Sequence[str],
    cells: Sequence[Sequence[str]],
    note: str = "",
) -> Table:
    columns = [Column("", "row", names, shown="math")]
    columns += [Column("", head, [row[k] for row in cells], shown="effect") for k, head in enumerate(heads)]
    return Table(key, title, tuple(columns), note)


def kept_matrix(findings: Findings) -> Table:
    """What the model by the founding text's own method keeps of D, h and c."""
    n = findings.arm.n_joints
    kept = {row["element"]: effect_of(row, "kept") for row in element_rows(findings)}
    labels = [
        [*(inertia_label(i, j) for j in range(n)), f"h{joined((i,))}", f"c{joined((i,))}"] for i in range(n)
    ]
    cells = [[f"{kept[label]} {LETTERS[kept[label]]}" for label in row] for row in labels]
    title = "What is kept of D (symmetric), h and c: T translation, R rotation, ✓ gravity, 0 nothing"
    heads = [*map(str, range(1, n + 1)), "h", "c"]
    return _matrix("kept_parts", title, [torque_symbol(i) for i in range(n)], heads, cells)


def _operations(key: str, model: SimplifiedModel) -> Table:
    full, left = model.operations_full, model.operations
    names = ("multiplications", "additions", "total", "sines_cosines")
    before, after = ([getattr(count, name) for name in names] for count in (full, left))
    saved = [1 - b / a if a else 0.0 for a, b in zip(before, after, strict=True)]
    words = ("multiplications", "additions", "both", "sines and cosines")
    return Table(
        key,
        "Operations for one evaluation of all torques",
        (
            Column("", "operations", words, shown="text"),
            Column("", "exact", before, shown="count"),
            Column("", "model", after, shown="count"),
            Column("", "saved", saved, shown="percent"),
        ),
    )


def _recursion(findings: Findings) -> tuple[Part, ...]:
    """Parameters (for people, and for JSON), what is left out, and equations of a recursion."""
    return recursion_parts(findings.model, states_of(findings.trajectory), 3)


def beyond_section(findings: Findings) -> Section:
    """Errors near the motion and beyond it, and what a payload or uncertain parameters do."""
    beyond, tube, arm = findings.tables["beyond"], findings.tables["tube"], findings.arm
    rows = joint_rows(findings, "simplified_model", "beyond", "tube")
    drawn, certified = int(beyond.attrs["states_drawn"]), bool(beyond.certified.notnull().all())
    uncertain = rows[0]["uncertainty"] is not None
    parts: list[Part] = []
    errors = {
        "allowed_error": ("allowed", "@effort_unit"),
        "largest_error": ("at set points", "@effort_unit"),
    }
    if tube_bound(findings) is not None:
        margin = {f"tube_margin_{name}": _degrees(arm, rows, name) for name in ("q", "qd", "qdd")}
        shown = [row | {name: cells[k] for name, cells in margin.items()} for k, row in enumerate(rows)]
        labels = {
            **errors,
            "tube_worst_found": ("found near it", "@effort_unit"),
            "tube_certified": ("proven", "@effort_unit", "bound"),
            "tube_certified_share": ("of peak", "", "bound_percent"),
            **{name: (words, "", "text") for name, words in zip(margin, ("± q", "± q̇", "± q̈"), strict=True)},
        }
        note = (
            f"Within {margins(findings)} of the motion, between its set points too, no state has a "
            "larger error than "
            f"the proven one. The found error is the worst that a search met. {tube.attrs['note']}"
        )
        parts.append(table_of("tube", "Torque error near the motion, proven", shown, labels, note))
    parts.append(
        Drawing(
            "beyond",
            "Errors as multiples of the allowed error, on a logarithmic scale.",
            reach_figure(findings),
        )
    )
    labels = {**errors, "largest_share": ("of peak", "", "percent")}
    said: list[str] = []
    if certified:
        labels |= {
            "worst_found": ("found in the box", "@effort_unit"),
            "certified": ("proven in the box", "@effort_unit", "bound"),
            "certified_share": ("of peak", "", "bound_percent"),
        }
        ratio = bound_ratio(findings)
        above = (
            ""
            if ratio is None
            else f" It is at most {number(math.ceil(100 * ratio) / 100)} times the found one."
        )
        said.append(
            "The box holds every position, velocity and acceleration between the smallest and the "
            "largest of the "
            f"trajectory, in any combination. The proven error bounds all of it.{above}"
        )
    if drawn:
        labels |= {
            "within_limits": ("within limits", "@effort_unit"),
            "within_limits_share": ("of peak", "", "percent"),
        }
        over = [row["joint"] for row in rows if (row["within_limits"] or 0.0) > row["allowed_error"]]
        said.append(
            f"{drawn} states were drawn from the arm's limits of position, velocity and acceleration; "
            "the error is "
            + (
                f"above the allowed one at joints {', '.join(map(str, over))}."
                if over
                else "within the allowed one."
            )
            + (f" For a model that holds everywhere: `gd-analyze simplify {arm.name}`." if over else "")
        )
    else:
        said.append(
            "No states were drawn from the arm's limits, as it does not state all of them (`--limits`)."
        )
    parts.append(table_of("beyond", "Torque error farther from the motion", rows, labels, "\n".join(said)))
    labels = {
        "torque_per_kg": ("torque per kg", "@effort_unit"),
        "mass_within_budget": ("payload within budget", "kg"),
        **({"uncertainty": ("uncertainty of torque", "@effort_unit")} if uncertain else {}),
    }
    shown = [row | {"mass_within_budget": _mass(row["mass_within_budget"])} for row in rows]
    said = [
        "A point mass at the origin of the last frame, which the model does not know of; state a "
        "real one with "
        "`--payload`."
    ]
    if uncertain:
        said.append(
            "The uncertainty is standard and follows from the stated uncertainties of the parameters."
        )
    parts.append(
        table_of("payload", "Payload and uncertainty of the parameters", shown, labels, " ".join(said))
    )
    return Section("beyond", "Near this motion, and beyond it", tuple(parts))


def _degrees(arm: Any, rows: Sequence[dict[str, Any]], name: str) -> list[str]:
    out = []
    for joint, row in zip(arm.joints, rows, strict=True):
        value = row[f"tube_margin_{name}"]
        shown = math.degrees(value) if joint.kind == "revolute" else value
        out.append(f"{number(shown)} {pretty(motion_unit(joint, name))}")
    return out


def _mass(kilograms: float) -> Any:
    return kilograms if kilograms < math.inf else "any"


def founding_section(findings: Findings) -> Section | None:
    """The model by the founding text's own method, where the model is another."""
    if made_of(findings) == "parts":
        return None
    model, elements = findings.model, findings.element_model
    note = (
        "[FGL87] simplifies by hand, an element at a time: where translation or rotation dominates, "
        "the other part "
        f"is dropped. Within the same budget that takes {elements.operations.total} operations; the "
        "model above takes "
        f"{model.operations.total}, the exact torque {elements.operations_full.total}."
    )
    formulas = equations_part("elements", "", elements.formulas, note=_PARTS)
    parts = (
        kept_matrix(findings),
        formulas,
        _operations("element_operations", elements),
        *_dropped(findings),
    )
    return Section("elements", "By the founding text's own method", parts, note)


def _dropped(findings: Findings) -> Iterator[Part]:
    """Parts that the founding text's method drops, by reason."""
    dropped, allowed = dropped_parts(findings), findings.element_model.accuracy.allowed
    rows = [
        row
        | {
            "symbol": part_symbol(*row["part"].split()),
            "of_allowed": row["torque_peak"] / float(allowed[row["torque_joint"] - 1])
            if allowed[row["torque_joint"] - 1]
            else None,
        }
        for row in dropped.costing
    ]
    labels = {
        "symbol": ("part", "", "math"),
        "torque_peak": ("largest torque", "@torque_unit"),
        "torque_joint": ("joint", "", "count"),
        "torque_share": ("of peak", "", "percent"),
        "of_allowed": ("of allowed", "", "percent"),
    }
    if rows:
        note = "Above 100 % of the allowed error: cancels against other dropped parts."
        yield table_of("dropped", "Parts dropped although they make torque here", rows, labels, note)
    for label, gone in (
        ("Dropped parts that are zero here", dropped.zero),
        ("that make no torque here", dropped.idle),
    ):
        if gone:
            names = ", ".join(row["part"] for row in gone)
            yield Fact("", label[:1].upper() + label[1:], len(gone), text=f"{len(gone)}: {names}")
