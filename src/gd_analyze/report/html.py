"""A document as one HTML file that opens offline, made by Jinja templates; styles and scripts are inside."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from gd_analyze.figures.figure import COLOURS, FIGURE_WIDTH
from gd_analyze.figures.svg import key_svg, panel_svg
from gd_analyze.report.document import Document
from gd_analyze.text import pretty, signed, unbroken

if TYPE_CHECKING:
    from jinja2 import Environment

_TEMPLATES = Path(__file__).parent / "templates"
# An option of the command line, which a browser would break after its hyphens.
_OPTION, _WHOLE = re.compile(r"--[a-z][a-z-]*"), r'<span class="option">\g<0></span>'


def page_of(document: Document) -> str:
    """Write a document as a page."""
    return (
        _environment()
        .get_template(f"{document.form}.html")
        .render(
            document=document.content,
            figures=document.figures,
            colours=COLOURS,
            page_width=FIGURE_WIDTH,
        )
    )


@cache
def _environment() -> Environment:
    """Templates whose values are escaped, but for MathML and SVG that the program writes."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # slow to load

    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    compact = {"ensure_ascii": False, "allow_nan": False, "separators": (",", ":")}
    environment.policies["json.dumps_kwargs"] = compact
    environment.filters |= {
        "words": _words,
        "signed": signed,
        "panel_svg": lambda panel, figure: Markup(panel_svg(panel, figure)),
        "key_svg": lambda key: Markup(key_svg(key)),
    }
    environment.globals["file"] = lambda name: Markup((_TEMPLATES / name).read_text(encoding="utf-8"))
    return environment


def _words(words: object) -> Markup:
    """The program's words as HTML, exponents raised; text between backquotes is code."""
    pieces = str(escape(pretty(str(words)))).split("`")
    if len(pieces) % 2 == 0:  # a backquote without its partner
        pieces[-2:] = ["`".join(pieces[-2:])]
    marked = (
        f"<code>{piece}</code>" if k % 2 else _OPTION.sub(_WHOLE, unbroken(piece))
        for k, piece in enumerate(pieces)
    )
    return Markup("".join(marked))
