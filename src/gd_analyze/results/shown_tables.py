"""Tables of the main job's answer, each described once: terminal, JSON, page and PDF show the same."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.verdicts import verdict_definition
from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.joints import motion_unit
from gd_analyze.formulas.formula import Formula, Symbol
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.writing import part_symbol, term_formula, torque_legend, torque_symbol
from gd_analyze.result import Mark, Table, values_of
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import bound_ratio, margins, tube_bound
from gd_analyze.results.rows import (
    SURE,
    Row,
    dropped_parts,
    element_rows,
    is_doubtful,
    joint_rows,
    sure_text,
    values_along,
)
from gd_analyze.schema import declared_columns, declared_table
from gd_analyze.text import enumerated, number, percent, pretty, thousands

# What people see of the rankings and of errors, in order; JSON and the files of results have all columns.
_ELEMENTS_IN_TERMINAL = [
    "element", "torque_share", "torque_peak", "torque_joint",
    "part_peak_translation", "part_peak_rotation",
    "verdict", "text_verdict",
]  # fmt: skip
_ELEMENTS_ON_PAGE = [
    "rank", "element", "torque_share", "torque_peak", "torque_joint", "peak",
    "part_peak_translation", "part_peak_rotation", "change_without_translation", "change_without_rotation",
    "verdict", "probability", "text_verdict",
]  # fmt: skip
TERMS_IN_TERMINAL = [  # of `gd-analyze rank-terms`; the main job's terminal has no room
    "rank", "label", "text", "alone_torque", "alone_joint", "alone_share", "without_share", "without_joint",
]  # fmt: skip
_TERMS_ON_PAGE = [
    "rank", "of", "label", "text", "alone_share", "alone_torque", "alone_joint",
    "without_share", "without_joint", "kept", "below_uncertainty",
]  # fmt: skip
_NEAR_ERRORS_ON_PAGE = [
    "joint", "allowed_error", "sampled_error", "tube_worst_found", "tube_certified", "tube_certified_share",
    "tube_margin_q", "tube_margin_qd", "tube_margin_qdd",
]  # fmt: skip
_FAR_ERRORS_ON_PAGE = [
    "joint", "allowed_error", "sampled_error", "largest_share", "worst_found", "certified", "certified_share",
    "within_limits", "within_limits_share",
]  # fmt: skip
# Terms that people see.
_SHOWN_TERMS = 40
_SYMBOLS = {"inertia": "D", "coriolis_centrifugal": "h", "gravity_loading": "c", "torque": "τ"}


def text_comparison(findings: Findings) -> dict[str, Any] | None:
    """Compare with [FGL87]'s verdicts; None for an arm it does not treat.

    Returns the `source` of its verdicts, the numbers `given` and `agreed` with ours, in `others` how many of
    the others have each verdict here, and `remarks` on elements where it contradicts itself: row, its remark,
    and what our numbers support.
    """
    reference = text_verdicts(findings.arm.name)
    if reference is None:
        return None
    compared = {row["element"]: row for row in element_rows(findings) if row["text_verdict"]}
    agreed = {name for name, row in compared.items() if row["verdict"] == row["text_verdict"]}
    others = Counter(row["verdict"] for name, row in compared.items() if name not in agreed)
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
    return {
        "source": reference.source,
        "agreed": len(agreed),
        "given": len(compared),
        "others": others,
        "remarks": remarks,
    }


# What the verdict on elements is called that the text judges otherwise.
_OTHERWISE = {
    "negligible": "negligible",
    "zero": "zero",
    "drive": "the drive's",
    "both": "in need of both parts",
    "translation": "translational",
    "rotation": "rotational",
}


def text_agreement(findings: Findings) -> str:
    """How many of [FGL87]'s verdicts agree with ours, and why the others do not; "" for another arm."""
    text = text_comparison(findings)
    if text is None:
        return ""
    counts = [
        f"{text['others'][effect]} {words}" for effect, words in _OTHERWISE.items() if text["others"][effect]
    ]
    return (
        f"{text['agreed']} of {text['given']} verdicts of [FGL87] agree; the others are "
        f"{enumerated(counts)} here. The text states neither its trajectory nor its masses."
    )


