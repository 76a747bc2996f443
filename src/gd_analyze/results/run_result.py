"""The main job's answer: facts, tables and notices for terminal, JSON, HTML and PDF."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.verdict_lists import DriveShare, verdict_lists
from gd_analyze.figures.elements import LETTERS
from gd_analyze.formulas.languages import equations
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.trajectory import in_words
from gd_analyze.result import Equations, Fact, Part, Result, Section, Table
from gd_analyze.results import motion_result
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import (
    drives_text,
    headline,
    joint_errors,
    norm_facts,
    operation_facts,
    worst_error,
)
from gd_analyze.results.rows import (
    SURE,
    budget_rows,
    dropped_parts,
    effect_of,
    element_rows,
    is_doubtful,
    joint_rows,
    rows_of,
    table_of,
    threshold_text,
)
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.effort import READABLE
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.text import amount, joined, named_joints, number, percent, thousands

# What stands before each list of elements.
_LISTED = {
    "translation": "Translation dominates",
    "rotation": "Rotation dominates",
    "both": "Both count in",
    "gravity": "Gravity",
    "drive": "Drive only",
    "negligible": "Negligible",
    "zero": "Zero",
}
# Most lines of equations in a terminal.
_MOST_LINES = 25
H_NOTE = "h has terms of its own: it is not the h of this D, which --level energy keeps."
# Most elements of a list that people see; JSON has all.
_MOST_LISTED = 12


def run_result(findings: Findings, top: int = 0) -> Result:
    """All results of a run; people see the answer, with `top` rows of the rankings, and JSON has the rest."""
    arm, model = findings.arm, findings.model
    details = (*first_facts(findings), *_settings(findings), *more_facts(findings))
    return Result(
        title=arm.title or arm.name,
        subtitle=subtitle(findings),
        headline=run_headline(findings),
        parts=(
            verdict_section(findings),
            _equations(findings),
            *_stops(findings),
            joint_errors(model, tube_bound(findings)),
            *(replace(fact, label="") for fact in details),
            *motion_result.measured_parts(findings),
            *motion_result.motion_parts(findings, top),
            *motion_result.recording_parts(findings),
            ranking_table(findings, top),
            *_tables(findings),
        ),
        notices=notices(findings),
        provenance=findings.provenance,
    )


def _equations(findings: Findings) -> Equations:
    """The model's D, h and c by element, or its torques; none of more terms than one can read."""
    model = findings.model
    if len(model.terms) > READABLE and (model.is_exact or not model.level.has_torque_terms):
        return equations("equations", "", ())
    if not model.level.has_torque_terms:
        return replace(equations("equations", "", model.formulas), most_lines=0)
    shown = model.equations
    note = "" if model.level.is_mechanical or model.is_exact else H_NOTE
    return replace(equations("equations", "", shown.formulas, shown.legend, note), most_lines=_MOST_LINES)


def _stops(findings: Findings) -> Iterator[Part]:
    """The named budgets, a line each: terms, operations, and the share that is used."""
    if "stops" not in findings.tables:
        return
    rows = rows_of(findings.tables["stops"], "stop")
    asked = int(findings.tables["budgets"].attrs["asked"])
    facts = []
    for row in rows:
        text = f"{row['terms_beyond']} terms exceed it alone: too many to read"
        if row["terms"] >= 0:
            used = row["proven_share"]
            proven = "" if used is None else f"; uses {percent(used)} of it (proven)"
            text = (
                f"{row['terms']} terms, {row['operations']} + {row['operations_torque']} operations{proven}"
            )
        mine = "this model: " * (row["position"] == asked)
        facts.append(Fact("", str(row["budget"]), row["terms"], text=f"{mine}{text}"))
    yield Section("", "Models by budget: terms, operations of D, h and c apart + of the torque", tuple(facts))
    yield Fact("stops", "", rows)


def subtitle(findings: Findings) -> str:
    """The motion, and whether drives are included."""
    drives = drives_text(findings.arm, findings.model.drives)
    motions = findings.trajectory.motions
    along = in_words([motion.name for motion in motions]) if motions else findings.trajectory.name
    where = f"along {along}, {findings.trajectory.n_stated} set points"
    return f"{where}, {drives}" if drives else where


