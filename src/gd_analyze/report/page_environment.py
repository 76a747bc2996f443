"""What templates of pages are given: words, filters that write numbers and formulas, styles and scripts."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from gd_analyze import text as formatting
from gd_analyze.figures.colours import css_variables
from gd_analyze.figures.elements import LETTERS
from gd_analyze.formulas.formula import Symbol, as_formula
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.formulas.writing import part_symbol, term_formula
from gd_analyze.report.beyond_chart import place
from gd_analyze.report.budget_path import DECADES, budget_words
from gd_analyze.report.compiled_templates import TEMPLATES
from gd_analyze.results.words import SYMBOLS, VERDICTS, told

if TYPE_CHECKING:
    from jinja2 import Environment

_MATHS = PageMathML()


@cache
def environment() -> Environment:
    """Jinja with the reports' templates, filters and words."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    from gd_analyze.report.compiled_templates import CompiledTemplates

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        bytecode_cache=CompiledTemplates(),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals |= {"letters": LETTERS, "symbols": SYMBOLS, "verdicts": VERDICTS}
    environment.filters |= {
        "number": lambda value: formatting.markup(formatting.number(float(value))),
        "percent": lambda share: formatting.markup(formatting.percent(float(share))),
        "bound_percent": lambda share: formatting.markup(
            formatting.percent(formatting.share_up(float(share)))
        ),
        "typeset": formatting.markup,
        "powers": formatting.markup_of_powers,
        "unit": formatting.pretty,
        "told": told,
        "symbol": _symbol,
        "cell": _cell,
        "formula": term_formula,
        "left": lambda formula: Markup(_MATHS.left(formula)),
        "line": lambda formula: Markup(_MATHS.line(formula)),
        "letter": lambda symbol: Markup(f"<math>{_MATHS.symbol(symbol)}</math>"),
        "summands": lambda terms: [*map(Markup, _MATHS.elements(as_formula(Symbol(""), terms)))],
        "pieces": lambda formula: [*map(Markup, _MATHS.elements(formula))],
        "amount": lambda value, unit: formatting.markup(
            formatting.pretty(formatting.amount(float(value), unit))
        ),
        "bound": lambda value, unit: formatting.markup(
            formatting.pretty(formatting.amount(formatting.rounded_up(float(value)), unit))
        ),
        "error_place": lambda row: _place(row["largest_error"], row["allowed_error"]),
        "proven_place": lambda row: _place(row.get("tube_certified"), row["allowed_error"]),
        "series": _series,
        "budget_words": budget_words,
        "codes": lambda words: Markup(re.sub("`(.+?)`", r"<code>\1</code>", str(escape(words)))),
        "digits": lambda value: formatting.markup(f"{float(value):.6g}"),
        "joints": formatting.named_joints,
        "mass": lambda kilograms: formatting.markup(formatting.mass(float(kilograms))),
        "degrees": lambda angle: formatting.markup(f"{math.degrees(float(angle)):.4g}"),
    }
    return environment


def _symbol(label: str) -> Markup:
    """Formula for an element's label or a part's, such as "D12 translation"."""
    return Markup(f"<math>{_MATHS.symbol(part_symbol(*label.split()))}</math>")


def _cell(label: str, kept: str) -> Markup:
    """Entry of the matrix D."""
    return Markup("<mn>0</mn>" if kept == "neither" else _MATHS.symbol(part_symbol(label, kept)))


def _amount(value: float, unit: str) -> Markup:
    return formatting.markup(formatting.pretty(formatting.amount(float(value), unit)))


def _place(error: float | None, allowed: float) -> float | None:
    """Place of an error on the axis that budgets move along; at its end where nothing is allowed."""
    if error is None:
        return None
    return place(error / allowed if allowed > 0.0 else float(error > 0.0), *DECADES)


def _series(k: int) -> str:
    """Style of the curve of the k-th of several joints: colour, and dashes after every sixth."""
    return f"--series:var(--series-{k % 6 + 1});--dashes:{('none', '6 3', '2 2', '7 3 2 3')[k // 6 % 4]}"


def style(*names: str) -> Markup:
    """Style sheets among the templates, behind the colours they name."""
    return Markup(css_variables() + "".join(map(template_text, names)))


def template_text(name: str) -> str:
    """Text of a file among the templates."""
    return (TEMPLATES / name).read_text(encoding="utf-8")
