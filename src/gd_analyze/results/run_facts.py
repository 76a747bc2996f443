"""What the main job answers: its headline, facts and notices, and the values that JSON adds."""

from __future__ import annotations

import math
import shlex
from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, replace
from itertools import takewhile
from typing import TYPE_CHECKING, Any

from gd_analyze.dynamics.dominance import elements
from gd_analyze.formulas.languages import equation_part
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.motions.trajectory import counted_motions
from gd_analyze.result import AnyFact, Fact, Section, Shown, Table, Value, value_text
from gd_analyze.results import motion_result
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import (
    MASS_MATRIX,
    drives_text,
    headline,
    joint_errors,
    norm_facts,
    operation_facts,
    worst_error,
)
from gd_analyze.results.near_motion import near_bound, tube_bound
from gd_analyze.results.rows import Row, budget_rows, dropped_parts, rows_of
from gd_analyze.results.shown_tables import not_worth_keeping, text_agreement
from gd_analyze.results.verdict_lists import DriveShare, verdict_lists
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.accuracy import STATED, gamma_size
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.torque_program import READABLE
from gd_analyze.text import amount, counted, joined, named_joints, number, thousands

if TYPE_CHECKING:
    import xarray as xr

# What stands before each list of elements.
_LISTED = {
    "translation": "Translation dominates",
    "rotation": "Rotation dominates",
    "both": "Neither part can be dropped",
    "gravity": "Gravity",
    "negligible": "Negligible",
    "zero": "Zero",
}
# Lists of what counts, and the mark of their elements that the model drops.
_COUNTING = ("translation", "rotation", "both", "gravity")
_MARK = "°"
# Most elements of a list in a terminal; JSON has all.
_MOST_LISTED = 12


def stop_rows(findings: Findings) -> list[Row]:
    """The named budgets: rows of the table "stops", whether each is the run's own, and its model in words."""
    if "stops" not in findings.tables:
        return []
    position = int(findings.tables["budgets"].attrs["asked"])
    return [
        row
        | {
            "own": row["position"] == position,
            "name": Budget.parse(row["budget"]).words,
            "words": _stop_words(row, findings.proof),
        }
        for row in rows_of(findings.tables["stops"], "stop")
    ]


def _stop_words(row: Row, proof: str) -> str:
    """Terms, operations and used share of a budget's model: "14 terms; D, h, c 17/8, torque 35/4; ..."."""
    if row["terms"] < 0:
        beyond = row["terms_beyond"]
        if row["unsearched"] == "terms":
            is_long = beyond > READABLE
            return f"{beyond} terms exceed it alone: too many to read" if is_long else "too many terms matter"
        why = "the log contradicts the file" if row["unsearched"] == "log" else "the time is over"
        return f"not searched, as {why}; {beyond} terms exceed it by themselves"
    if row["terms"] > READABLE:
        return f"{row['terms']} terms: too many to read"
    costs = (
        f"D, h, c {row['operations_apart']}/{row['sines_cosines_apart']}, "
        f"torque {row['operations']}/{row['sines_cosines']}"
    )
    return f"{row['terms']} terms; {costs}; {_used_words(row, proof)}"


def _used_words(row: Row, proof: str) -> str:
    """How much of a budget its model uses: "the worst joint reaches 76 % of its allowance (proven)"."""
    share = row["proven_share"]
    if share is None or share > 1.0:
        return "not proven"
    if share == 0.0:
        return "exact up to round-off"
    reached = value_text(share, "", "bound_percent")
    return f"the worst joint reaches {reached} of its allowance ({proof})"


def stop_facts(findings: Findings) -> Iterator[AnyFact]:
    """The named budgets, a line each; JSON has their numbers."""
    rows = stop_rows(findings)
    for row in rows:
        yield Shown(("this: " if row["own"] and len(rows) > 1 else "") + row["name"], row["words"])
    if "stops" in findings.tables:
        yield Value("stops", rows_of(findings.tables["stops"], "stop"))


def errors_table(findings: Findings) -> Table:
    """The errors of the joints, sampled and near the motion."""
    return joint_errors(findings.model, tube_bound(findings), findings.proof)


