"""What the main job answers: facts, tables and notices, which terminal, JSON, HTML and PDF show."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.tube import Margin
from gd_analyze.dynamics.dominance import text_verdicts
from gd_analyze.dynamics.measured_torque import CONTRADICTING
from gd_analyze.figures.elements import LETTERS
from gd_analyze.formulas.languages import equations
from gd_analyze.motions.trajectory import in_words
from gd_analyze.result import Column, Fact, Part, Result, Section, Table, joint_columns
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of, table_of
from gd_analyze.results.model_facts import (
    WorstError,
    drives_text,
    headline,
    joint_errors,
    norm_facts,
    operation_facts,
    worst_error,
)
from gd_analyze.results.rows import Row, budget_rows, dropped_parts, element_rows, joint_rows
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint
from gd_analyze.schema import UNITS
from gd_analyze.simplification.accuracy import share_of
from gd_analyze.simplification.budget import ReferenceTorques
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.text import amount, joined, named_joints, number, with_error

if TYPE_CHECKING:
    import xarray as xr

# Verdicts in the order of the reports, and what they are called.
VERDICTS = {
    "translation": "translation",
    "rotation": "rotation",
    "both": "both",
    "gravity": "gravity",
    "negligible": "negligible",
    "neither": "zero",
}
_NOTHING = {"negligible", "neither"}
# Elements that a fact names, and motions that have a column each.
_NAMED, _MOST_COLUMNS = 8, 12
# A motion that allows a joint so many times less than others is named: it may be what costs the operations.
_STRICT = 20.0
# Where to look for the reason why a measured torque contradicts the model.
_CHECK = {
    "too light": ("masses", "payload", "the unit of the torques"),
    "too heavy": ("masses", "the unit of the torques"),
    "other sign": ("the directions of the axes",),
    "another joint's": ("the order of the columns",),
    "does not follow": ("the columns of the torques", "the units of the motion"),
}


def run_result(findings: Findings, top: int = 12) -> Result:
    """All that a run found, `top` rows of the rankings for people."""
    arm, model = findings.arm, findings.model
    return Result(
        title=arm.title or arm.name,
        subtitle=subtitle(findings),
        headline=run_headline(findings),
        facts=first_facts(findings),
        parts=(
            *_settings(findings),
            joint_errors(model, tube_bound(findings)),
            *more_facts(findings),
            *measured_parts(findings),
            *motion_parts(findings, top),
            *recording_parts(findings),
            ranking_table(findings, top),
            *_tables(findings),
        ),
        notices=notices(findings),
        provenance=findings.provenance,
    )


def subtitle(findings: Findings) -> str:
    """Along what, and whether drives act."""
    drives = drives_text(findings.arm, findings.model.drives)
    motions = findings.trajectory.motions
    along = in_words([motion.name for motion in motions]) if motions else findings.trajectory.name
    where = f"along {along}, {findings.trajectory.n_set_points} set points"
    return f"{where}, {drives}" if drives else where


def run_headline(findings: Findings) -> str:
    """What can be dropped, at what error, and whether that is proven."""
    model, bound = findings.model, tube_bound(findings)
    if not model.accuracy.errors.peak_torque.any():
        largest = number(float(abs(findings.exact_torque).max()))
        return f"No joint needs torque here beyond round-off ({largest} N m): nothing to rank or simplify."
    motion = "the motions" if findings.trajectory.motions else "the trajectory"
    if bound is None:
        error = f"{worst_error(model).text} at the set points, not proven between them"
    else:
        error = f"{worst_error(model, bound).text} near {motion} (proven)"
    return headline(model, f"Torque error at most {error}")


def first_facts(findings: Findings) -> tuple[Fact, ...]:
    """Four figures to begin with: how well proven, how good, how many operations, of what."""
    model, bound = findings.model, tube_bound(findings)
    label = "Torque error, proven near the motion"
    proven = Fact("proven_error", label, None, text="not proven")
    if bound is not None:
        proven = worst_error(model, bound).fact("proven_error", label)
    if bound is not None and not model.saves:
        proven = Fact("proven_error", label, 0.0, text="round-off only")
    full, left = model.operations_full.total, model.operations.total
    kept = f"{model.size[0]} of {model.size[1]} {model.level.keeps}"
    return (
        proven,
        worst_error(model).fact("sampled_error", "Torque error at the set points"),
        Fact("", "Operations", left, text=f"{left} instead of {full}"),
        Fact("kept_terms", "Kept", len(model.terms), text=kept if model.saves else "everything"),
    )


def _settings(findings: Findings) -> tuple[Fact, ...]:
    model, accuracy, trajectory = findings.model, findings.model.accuracy, findings.trajectory
    operations, full, saves = operation_facts(model)
    return (
        Fact("arm", "", findings.arm.name),
        Fact("trajectory", "", trajectory.name),
        Fact("set_points", "", trajectory.n_set_points),
        Fact("budget", "Budget", accuracy.budget),
        Fact("level", "Level", model.level.name, note="coefficients refitted" if model.refitted else ""),
        Fact("drives", "", model.drives),
        Fact("refitted", "", model.refitted),
        operations,
        full,
        saves,
        Fact("", "Operations by level", "", text=_by_level(findings)),
        Fact("levels", "", [one._asdict() for one in accuracy.levels]),
        Fact("search", "", [step._asdict() for step in accuracy.steps]),
        Fact("", "" if model.level is ELEMENT else "Search", "quick; `gd-analyze simplify` searches longer"),
        *norm_facts(accuracy.norms, findings.arm),
    )


def _by_level(findings: Findings) -> str:
    """Operations of every level under the budget, and in brackets those of its refitted model."""
    asked = findings.tables["trade_off"].sel(factor=1.0)
    counts: dict[str, str] = {}
    for level, refit, count in zip(
        asked.level.values, asked.refit.values, asked.operations.values, strict=True
    ):
        counts[level] = f"{counts[level]} (refitted {count})" if refit else f"{level} {count}"
    return ", ".join(counts.values())


def more_facts(findings: Findings) -> tuple[Fact, ...]:
    """What is proven and where, and what confirms or limits the numbers."""
    model, tube, arm = findings.model, findings.tables["tube"], findings.arm
    beyond = findings.tables["beyond"]
    text, check, unlisted = text_comparison(findings), cross_check_row(findings), not_worth_keeping(findings)
    facts = [Fact("margin", "Margins of the proof", str(tube.attrs["margin"]), text=margins(findings))]
    if model.saves and beyond.certified.notnull().all():
        worst = worst_error(model, beyond.certified.values)
        facts.append(worst.fact("box_error", "Torque error, proven in the motion's box"))
    facts.append(
        Fact(
            "cross_check",
            "Difference from Pinocchio",
            check["largest_difference"],
            check["unit"],
            note=f"round-off allows {number(check['round_off_bound'])}",
        )
    )
    if text is not None:
        facts.append(
            Fact("", "Verdicts of the founding text met", f"{text['agreed']} of {text['given']} elements")
        )
    label = "" if unlisted is None else "Last terms within the torque's uncertainty"
    facts.append(Fact("terms_not_worth_keeping", label, unlisted, shown="count"))
    smallest = beyond.mass_within_budget.values
    joint = int(smallest.argmin())
    if math.isfinite(smallest[joint]):
        facts.append(
            Fact(
                "payload_within_budget",
                "Unmodelled payload that uses up the budget",
                float(smallest[joint]),
                "kg",
                note=f"joint {arm.joints[joint].name}",
            )
        )
    return tuple(facts)


def margins(findings: Findings) -> str:
    """How far from the motion the errors are proven, in words."""
    return Margin.parse(findings.tables["tube"].attrs["margin"]).in_words(findings.arm)


def tube_bound(findings: Findings) -> FloatArray | None:
    """What is proven of every joint's error near the motion, N m, shape (n,); None where nothing is."""
    bound = findings.tables["tube"].tube_certified
    return None if bound.isnull().any() else np.asarray(bound.values)


