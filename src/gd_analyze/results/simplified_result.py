"""The result of a simplification: operations, errors per joint, and the model as parts or equations."""

from __future__ import annotations

import numpy as np

from gd_analyze.certification.held import Held
from gd_analyze.formulas.languages import Written, equation_part
from gd_analyze.motions.states import States, in_words
from gd_analyze.result import (
    AnyFact,
    Fact,
    Part,
    Result,
    Shown,
    Value,
    values_of,
)
from gd_analyze.results.model_facts import (
    drives_text,
    headline,
    joint_errors,
    norm_facts,
    operation_facts,
    structure_note,
    worst_error,
)
from gd_analyze.schema import declared_table
from gd_analyze.simplification.element import ELEMENT, operations_by_quantity, parts_of
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.torque_program import READABLE
from gd_analyze.text import thousands


def simplified_result(
    held_model: Held,
    states: States,
    seconds: float,
    digits: int,
    *,
    joint_velocities: bool = False,
) -> Result:
    """Facts of a model fitted on states, and where its budget holds; coefficients are rounded.

    Equations are torques in the velocities of the terms, or by element in joint velocities.
    """
    model, certificate = held_model.model, held_model.certificate
    accuracy, arm = model.accuracy, model.arm
    bound = None if certificate is None else certificate.certified
    error_text, proven = None, list[AnyFact]()
    further = {"certified": np.full(arm.n_joints, np.nan) if bound is None else bound}
    if accuracy.uncertainty is not None:
        further["uncertainty"] = accuracy.uncertainty
    if certificate is not None:
        worst = worst_error(model, certificate.counting)
        region = " near each motion" if accuracy.motions else ""
        error_text = f"Torque error at most {worst.text}{region} (joint {worst.joint}), proven"
        proven = [
            Fact("certified_within", "Proven within", certificate.region.where),
            *((Shown("Proof", certificate.note),) if certificate.note else ()),
        ]
    if held_model.found is not None and held_model.tried:
        worst, tried = (
            worst_error(model, held_model.found),
            f"{thousands(held_model.tried)} {held_model.tried_are}",
        )
        error_text = f"Torque error up to {worst.text} (joint {worst.joint}), found at {tried}"
        ascent = ""
        if held_model.tried_are == "positions":
            ascent = ": velocities and accelerations the worst at each, then an ascent from the worst"
        proven.append(
            Fact("tried", "Tried at", held_model.tried, text=f"{tried} of {held_model.where}{ascent}")
        )
        further["found"] = held_model.found
        if certificate is None:
            proven.append(Shown("Proof", "none: --certified asks for one"))
    size_text = f"{model.size[0]} of {model.size[1]} {model.level.keeps}"
    return Result(
        title=", ".join(filter(None, [arm.title or arm.name, drives_text(arm, model.drives)])),
        headline=headline(model, error_text),
        facts=(
            Value("arm", arm.name),
            Fact(
                "level",
                "Level",
                model.level.name,
                text=f"{model.level.name}: {size_text}",
                note=in_words(accuracy.fitted_on),
            ),
            Value("drives", model.drives),
            Value("budget", accuracy.budget),
            Value("fitted_on", dict(accuracy.fitted_on)),
            *operation_facts(model),
            *proven,
            *norm_facts(accuracy.norms, arm),
            Value("seconds", seconds),
        ),
        parts=(
            joint_errors(model, bound, further=further),
            Value("search", [step._asdict() for step in accuracy.steps]),
            *_model_parts(model, states, digits, joint_velocities),
        ),
        notices=tuple(filter(None, [model.notice])),
    )


def _model_parts(
    model: SimplifiedModel, states: States, digits: int, joint_velocities: bool
) -> tuple[Part, ...]:
    """The model itself: parts kept, or equations."""
    if model.level is ELEMENT:
        parts = parts_of(model.arm.n_joints)
        kept_labels = [part.label for part in parts if part in model.terms]
        dropped_labels = [part.label for part in parts if part not in model.terms]
        counts = [
            {name: count.total for name, count in operations_by_quantity(model.form, kept).items()}
            for kept in (model.terms, parts)
        ]
        values = {"program": ["model", "exact"], **values_of(counts)}
        seen = {f"operations_{name}": values[name] for name in counts[0]}
        title = "Operations of D, h and c by element"
        by_element = declared_table("by_verdicts", "by_element", title, values, ["program", *seen], seen=seen)
        return (
            Fact("kept", "Kept", kept_labels),
            Fact("dropped", "Dropped", dropped_labels).seen_if(bool(dropped_labels)),
            by_element,
        )
    title, note = "Equations, in kg, m, s, rad", structure_note(model)
    equation_set = model.equations if joint_velocities else Written(model.formulas, model.legend)
    too_many = model.has_terms and len(model.terms) > READABLE
    written = equation_part(
        "equations",
        title,
        equation_set.formulas,
        equation_set.legend,
        note,
        digits,
        most_lines=0 if too_many else None,
    )
    facts = (Value("terms", len(model.terms)), Value("legend", list(written.legend_lines)))
    return (*facts, written)
