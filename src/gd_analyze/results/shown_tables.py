"""Tables of the main job's answer, each described once: terminal, JSON, page and PDF show the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.verdicts import verdict_definition
from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.joints import motion_unit
from gd_analyze.formulas.formula import Formula, Symbol
from gd_analyze.formulas.writing import part_symbol, term_formula, torque_symbol
from gd_analyze.result import Column, Mark, SeenColumn, ShownColumn, Table, for_pages, for_people
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import bound_ratio, margins, tube_bound
from gd_analyze.results.rows import (
    SURE,
    Row,
    dropped_parts,
    effect_of,
    element_rows,
    is_doubtful,
    joint_rows,
    rows_of,
    sure_text,
    table_of,
)
from gd_analyze.schema import declared_column
from gd_analyze.text import number, percent, pretty, thousands

# Terms that people see.
_SHOWN_TERMS = 40
_SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c", "torque": "τ"}


def text_comparison(findings: Findings) -> dict[str, Any] | None:
    """Compare with [FGL87]'s verdicts; None for an arm it does not treat.

    Returns the `source` of its verdicts, the numbers `given` and `agreed` with ours, and `remarks` on
    elements where it contradicts itself: row, its remark, and what our numbers support.
    """
    reference = text_verdicts(findings.arm.name)
    if reference is None:
        return None
    compared = {row["element"]: row for row in element_rows(findings) if row["text_verdict"]}
    agreed = {name for name, row in compared.items() if row["dominant"] == row["text_verdict"]}
    # For verdicts of translation, and remarks in favour of rotation.
    conclusions = {
        "rotation": "our numbers support the remark, not the verdict",
        "zero": "the element is zero here, which supports neither",
    }
    remarks = []
    for name, remark in reference.remarks.items():
        conclusion = conclusions.get(
            compared[name]["dominant"], "both effects count here, which supports neither"
        )
        conclusion = "our numbers support the verdict, not the remark" if name in agreed else conclusion
        remarks.append((compared[name], remark, conclusion))
    return {"source": reference.source, "agreed": len(agreed), "given": len(compared), "remarks": remarks}


def not_worth_keeping(findings: Findings) -> int | None:
    """Number of terms that together stay below the stated uncertainty; None if none is stated."""
    stated = findings.tables["beyond"].uncertainty.notnull().any()
    return int(findings.tables["terms"].attrs["not_worth_keeping"]) if stated else None


def ranking_table(findings: Findings, top: int | None = None) -> Table:
    """Elements by torque: parts, largest torques of links and drive, verdict."""
    rows = element_rows(findings)
    names = [row["element"] for row in rows]
    symbols = [part_symbol(name) for name in names]
    effects = [effect_of(row) for row in rows]
    letters = [LETTERS[effect] + "?" * is_doubtful(row) for effect, row in zip(effects, rows, strict=True)]
    columns: dict[str, str | SeenColumn] = {
        "rank": Column("rank", "rank", [row["rank"] for row in rows], shown="count"),
        "element": declared_column("dominance", "element", names, drawn=symbols),
        **dict.fromkeys(("torque_share", "torque_peak", "torque_joint", "peak"), "dominance"),
        **{f"part_peak_{effect}": _part_column(rows, f"part_peak_{effect}") for effect in EFFECTS},
        **{
            f"change_without_{effect}": _part_column(
                rows, f"change_without_{effect}", label=f"without {LETTERS[effect]}"
            )
            for effect in EFFECTS
        },
        "letter": for_people(
            declared_column(
                "dominance", "verdict", letters, drawn=[Mark(effect, effect) for effect in effects]
            )
        ),
    }
    if "robustness" in findings.tables:
        columns["sure"] = ShownColumn("probability", [sure_text(row) for row in rows], shown="text")
    if any(row["text_verdict"] for row in rows):
        columns["text"] = ShownColumn(
            "[FGL87]",
            [LETTERS.get(row["text_verdict"], "") for row in rows],
            shown="text",
            meaning="verdict of [FGL87]; ✓: as ours",
            drawn=[_text_words(row) for row in rows],
        )
    title = "Elements by torque: largest parts by effect, largest torque, and its share of peak torque"
    doubts = f"; ?: less than {percent(SURE)} sure" if "robustness" in findings.tables else ""
    definition = verdict_definition(findings.dominance.attrs["threshold"], findings.arm.n_joints)
    note = f"Verdict: {definition}{doubts}."
    wide = ("rank", "peak", "sure", "change_without_translation", "change_without_rotation")
    return table_of("dominance", title, rows, columns, note, top, pages_only=wide)


def _part_column(rows: Sequence[Row], name: str, **changes: Any) -> ShownColumn:
    """A column by effect, empty for gravity, which has no rotational part; JSON has all."""
    values = [None if row["quantity"] == "gravity_loading" else row[name] for row in rows]
    return for_people(declared_column("dominance", name, values, [row["unit"] for row in rows], **changes))


def _text_words(row: Row) -> str:
    """[FGL87]'s verdict and whether it is ours."""
    verdict = row["text_verdict"]
    return f"{'✓' if verdict == row['dominant'] else '≠'} {verdict}" if verdict else "–"