def subtitle(findings: Findings) -> str:
    """The motion, and whether drives are included."""
    drives = drives_text(findings.arm, findings.model.drives)
    motions = findings.trajectory.motions
    along = counted_motions([motion.name for motion in motions]) if motions else findings.trajectory.name
    where = f"along {along}, {counted(findings.trajectory.n_stated, 'set point')}"
    return f"{where}, {drives}" if drives else where


def run_headline(findings: Findings) -> str:
    """Whether a log agrees with the file, and what the model saves."""
    return f"{motion_result.agreement_sentence(findings)}{model_headline(findings)}"


def model_headline(findings: Findings) -> str:
    """Operations saved, error, and whether it is proven."""
    model, bound = findings.model, near_bound(findings)
    if not model.accuracy.errors.peak_torque.any():
        largest = number(float(abs(findings.exact_torque).max()))
        return f"No joint needs torque here beyond round-off ({largest} N m): nothing to rank or simplify."
    if findings.is_unreadable:
        return _unreadable_headline(findings)
    motion = "each of the motions" if findings.trajectory.motions else "the trajectory"
    tube = findings.tables["tube"]
    tried = int(tube.attrs["tried"])
    if tried:
        proof = "not proven" if bound is None else f"{findings.proof} {worst_error(model, bound).size}"
        error_text = worst_error(model, tube.tube_worst_found.values).text
        error = f"up to {error_text} near {motion} ({thousands(tried)} states tried; {proof})"
    elif bound is None:
        error = f"up to {worst_error(model).text} at the set points, not proven between them"
    else:
        error = f"at most {worst_error(model, bound).text} near {motion} ({findings.proof})"
    return f"{_other_budget(findings)}{headline(model, f'Torque error {error}')}"


def _unreadable_headline(findings: Findings) -> str:
    model, stops = findings.model, stop_rows(findings)
    readable = next((row["budget"] for row in stops if 0 <= row["terms"] <= READABLE), "")
    wider = f" `--budget {shlex.quote(readable)}` has a readable model." if readable else ""
    return (
        f"{findings.substitute_reason} Shown instead: the dominant elements, and the exact torque in "
        f"{model.operations_full.in_words}.{wider}"
    )


def _other_budget(findings: Findings) -> str:
    """Name the budget of the model where a smaller one has none that can be read, or that saves anything."""
    passed = [*takewhile(lambda row: not row["own"], stop_rows(findings))]
    if not passed:
        return ""
    is_read = 0 <= passed[0]["terms"] <= READABLE
    reason = "saves nothing" if is_read else f"has more than {READABLE} terms"
    budgets = " and ".join(row["name"] for row in passed)
    return f"Within {findings.model.accuracy.asked.words} ({budgets} {reason}): "


def elements_by_verdict(findings: Findings) -> Section:
    """The elements of a run by verdict, and how many of the text's verdicts agree."""
    section = verdict_section(findings.dominance, _dropped_elements(findings))
    agreement = text_agreement(findings)
    if not agreement:
        return section
    return replace(section, parts=(*section.parts, Fact("text", "Beside the text", agreement, shown="text")))


def _dropped_elements(findings: Findings) -> set[str]:
    """Elements that the simplified model leaves out."""
    model = findings.model
    if model.is_exact:
        return set()
    if model.has_terms:
        kept = {f"{formula.left.letter}{formula.left.index}" for formula in model.equations.formulas}
    else:
        kept = {part.element.label for part in model.terms}
    return {element.label for element in elements(findings.arm.n_joints)} - kept


