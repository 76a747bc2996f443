"""The result of a simplification: operations, errors per joint, and the model as parts or equations."""

from __future__ import annotations

from dataclasses import replace

from gd_analyze.certification.held import Held
from gd_analyze.formulas.languages import Written, equations
from gd_analyze.motions.states import States, in_words
from gd_analyze.result import Column, Fact, Part, Result, Table, columns_of
from gd_analyze.results.model_facts import (
    drives_text,
    headline,
    joint_errors,
    norm_facts,
    operation_facts,
    structure_note,
    worst_error,
)
from gd_analyze.simplification.effort import READABLE
from gd_analyze.simplification.element import ELEMENT, parts_of
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.verdicts import operations_by_quantity
from gd_analyze.text import thousands


def simplified_result(
    held: Held,
    states: States,
    seconds: float,
    digits: int,
    *,
    joint_velocities: bool = False,
) -> Result:
    """Facts of a model fitted on states, and where its budget holds; coefficients are rounded.

    Equations are in absolute velocities, or by element in joint velocities.
    """
    model, certificate = held.model, held.certificate
    accuracy, arm = model.accuracy, model.arm
    bound = None if certificate is None else certificate.certified
    answer, proven, joints = None, [], joint_errors(model, bound)
    more = [Column("certified", "", [None] * arm.n_joints if bound is None else bound)]
    if accuracy.uncertainty is not None:
        more.append(Column("uncertainty", "", accuracy.uncertainty))
    if certificate is not None:
        worst = worst_error(model, certificate.counting)
        each = " near each motion" if accuracy.motions else ""
        answer = f"Torque error at most {worst.text}{each} (joint {worst.joint}), proven"
        proven = [
            Fact("certified_within", "Proven within", certificate.region.where),
            Fact("", "Proof" * bool(certificate.note), certificate.note),
        ]
    if held.found is not None and held.tried:
        worst, tried = worst_error(model, held.found), f"{thousands(held.tried)} {held.tried_are}"
        answer = f"Torque error up to {worst.text} (joint {worst.joint}), found at {tried}"
        ways = "velocities and accelerations the worst at each, then an ascent from the worst"
        how = f": {ways}" * (held.tried_are == "positions")
        proven.append(Fact("tried", "Tried at", held.tried, text=f"{tried} of {held.where}{how}"))
        units = [joint.effort_unit for joint in arm.joints]
        more.append(Column("found", "found", held.found, units))
        if certificate is None:
            along = "trajectory" in accuracy.fitted_on
            why = "too many equations to write out here; `gd-analyze certify` does it"
            proven.append(Fact("", "Proof", f"none: {why if along else '--certified asks for one'}"))
    steps = columns_of(accuracy.steps, ("name", "", "text"), ("operations", "", "count"))
    kept = f"{model.size[0]} of {model.size[1]} {model.level.keeps}{', refitted' * model.refitted}"
    notices = [f"The search was stopped {held.stopped}; a longer one may find fewer operations."] * bool(
        held.stopped
    )
    return Result(
        title=", ".join(filter(None, [arm.title or arm.name, drives_text(arm, model.drives)])),
        headline=headline(model, answer),
        facts=(
            Fact("arm", "", arm.name),
            Fact(
                "level",
                "Level",
                model.level.name,
                text=f"{model.level.name}: {kept}",
                note=in_words(accuracy.fitted_on),
            ),
            Fact("refitted", "", model.refitted),
            Fact("drives", "", model.drives),
            Fact("budget", "", accuracy.budget),
            Fact("fitted_on", "", dict(accuracy.fitted_on)),
            *operation_facts(model),
            *proven,
            *norm_facts(accuracy.norms, arm),
            Fact("seconds", "", seconds, "s"),
        ),
        parts=(
            replace(joints, columns=(*joints.columns, *more)),
            Table("search", "", tuple(steps)),
            *_model_parts(model, states, digits, joint_velocities),
        ),
        notices=(*notices, *filter(None, [model.notice])),
    )


def _model_parts(
    model: SimplifiedModel, states: States, digits: int, joint_velocities: bool
) -> tuple[Part, ...]:
    """The model itself: parts kept, or equations."""
    if model.level is ELEMENT:
        parts = parts_of(model.arm.n_joints)
        kept = [part.label for part in parts if part in model.terms]
        dropped = [part.label for part in parts if part not in model.terms]
        counts = operations_by_quantity(model.form, model.terms), operations_by_quantity(model.form, parts)
        columns = [Column(name, name, [one[name] for one in counts], shown="count") for name in counts[0]]
        names = Column("program", "program", ["model", "exact"], shown="text")
        title = "Operations of D, h and c by element"
        by_element = Table("by_element", title, (names, *columns))
        return Fact("kept", "Kept", kept), Fact("dropped", "Dropped" * bool(dropped), dropped), by_element
    title, note = "Equations, in kg, m, s, rad", structure_note(model)
    shown = model.equations if joint_velocities else Written(model.formulas, model.legend)
    written = equations("equations", title, shown.formulas, shown.legend, note, digits=digits)
    if model.level.has_torque_terms and len(model.terms) > READABLE:
        written = replace(written, most_lines=0)
    facts = (Fact("terms", "", len(model.terms)), Fact("legend", "", list(written.legend_lines)))
    return (*facts, written)
