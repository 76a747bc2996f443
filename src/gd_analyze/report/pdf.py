"""A document as a typeset PDF: its JSON values and its figures as SVG, laid out by Typst."""

from __future__ import annotations

import datetime
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.figures.figure import ON_PAPER, Figure
from gd_analyze.figures.svg import figure_svg
from gd_analyze.report.document import Document

_TEMPLATES = Path(__file__).parent / "templates"
# What only a page or a program reads.
_NOT_PRINTED = ("values", "interactive")


def pdf_of(document: Document) -> bytes:
    """Typeset a document; the same document gives the same bytes."""
    data = {name: value for name, value in document.content.items() if name not in _NOT_PRINTED}
    drawings = {key: figure_svg(figure) for key, figure in document.figures.items()}
    return typeset(f"{document.form}.typ", data, drawings, document.content["created"])


def drawing_file(figure: Figure, form: Any) -> bytes:
    """A figure by itself, as "svg", "pdf" or "png" at 200 pixels per inch."""
    import typst

    svg = figure_svg(figure)
    if form == "svg":
        return svg.encode()
    page = b"#set page(width: auto, height: auto, margin: 4pt)\n#image(bytes(sys.inputs.drawing))"
    return typst.compile(page, format=form, ppi=200, sys_inputs={"drawing": svg}, ignore_system_fonts=True)


def typeset(template: str, data: Mapping[str, Any], drawings: Mapping[str, str], created: str) -> bytes:
    """Compile a template that reads data, colours and drawings (SVG by name) from `sys.inputs`."""
    import typst

    try:
        pdf = typst.compile(
            _TEMPLATES / template,
            root=_TEMPLATES,
            ignore_system_fonts=True,
            sys_inputs={
                "data": json.dumps(data, ensure_ascii=False, allow_nan=False),
                "colours": json.dumps(ON_PAPER),
                **{f"drawing-{name}": svg for name, svg in drawings.items()},
            },
            timestamp=datetime.datetime.fromisoformat(created),
        )
    except typst.TypstError as error:
        raise GdAnalyzeError(
            "the PDF report cannot be typeset",
            where=template,
            found=" ".join([error.message, *error.hints, error.diagnostic]),
            next_step="please report this with the arm file and the trajectory; `formats` without pdf work",
        ) from error
    return bytes(pdf)