def tube_error(findings: Findings) -> WorstError | None:
    """Error that is proven near the motion, of the joint where it is worst; None where nothing is."""
    bound = tube_bound(findings)
    return None if bound is None else worst_error(findings.model, bound)


def bound_ratio(findings: Findings) -> float | None:
    """How far the certified bound lies above the worst error found, at most, where that is an error."""
    rows = rows_of(findings.tables["beyond"], "joint")
    pairs = [(row["certified"], row["worst_found"]) for row in rows if row["certified"] is not None]
    return max((bound / found for bound, found in pairs if found > findings.round_off), default=None)


def notices(findings: Findings) -> tuple[str, ...]:
    """What the reader must know before believing the numbers."""
    note = str(findings.tables["tube"].attrs["note"])
    said = [*_recording_notices(findings), strict_notice(findings), findings.model.notice, note]
    return tuple(filter(None, [*said, symmetry_notice(findings)]))


def unsymmetric(findings: Findings) -> list[tuple[int, int]]:
    """Elements of D', row and column from 1, of which the model keeps other terms than of their mirror image.

    Torques are simplified one by one at the level of torque terms; D' is the matrix of absolute velocities.
    """
    model = findings.model
    if not model.level.has_torque_terms or model.level.is_mechanical:
        return []
    kept = {
        (term.row, term.velocities[0].joint, term.monomial)
        for term in model.torques
        if term.quantity == "inertia" and term.row != term.velocities[0].joint
    }
    places = {(i, j) for i, j, monomial in kept if (j, i, monomial) not in kept}
    return sorted({(min(place) + 1, max(place) + 1) for place in places})


