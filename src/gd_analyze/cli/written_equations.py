"""What `gd-analyze equations` writes, equation after equation in any language, and what heads them."""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING

from gd_analyze.cli.joint_table import arm_in_words
from gd_analyze.cli.terminal import WIDTH, lines
from gd_analyze.files import replacing
from gd_analyze.formulas.languages import Latex, MathML, Plain
from gd_analyze.formulas.sympy import sympy_head, sympy_line
from gd_analyze.formulas.writing import element_formula, factor_legend
from gd_analyze.text import visible

if TYPE_CHECKING:
    from gd_analyze.harmonics.equations import Equation
    from gd_analyze.harmonics.terms import Factor
    from gd_analyze.harmonics.transform import Harmonics

# Characters printed at once.
_AT_ONCE = 2**22
# What a comment of each language stands between.
_COMMENTS = {"text": ("", ""), "latex": ("% ", ""), "mathml": ("<!-- ", " -->"), "sympy": ("# ", "")}


@dataclass
class Told:
    """What the header says of the equations noted so far."""

    terms: int = 0
    couples: bool = False
    factors: set[Factor] = field(default_factory=set)

    def note(self, equation: Equation) -> None:
        """Count an equation."""
        self.terms += len(equation.terms)
        self.couples |= equation.symbol.startswith("h")
        self.factors.update(factor for term in equation.terms for factor in term.factors)

    def header(
        self, harmonics: Harmonics, form: str, *, whole: bool, min_share: float, seconds: float
    ) -> str:
        """Say what is shown and how to read it, as a comment of the language where there is one."""
        terms = f"{self.terms} term{'s' if self.terms != 1 else ''}"
        cut = f" of at least {100 * min_share:g} % of the largest of their element" if min_share > 0 else ""
        about = [f"{arm_in_words(harmonics.arm)}: {terms}{cut}; identified in {seconds:.2g} s"]
        about.append("Units: kg, m, s, rad")
        if whole:
            about[-1] += "; D is symmetric, and elements not shown are zero"
        if self.couples:
            about[-1] += "; h_i is the sum over j and k of h_ijk qd_j qd_k, and h_ikj = h_ijk"
        meanings = Plain().legend(factor_legend(self.factors))
        if meanings:
            about.append(", ".join(meanings))
        before, after = _COMMENTS[form]
        # Two hyphens would end a comment of XML.
        said = [re.sub("-(?=-)", "- ", text) if form == "mathml" else text for text in about]
        room = WIDTH - len(before) - len(after)
        pieces = [piece for text in said for piece in textwrap.wrap(f"{visible(text)}.", room)]
        return "".join(f"{before}{piece}{after}\n" for piece in pieces) + "\n"


def written_before(form: str, n_joints: int) -> str:
    """Write what stands before the first equation."""
    return sympy_head(n_joints) if form == "sympy" else ""


def written(equation: Equation, form: str, digits: int) -> str:
    """Write one equation, with the end of its line."""
    if form == "sympy":
        text = sympy_line(equation)
    elif form == "text":
        text = Plain(digits).wrapped(element_formula(equation), WIDTH)
    else:
        text = (Latex(digits) if form == "latex" else MathML(digits)).line(element_formula(equation))
    return f"{text}\n"


def save(path: Path, header: str, body: IO[str]) -> None:
    """Write the header and what has been written so far into a file."""
    body.seek(0)
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        file.write(header)
        file.writelines(body)


def show(header: str, body: IO[str]) -> None:
    """Print the header and what has been written so far, some megabytes at a time."""
    body.seek(0)
    lines(header)
    while some := body.readlines(_AT_ONCE):
        lines("".join(some))
