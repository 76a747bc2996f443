"""The model in the main report: formulas, terms kept, operations saved, and errors elsewhere."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.joints import motion_unit
from gd_analyze.figures.reach import reach_figure
from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.languages import equation_part
from gd_analyze.formulas.writing import energy_formulas, part_symbol, torque_legend, torque_symbol
from gd_analyze.harmonics.terms import TorqueTerm, Velocity
from gd_analyze.result import Column, Drawing, Fact, Part, Section, Table, joint_columns
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import structure_note
from gd_analyze.results.rows import dropped_parts, joint_rows, table_of
from gd_analyze.results.run_result import bound_ratio, is_unreadable, margins, tube_bound
from gd_analyze.simplification.effort import READABLE
from gd_analyze.simplification.element import ELEMENT, kept_effects
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import inertia_label, joined, number, percent, pretty, thousands

_CLASSES = {"inertia": "inertia", "coriolis_centrifugal": "velocity", "gravity_loading": "gravity"}
_PARTS = "A superscript names the part of an element that is kept; an element without one is kept whole."
_TERMS = (
    "Elements in joint velocities (J: drives, if any); those not listed are zero. SI units; three digits are "
    "shown, `model.json` has all."
)
_ENERGY = (
    "Kinetic and potential energy; D' is the symmetric mass matrix of absolute velocities; elements not "
    "listed are zero. Torques follow from Lagrange's equations, so energy is conserved."
)

_STEPS = (
    "Steps u in the order of evaluation, then the torques. SI units; three digits are shown, `model.json` "
    "has all."
)


def made_of(findings: Findings) -> str:
    """Kind of the model: "terms", "parts" of elements, or the "steps" of a program."""
    level = findings.model.level
    if level.has_torque_terms:
        return "terms"
    return "parts" if level is ELEMENT else "steps"


def model_parts(findings: Findings) -> tuple[Part, ...]:
    """The model itself as formulas, with explanations."""
    model, kind = findings.model, made_of(findings)
    if is_unreadable(findings):
        return _substitute_parts(findings)
    if kind == "parts":
        return (equation_part("model", "", findings.element_model.formulas, note=_PARTS),)
    if model.level.is_mechanical:
        with_velocities = (
            TorqueTerm(0, () if t.is_potential else (Velocity(1, t.i), Velocity(1, t.j)), t.monomial)
            for t in model.terms
        )
        legend = torque_legend(model.form.velocities, with_velocities)
        return (equation_part("model", "", energy_formulas(model.terms), legend, _ENERGY),)
    if kind == "terms":
        by_element = model.equations
        note = f"{structure_note(model)}\n{_TERMS}".lstrip()
        return (equation_part("model", "", by_element.formulas, by_element.legend, note),)
    return (equation_part("model", "", model.formulas, model.legend, _STEPS),)


def _substitute_parts(findings: Findings) -> tuple[Part, ...]:
    """What stands for a model that can be read: the dominant parts of the elements, and the exact torque."""
    elements, share = findings.element_model, _largest_share(findings.element_model)
    note = (
        f"No model with at most {READABLE} terms keeps the budget, so these are the dominant parts of the "
        f"elements, with an error of up to {percent(share)} of peak torque at the set points. The exact "
        f"torque takes {findings.model.operations_full.total} operations; `model.json` has it.\n{_PARTS}"
    )
    return (equation_part("model", "", elements.formulas, note=note),)


def _largest_share(model: SimplifiedModel) -> float:
    shares = model.accuracy.errors.largest_share
    return float(shares[np.isfinite(shares)].max(initial=0.0))


def model_section(findings: Findings) -> Section:
    """Terms of the exact equations that the model keeps, and the operations saved."""
    model, kind = findings.model, made_of(findings)
    parts: list[Part] = []
    if kind == "terms":
        parts.append(_tallies(model))
    elif kind == "parts":
        parts += [_kept_matrix(findings), *_dropped(findings)]
    if kind != "parts" or not model.is_exact:
        parts.append(_operations("operations", model))
    parts.append(_steps(model))
    note = (
        "Operations are counted in the program that computes only what the model needs: factored, common "
        "subexpressions computed once, changes of sign free. The exact program is the cheapest known of any "
        "formulation."
    )
    return Section("model", "Terms kept and operations saved", tuple(parts), note)


def _steps(model: SimplifiedModel) -> Table:
    """Operations after each step of the search, and what they compute."""
    searched, full = "torque", model.operations_full.total
    if model.level is TERM:
        searched, full = "D, h and c", model.form.functions.operations.total
    steps = [("exact model", searched, full)]
    steps += [(step.name, searched, step.operations) for step in model.accuracy.steps]
    steps.append(("final program", "torque", model.operations.total))
    names, quantities, counts = zip(*steps, strict=True)
    columns = (
        Column("", "step", names, shown="text"),
        Column("", "computes", quantities, shown="text"),
        Column("", "operations", counts, shown="count"),
    )
    return Table("steps", "Operations after each step of the search", columns)


def _tallies(model: SimplifiedModel) -> Table:
    """Terms kept, of all: torque terms by row and acceleration, h and c; or energy terms by element."""
    n = model.form.velocities.n_joints
    heads = [f"p̈{joined((j,))}" for j in range(n)]
    if model.level.is_mechanical:
        energy_totals, energy_kept = (
            Counter((t.i, t.j) for t in terms) for terms in (model.form.energies, model.terms)
        )
        cells = [
            [_tally("inertia", energy_kept[i, j], energy_totals[i, j]) if i <= j else "" for j in range(n)]
            + [_tally("inertia", energy_kept[-1, -1], energy_totals[-1, -1]) if i == 0 else ""]
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
        [
            _tally(_CLASSES[quantity], torque_kept[i, quantity, j], torque_totals[i, quantity, j])
            for quantity, j in places
        ]
        for i in range(n)
    ]
    title = "Torque terms kept, of all, by joint (row): with each acceleration, in h, and in c"
    return _matrix("kept", title, [torque_symbol(i) for i in range(n)], [*heads, "h", "c"], cells)


def _place(term: TorqueTerm) -> tuple[int, str, int]:
    """Row, quantity and the acceleration's joint, -1 without one."""
    return term.row, term.quantity, term.velocities[0].joint if term.quantity == "inertia" else -1