def symmetry_notice(findings: Findings) -> str:
    """Say that D is not symmetric, and what to use where it must be; "" where it is."""
    places = unsymmetric(findings)
    if not places:
        return ""
    i, j = (place - 1 for place in places[0])
    return (
        f"The model's D is not symmetric, as each torque is simplified by itself: D{joined((i, j))} and "
        f"D{joined((j, i))} keep different terms, the first of {len(places)} such pairs. Torques are as "
        "accurate as stated. Where D must be symmetric, as in simulation or in a controller that relies on "
        "energy, use `--level energy`."
    )


def cross_check_row(findings: Findings) -> Row:
    """Row of the cross-check that comes closest to what round-off explains."""
    rows = rows_of(findings.tables["cross_check"], "comparison")
    # Without gravity its bound is zero, and so is the difference.
    return max(rows, key=lambda row: row["largest_difference"] / (row["round_off_bound"] or 1.0))


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
        (compared[name], remark, _borne_out(compared[name])) for name, remark in reference.remarks.items()
    ]
    return {"source": reference.source, "agreed": agreed, "given": len(compared), "remarks": remarks}


def _borne_out(row: Row) -> str:
    """What our numbers say of a verdict of translation and a remark that speaks for rotation."""
    if row["dominant"] == row["text_verdict"]:
        return "our numbers support the verdict, not the remark"
    if row["dominant"] == "rotation":
        return "our numbers support the remark, not the verdict"
    if row["dominant"] == "neither":
        return "the element is zero here, which supports neither"
    return "both effects count here, which supports neither"


def not_worth_keeping(findings: Findings) -> int | None:
    """How many terms together stay below the parameters' stated uncertainty; None where none is stated."""
    stated = findings.tables["beyond"].uncertainty.notnull().any()
    return int(findings.tables["terms"].attrs["not_worth_keeping"]) if stated else None


def effect_of(row: Row, what: str = "verdict") -> str:
    """The "verdict", "dominant" or "kept" effect of a row of `element_rows`; gravity has no effects."""
    effect: str = row[what]
    return "gravity" if row["quantity"] == "gravity_loading" and effect not in _NOTHING else effect


def ranking_table(findings: Findings, top: int | None = None) -> Table:
    """Elements by torque: what each consists of, which effect dominates, and which is kept."""
    rows = element_rows(findings)
    with_text = any(row["text_verdict"] for row in rows)
    shown = [
        row
        | {
            "shown_verdict": mark_of(effect_of(row)),
            "shown_kept": LETTERS[effect_of(row, "kept")],
            "shown_text": LETTERS.get(row["text_verdict"], ""),
        }
        for row in rows
    ]
    labels = {
        "element": ("element", "", "text"),
        "part_peak_translation": ("tran", "@unit"),
        "part_peak_rotation": ("rot", "@unit"),
        "torque_peak": ("torque", "@torque_unit"),
        "torque_joint": ("joint", "", "count"),
        "torque_share": ("of peak", "", "percent"),
        "shown_verdict": ("effect", "", "text"),
        "shown_kept": ("kept", "", "text"),
        **({"shown_text": ("FGL87", "", "text")} if with_text else {}),
    }
    title = "Elements by torque: largest parts by effect, largest torque, and its share of peak torque"
    return table_of("dominance", title, shown, labels, top=top)


def measured_parts(findings: Findings) -> tuple[Part, ...]:
    """Measured torque beside the model's, and the friction fitted; nothing where none was measured."""
    if "measured_torque" not in findings.tables:
        return ()
    table = findings.tables["measured_torque"]
    parts: list[Part] = [
        Fact("described", "", is_described(table)),
        Fact("compared", "Set points with measured torque", table.attrs["compared"], shown="count"),
        measured_table(table, findings.arm),
        *friction_tables(table, findings.arm),
    ]
    return (Section("measured_torque", "", tuple(parts)),)


