"""The result of a simplification: operations, errors per joint, and the model as parts or equations."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gd_analyze.certification.holding import Held
from gd_analyze.formulas.languages import Plain, Written, equations
from gd_analyze.motions.states import States, in_words
from gd_analyze.result import Column, Fact, Part, Result, Section, Table, columns_of
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
from gd_analyze.simplification.recursion_losses import first_terms, link_parameters, omissions
from gd_analyze.simplification.recursive import MEANINGS, RECURSIVE
from gd_analyze.simplification.verdicts import operations_by_quantity
from gd_analyze.text import thousands

_MEANINGS = (("M", "M mass, MX MY MZ first moment"), ("P", "P second moment"), ("J", "J drive inertia"))
# Rows of dropped parts shown to people.
_ROWS = 12


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
        notices=(model.notice,) if model.notice else (),
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
    if model.level is not RECURSIVE:
        return (*facts, written)
    return (*facts, Fact("equations", "", list(written.lines)), *recursion_parts(model, states, digits))


def recursion_parts(model: SimplifiedModel, states: States, digits: int) -> tuple[Part, ...]:
    """Parameters, omissions with their torque at the states, and equations link by link."""
    plain, reading = Plain(digits), RECURSIVE.reading(model.form, model.terms)
    meanings = tuple(f"{', '.join(map(plain.symbol, symbols))}: {words}" for symbols, words in MEANINGS)
    explained = equations("", "Symbols of the equations, in kg, m, s, rad", (), reading.legend, digits=digits)
    return (
        *_parameters(model),
        _left_out(model, states, plain),
        Section("", explained.title, (), "; ".join((*explained.legend_lines, *meanings)) + "."),
        *(equations("", passage.heading, passage.formulas, digits=digits) for passage in reading.passages),
    )


def _parameters(model: SimplifiedModel) -> tuple[Table, Table]:
    """Products left with every link's regrouped parameters: for people, and for JSON."""
    every = link_parameters(model.form, model.terms)
    acting = [one for one in every if one.places]
    kinds, links = dict.fromkeys(one.kind for one in acting), dict.fromkeys(one.link for one in acting)
    cells = {(one.link, one.kind): f"{len(one.kept)}/{one.places}{'*' * one.is_changed}" for one in acting}
    notes = [words for prefix, words in _MEANINGS if any(kind.startswith(prefix) for kind in kinds)]
    columns = [Column("", "link", [link + 1 for link in links], shown="count")]
    for kind in kinds:
        columns.append(Column("", kind, [cells.get((link, kind), "·") for link in links], shown="text"))
    matrix = Table(
        "",
        "Regrouped parameters of the links: products kept / total",
        tuple(columns),
        f"{'; '.join(['* changed number', '· no effect', *notes])}. Inertia that a joint does not move is "
        "added to the previous link.",
    )
    rows: dict[str, list[Any]] = {
        "link": [one.link + 1 for one in every],
        "parameter": [one.kind for one in every],
        "number": [one.number for one in every],
        "unit": [one.unit for one in every],
        "state": [one.state for one in every],
        "products": [one.places for one in every],
        "kept": [list(one.kept) for one in every],
    }
    return matrix, Table("parameters", "", tuple(Column(key, "", values) for key, values in rows.items()))


def _left_out(model: SimplifiedModel, states: States, plain: Plain) -> Table:
    found = omissions(model.form, model.terms, states)
    worst = [float(one.torque[one.joint]) for one in found]
    units = [model.arm.joints[one.joint].effort_unit for one in found]
    instead = [one.changed_by or first_terms(one.instead, plain) or "nothing" for one in found]
    return Table(
        "left_out",
        "Omissions by torque of each alone, at the states",
        (
            Column("link", "", [one.quantity.link + 1 for one in found]),
            Column("in", "in", [plain.symbol(one.quantity.symbol) for one in found], shown="text"),
            Column("exact", "", [plain.sum(one.exact) for one in found]),
            Column("", "replaced", [first_terms(one.exact, plain) for one in found], shown="text"),
            Column("instead", "", [plain.sum(one.instead) for one in found]),
            Column("", "by", instead, shown="text"),
            Column("changed_by", "", [one.changed_by for one in found]),
            Column("", "torque", worst, units),
            Column("", "of peak", [float(one.share[one.joint]) for one in found], shown="percent"),
            Column("", "joint", [one.joint + 1 for one in found], shown="count"),
            Column("torque", "", [one.torque.tolist() for one in found]),
            Column("share", "", [one.share.tolist() for one in found]),
        ),
        top=_ROWS,
    )