def _tally(kind: str, count: int, total: int) -> str:
    return f"{kind if count else 'none'} {count}/{total}" if total else "none ·"


def _matrix(
    key: str, title: str, names: Sequence[Symbol], heads: Sequence[str], cells: Sequence[Sequence[str]]
) -> Table:
    columns = [Column("", "row", names, shown="math")]
    columns += [Column("", head, [row[k] for row in cells], shown="effect") for k, head in enumerate(heads)]
    return Table(key, title, tuple(columns))


def _kept_matrix(findings: Findings) -> Table:
    """Parts of D, h and c that the model by [FGL87]'s own method keeps."""
    n = findings.arm.n_joints
    effects = kept_effects(n, findings.element_model.terms)
    effects |= {f"c{joined((i,))}": "gravity" for i in range(n) if effects[f"c{joined((i,))}"] != "nothing"}
    labels = [
        [*(inertia_label(i, j) for j in range(n)), f"h{joined((i,))}", f"c{joined((i,))}"] for i in range(n)
    ]
    cells = [[f"{effects[label]} {LETTERS.get(effects[label], '0')}" for label in row] for row in labels]
    title = "Parts kept of D (symmetric), h and c: T translation, R rotation, ✓ gravity, 0 nothing"
    heads = [*map(str, range(1, n + 1)), "h", "c"]
    return _matrix("kept_parts", title, [torque_symbol(i) for i in range(n)], heads, cells)


def _operations(key: str, model: SimplifiedModel) -> Table:
    names = ("multiplications", "additions", "total", "sines_cosines")
    words = ("multiplications", "additions", "both", "sines and cosines")
    before, after = (
        [getattr(count, name) for name in names] for count in (model.operations_full, model.operations)
    )
    saved = [1 - b / a if a else 0.0 for a, b in zip(before, after, strict=True)]
    columns = (
        Column("", "operations", words, shown="text"),
        Column("", "exact", before, shown="count"),
        Column("", "model", after, shown="count"),
        Column("", "saved", saved, shown="percent"),
    )
    return Table(key, "Operations for one evaluation of all torques", columns)