def measured_table(table: xr.Dataset, arm: RobotArm) -> Table:
    """Measured torque beside the exact one, joint by joint."""
    rows = [
        row | {"effort_unit": joint.effort_unit, "shown_verdict": verdict_text(row)}
        for row, joint in zip(rows_of(table, "joint"), arm.joints, strict=True)
    ]
    labels = {
        "correlation": ("correlation",),
        "slope": ("slope",),
        "rms_difference": ("RMS difference", "@effort_unit"),
        "explained": ("explained", "", "percent"),
        "shown_verdict": ("verdict", "", "text"),
    }
    title = "Measured torque beside the exact one"
    return table_of("joints", title, rows, labels)


def friction_tables(table: xr.Dataset, arm: RobotArm, beside: str = "") -> tuple[Table, ...]:
    """Friction and offset fitted to each joint's difference, with standard errors, where it was asked for."""
    if "coulomb" not in table:
        return ()
    rows = rows_of(table, "joint")
    efforts = [joint.effort_unit for joint in arm.joints]
    viscous = [UNITS["viscous"][unit == "N m"] for unit in efforts]

    def cells(name: str, units: Sequence[str]) -> list[str]:
        known = ((row[name], row[f"{name}_error"]) for row in rows)
        pairs = zip(known, units, strict=True)
        return [
            "–" if value is None else f"{with_error(value, error or 0.0, 1)} {unit}"
            for (value, error), unit in pairs
        ]

    columns = (
        *joint_columns(arm.joints),
        Column("", "Coulomb", cells("coulomb", efforts), shown="text"),
        Column("", "viscous", cells("viscous", viscous), shown="text"),
        Column("", "offset", cells("offset", efforts), shown="text"),
        Column("", "RMS left", [row["rms_beside_friction"] for row in rows], efforts),
    )
    title = f"Friction and offset fitted to the difference{beside}, with standard errors"
    return (Table("", title, columns),)


def verdict_text(row: Mapping[str, Any]) -> str:
    """How a joint's measurement and model go together: "too light by a factor 1.9"."""
    verdict: str = row["verdict"]
    slope = row["slope_beside_friction"]
    if verdict == "another joint's":
        return f"follows the model of joint {row['resembles']}"
    if verdict in ("too light", "too heavy") and slope:
        factor = slope if verdict == "too light" else 1.0 / slope
        return (
            f"{verdict} by a factor {factor:.0f}" if factor > 99.5 else f"{verdict} by a factor {factor:.2g}"
        )
    return verdict


def is_described(table: xr.Dataset) -> bool:
    """Whether no measured torque contradicts the model."""
    return not {*table.verdict.values.tolist()} & {*CONTRADICTING}


def torque_warning(table: xr.Dataset, arm: str) -> str:
    """At which joints a model is not what was measured, and what to check."""
    rows = [row for row in rows_of(table, "joint") if row["verdict"] in CONTRADICTING]
    places = dict.fromkeys(place for row in rows for place in _CHECK[row["verdict"]])
    said = "; ".join(f"joint {row['joint']} {verdict_text(row)}" for row in rows)
    return f"measured torques contradict the model of {arm}: {said}. Check {', '.join(places)}"


def motion_rows(findings: Findings) -> list[Row]:
    """One row per motion: set points, duration, torques and errors of the joints, and the worst of these.

    `used` is the largest error of every joint over what the budget allows it along the motion, `worst` the
    largest of them and `joint` its joint, from 1.
    """
    table = findings.tables["motions"]
    used = share_of(table.largest_error.values, table.allowed_error.values)
    per_joint = ("peak_torque", "allowed_error", "largest_error", "rms_error")
    return [
        {
            "motion": str(table.motion.values[k]),
            "origin": str(table.motion_origin.values[k]),
            "set_points": int(table.set_points.values[k]),
            "duration": float(table.duration.values[k]),
            **{name: table[name].values[k].tolist() for name in per_joint},
            "used": used[k].tolist(),
            "worst": float(used[k].max()),
            "joint": int(used[k].argmax()) + 1,
        }
        for k in range(table.sizes["motion"])
    ]