def verdict_section(ranking: xr.Dataset, dropped: Collection[str] = ()) -> Section:
    """[FGL87]'s answer: elements listed by verdict, and joints where drives make most torque.

    Those that count although a model has dropped them are marked for people.
    """
    listed = verdict_lists(ranking)
    facts: list[AnyFact] = []
    marks = {label: _MARK for name in _COUNTING for label in listed.labels(name) if label in dropped}
    first_marked = next(iter(marks), None)
    for name, label in _LISTED.items():
        labels = listed.labels(name)
        labels_of_people = [label + marks.get(label, "") for label in labels]
        unlisted = len(labels) - _MOST_LISTED
        text = ", ".join(labels_of_people[:_MOST_LISTED]) + (f" and {unlisted} more" if unlisted > 0 else "")
        if name in ("translation", "rotation", "both"):
            text = text or "none that counts"
        note = "up to round-off" if name == "zero" else ""
        if first_marked in labels:
            note = f"{_MARK} not in the model"
        symbols = [part_symbol(label) for label in labels_of_people]
        facts.append(Fact(name, label, labels, text=text, note=note, drawn=symbols).seen_if(bool(text)))
    alone = listed.labels("drive")
    text = "; ".join(filter(None, [_drives_text(listed.drives, int(ranking.i.max())), _alone_text(alone)]))
    drives = [asdict(drive) for drive in listed.drives]
    facts.insert(-2, Value("drive", alone))
    facts.insert(-2, Fact("drives", "Drives", drives, text=text).seen_if(bool(text)))
    dominances = {row.element: row.dominant for row in listed.lists["negligible"]}
    return Section("verdicts", "", (*facts, Value("negligible_dominance", dominances)))


def _drives_text(drives: Sequence[DriveShare], n_joints: int) -> str:
    """Their shares and joints: "98 to 100 % of peak torque at joints 4, 5 and 6"."""
    if not drives:
        return ""
    lowest, highest = (f"{100 * pick(drive.share for drive in drives):.0f}" for pick in (min, max))
    share = f"{lowest} %" if lowest == highest else f"{lowest} to {highest} %"
    return f"{share} of peak torque at {named_joints([drive.joint for drive in drives], n_joints)}"


def _alone_text(labels: Sequence[str]) -> str:
    """Elements of which only the drive counts: "alone in D66"."""
    return f"alone in {', '.join(labels)}" if labels else ""


def first_facts(findings: Findings) -> tuple[AnyFact, ...]:
    """The first figures: error near the motion and at its set points, terms or steps counted, and gamma."""
    model, bound, tube = findings.model, near_bound(findings), findings.tables["tube"]
    tried = int(tube.attrs["tried"])
    label = f"Torque error near the motion, {findings.proof}"
    is_seen, worst = not tried and not findings.is_unreadable, worst_error(model)
    proven: tuple[AnyFact, ...]
    if model.is_exact or bound is None:
        text = "round-off only" if model.is_exact else "not proven"
        error = Fact("proven_error", label, None if bound is None else 0.0, text=text)
        proven = error.seen_if(is_seen), Value("proven_error_of", worst.reference)
    else:
        proven = worst_error(model, bound).facts("proven_error", label, "at most", is_seen=is_seen)
    tried_label = f"Torque error near the motion, {thousands(tried)} states tried"
    tried_error = worst_error(model, tube.tube_worst_found.values).facts("tried_error", tried_label, "up to")
    size, gamma = model.size, model.accuracy.gamma
    counted = f"{model.level.keeps.capitalize()} kept"
    has_gamma = gamma is not None and not model.is_exact
    return (
        *(tried_error if tried else ()),
        *proven,
        *worst.facts("sampled_error", "Torque error at the set points", "up to", is_seen=not model.is_exact),
        Fact(
            "kept_terms",
            "Operations, and sines and cosines, of the exact torque" if model.is_exact else counted,
            len(model.terms),
            text=model.operations_full.pair if model.is_exact else f"{size[0]} of {thousands(size[1])}",
        ),
        *((Shown(MASS_MATRIX, gamma_size(gamma)),) if has_gamma else ()),
    )


def settings_values(findings: Findings) -> tuple[AnyFact, ...]:
    """Input and settings, and the model's operations and norms."""
    model, accuracy, trajectory = findings.model, findings.model.accuracy, findings.trajectory
    return (
        Value("arm", findings.arm.name),
        Value("trajectory", trajectory.name),
        Value("set_points", trajectory.n_stated),
        Value("budget", accuracy.budget),
        Value("level", model.level.name),
        Value("drives", model.drives),
        *operation_facts(model),
        Value("search", [step._asdict() for step in accuracy.steps]),
        *norm_facts(accuracy.norms, findings.arm),
    )


