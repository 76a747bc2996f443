"""A simplified recursion as parts of a result: parameters kept, equations by link, what is left out."""

from __future__ import annotations

from collections.abc import Sequence

from gd_analyze.formulas.languages import Plain, equations
from gd_analyze.motions.states import States
from gd_analyze.result import Column, Part, Section, Table
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursion_losses import (
    LinkParameter,
    first_terms,
    link_parameters,
    omissions,
)
from gd_analyze.simplification.recursion_reading import MEANINGS
from gd_analyze.simplification.recursive import RECURSIVE

_MEANINGS = (("M", "M mass, MX MY MZ first moment"), ("P", "P second moment"), ("J", "J drive inertia"))
# Rows of what is left out that people see.
_ROWS = 12


def recursion_parts(model: SimplifiedModel, states: States, digits: int) -> tuple[Part, ...]:
    """Parameters, omissions with their torque at the states, and equations link by link."""
    plain, reading = Plain(digits), RECURSIVE.reading(model.form, model.terms)
    meanings = tuple(f"{', '.join(map(plain.symbol, symbols))}: {words}" for symbols, words in MEANINGS)
    explained = equations("", "Symbols of the equations, in kg, m, s, rad", (), reading.legend, digits=digits)
    return (
        *_parameters(link_parameters(model.form, model.terms)),
        _left_out(model, states, plain),
        Section("", explained.title, (), "; ".join((*explained.legend_lines, *meanings)) + "."),
        *(equations("", passage.heading, passage.formulas, digits=digits) for passage in reading.passages),
    )


def _parameters(parameters: Sequence[LinkParameter]) -> tuple[Part, ...]:
    acting = [one for one in parameters if one.places]
    kinds = list(dict.fromkeys(one.kind for one in acting))
    links = list(dict.fromkeys(one.link for one in acting))
    cells = {(one.link, one.kind): f"{len(one.kept)}/{one.places}{'*' * one.is_changed}" for one in acting}
    notes = [words for prefix, words in _MEANINGS if any(kind.startswith(prefix) for kind in kinds)]
    matrix = Table(
        "",
        "Regrouped parameters of the links: products left, of all",
        (
            Column("", "link", [link + 1 for link in links], shown="count"),
            *(
                Column("", kind, [cells.get((link, kind), "·") for link in links], shown="text")
                for kind in kinds
            ),
        ),
        note="; ".join(["* with another number", "· never acts", *notes])
        + ". The inertia that a joint does not "
        "move is part of the previous link.",
    )
    rows = Table(
        "parameters",
        "",
        (
            Column("link", "", [one.link + 1 for one in parameters]),
            Column("parameter", "", [one.kind for one in parameters]),
            Column("number", "", [one.number for one in parameters]),
            Column("unit", "", [one.unit for one in parameters]),
            Column("state", "", [one.state for one in parameters]),
            Column("products", "", [one.places for one in parameters]),
            Column("kept", "", [list(one.kept) for one in parameters]),
        ),
    )
    return matrix, rows


def _left_out(model: SimplifiedModel, states: States, plain: Plain) -> Table:
    found = omissions(model.form, model.terms, states)
    worst = [float(one.torque[one.joint]) for one in found]
    units = [model.arm.joints[one.joint].effort_unit for one in found]
    instead = [one.changed_by or first_terms(one.instead, plain) or "nothing" for one in found]
    return Table(
        "left_out",
        "Left out, by torque alone at the states",
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