def verdict_rows(findings: Findings) -> list[Row]:
    """One row per element, ranked over all motions: verdict and torque share along each, and if they change.

    That an element is zero along one motion and negligible along another is no change.
    """
    table = findings.tables["motions"]
    rows = []
    for k, element in enumerate(table.element.values.tolist()):
        quantity = str(table.quantity.values[k])
        found = table.verdict.values[k].tolist()
        verdicts = [effect_of({"quantity": quantity, "verdict": verdict}) for verdict in found]
        rows.append(
            {
                "element": element,
                "verdicts": verdicts,
                "torque_shares": table.torque_share.values[k].tolist(),
                "changes": len({"" if verdict in _NOTHING else verdict for verdict in verdicts}) > 1,
            }
        )
    return rows


def mark_of(verdict: str) -> str:
    """A verdict where there is no room for words."""
    return "–" if verdict == "negligible" else LETTERS[verdict]


def motion_parts(findings: Findings, top: int | None = None) -> tuple[Part, ...]:
    """Errors along each of several motions, and the verdicts that change between them."""
    if "motions" not in findings.tables:
        return ()
    rows, verdicts = motion_rows(findings), verdict_rows(findings)
    worst = max(rows, key=lambda row: row["worst"])
    changing = [row for row in verdicts if row["changes"]]
    labels = {
        "motion": ("motion", "", "name"),
        "set_points": ("set points", "", "count"),
        "duration": ("duration", "s"),
        "worst": ("error of allowed", "", "percent"),
        "joint": ("joint", "", "count"),
    }
    parts: list[Part] = [
        Fact(
            "worst_of_allowed",
            "Largest share of the allowed error",
            worst["worst"],
            shown="percent",
            note=f"joint {worst['joint']} along {worst['motion']}",
        ),
        Fact(
            "changing",
            "Verdicts that differ by motion",
            [row["element"] for row in changing],
            text=_named([row["element"] for row in changing]),
        ),
        table_of("each", "Motions", rows, labels),
        Fact("verdicts", "", verdicts),
    ]
    if changing and len(rows) <= _MOST_COLUMNS:
        marks = [
            Column("", row["motion"], [mark_of(one["verdicts"][k]) for one in changing], shown="text")
            for k, row in enumerate(rows)
        ]
        names = Column("", "element", [row["element"] for row in changing], shown="text")
        title = "Dominant effect along each motion: T translation, R rotation, – negligible"
        parts.append(Table("", title, (names, *marks), top=top))
    return (Section("motions", "", tuple(parts)),)