def run_headline(findings: Findings) -> str:
    """Operations saved, error, and whether it is proven; preceded by joints that a log contradicts."""
    model, bound = findings.model, near_bound(findings)
    contradicted = motion_result.contradicted_joints(findings)
    if not model.accuracy.errors.peak_torque.any():
        largest = number(float(abs(findings.exact_torque).max()))
        return f"No joint needs torque here beyond round-off ({largest} N m): nothing to rank or simplify."
    motion = "each of the motions" if findings.trajectory.motions else "the trajectory"
    tube = findings.tables["tube"]
    if tried := int(tube.attrs["tried"]):
        known = "not proven" if bound is None else f"proven {worst_error(model, bound).size}"
        near = worst_error(model, tube.tube_worst_found.values).text
        error = f"up to {near} near {motion} ({thousands(tried)} states tried; {known})"
    elif bound is None:
        error = f"up to {worst_error(model).text} at the set points, not proven between them"
    else:
        error = f"at most {worst_error(model, bound).text} near {motion} (proven)"
    return f"{contradicted}{headline(model, f'Torque error {error}')}"


def verdict_section(findings: Findings) -> Section:
    """The founding text's answer: elements listed by verdict, and joints where drives make most torque."""
    listed = verdict_lists(findings.dominance)
    facts = []
    for name, label in _LISTED.items():
        labels = listed.labels(name)
        shown, more = labels[:_MOST_LISTED], len(labels) - _MOST_LISTED
        text = ", ".join(shown) + (f" and {more} more" if more > 0 else "")
        if name in ("translation", "rotation", "both"):
            text = text or "none that counts"
        note = "up to round-off" if name == "zero" else ""
        facts.append(Fact(name, label if text else "", labels, text=text, note=note))
    text = _drives_text(listed.drives, findings.arm.n_joints)
    drives = [asdict(drive) for drive in listed.drives]
    facts.insert(-2, Fact("drives", "Drives make" if text else "", drives, text=text))
    dominances = {row.element: row.dominant for row in listed.lists["negligible"]}
    return Section("verdicts", "", (*facts, Fact("negligible_dominance", "", dominances)))


def _drives_text(drives: Sequence[DriveShare], n_joints: int) -> str:
    """Their shares and joints: "98 to 100 % of peak torque at joints 4, 5 and 6 (D44, D55, D66)"."""
    if not drives:
        return ""
    least, most = (f"{100 * pick(drive.share for drive in drives):.0f}" for pick in (min, max))
    share = f"{least} %" if least == most else f"{least} to {most} %"
    where = named_joints([drive.joint for drive in drives], n_joints)
    return f"{share} of peak torque at {where} ({', '.join(drive.element for drive in drives)})"


def first_facts(findings: Findings) -> tuple[Fact, ...]:
    """The first four figures: error near the motion, error at its set points, operations, terms kept."""
    model, bound, tube = findings.model, near_bound(findings), findings.tables["tube"]
    tried = int(tube.attrs["tried"])
    label = "" if tried else "Torque error, proven near the motion"
    if bound is None:
        proven = Fact("proven_error", label, None, text="not proven")
    elif model.is_exact:
        proven = Fact("proven_error", label, 0.0, text="round-off only")
    else:
        proven = worst_error(model, bound).fact("proven_error", label)
    full, left = model.operations_full.total, model.operations.total
    kept = f"{model.size[0]} of {model.size[1]} {model.level.keeps}"
    near = f"Torque error near the motion, {thousands(tried)} states tried"
    found = (worst_error(model, tube.tube_worst_found.values).fact("tried_error", near),) if tried else ()
    return (
        *found,
        proven,
        worst_error(model).fact("sampled_error", "Largest torque error at the set points"),
        Fact("", "Operations", left, text=f"{left} instead of {full}"),
        Fact("kept_terms", "Model", len(model.terms), text="everything" if model.is_exact else kept),
    )


def _for_json(**values: Any) -> tuple[Fact, ...]:
    return tuple(Fact(key, "", value) for key, value in values.items())


def _settings(findings: Findings) -> tuple[Fact, ...]:
    model, accuracy, trajectory = findings.model, findings.model.accuracy, findings.trajectory
    quick = "" if model.level is ELEMENT else "Search"
    return (
        *_for_json(arm=findings.arm.name, trajectory=trajectory.name, set_points=trajectory.n_stated),
        Fact("budget", "Budget", accuracy.budget),
        Fact("level", "Level", model.level.name, note="coefficients refitted" if model.refitted else ""),
        *_for_json(drives=model.drives, refitted=model.refitted),
        *operation_facts(model),
        *_for_json(
            search=[step._asdict() for step in accuracy.steps],
        ),
        Fact("", quick, "quick; `gd-analyze simplify` searches longer"),
        *norm_facts(accuracy.norms, findings.arm),
    )