def beyond_section(findings: Findings) -> Section:
    """Errors near the motion and beyond it, and the effect of a payload or uncertain parameters."""
    rows = joint_rows(findings, "simplified_model", "beyond", "tube")
    has_tube = findings.tables["tube"].tube_worst_found.notnull().any()
    near = [_near(findings, rows)] if has_tube else []
    words = "Errors as multiples of the allowed error, on a logarithmic scale."
    ratios = Drawing("beyond", words, reach_figure(findings))
    parts: tuple[Part, ...] = (*near, ratios, _farther(findings, rows), _payload(rows))
    return Section("beyond", "Near this motion, and beyond it", parts)


_ERRORS = {"allowed_error": ("allowed", "@effort_unit"), "largest_error": ("at set points", "@effort_unit")}


def _near(findings: Findings, rows: Sequence[dict[str, Any]]) -> Table:
    table_rows, letters = [], {"q": "± q", "qd": "± q̇", "qdd": "± q̈"}
    tube, near = findings.tables["tube"], f"within {margins(findings)} of the motion"
    tried, proof = int(tube.attrs["tried"]), dict[str, tuple[str, ...]]()
    if tube_bound(findings) is not None:
        proof["tube_certified"] = ("proven", "@effort_unit", "bound")
        proof["tube_certified_share"] = ("of peak", "", "bound_percent")
    for joint, row in zip(findings.arm.joints, rows, strict=True):
        cells = {}
        for name in letters:
            value = row[f"tube_margin_{name}"]
            value = math.degrees(value) if joint.kind == "revolute" else value
            cells[f"tube_margin_{name}"] = f"{number(value)} {pretty(motion_unit(joint, name))}"
        table_rows.append(row | cells)
    labels = {
        **_ERRORS,
        "tube_worst_found": ("found near it", "@effort_unit"),
        **proof,
        **{f"tube_margin_{name}": (words, "", "text") for name, words in letters.items()},
    }
    note = f"{near[:1].upper()}{near[1:]}, between its set points too"
    note += ", no state has a larger error than the proven one. " if proof else ": the states considered. "
    note += "The found error is the largest that a search met"
    note += f", or one of {thousands(tried)} states drawn. " if tried else ". "
    note += str(tube.attrs["note"])
    return table_of("tube", "Torque error near the motion", table_rows, labels, note)


def _farther(findings: Findings, rows: Sequence[dict[str, Any]]) -> Table:
    beyond, sentences = findings.tables["beyond"], []
    drawn = int(beyond.attrs["states_drawn"])
    labels: dict[str, tuple[str, ...]] = {**_ERRORS, "largest_share": ("of peak", "", "percent")}
    if beyond.certified.notnull().all():
        labels |= {
            "worst_found": ("found in the box", "@effort_unit"),
            "certified": ("proven in the box", "@effort_unit", "bound"),
            "certified_share": ("of peak", "", "bound_percent"),
        }
        sentences.append(
            "The box holds every position, velocity and acceleration between the smallest and the largest of "
            "the trajectory, in any combination. The proven error holds in all of the box."
        )
        ratio = bound_ratio(findings)
        if ratio is not None:
            sentences[0] += f" It is at most {number(math.ceil(100 * ratio) / 100)} times the found one."
    if drawn:
        labels |= {
            "within_limits": ("within limits", "@effort_unit"),
            "within_limits_share": ("of peak", "", "percent"),
        }
        over = [str(row["joint"]) for row in rows if (row["within_limits"] or 0.0) > row["allowed_error"]]
        where = "within the allowed one."
        if over:
            everywhere = f"`gd-analyze simplify {findings.arm.name}` searches a model for all of them."
            where = f"above the allowed one at joints {', '.join(over)}. {everywhere}"
        sentences.append(
            f"{drawn} states were drawn within the arm's limits of position, velocity and acceleration; the "
            f"error is {where}"
        )
    else:
        sentences.append(
            "No states were drawn within the arm's limits, as it does not state all of them (`--limits`)."
        )
    return table_of("beyond", "Torque error farther from the motion", rows, labels, "\n".join(sentences))