def check_values(findings: Findings) -> tuple[Value, ...]:
    """Proven bounds, checks of the numbers, and their limits."""
    model, beyond = findings.model, findings.tables["beyond"]
    values: dict[str, Any] = {"margin": str(findings.tables["tube"].attrs["margin"])}
    if not model.is_exact and beyond.certified.notnull().all():
        worst = worst_error(model, beyond.certified.values)
        values |= {"box_error": worst.value, "box_error_of": worst.reference}
    # The row closest to its round-off bound; without gravity bound and difference are zero.
    rows = rows_of(findings.tables["cross_check"], "comparison")
    check = max(rows, key=lambda row: row["largest_difference"] / (row["round_off_bound"] or 1.0))
    values["cross_check"] = check["largest_difference"]
    values["terms_not_worth_keeping"] = not_worth_keeping(findings)
    mass = float(beyond.mass_within_budget.values.min())
    if math.isfinite(mass):
        values["payload_within_budget"] = mass
    return _values(**values)


def model_values(findings: Findings) -> tuple[Value, ...]:
    """The model, the one by [FGL87]'s own method, and those of other budgets."""
    tables, elements = findings.tables, findings.element_model
    of_elements = {
        "kept": [row["part"] for row in rows_of(tables["parts"], "part") if row["kept_by_element"]],
        "dropped": [row for group in dropped_parts(findings) for row in group],
        "operations": asdict(elements.operations),
        "operations_full": asdict(findings.model.operations_full),
    }
    return _values(
        equations=list(equation_part("equations", "", findings.model.formulas).lines),
        elements=of_elements,
        terms_total=tables["terms"].attrs["total"],
        budgets=budget_rows(findings),
        states_drawn=tables["beyond"].attrs["states_drawn"],
    )


def _values(**values: Any) -> tuple[Value, ...]:
    return tuple(Value(key, value) for key, value in values.items())


def notices(findings: Findings) -> tuple[str, ...]:
    """What the reader must know before using the numbers."""
    # At level element the error is stated as the budget, which nobody asked for.
    is_asked = findings.model.level is not ELEMENT or findings.is_unreadable
    is_asked = is_asked and not _has_wider_stop(findings)
    model_notice = findings.model.notice if is_asked else ""
    stated = ""
    if findings.proof == STATED and tube_bound(findings) is not None:
        stated = f"Bounds are {STATED}; `{findings.model.accuracy.command_to_check}` proves them again."
    texts = (*motion_result.recording_notices(findings), model_notice, _drives_notice(findings), stated)
    return tuple(filter(None, texts))


def notes(findings: Findings) -> tuple[str, ...]:
    """What the report says at its end."""
    model_notice = findings.model.notice if _has_wider_stop(findings) else ""
    motion = motion_result.strict_notice(findings), str(findings.tables["tube"].attrs["note"])
    return tuple(filter(None, (model_notice, *motion, _long_notice(findings))))


def _has_wider_stop(findings: Findings) -> bool:
    """Whether a named budget accounts for the friction that the run's own is below."""
    return any("friction" in row["budget"] and row["terms"] >= 0 for row in stop_rows(findings))


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
    shown_count, whole_count = thousands(motion.n_set_points), thousands(motion.n_stated)
    covering = "peaks, RMS values and the budget cover all"
    if "recording" in findings.tables:
        covering += ", as does the noise"
    if "measured_torque" in findings.tables:
        covering += "; so do the differences of measured torque and the verdict on the log"
    return (
        f"Curves show {shown_count} of {whole_count} set points, including the extremes of every quantity; "
        f"{covering}. {stored}."
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


def provenance_lines(findings: Findings) -> dict[str, str]:
    """Origin of the results, as reports state it."""
    trajectory = findings.trajectory
    return {
        "arm": f"{findings.arm.name}, SHA-256 {fingerprint(findings.arm)[:16]}",
        "trajectory": f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}",
        "trajectory origin": trajectory.origin,
        "velocities": trajectory.derivatives_from,
        "drives": "inertia included, friction not" if findings.model.drives else "not included",
        **findings.provenance,
    }