def ranked_terms_table(findings: Findings) -> Table:
    """Single terms by torque; pages show the first."""
    table = findings.tables["terms"]
    rows = rows_of(table, "rank")
    kept_terms = findings.model.torques if findings.model.has_terms else None
    stated = not_worth_keeping(findings) is not None
    seen = list(zip(rows, findings.ranked_terms.items(), strict=False))[:_SHOWN_TERMS]
    terms = [term for _, (term, _) in seen]
    formulas = [Formula(Symbol(""), term_formula(term, weight).pieces) for _, (term, weight) in seen]
    quantities = [_SYMBOLS[row["quantity"]] for row, _ in seen]
    columns: dict[str, str | SeenColumn] = {
        "rank": "terms",
        "of": ShownColumn("of", quantities, shown="text"),
        "label": declared_column(
            "terms",
            "label",
            [row["label"] for row in rows],
            drawn=[torque_symbol(term.row) for term in terms],
        ),
        "text": declared_column("terms", "text", [row["text"] for row in rows], drawn=formulas),
        **dict.fromkeys(
            ("alone_share", "alone_torque", "alone_joint", "without_share", "without_joint"), "terms"
        ),
    }
    if kept_terms is not None:
        kept = ["✓" if term in kept_terms else "–" for term in terms]
        columns["kept"] = ShownColumn("kept", kept, shown="text")
    if stated:
        above = ["–" if row["below_uncertainty"] else "✓" for row, _ in seen]
        columns["above"] = for_people(declared_column("terms", "below_uncertainty", above))
    title = f"The {len(seen)} terms that matter most, of {table.attrs['total']}"
    return for_pages(table_of("terms", title, rows, columns, top=_SHOWN_TERMS))


def near_errors_table(findings: Findings) -> Table:
    """Errors near the motion, and how near."""
    rows, tube = joint_rows(findings, "tube"), findings.tables["tube"]
    columns: dict[str, str | SeenColumn] = {**_stated_errors(findings), "tube_worst_found": "tube"}
    is_proven = tube_bound(findings) is not None
    if is_proven:
        columns |= dict.fromkeys(("tube_certified", "tube_certified_share"), "tube")
    for name in ("q", "qd", "qdd"):
        cells = []
        for joint, row in zip(findings.arm.joints, rows, strict=True):
            value = row[f"tube_margin_{name}"]
            value = math.degrees(value) if joint.kind == "revolute" else value
            cells.append(f"{number(value)} {pretty(motion_unit(joint, name))}")
        columns[f"± {name}"] = for_people(declared_column("tube", f"tube_margin_{name}", cells))
    tried = int(tube.attrs["tried"])
    states = ", no state has a larger error than the bound" if is_proven else ": the states considered"
    note = f"Within {margins(findings)} of the motion, between its set points too{states}. "
    note += "The found error is the largest that a search met"
    note += f", or one of {thousands(tried)} states drawn. " if tried else ". "
    note += str(tube.attrs["note"])
    return for_pages(table_of("joints", "Torque error near the motion", rows, columns, note))


