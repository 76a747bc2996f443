"""LaTeX: a document with readable equations, nomenclature and errors."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from gd_analyze.errors import UsageError
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.header import proven_rows, sampled_rows
from gd_analyze.exporting.language import Language
from gd_analyze.exporting.names import LANGUAGES
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.languages import LatexPrinter as Printer
from gd_analyze.formulas.languages import Plain
from gd_analyze.formulas.steps import NamedSteps
from gd_analyze.simplification.accuracy import STATED
from gd_analyze.simplification.exact import ExactForm

# Significant digits of coefficients, and characters of plain text per line of a page.
_COEFFICIENT_DIGITS = 6
_CHARACTERS_PER_LINE = 68
# Functions whose equations the document has.
_TYPESET = ("torque", "inertia", "coriolis_centrifugal", "gravity_loading")

_SIGNS = {
    **{sign: rf"\{sign}" for sign in "#$%&_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
}


class Latex(Language):
    """A standalone document."""

    files: ClassVar = {".tex": "latex.tex.jinja"}
    comment = ("", "%", "")

    def tex(self, text: str) -> str:
        r"""Write a text from outside for the document."""
        return "".join(_SIGNS.get(sign, sign) for sign in self.foreign(text))

    def values(self, subject: ExportInput) -> dict[str, Any]:
        """The document's parts; `UsageError` for a decomposition, whose equations another verb prints."""
        if subject.torque is None:
            raise UsageError(
                "a decomposition cannot be exported to LaTeX",
                where="language",
                expected=", ".join(name for name in LANGUAGES if name != "latex"),
                found="latex",
                next_step="print its equations with `gd-analyze equations ROBOT --format latex`",
            )
        if further := [function.name for function in subject.functions if function.name not in _TYPESET]:
            raise UsageError(
                "LaTeX has the equations of the torque alone",
                where="what",
                expected=", ".join(_TYPESET),
                found=", ".join(further),
                next_step="export to LaTeX by itself, and these to another language",
            )
        printer = Printer(_COEFFICIENT_DIGITS)
        formulas, legend = _equations(subject)
        model = subject.model
        return {
            "title": self.tex(subject.arm.title or subject.arm.name),
            "joints": [(self.tex(joint.name), joint.kind, joint.effort_unit) for joint in subject.arm.joints],
            "lines": [line for formula in formulas for line in _lines(formula)],
            "legend": printer.legend(legend),
            "sampled": "Sampled" if model is None or model.accuracy.measured else f"{STATED.capitalize()},",
            "errors": [] if subject.model is None else sampled_rows(subject.model),
            "bounds": [] if subject.certificate is None else proven_rows(subject.certificate),
            "digits": _COEFFICIENT_DIGITS,
        }


def _equations(subject: ExportInput) -> tuple[tuple[Formula, ...], Legend]:
    """Formulas, and the meaning of their names; for exact dynamics those of the cheapest program's steps."""
    if subject.model is not None:
        return subject.model.formulas, subject.model.legend
    steps = NamedSteps(ExactForm(subject.arm, subject.drives).program)
    return steps.formulas, steps.legend


def _lines(formula: Formula) -> Iterator[str]:
    """Break a formula into lines of a page, aligned at the sign of equality."""
    printer, ruler = Printer(_COEFFICIENT_DIGITS), Plain(_COEFFICIENT_DIGITS)
    line, width = f"{printer.symbol(formula.left)} &=", 0
    for piece, plain in zip(printer.pieces(formula), ruler.pieces(formula), strict=True):
        if width and width + len(plain) > _CHARACTERS_PER_LINE:
            yield line
            line, width = r"&\quad", 0
        line, width = f"{line} {piece}", width + len(plain) + 1
    yield line if width else f"{line} 0"