def more_facts(findings: Findings) -> tuple[Fact, ...]:
    """Proven bounds, checks of the numbers, and their limits."""
    model, beyond = findings.model, findings.tables["beyond"]
    text, unlisted = text_comparison(findings), not_worth_keeping(findings)
    # The row closest to its round-off bound; without gravity bound and difference are zero.
    rows = rows_of(findings.tables["cross_check"], "comparison")
    check = max(rows, key=lambda row: row["largest_difference"] / (row["round_off_bound"] or 1.0))
    margin = str(findings.tables["tube"].attrs["margin"])
    facts = [Fact("margin", "Margins of the motion", margin, text=margins(findings))]
    if not model.is_exact and beyond.certified.notnull().all():
        worst = worst_error(model, beyond.certified.values)
        facts.append(worst.fact("box_error", "Torque error, proven in the motion's box"))
    allows = f"round-off allows {number(check['round_off_bound'])}"
    difference = check["largest_difference"], check["unit"]
    facts.append(Fact("cross_check", "Difference from Pinocchio", *difference, note=allows))
    if text is not None:
        met = f"{text['agreed']} of {text['given']} elements"
        facts.append(Fact("", "Verdicts of the founding text met", met))
    label = "" if unlisted is None else "Lowest-ranked terms within the torque's uncertainty"
    facts.append(Fact("terms_not_worth_keeping", label, unlisted, shown="count"))
    mass = beyond.mass_within_budget.values
    joint = int(mass.argmin())
    if math.isfinite(mass[joint]):
        label, note = "Unmodelled payload that uses up the budget", f"joint {joint + 1}"
        facts.append(Fact("payload_within_budget", label, float(mass[joint]), "kg", note=note))
    return tuple(facts)


def margins(findings: Findings) -> str:
    """How far from the motion the budget holds and errors are bounded, in words."""
    return Margin.parse(findings.tables["tube"].attrs["margin"]).in_words(findings.arm)


def tube_bound(findings: Findings) -> FloatArray | None:
    """Proven bound on every joint's error near the motion, N m, shape (n,); None if there is none."""
    bound = findings.tables["tube"].tube_certified
    return None if bound.isnull().any() else np.asarray(bound.values)


def near_bound(findings: Findings) -> FloatArray | None:
    """The same bound; with several motions each one's is scaled by the overall over its own allowed error."""
    bound = tube_bound(findings)
    if bound is None or "motions" not in findings.tables:
        return bound
    each = findings.tables["motions"]
    return np.asarray((each.certified * (findings.model.accuracy.allowed / each.allowed_error)).max("motion"))


def bound_ratio(findings: Findings) -> float | None:
    """Largest ratio of the certified bound to the worst error found, where that exceeds round-off."""
    rows = rows_of(findings.tables["beyond"], "joint")
    pairs = [(row["certified"], row["worst_found"]) for row in rows if row["certified"] is not None]
    return max((bound / found for bound, found in pairs if found > findings.round_off), default=None)


def notices(findings: Findings) -> tuple[str, ...]:
    """Notices that the reader must know before using the numbers."""
    note = str(findings.tables["tube"].attrs["note"])
    of_motions = *motion_result.recording_notices(findings), motion_result.strict_notice(findings)
    others = findings.model.notice, note, _drives_notice(findings), _symmetry_notice(findings)
    return tuple(filter(None, (*of_motions, *others, _long_notice(findings))))


def _long_notice(findings: Findings) -> str:
    """State which set points of a long motion are shown and stored."""
    motion = findings.trajectory
    if motion.whole is None:
        return ""
    stored = "D, h and c are stored at all of them"
    if "every_set_point" not in findings.tables:
        stored = "--every-set-point stores D, h and c at all of them"
    if "christoffel" not in findings.decomposition:
        stored += "; h_ijk are not stored (--christoffel)"
    shown, whole = thousands(motion.n_set_points), thousands(motion.n_stated)
    return (
        f"Curves show {shown} of {whole} set points, including the extremes of every quantity; peaks, RMS "
        f"values and the budget cover all. {stored}."
    )


def _drives_notice(findings: Findings) -> str:
    """State where the missing inertia of drives would matter most."""
    arm = findings.arm
    if not arm.drives or arm.counts_drives():
        return ""
    labels = [f"D{joined((i, i))}" for i in range(arm.n_joints)]
    peaks = findings.dominance.peak.sel(element=labels).values
    joint = int(peaks.argmin())
    least = amount(float(peaks[joint]), "kg m^2" if arm.is_revolute[joint] else "kg")
    return (
        f"The robot's file states no drive inertia, and none is included. It would matter most at joint "
        f"{joint + 1}: {labels[joint]} reaches {least}. State it with --drive-inertia."
    )