def _payload(rows: Sequence[dict[str, Any]]) -> Table:
    labels: dict[str, tuple[str, ...]] = {
        "torque_per_kg": ("torque per kg", "@effort_unit"),
        "mass_within_budget": ("payload within budget", "kg"),
    }
    note = (
        "A point mass at the origin of the last frame, unknown to the model; state a real payload "
        "with `--payload`."
    )
    if rows[0]["uncertainty"] is not None:
        labels["uncertainty"] = ("uncertainty of torque", "@effort_unit")
        note += " The standard uncertainty follows from the stated uncertainties of the parameters."
    masses = [row["mass_within_budget"] for row in rows]
    any_mass = [{"mass_within_budget": mass if mass < math.inf else "any"} for mass in masses]
    table_rows = [row | mass for row, mass in zip(rows, any_mass, strict=True)]
    return table_of("payload", "Payload and uncertainty of the parameters", table_rows, labels, note)


def founding_section(findings: Findings) -> Section:
    """The model by [FGL87]'s own method."""
    model, elements = findings.model, findings.element_model
    share = _largest_share(elements)
    note = (
        "[FGL87] simplifies by hand, element by element: where translation or rotation dominates, the "
        f"other part is dropped. This takes {elements.operations.total} operations, with an error of up to "
        f"{percent(share)} of peak torque; the model above takes {model.operations.total}, the exact torque "
        f"{elements.operations_full.total}."
    )
    parts = (
        _kept_matrix(findings),
        equation_part("elements", "", elements.formulas, note=_PARTS),
        _operations("element_operations", elements),
        *_dropped(findings),
        *_by_verdicts(findings),
    )
    return Section("elements", "By [FGL87]'s own method", parts, note)


def _by_verdicts(findings: Findings) -> tuple[Table, Table]:
    """Torque error and operations of models that keep only the dominant part of every element."""
    table, source_names = findings.tables["by_verdicts"], {"own": "our verdicts", "text": "[FGL87]"}
    errors = zip(table.verdicts.values.tolist(), table.largest_share.values, strict=True)
    shares = (
        Column("", f"by {source_names.get(name, name)}", values.tolist(), shown="percent")
        for name, values in errors
    )
    counts = zip(table.quantity.values.tolist(), table.operations.values.T, strict=True)
    operations = (Column("", name, values.tolist(), shown="count") for name, values in counts)
    programs = [source_names.get(name, name) for name in table.program.values.tolist()]
    title = "Largest torque error over peak torque if only the dominant parts of D and h are kept"
    note = (
        "Exact: the cheapest known program of each quantity. By element: D, h and c as [FGL87] writes them, "
        "with shared subexpressions."
    )
    return (
        Table("verdict_errors", title, (*joint_columns(findings.arm.joints), *shares)),
        Table(
            "verdict_operations",
            "Operations of D, h and c",
            (Column("", "program", programs, shown="text"), *operations),
            note,
        ),
    )


def _dropped(findings: Findings) -> Iterator[Part]:
    """Parts that [FGL87]'s method drops, by reason."""
    dropped, allowed = dropped_parts(findings), findings.model.accuracy.allowed
    labels = {
        "symbol": ("part", "", "math"),
        "torque_peak": ("largest torque", "@torque_unit"),
        "torque_joint": ("joint", "", "count"),
        "torque_share": ("of peak", "", "percent"),
        "of_allowed": ("of allowed", "", "percent"),
    }
    rows = []
    for row in dropped.costing:
        most = float(allowed[row["torque_joint"] - 1])
        used = {"of_allowed": row["torque_peak"] / most if most else None}
        rows.append(row | used | {"symbol": part_symbol(*row["part"].split())})
    if rows:
        yield table_of("dropped", "Parts dropped although they contribute torque here", rows, labels)
    reasons = {
        "Dropped parts that are zero here": dropped.zero,
        "Dropped parts without torque here": dropped.idle,
    }
    for label, dropped_rows in reasons.items():
        if dropped_rows:
            names = ", ".join(row["part"] for row in dropped_rows)
            yield Fact("", label, len(dropped_rows), text=f"{len(dropped_rows)}: {names}")
