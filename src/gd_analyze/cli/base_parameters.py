"""`gd-analyze equations --parameters`: the numbers that torque is linear in, and what each consists of."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot
from gd_analyze.cli.output import Output
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.terminal import lines, sentence, table, width

if TYPE_CHECKING:
    from gd_analyze.dynamics.base_parameters import BaseParameter
    from gd_analyze.formulas.printer import Printer
    from gd_analyze.robots.parts import Placement

# Columns of the combinations, at least.
_LEAST = 24


def give_parameters(robot: GivenRobot, form: str, digits: int, out: Path | None, output: Output) -> None:
    """Print, or write, an arm's base parameters; a table for the terminal, and equations otherwise.

    Raises
    ------
    click.UsageError
        If the form is one that has no such equations.
    """
    if form not in ("text", "latex"):
        raise click.UsageError(f"--parameters are written as text or latex, not as {form}")
    require_outputs(out)
    with output.working() as stage:
        from gd_analyze.files import write_text

        arm = robot.load()
        stage("regrouping")
        base = gd.base_parameters(arm)
        written = "".join(f"{line}\n" for line in _equations(base, form, digits))
        if out is not None:
            stage(f"writing {out.name}")
            write_text(out, written)
    if output.as_json or out is not None:
        document = _document(base) | {"format": form, "written": written}
        output.give(lambda: document | output.about(out), wrote=out)
    elif form == "latex" or output.quiet:
        lines(written)
    else:
        _show(base, digits)


def _show(base: gd.BaseParameters, digits: int) -> None:
    from gd_analyze.cli.joint_table import arm_in_words
    from gd_analyze.formulas.printer import number

    combinations = [_combination(one, digits) for one in base]
    zero = sum(one.number == 0.0 for one in base)
    sentence(
        f"{arm_in_words(base.arm)}: torque is linear in {len(base)} base parameters and in no fewer, out of "
        f"{len(base.original)} parameters of links{' and drives' if base.drives else ''}. Geometry and "
        f"gravity's direction decide which combinations these are; {zero or 'none'} of them "
        f"{'is' if zero == 1 else 'are'} zero in this arm."
    )
    sentence(
        "Translation is what masses at their centres make of a number, rotation what inertias about these "
        f"do{', drive what drives add' if base.drives else ''}. Units: kg, m. Pxx, Pxy, ... are second "
        "moments: Ixx = Pyy + Pzz, Ixy = -Pxy."
        f"{' m3..6 = m3 + m4 + m5 + m6.' if any('..' in one for one in combinations) else ''}"
    )
    effects = ["translation", "rotation", *(["drive"] if base.drives else [])]
    cells = [
        [one.symbol, *(number(getattr(one, of), digits) for of in ("number", *effects)), one.unit]
        for one in base
    ]
    _wrapped_table(
        "base parameters",
        ["symbol", "number", *effects, "unit", "combination"],
        cells,
        combinations,
    )
    table("parameters of the links", ["link", "alone", "in combination", "never"], _acting(base), "llll")
    table(
        "frames they are of, z along the axis of a joint that turns: origin (m) and axes in the link's own",
        ["link", "origin", "x", "z"],
        [[str(link), *_standing(frame, digits)] for link, frame in enumerate(base.frames, 1)],
        "llll",
    )


def _standing(frame: Placement, digits: int) -> Iterable[str]:
    """Origin, x and z of a frame."""
    from gd_analyze.formulas.printer import number

    for vector in (frame.translation, *frame.rotation.T[[0, 2]]):
        yield " ".join(number(x, digits) for x in vector)


def _wrapped_table(
    title: str, headings: Sequence[str], cells: Sequence[Sequence[str]], last: Sequence[str]
) -> None:
    """Print a table whose last column goes on in lines below where the terminal is not wide enough."""
    columns = zip(headings, *cells, strict=False)
    room = width() - sum(2 + max(map(len, column)) for column in columns)
    rows: list[list[str]] = []
    for row, words in zip(cells, last, strict=True):
        wrapped = textwrap.wrap(words, max(room, _LEAST), break_long_words=False, break_on_hyphens=False)
        first, *others = (one.replace("\u00a0", " ") for one in wrapped)
        rows.append([*row, first])
        rows += [[""] * len(row) + [other] for other in others]
    table(title, headings, rows, "l" + "r" * (len(headings) - 3) + "ll")


def _combination(parameter: BaseParameter, digits: int) -> str:
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.formulas.writing import base_formula

    # A line does not break between a number and what it multiplies, nor behind a sign.
    pieces = Plain(digits).pieces(base_formula(parameter))
    return " ".join(piece.replace(" ", "\u00a0") for piece in pieces)


def _acting(base: gd.BaseParameters) -> list[list[str]]:
    """Which parameters of each link act by themselves, in combination only, and never."""
    rows = []
    for link in range(1, base.arm.n_joints + 1):
        of_link = [kind for kind, one in base.original if one == link]
        alone = [kind for kind in of_link if (kind, link) in base.acting_alone]
        never = [kind for kind in of_link if (kind, link) in base.never_acting]
        combined = [kind for kind in of_link if kind not in (*alone, *never)]
        rows.append([str(link), *(_named(kinds, of_link) for kinds in (alone, combined, never))])
    return rows


def _named(kinds: Sequence[str], of_link: Sequence[str]) -> str:
    """List some of a link's parameters, or the fewer that are not of them."""
    others = [kind for kind in of_link if kind not in kinds]
    if len(others) < len(kinds) - 1:
        return f"all but {' '.join(others)}" if others else "all"
    return " ".join(kinds)


def _equations(base: Iterable[BaseParameter], form: str, digits: int) -> Iterable[str]:
    """MX2 = mx2 + 0.432 m3..6 = 3.8 kg m, a line each."""
    from gd_analyze.formulas.formula import Product
    from gd_analyze.formulas.languages import Latex, Plain
    from gd_analyze.formulas.writing import base_formula

    printer: Printer = Latex(digits) if form == "latex" else Plain(digits)
    for one in base:
        value = printer.argument((Product(one.number),))
        unit = rf" \; \mathrm{{{one.unit.replace(' ', '~')}}}" if form == "latex" else f" {one.unit}"
        yield f"{printer.line(base_formula(one))} = {value}{unit}"


def _document(base: gd.BaseParameters) -> dict[str, Any]:
    def listed(original: Iterable[tuple[str, int]]) -> list[dict[str, Any]]:
        return [{"kind": kind, "link": link} for kind, link in original]

    return {
        "arm": base.arm.name,
        "drives": base.drives,
        "parameters": [
            asdict(one) | {"combination": [share._asdict() for share in one.combination]} for one in base
        ],
        "acting_alone": listed(base.acting_alone),
        "never_acting": listed(base.never_acting),
        "frames": [
            {"rotation": frame.rotation.tolist(), "translation": frame.translation.tolist()}
            for frame in base.frames
        ],
    }
