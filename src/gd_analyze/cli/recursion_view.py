"""A model that is a changed recursion, for people and as JSON: what it keeps and leaves out, its steps."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from gd_analyze.cli.terminal import WIDTH, line, lines, sentence, table

if TYPE_CHECKING:
    import gd_analyze as gd
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.motions.states import States
    from gd_analyze.simplification.evaluation import Loss
    from gd_analyze.simplification.recursion_losses import LinkParameter, Omission

_WORDS = (("M", "M mass, MX MY MZ first moment"), ("P", "P second moment"), ("J", "J drive's inertia"))
# Of what is left out, so many lines are shown, with sums of so many characters.
_ROWS, _LONGEST = 12, 24


def recursion_document(model: gd.SimplifiedModel, states: States, digits: int) -> dict[str, Any]:
    """All of it as JSON has it; torque left out is that at some states."""
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.simplification.recursion_losses import link_parameters, omissions

    plain = Plain(digits)
    return {
        "parameters": [
            {
                "link": one.link + 1,
                "parameter": one.kind,
                "number": one.number,
                "unit": one.unit,
                "state": one.state,
                "products": one.places,
                "kept": list(one.kept),
            }
            for one in link_parameters(model.form, model.terms)
        ],
        "left_out": [
            {
                "link": one.quantity.link + 1,
                "in": plain.symbol(one.quantity.symbol),
                "exact": plain.sum(one.exact),
                "instead": plain.sum(one.instead),
                "changed_by": one.changed_by,
                "torque": one.torque.tolist(),
                "share": one.share.tolist(),
            }
            for one in omissions(model.form, model.terms, states)
        ],
    }


def show_recursion(model: gd.SimplifiedModel, states: States, digits: int) -> None:
    """Print which parameters it keeps, what it leaves out that makes most torque, and its equations."""
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.simplification.recursion_losses import link_parameters, omissions
    from gd_analyze.simplification.recursion_reading import MEANINGS
    from gd_analyze.simplification.recursive import RECURSIVE

    plain = Plain(digits)
    _show_parameters(link_parameters(model.form, model.terms))
    _show_left_out(model, omissions(model.form, model.terms, states), plain)
    reading = RECURSIVE.reading(model.form, model.terms)
    line()
    sentence("The model, in kg, m, s, rad", bold=True)
    meanings = [f"{', '.join(map(plain.symbol, symbols))}: {words}" for symbols, words in MEANINGS]
    sentence("; ".join([*plain.legend(reading.legend), *meanings]) + ".")
    for passage in reading.passages:
        line()
        sentence(passage.heading)
        for formula in passage.formulas:
            lines(plain.wrapped(formula, WIDTH) + "\n")


def _show_parameters(parameters: Sequence[LinkParameter]) -> None:
    acting = {one.kind for one in parameters if one.places}
    shown = [one for one in parameters if one.kind in acting]
    kinds = list(dict.fromkeys(one.kind for one in shown))
    rows = [
        [str(link + 1), *(_cell(one) for one in own)]
        for link, own in groupby(shown, key=lambda one: one.link)
    ]
    table(
        "Regrouped parameters of the links: products with each that are left, of all",
        ["link", *kinds],
        rows,
        "r",
    )
    told = ["* with another number"] * any(one.is_changed for one in shown)
    told += ["· never acts", *(words for prefix, words in _WORDS if any(k.startswith(prefix) for k in kinds))]
    sentence(f"{'; '.join(told)}; what a joint does not move counts to the link before.")


def _cell(one: LinkParameter) -> str:
    if not one.places:
        return "·"
    return f"{len(one.kept)}/{one.places}{'*' * one.is_changed}"


def losses_of_changes(model: gd.SimplifiedModel, states: States) -> tuple[Loss, ...]:
    """What a changed recursion leaves out, as what a model of parts does; by what is allowed of it."""
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.simplification.accuracy import share_of
    from gd_analyze.simplification.evaluation import Loss
    from gd_analyze.simplification.recursion_losses import omissions

    plain, out = Plain(), []
    for one in omissions(model.form, model.terms, states):
        multiples = share_of(one.torque, model.accuracy.allowed)
        joint = int(multiples.argmax())
        told = f"{_short(one.exact, plain)} in {plain.symbol(one.quantity.symbol)}"
        lost = Loss(told, float(one.torque[joint]), joint + 1, float(one.share[joint]))
        out.append((float(multiples[joint]), lost))
    return tuple(lost for _, lost in sorted(out, key=lambda pair: -pair[0]))


def _show_left_out(model: gd.SimplifiedModel, left_out: Sequence[Omission], plain: Plain) -> None:
    """Print a line of each change, as many as there is room for, and count the rest."""
    from gd_analyze.text import amount, percent

    rows = [
        [
            plain.symbol(one.quantity.symbol),
            _short(one.exact, plain),
            one.changed_by or _short(one.instead, plain) or "nothing",
            amount(float(one.torque[one.joint]), model.arm.joints[one.joint].effort_unit),
            percent(float(one.share[one.joint])),
            str(one.joint + 1),
        ]
        for one in left_out[:_ROWS]
    ]
    if not rows:
        line()
        sentence("Nothing is left out.")
        return
    table(
        "Left out: what makes most torque by itself, at the states",
        ["in", "in place of", "stands", "torque", "share", "joint"],
        rows,
        "lll",
    )
    if len(left_out) > _ROWS:
        largest = float(left_out[_ROWS].share.max())
        sentence(
            f"And {len(left_out) - _ROWS} more, none with more than {percent(largest)} of a joint's peak; "
            "--json has all."
        )


def _short(terms: Sequence[Any], plain: Plain) -> str:
    """A sum, of a long one only the first summand."""
    whole = plain.sum(terms)
    return whole if len(terms) < 2 or len(whole) <= _LONGEST else f"{plain.sum(terms[:1])} + …"
