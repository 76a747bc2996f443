"""LaTeX: the equations as a person would write them, with nomenclature and errors, as one document."""

from __future__ import annotations

from collections.abc import Iterator

from gd_analyze.errors import UsageError
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.foreign import tex
from gd_analyze.exporting.templating import filled
from gd_analyze.exporting.told import proven_rows, told
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.languages import Latex, Plain
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.recursion_reading import MEANINGS
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.text import number

# Significant digits of coefficients, and signs of plain text that fill a line of a page.
_DIGITS = 6
_WIDTH = 68


def latex_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a document.

    Raises
    ------
    UsageError
        Of a decomposition, whose equations are those of `gd-analyze equations`.
    """
    if subject.torque is None:
        raise UsageError(
            "the decomposition is no document",
            where="language",
            expected="c, cpp, python, matlab, casadi or jax",
            found="latex",
            next_step="print its equations with `gd-analyze equations ROBOT --format latex`",
        )
    printer = Latex(_DIGITS)
    passages, legend = _equations(subject)
    meanings = MEANINGS if len(passages) > 1 else ()
    text = filled(
        "model.tex.jinja",
        subject=subject,
        lines=told(subject),
        title=tex(subject.arm.title or subject.arm.name),
        joints=[(tex(joint.name), joint.kind, joint.effort_unit) for joint in subject.arm.joints],
        passages=[
            (heading, [line for formula in formulas for line in _broken(formula)])
            for heading, formulas in passages
        ],
        meanings=[("$, $".join(map(printer.symbol, symbols)), words) for symbols, words in meanings],
        legend=printer.legend(legend),
        errors=_errors(subject),
        bounds=_bounds(subject),
        digits=_DIGITS,
    )
    return (text,)


def _equations(subject: ExportInput) -> tuple[list[tuple[str, tuple[Formula, ...]]], Legend]:
    """Headings and formulas, and what names in them mean; of exact dynamics those of the recursion."""
    model = subject.model
    if model is not None and model.level is not RECURSIVE:
        return [("", model.formulas)], model.legend
    form = ExactForm(subject.arm, subject.drives) if model is None else model.form
    reading = RECURSIVE.reading(form, {} if model is None else model.terms)
    return [(passage.heading, passage.formulas) for passage in reading.passages], reading.legend


def _broken(formula: Formula) -> Iterator[str]:
    """Break a formula into lines of a page, each aligned at its sign of equality."""
    printer, ruler = Latex(_DIGITS), Plain(_DIGITS)
    line, width = f"{printer.symbol(formula.left)} &=", 0
    for piece, plain in zip(printer.pieces(formula), ruler.pieces(formula), strict=True):
        if width and width + len(plain) > _WIDTH:
            yield line
            line, width = r"&\quad", 0
        line, width = f"{line} {piece}", width + len(plain) + 1
    yield line if width else f"{line} 0"


def _errors(subject: ExportInput) -> list[list[str]]:
    if subject.model is None:
        return []
    errors, allowed = subject.model.accuracy.errors, subject.model.accuracy.allowed
    columns = (errors.peak_torque, allowed, errors.largest, errors.rms)
    return [[number(float(x)) for x in row] for row in zip(*columns, strict=True)]


def _bounds(subject: ExportInput) -> list[list[str]]:
    rows = [] if subject.certificate is None else proven_rows(subject.certificate)
    return [[f"{x:.6g}" for x in row] for row in rows]