def _named(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{len(names)}: {', '.join(names[:_NAMED])}{more}" if names else "none"


def strict_notice(findings: Findings) -> str:
    """Name the joint of which one motion allows far less than another, and what settles it; "" if none."""
    if "motions" not in findings.tables:
        return ""
    table, arm, asked = findings.tables["motions"], findings.arm, findings.model.accuracy.asked
    allowed = table.allowed_error.values
    ratio = allowed.max(axis=0) / allowed.min(axis=0)
    if not (ratio >= _STRICT).any() or not asked.wholes & {"peak", "uncertainty"}:
        return ""
    joint = int(ratio.argmax())
    least, most = int(allowed[:, joint].argmin()), int(allowed[:, joint].argmax())
    names, peak = table.motion.values, float(table.peak_torque.values[least, joint])
    needs = amount(peak, arm.joints[joint].effort_unit)
    said = (
        f"Joint {joint + 1} needs at most {needs} along {names[least]} and is allowed "
        f"{number(float(ratio[joint]))} times less error than along {names[most]}, which may cost operations."
    )
    if findings.model.notice:
        return said
    friction = ReferenceTorques(arm, np.zeros(arm.n_joints)).all("friction")
    if len(asked.entries) == 1 and np.isfinite(friction).all():
        return f'{said} --budget "{asked} or 10% friction" sets a floor.'
    return f"{said} An amount in N m in --budget, or a share of friction, sets a floor."


def is_recorded(findings: Findings) -> bool:
    """Whether the motion was measured."""
    return "recording" in findings.tables


def noise_rows(findings: Findings) -> list[Row]:
    """Cut-off and noise of every joint, and what the noise makes of torque beside the budget."""
    names = ["cutoff", "noise_q", "noise_qdd", "torque_noise"]
    rows = rows_of(findings.tables["recording"][names], "joint")
    allowed = findings.model.accuracy.allowed.tolist()
    return [
        row
        | {
            "joint_name": joint.name,
            "unit": joint.unit,
            "qdd_unit": f"{joint.unit}/s^2",
            "effort_unit": joint.effort_unit,
            "allowed": budget,
            "of_allowed": row["torque_noise"] / budget,
        }
        for row, joint, budget in zip(rows, findings.arm.joints, allowed, strict=True)
    ]


def recording_parts(findings: Findings) -> tuple[Part, ...]:
    """Of a measured motion: what was done with the readings, and what their noise does."""
    if not is_recorded(findings):
        return ()
    table = findings.tables["recording"]
    elements, noise = table.element.values, table.element_noise.values
    within = elements[table.within_noise.values].tolist()
    undecided = elements[table.verdict_open.values].tolist()
    labels = {
        "cutoff": ("cut-off", "Hz"),
        "noise_q": ("noise of q", "@unit"),
        "noise_qdd": ("noise of qdd", "@qdd_unit"),
        "torque_noise": ("torque of it", "@effort_unit"),
        "of_allowed": ("of allowed", "", "percent"),
    }
    columns = [
        {key.removeprefix("column_"): value for key, value in row.items()} for row in rows_of(table, "column")
    ]
    parts = (
        Fact("treatment", "", table.attrs["treatment"].split("\n")),
        Fact(
            "within_noise",
            f"Elements of D within twice the noise, of {np.count_nonzero(noise)}" * bool(within),
            within,
            text=_named(within),
        ),
        Fact(
            "verdict_open",
            "Elements whose verdict the noise decides" * bool(undecided),
            undecided,
            text=_named(undecided),
        ),
        table_of("joints", "Noise of the readings (standard deviation)", noise_rows(findings), labels),
        Fact("elements", "", rows_of(table[["element_noise", "within_noise", "verdict_open"]], "element")),
        Fact("columns", "", columns),
    )
    return (Section("recording", "", parts),)


def _recording_notices(findings: Findings) -> list[str]:
    if not is_recorded(findings):
        return []
    table = findings.tables["recording"]
    if findings.trajectory.motions:
        lowest = number(float(table.cutoff.values.min()))
        smoothed = f"readings smoothed without delay, cut-off {lowest} Hz or higher"
    else:
        smoothed = table.attrs["treatment"].split("\n")[-1].partition(";")[0]
    said = [f"Measured motion, not a plan: {smoothed}."]
    rows = noise_rows(findings)
    beyond = [row["joint"] for row in rows if row["of_allowed"] > 1.0]
    if beyond:
        said.append(
            "Noise left in the accelerations exceeds the allowed torque error at "
            f"{named_joints(beyond, len(rows))}: models for this budget follow the noise, too. A lower "
            "--cutoff leaves less."
        )
    return said


def _tables(findings: Findings) -> tuple[Part, ...]:
    """What JSON has besides."""
    tables, elements = findings.tables, findings.element_model
    tube, dropped = tables["tube"], [row for group in dropped_parts(findings) for row in group]
    kept = [row["part"] for row in rows_of(tables["parts"], "part") if row["kept"]]
    of_elements = {
        "kept": kept,
        "dropped": dropped,
        "operations": asdict(elements.operations),
        "operations_full": asdict(elements.operations_full),
    }
    around = {name: tube.attrs[name] for name in ("coarse", "note")}
    lines = equations("equations", "", findings.model.formulas).lines
    return (
        Fact("equations", "", list(lines)),
        Fact("elements", "", of_elements),
        Fact("terms", "", rows_of(tables["terms"], "rank")),
        Fact("terms_total", "", tables["terms"].attrs["total"]),
        Fact("trade_off_shares_of", "", tables["trade_off"].attrs["shares_of"]),
        Fact("trade_off", "", rows_of(tables["trade_off"], "kind", "factor")),
        Fact("budgets", "", budget_rows(findings)),
        Fact("beyond", "", joint_rows(findings, "beyond")),
        Fact("states_drawn", "", tables["beyond"].attrs["states_drawn"]),
        Fact("tube", "", {"joints": joint_rows(findings, "tube"), **around}),
        Fact("residuals", "", rows_of(tables["cross_check"], "comparison")),
    )


def provenance_lines(findings: Findings) -> list[tuple[str, str]]:
    """What the results come from: label and value."""
    trajectory = findings.trajectory
    return [
        ("arm", f"{findings.arm.name}, SHA-256 {fingerprint(findings.arm)[:16]}"),
        ("trajectory", f"{trajectory.name}, SHA-256 {trajectory.fingerprint[:16]}"),
        ("trajectory origin", trajectory.origin or "not stated"),
        ("velocities", trajectory.derivatives_from),
        ("drives", "inertia included, friction not" if findings.model.drives else "not included"),
        *findings.provenance.items(),
    ]