def _symmetry_notice(findings: Findings) -> str:
    """State where D' of absolute velocities is not symmetric, as each torque is simplified by itself."""
    model = findings.model
    if not model.level.has_torque_terms or model.level.is_mechanical:
        return ""
    kept = {
        (term.row, term.velocities[0].joint, term.monomial)
        for term in model.torques
        if term.quantity == "inertia"
    }
    places = sorted({(min(i, j), max(i, j)) for i, j, monomial in kept if (j, i, monomial) not in kept})
    if not places:
        return ""
    i, j = places[0]
    return (
        f"The model's D is not symmetric, as each torque is simplified by itself: D{joined((i, j))} and "
        f"D{joined((j, i))} keep different terms, as the first of {len(places)} such pairs. Torques are as "
        "accurate as stated. Where D must be symmetric, as in simulation or in a controller that relies on "
        "energy, use `--level energy`."
    )


def text_comparison(findings: Findings) -> dict[str, Any] | None:
    """Compare with the founding text's verdicts; None for an arm it does not treat.

    Returns the `source` of its verdicts, the numbers `given` and `agreed` with ours, and `remarks` on
    elements where it contradicts itself: row, its remark, and what our numbers support.
    """
    reference = text_verdicts(findings.arm.name)
    if reference is None:
        return None
    compared = {row["element"]: row for row in element_rows(findings) if row["text_verdict"]}
    agreed = {name for name, row in compared.items() if row["dominant"] == row["text_verdict"]}
    # For verdicts of translation, and remarks in favour of rotation.
    says = {
        "rotation": "our numbers support the remark, not the verdict",
        "zero": "the element is zero here, which supports neither",
    }
    remarks = []
    for name, remark in reference.remarks.items():
        found = says.get(compared[name]["dominant"], "both effects count here, which supports neither")
        found = "our numbers support the verdict, not the remark" if name in agreed else found
        remarks.append((compared[name], remark, found))
    return {"source": reference.source, "agreed": len(agreed), "given": len(compared), "remarks": remarks}


def not_worth_keeping(findings: Findings) -> int | None:
    """Number of terms that together stay below the stated uncertainty; None if none is stated."""
    stated = findings.tables["beyond"].uncertainty.notnull().any()
    return int(findings.tables["terms"].attrs["not_worth_keeping"]) if stated else None


def ranking_table(findings: Findings, top: int | None = None) -> Table:
    """Elements by torque: parts, largest torques of links and drive, verdict."""
    rows = element_rows(findings)
    with_text = any(row["text_verdict"] for row in rows)
    for row in rows:
        row["shown_verdict"] = LETTERS[effect_of(row)] + "?" * is_doubtful(row)
        row["shown_text"] = LETTERS.get(row["text_verdict"], "")
    labels = {
        "element": ("element", "", "text"),
        "part_peak_translation": ("tran", "@unit"),
        "part_peak_rotation": ("rot", "@unit"),
        "torque_peak": ("torque", "@torque_unit"),
        "torque_joint": ("joint", "", "count"),
        "torque_share": ("of peak", "", "percent"),
        "shown_verdict": ("verdict", "", "text"),
        **({"shown_text": ("FGL87", "", "text")} if with_text else {}),
    }
    title = "Elements by torque: largest parts by effect, largest torque, and its share of peak torque"
    note = f"Verdict: {threshold_text(findings)}; ?: less than {percent(SURE)} sure."
    return table_of("dominance", title, rows, labels, note, top=top)


def _tables(findings: Findings) -> tuple[Fact, ...]:
    """Further tables for JSON."""
    tables, elements, tube = findings.tables, findings.element_model, findings.tables["tube"].attrs
    of_elements = {
        "kept": [row["part"] for row in rows_of(tables["parts"], "part") if row["kept_by_element"]],
        "dropped": [row for group in dropped_parts(findings) for row in group],
        "operations": asdict(elements.operations),
        "operations_full": asdict(elements.operations_full),
    }
    return _for_json(
        elements=of_elements,
        terms=rows_of(tables["terms"], "rank"),
        terms_total=tables["terms"].attrs["total"],
        budgets=budget_rows(findings),
        beyond=joint_rows(findings, "beyond"),
        states_drawn=tables["beyond"].attrs["states_drawn"],
        tube={"joints": joint_rows(findings, "tube")}
        | {key: tube[key] for key in ("coarse", "tried", "note")},
        residuals=rows_of(tables["cross_check"], "comparison"),
    )


def provenance_lines(findings: Findings) -> list[tuple[str, str]]:
    """Origin of the results: label and value."""
    trajectory = findings.trajectory
    return [
        ("arm", f"{findings.arm.name}, SHA-256 {fingerprint(findings.arm)[:16]}"),
        ("trajectory", f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}"),
        ("trajectory origin", trajectory.origin or "not stated"),
        ("velocities", trajectory.derivatives_from),
        ("drives", "inertia included, friction not" if findings.model.drives else "not included"),
        *findings.provenance.items(),
    ]