def not_worth_keeping(findings: Findings) -> int | None:
    """Number of terms that together stay below the stated uncertainty; None if none is stated."""
    count = int(findings.tables["terms"].attrs["not_worth_keeping"])
    return None if count < 0 else count


def ranking_table(findings: Findings, top: int | None = None) -> Table:
    """Elements by torque: parts, largest torques of links and drive, verdict."""
    rows = element_rows(findings)
    is_uncertain, is_in_text = "robustness" in findings.tables, any(row["text_verdict"] for row in rows)
    seen: dict[str, Any] = {
        "verdict": [LETTERS[row["verdict"]] + "?" * is_doubtful(row) for row in rows],
        "probability": [sure_text(row) for row in rows] if is_uncertain else None,
        "text_verdict": [LETTERS.get(row["text_verdict"], "") for row in rows] if is_in_text else None,
    }
    for effect in EFFECTS:  # gravity has no rotational part
        for name in (f"part_peak_{effect}", f"change_without_{effect}"):
            seen[name] = [None if row["quantity"] == "gravity_loading" else row[name] for row in rows]
    drawn: dict[str, Any] = {
        "element": [part_symbol(row["element"]) for row in rows],
        "verdict": [Mark(row["verdict"], row["verdict"]) for row in rows],
        "text_verdict": [_text_words(row) for row in rows],
    }
    definition = verdict_definition(findings.dominance.attrs["threshold"], findings.arm.n_joints)
    doubts = f"; ?: less than {percent(SURE)} sure" if is_uncertain else ""
    return declared_table(
        "dominance",
        "dominance",
        "Elements by torque: largest parts by effect, largest torque, and its share of peak torque",
        values_of(rows),
        _ELEMENTS_IN_TERMINAL,
        _ELEMENTS_ON_PAGE,
        f"Verdict: {definition}{doubts}.",
        top,
        seen=seen,
        words={f"change_without_{effect}": LETTERS[effect] for effect in EFFECTS},
        drawn=drawn,
    )


def _text_words(row: Row) -> str:
    """[FGL87]'s verdict and whether it is ours."""
    verdict = row["text_verdict"]
    return f"{'✓' if verdict == row['verdict'] else '≠'} {verdict}" if verdict else "–"


def ranked_terms_table(findings: Findings) -> Table:
    """Single terms by torque; pages show the first."""
    table, model = findings.tables["terms"], findings.model
    values = values_along(table, "rank")
    terms = list(findings.ranked_terms.items())[:_SHOWN_TERMS]
    seen = {
        "of": [_SYMBOLS[quantity] for quantity in values["quantity"].tolist()],
        "kept": None,
        "below_uncertainty": None,
    }
    if model.has_terms:
        seen["kept"] = ["✓" if term in model.torques else "–" for term in findings.ranked_terms]
    if not_worth_keeping(findings) is not None:
        seen["below_uncertainty"] = ["–" if is_below else "✓" for is_below in values["below_uncertainty"]]
    legend = Plain().legend(torque_legend(model.form.velocities, [term for term, _ in terms]))
    return declared_table(
        "terms",
        "terms",
        f"The {len(terms)} terms that matter most, of {table.attrs['total']}",
        values,
        _TERMS_ON_PAGE,
        note=f"Where {', '.join(legend)}." if legend else "",
        top=_SHOWN_TERMS,
        seen=seen,
        drawn={
            "label": [torque_symbol(term.row) for term, _ in terms],
            "text": [Formula(Symbol(""), term_formula(*term).pieces) for term in terms],
        },
    )


def near_errors_table(findings: Findings) -> Table:
    """Errors near the motion, and how near."""
    rows, tube = joint_rows(findings, "tube"), findings.tables["tube"]
    is_proven = tube_bound(findings) is not None
    seen = _stated_errors(findings)
    if not is_proven:
        seen |= {"tube_certified": None, "tube_certified_share": None}
    for name in ("q", "qd", "qdd"):
        margin, cells = f"tube_margin_{name}", []
        for joint, row in zip(findings.arm.joints, rows, strict=True):
            value = math.degrees(row[margin]) if joint.kind == "revolute" else row[margin]
            cells.append(f"{number(value)} {pretty(motion_unit(joint, name))}")
        seen[margin] = cells
    tried = int(tube.attrs["tried"])
    states = ", no state has a larger error than the bound" if is_proven else ": the states considered"
    note = f"Within {margins(findings)} of the motion, between its set points too{states}. "
    note += "The found error is the largest that a search met"
    note += f", or one of {thousands(tried)} states drawn. " if tried else ". "
    note += str(tube.attrs["note"])
    return declared_table(
        "tube",
        "joints",
        "Torque error near the motion",
        values_of(rows),
        _NEAR_ERRORS_ON_PAGE,
        note=note,
        seen=seen,
    )


