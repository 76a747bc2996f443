"""A changed recursion in the reports: parameters kept, equations by link, what is left out and its torque."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any, NamedTuple

from gd_analyze.formulas.formula import Formula, Symbol
from gd_analyze.formulas.languages import Typst
from gd_analyze.motions.states import states_of
from gd_analyze.report.harmonic_data import equation_data
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.simplification.recursion_losses import LinkParameter, Omission, link_parameters, omissions
from gd_analyze.simplification.recursion_reading import MEANINGS
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.text import percent

_TYPST = Typst()


class LinkSteps(NamedTuple):
    """Equations of one link, on the way out and on the way back."""

    link: int
    outward: tuple[Formula, ...]
    inward: tuple[Formula, ...]


class LeftOut(NamedTuple):
    """Changes of one link's steps, those of one quantity side by side."""

    link: int
    rows: tuple[Omission, ...]

    @property
    def share(self) -> float:
        """Of what makes most torque by itself."""
        return max(float(one.share.max()) for one in self.rows)


class RecursionShown(NamedTuple):
    """What reports show of a changed recursion.

    Parameters
    ----------
    kinds, parameters
        Kinds of parameters that act in the arm, and those of every link.
    steps, legend
        Equations by link, and what sines and cosines are.
    left_out
        Changes by link.
    """

    kinds: tuple[str, ...]
    parameters: tuple[tuple[LinkParameter, ...], ...]
    steps: tuple[LinkSteps, ...]
    legend: tuple[Formula, ...]
    left_out: tuple[LeftOut, ...]

    @property
    def changes(self) -> int:
        """How many changes there are."""
        return sum(len(one.rows) for one in self.left_out)

    @property
    def meanings(self) -> tuple[tuple[tuple[Symbol, ...], str], ...]:
        """What letters mean."""
        return MEANINGS


def recursion_shown(findings: Findings) -> RecursionShown | None:
    """Collect it along the motion; None of a model that is no recursion."""
    if summary.made_of(findings) != "recursion":
        return None
    model = findings.model
    parameters = link_parameters(model.form, model.terms)
    acting = {one.kind for one in parameters if one.places}
    shown = [one for one in parameters if one.kind in acting]
    reading = RECURSIVE.reading(model.form, model.terms)
    changes = omissions(model.form, model.terms, states_of(findings.trajectory))
    steps = []
    for link in range(findings.arm.n_joints):
        ways = [
            tuple(f for p in reading.passages if (p.link, p.outward) == (link, way) for f in p.formulas)
            for way in (True, False)
        ]
        steps.append(LinkSteps(link, *ways))
    return RecursionShown(
        tuple(dict.fromkeys(one.kind for one in shown)),
        tuple(tuple(own) for _, own in groupby(shown, key=lambda one: one.link)),
        tuple(steps),
        reading.legend.factors,
        tuple(_by_link(changes)),
    )


def _by_link(changes: Sequence[Omission]) -> list[LeftOut]:
    """Changes by link, those of one quantity together, and where they make most torque first."""
    out = []
    for link in sorted({one.quantity.link for one in changes}):
        own = [one for one in changes if one.quantity.link == link]
        first = {one.quantity: place for place, one in reversed([*enumerate(own)])}
        out.append(LeftOut(link, tuple(sorted(own, key=lambda one: first[one.quantity]))))
    return out


def recursion_data(findings: Findings) -> dict[str, Any] | None:
    """The same as JSON values for paper."""
    shown = recursion_shown(findings)
    if shown is None:
        return None
    return {
        "kinds": list(shown.kinds),
        "parameters": [
            [{"kept": len(one.kept), "of": one.places, "changed": one.is_changed} for one in own]
            for own in shown.parameters
        ],
        "steps": [
            {
                "link": one.link + 1,
                "outward": [equation_data(formula) for formula in one.outward],
                "inward": [equation_data(formula) for formula in one.inward],
            }
            for one in shown.steps
        ],
        "legend": [*map(_TYPST.line, shown.legend)],
        "meanings": [[[*map(_TYPST.symbol, symbols)], words] for symbols, words in shown.meanings],
        "left_out": [
            {"link": one.link + 1, "rows": [_row(row) for row in one.rows]} for one in shown.left_out
        ],
    }


def _row(one: Omission) -> dict[str, Any]:
    return {
        "in": _TYPST.symbol(one.quantity.symbol),
        "exact": _TYPST.sum(one.exact),
        "instead": _TYPST.sum(one.instead),
        "changed": one.changed_by,
        "share": percent(float(one.share[one.joint])),
        "joint": one.joint + 1,
    }