def _stated_errors(findings: Findings) -> dict[str, str | SeenColumn]:
    """Allowed and sampled errors, which precede others on pages."""
    table = findings.tables["simplified_model"]
    units = [joint.effort_unit for joint in findings.arm.joints]
    names = "allowed_error", "largest_error"
    return {
        name: for_people(declared_column("simplified_model", name, table[name].values, units))
        for name in names
    }


def far_errors_table(findings: Findings) -> Table:
    """Errors farther from the motion: in its box, and within the arm's limits."""
    beyond, rows, sentences = findings.tables["beyond"], joint_rows(findings, "beyond"), []
    simplified = findings.tables["simplified_model"]
    drawn = int(beyond.attrs["states_drawn"])
    shares = for_people(declared_column("simplified_model", "largest_share", simplified.largest_share.values))
    columns: dict[str, str | SeenColumn] = {**_stated_errors(findings), "largest_share": shares}
    if beyond.certified.notnull().all():
        columns |= dict.fromkeys(("worst_found", "certified", "certified_share"), "beyond")
        sentences.append(
            "The box holds every position, velocity and acceleration between the smallest and the largest of "
            "the trajectory, in any combination. The bound holds in all of the box."
        )
        ratio = bound_ratio(findings)
        if ratio is not None:
            sentences[0] += f" It is at most {number(math.ceil(100 * ratio) / 100)} times the found one."
    if drawn:
        columns |= dict.fromkeys(("within_limits", "within_limits_share"), "beyond")
        allowed = simplified.allowed_error.values.tolist()
        over = [
            str(row["joint"])
            for row, most in zip(rows, allowed, strict=True)
            if (row["within_limits"] or 0.0) > most
        ]
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
    note = "\n".join(sentences)
    return for_pages(table_of("beyond", "Torque error farther from the motion", rows, columns, note))


def payload_table(findings: Findings) -> Table:
    """Effect of a payload, and uncertainty of the torque; JSON has both in `far_errors_table`."""
    rows = joint_rows(findings, "beyond")
    masses = [row["mass_within_budget"] for row in rows]
    any_mass = [mass if mass < math.inf else "any" for mass in masses]
    columns: dict[str, str | SeenColumn] = {
        "torque_per_kg": "beyond",
        "mass_within_budget": declared_column("beyond", "mass_within_budget", any_mass),
    }
    note = (
        "A point mass at the origin of the last frame, unknown to the model; state a real payload "
        "with `--payload`."
    )
    if rows[0]["uncertainty"] is not None:
        columns["uncertainty"] = "beyond"
        note += " The standard uncertainty follows from the stated uncertainties of the parameters."
    title = "Payload and uncertainty of the parameters"
    return table_of("payload", title, rows, columns, note, in_json=False)


def difference_table(findings: Findings) -> Table:
    """Differences from Pinocchio, and what round-off explains."""
    rows = rows_of(findings.tables["cross_check"], "comparison")
    quantities = [row["quantity"].replace("_", " ") for row in rows]
    columns: dict[str, str | SeenColumn] = {
        "words": for_people(declared_column("cross_check", "quantity", quantities)),
        **dict.fromkeys(("largest_difference", "round_off_bound"), "cross_check"),
    }
    title = "Difference from Pinocchio, an independent implementation"
    return for_pages(table_of("residuals", title, rows, columns))


def dropped_table(findings: Findings) -> Table:
    """Parts with torque here that [FGL87]'s method drops, for pages."""
    rows, allowed = dropped_parts(findings).costing, findings.model.accuracy.allowed
    used = []
    for row in rows:
        most = float(allowed[row["torque_joint"] - 1])
        used.append(row["torque_peak"] / most if most else None)
    names = [row["part"] for row in rows]
    columns: dict[str, str | SeenColumn] = {
        "part": declared_column("parts", "part", names, drawn=[part_symbol(*name.split()) for name in names]),
        **dict.fromkeys(("torque_peak", "torque_joint", "torque_share"), "parts"),
        "of_allowed": ShownColumn("of allowed", used, shown="percent"),
    }
    title = "Parts dropped although they contribute torque here"
    return table_of("dropped", title, rows, columns, in_json=False)
