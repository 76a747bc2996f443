"""What is said of findings in sentences and figures, once for terminal, JSON, HTML and PDF."""

from __future__ import annotations

from collections import Counter
from typing import Any

from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.results.error_words import WorstError
from gd_analyze.results.error_words import measure_told as measure_told
from gd_analyze.results.error_words import nothing_gained as nothing_gained
from gd_analyze.results.error_words import off_by as off_by
from gd_analyze.results.error_words import worst_error as worst_error
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.motion_words import along_told, short_sentence
from gd_analyze.results.motion_words import budget_sentence as budget_sentence
from gd_analyze.results.motion_words import changing_sentence as changing_sentence
from gd_analyze.results.motion_words import has_motions as has_motions
from gd_analyze.results.motion_words import strict_sentence as strict_sentence
from gd_analyze.results.proof_words import bound_ratio as bound_ratio
from gd_analyze.results.proof_words import margins_told as margins_told
from gd_analyze.results.proof_words import tube_bound as tube_bound
from gd_analyze.results.proof_words import tube_proven as tube_proven
from gd_analyze.results.proof_words import tube_sentence as tube_sentence
from gd_analyze.results.recording_words import recording_told as recording_told
from gd_analyze.results.rows import Row, dropped_parts, element_rows
from gd_analyze.results.symmetry_words import unsymmetric_told as unsymmetric_told
from gd_analyze.results.words import drives_told
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.text import number, percent


def title(findings: Findings) -> str:
    """Name of the arm."""
    return findings.arm.title or findings.arm.name


def subtitle(findings: Findings) -> str:
    """Say along what, and whether drives act."""
    told = drives(findings)
    where = f"along {along_told(findings)}, {findings.trajectory.n_set_points} set points"
    return f"{where}, {told}" if told else where


def drives(findings: Findings) -> str:
    """Say whether drives act: "drives included" or "links alone"; "" of an arm that has none."""
    return drives_told(findings.arm, findings.model.drives)


def kept(findings: Findings) -> str:
    """How much the model keeps, in words."""
    return f"{findings.model.size[0]} {findings.model.level.keeps}"


def made_of(findings: Findings) -> str:
    """What the model is made of: "terms", "parts" of elements, or a "recursion"."""
    level = findings.model.level
    return "terms" if level.has_torque_terms else "parts" if level is ELEMENT else "recursion"


def headline(findings: Findings) -> str:
    """Answer "what can I drop, what does it cost me and is that proven" in a sentence or two."""
    model = findings.model
    if not model.accuracy.errors.peak_torque.any():
        largest = number(float(abs(findings.exact_torque).max()))
        return (
            f"No joint needs torque along this trajectory beyond round-off ({largest} N m): there is nothing "
            "to rank, and nothing to simplify."
        )
    full, left = model.operations_full.total, model.operations.total
    told = drives(findings) and f", {drives(findings)},"
    if not model.saves:
        return nothing_gained(model, "model found" if findings.is_written_out else "model of whole elements")
    cost = _cost(findings)
    if made_of(findings) != "parts":
        terms, gives = kept(findings), "give" if made_of(findings) == "terms" else "gives"
        return (
            f"{terms[0].upper()}{terms[1:]} {gives} every torque{told} in {left} operations, where the "
            f"cheapest exact program known takes {full}. {cost[0].upper()}{cost[1:]}"
        )
    dropped, all_parts = dropped_parts(findings), findings.tables["parts"].sizes["part"]
    idle = len(dropped.zero) + len(dropped.idle)
    if not dropped.costing:
        return (
            f"No part that acts can go within the budget; {idle} of {all_parts} parts make no torque along "
            "this trajectory and leaving them out costs nothing."
        )
    rest = f"; {idle} more make no torque here anyway" if idle else ""
    return (
        f"{len(dropped.costing)} of {all_parts} parts can go{rest}. That saves {percent(1 - left / full)} of "
        f"the cheapest exact program's operations{told.removesuffix(',')}. {cost[0].upper()}{cost[1:]}"
    )


def _cost(findings: Findings) -> str:
    """Say what is proven near the motion, and beside it what was sampled; or that nothing is proven."""
    model, worst = findings.model, worst_error(findings.model)
    bound = tube_bound(findings)
    if bound is None:
        said = f"{off_by(model)} along {_these(findings)}"
        return f"{said}, sampled at {_whose(findings)} set points; nothing is proven between them."
    sampled = worst.size + (f" of the {worst.of}" if worst.of == "allowed error" else "")
    near, whose = _these(findings), _whose(findings)
    return f"near {near}, proven, {off_by(model, bound)}; at {whose} set points by {sampled}."


def _these(findings: Findings) -> str:
    return "these motions" if has_motions(findings) else "this trajectory"


def _whose(findings: Findings) -> str:
    return "their" if has_motions(findings) else "its"


