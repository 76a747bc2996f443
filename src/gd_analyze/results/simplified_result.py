"""The result of a simplification: operations, errors per joint, and the model as parts or equations."""

from __future__ import annotations

from dataclasses import replace

from gd_analyze.certification.certificate import Certificate
from gd_analyze.formulas.languages import equations
from gd_analyze.motions.states import States, in_words
from gd_analyze.result import Column, Fact, Part, Result, Table, columns_of
from gd_analyze.results.model_facts import (
    drives_text,
    headline,
    joint_errors,
    norm_facts,
    operation_facts,
    worst_error,
)
from gd_analyze.results.recursion_parts import recursion_parts
from gd_analyze.simplification.element import ELEMENT, parts_of
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursive import RECURSIVE


def simplified_result(
    model: SimplifiedModel, states: States, certificate: Certificate | None, seconds: float, digits: int
) -> Result:
    """Facts of a model fitted on states, with what is proven of it; coefficients are shown in few digits."""
    accuracy, arm = model.accuracy, model.arm
    bound = None if certificate is None else certificate.certified
    answer, proven, joints = None, [], joint_errors(model, bound)
    more = [Column("certified", "", [None] * arm.n_joints if bound is None else bound)]
    if accuracy.uncertainty is not None:
        more.append(Column("uncertainty", "", accuracy.uncertainty))
    if certificate is not None:
        worst = worst_error(model, bound)
        answer = f"Torque error at most {worst.text} (joint {worst.joint}), proven"
        proven = [
            Fact("certified_within", "Proven for every state", certificate.region.where),
            Fact("", "Proof" * bool(certificate.note), certificate.note),
        ]
    search = Table(
        "search",
        "Operations after each step of the search",
        tuple(columns_of(accuracy.steps, ("name", "step", "text"), ("operations", "operations", "count"))),
        note="Effort used up before the end." if accuracy.cut_short else "",
    )
    kept = f"{model.size[0]} of {model.size[1]} {model.level.keeps}{', refitted' * model.refitted}"
    tried = {
        one.level: f"not tried: {one.why}" if one.why else f"{one.operations} operations"
        for one in accuracy.levels
    }
    return Result(
        title=", ".join(filter(None, [arm.title or arm.name, drives_text(arm, model.drives)])),
        headline=headline(model, answer),
        facts=(
            Fact("arm", "", arm.name),
            Fact("level", "Level", model.level.name, note=kept),
            Fact("refitted", "", model.refitted),
            Fact("drives", "", model.drives),
            Fact("budget", "Budget", accuracy.budget),
            Fact("fitted_on", "States", dict(accuracy.fitted_on), text=in_words(accuracy.fitted_on)),
            *operation_facts(model),
            *(Fact("", f"Level {level}", found) for level, found in tried.items()),
            Fact("levels", "", [one._asdict() for one in accuracy.levels]),
            Fact("solved", "", accuracy.solved),
            Fact("cut_short", "", accuracy.cut_short),
            *proven,
            *norm_facts(accuracy.norms, arm),
            Fact("seconds", "Time", seconds, "s"),
        ),
        parts=(
            replace(joints, columns=(*joints.columns, *more)),
            search,
            *_model_parts(model, states, digits),
        ),
        notices=(model.notice,) if model.notice else (),
    )


def _model_parts(model: SimplifiedModel, states: States, digits: int) -> tuple[Part, ...]:
    """What the model is: parts kept, or equations."""
    if model.level is ELEMENT:
        parts = parts_of(model.arm.n_joints)
        kept = [part.label for part in parts if part in model.terms]
        dropped = [part.label for part in parts if part not in model.terms]
        return Fact("kept", "Kept", kept), Fact("dropped", "Dropped" * bool(dropped), dropped)
    title = "Equations, in kg, m, s, rad"
    written = equations("equations", title, model.formulas, model.legend, digits=digits)
    facts = (Fact("terms", "", len(model.terms)), Fact("legend", "", list(written.legend_lines)))
    if model.level is not RECURSIVE:
        return (*facts, written)
    return (*facts, Fact("equations", "", list(written.lines)), *recursion_parts(model, states, digits))