def _stated_errors(findings: Findings) -> dict[str, Any]:
    """Allowed and sampled errors, which precede others on pages."""
    table = findings.tables["simplified_model"]
    return {
        "allowed_error": table.allowed_error.values,
        "sampled_error": table.largest_error.values,
        "largest_share": table.largest_share.values,
    }


def far_errors_table(findings: Findings) -> Table:
    """Errors farther from the motion: in its box, and within the arm's limits."""
    beyond, rows, sentences = findings.tables["beyond"], joint_rows(findings, "beyond"), []
    simplified = findings.tables["simplified_model"]
    drawn = int(beyond.attrs["states_drawn"])
    seen = _stated_errors(findings)
    if beyond.certified.isnull().any():
        seen |= {"worst_found": None, "certified": None, "certified_share": None}
    else:
        sentences.append(
            "The box holds every position, velocity and acceleration between the smallest and the largest of "
            "the trajectory, in any combination. The bound holds in all of the box."
        )
        ratio = bound_ratio(findings)
        if ratio is not None:
            sentences[0] += f" It is at most {number(math.ceil(100 * ratio) / 100)} times the found one."
    if drawn:
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
        seen |= {"within_limits": None, "within_limits_share": None}
        sentences.append(
            "No states were drawn within the arm's limits, as it does not state all of them (`--limits`)."
        )
    return declared_table(
        "beyond",
        "beyond",
        "Torque error farther from the motion",
        values_of(rows),
        _FAR_ERRORS_ON_PAGE,
        note="\n".join(sentences),
        seen=seen,
    )


def payload_table(findings: Findings) -> Table:
    """Effect of a payload, and uncertainty of the torque; JSON has both in `far_errors_table`."""
    rows = joint_rows(findings, "beyond")
    masses = [row["mass_within_budget"] for row in rows]
    seen: dict[str, Any] = {"mass_within_budget": [mass if mass < math.inf else "any" for mass in masses]}
    note = (
        "A point mass at the origin of the last frame, unknown to the model; state a real payload "
        "with `--payload`."
    )
    if rows[0]["uncertainty"] is None:
        seen["uncertainty"] = None
    else:
        note += " The standard uncertainty follows from the stated uncertainties of the parameters."
    names = ["joint", "torque_per_kg", "mass_within_budget", "uncertainty"]
    title = "Payload and uncertainty of the parameters"
    return Table("payload", title, declared_columns("beyond", values_of(rows) | seen, names), note)


def difference_table(findings: Findings) -> Table:
    """Differences from Pinocchio, and what round-off explains."""
    values = values_along(findings.tables["cross_check"], "comparison")
    return declared_table(
        "cross_check",
        "residuals",
        "Difference from Pinocchio, an independent implementation",
        values,
        ["quantity", "largest_difference", "round_off_bound"],
        seen={"quantity": [quantity.replace("_", " ") for quantity in values["quantity"].tolist()]},
    )


def dropped_table(findings: Findings) -> Table:
    """Parts with torque here that [FGL87]'s method drops, for pages."""
    rows, allowed = dropped_parts(findings).costing, findings.model.accuracy.allowed
    used = []
    for row in rows:
        most = float(allowed[row["torque_joint"] - 1])
        used.append(row["torque_peak"] / most if most else None)
    names = ["part", "torque_peak", "torque_joint", "torque_share"]
    columns = declared_columns(
        "parts",
        values_of(rows, *names, "torque_unit") | {"of_allowed": used},
        [*names, "of_allowed"],
        drawn={"part": [part_symbol(*row["part"].split()) for row in rows]},
    )
    return Table("dropped", "Parts dropped although they contribute torque here", columns)