def facts(findings: Findings) -> list[tuple[str, str]]:
    """Four figures to begin with, and what each of them is: how good, how proven, how many, of what."""
    model, worst, proven = findings.model, worst_error(findings.model), tube_proven(findings)
    if not model.saves:
        keeps = ("exact", "the model given is the exact one")
    elif made_of(findings) in ("terms", "recursion"):
        keeps = (kept(findings), f"of {model.size[1]} in the exact model")
    else:
        dropped = dropped_parts(findings)
        gone = sum(map(len, dropped))
        keeps = (
            f"{gone} / {findings.tables['parts'].sizes['part']}",
            f"parts dropped, {gone - len(dropped.costing)} without torque here",
        )
    if not model.saves:
        bound = ("≈ 0", f"{'proven' if proven else 'error'} near the motion: only round-off")
    elif proven is None:
        bound = ("not proven", "no bound on the error is proven for this model")
    else:
        bound = (f"≤ {proven.size}", f"proven near the motion{_of(proven)}")
    return [
        bound,
        (worst.size, f"largest error at the set points{_of(worst)}"),
        (
            f"{model.operations_full.total} → {model.operations.total}",
            "operations, from the cheapest exact program known",
        ),
        keeps,
    ]


def _of(worst: WorstError) -> str:
    return f"{worst.of and f', of the {worst.of}'} (joint {worst.joint})"


def notice(findings: Findings) -> str:
    """What readings were made of, how the budget holds on several motions, and the model's own notice."""
    several = [short_sentence(findings)] if has_motions(findings) else []
    return " ".join([*recording_told(findings), *several, findings.model.notice]).strip()


def opening(findings: Findings) -> dict[str, Any]:
    """What a report opens with."""
    return {
        "title": title(findings),
        "subtitle": subtitle(findings),
        "headline": headline(findings),
        "notice": notice(findings),
        "facts": facts(findings),
        "kept_terms": kept(findings),
        "made_of": made_of(findings),
    }


def cross_check_row(findings: Findings) -> Row:
    """Row of the cross-check that comes closest to what round-off explains."""
    rows = rows_of(findings.tables["cross_check"], "comparison")
    # Without gravity its bound is zero, and so is the difference.
    return max(rows, key=lambda row: row["largest_difference"] / (row["round_off_bound"] or 1.0))


def search_steps(findings: Findings) -> list[SearchStep]:
    """The exact model, every step of the search in words, and the program made of its result."""
    model = findings.model
    return [
        SearchStep("exact model", model.operations_full.total),
        *model.accuracy.steps,
        SearchStep("final program", model.operations.total),
    ]


def verdict_counts(findings: Findings) -> dict[str, int]:
    """How many elements of D and h are of each verdict."""
    dominance = findings.dominance
    split = dominance.verdict.values[dominance.quantity.values != "gravity_loading"]
    return dict(Counter(split.tolist()))


def text_comparison(findings: Findings) -> dict[str, Any] | None:
    """Compare with the founding text's verdicts; None for an arm it does not show.

    Returns
    -------
    dict
        `source` of its verdicts; how many are `given` and how many of them `agreed` with ours; `remarks`, the
        elements on which it contradicts itself: row, its remark, and what our numbers say of it.
    """
    reference = text_verdicts(findings.arm.name)
    if reference is None:
        return None
    compared = {row["element"]: row for row in element_rows(findings) if row["text_verdict"]}
    agreed = sum(row["dominant"] == row["text_verdict"] for row in compared.values())
    remarks = [
        (compared[element], remark, _borne_out(compared[element]))
        for element, remark in reference.remarks.items()
    ]
    return {"source": reference.source, "agreed": agreed, "given": len(compared), "remarks": remarks}


def _borne_out(row: Row) -> str:
    """What our numbers say of a verdict of translation and a remark that speaks for rotation."""
    if row["dominant"] == row["text_verdict"]:
        return "our numbers support the verdict, not the remark"
    if row["dominant"] == "rotation":
        return "our numbers support the remark, not the verdict"
    if row["dominant"] == "neither":
        return "here the element is zero to round-off, so neither statement is borne out"
    return "here both effects count, so neither statement is borne out"


def not_worth_keeping(findings: Findings) -> int | None:
    """How many terms together stay below the parameters' stated uncertainty; None where none is stated."""
    stated = findings.tables["beyond"].uncertainty.notnull().any()
    return int(findings.tables["terms"].attrs["not_worth_keeping"]) if stated else None


def nothing_to_trade(findings: Findings) -> bool:
    """Whether no budget of the trade-off gives a model of fewer operations than the exact torque."""
    operations = findings.tables["trade_off"].operations.values
    return bool((operations >= findings.model.operations_full.total).all())


def above_allowed(rows: list[Row], torque: str) -> list[int]:
    """Joints at which a torque of the table "beyond" is known and above the allowed error."""
    return [row["joint"] for row in rows if (row[torque] or 0.0) > row["allowed_error"]]


def provenance_lines(findings: Findings) -> list[tuple[str, str]]:
    """What the results come from: label and value."""
    trajectory = findings.trajectory
    return [
        ("arm", f"{findings.arm.name}, SHA-256 {fingerprint(findings.arm)[:16]}"),
        ("trajectory", f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}"),
        ("trajectory origin", trajectory.origin or "not stated"),
        ("rates", trajectory.derivatives_from),
        ("drives", "inertia included, friction not" if findings.model.drives else "not included"),
        *findings.provenance.items(),
    ]
