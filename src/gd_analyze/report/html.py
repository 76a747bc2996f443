"""A result as one HTML file that opens offline: title, headline, facts, notices, parts and provenance."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from gd_analyze.figures.figure import COLOURS, FIGURE_WIDTH, Figure, LegendKey
from gd_analyze.figures.svg import key_svg, panel_svg
from gd_analyze.formulas.formula import Formula, Legend, Symbol
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.report.numbering import PartNumbers, is_seen
from gd_analyze.result import (
    AnyFact,
    Drawing,
    Equations,
    Mark,
    Part,
    Result,
    Section,
    SeenColumn,
    SeenFact,
    Table,
)
from gd_analyze.text import pretty, signed, unbroken

TEMPLATES = Path(__file__).parent / "templates"
# Least number of rows of a sortable table.
_FEWEST_SORTABLE_ROWS = 12
_MATHS = PageMathML()
# An option of the command line, which a browser would break after its hyphens.
_OPTION, _WHOLE = re.compile(r"--[a-z][a-z-]*"), r'<span class="option">\g<0></span>'


def page_of(result: Result) -> str:
    """Write a result as a page; styles, drawings and scripts are inside it."""
    numbers = PartNumbers.of(result.parts)
    sections = [part for part in result.parts if isinstance(part, Section)]
    body = (
        f'<section id="answer">\n{opening(result)}\n</section>\n'
        f"{parts_html(result.parts, numbers)}\n{provenance_html(result.provenance)}\n"
    )
    links = [("answer", "Answer"), *((part.key, part.title) for part in sections if part.key)]
    return frame(
        f"{result.title} {result.subtitle}".strip(), links, body, run=result.provenance.get("run", "")
    )


def frame(title: str, links: Iterable[tuple[str, str]], body: str, *, data: str = "", run: str = "") -> str:
    """Put a body into a page with a bar of links (identifier, name), style and script.

    `data` is the JSON that the script of the main report reads, `run` the mark of the run.
    """
    styles, scripts = ["page.css"], ["page.js"]
    if data:
        styles.append("report.css")
        scripts.append("report.js")
    mark = f'<meta name="gd-analyze-run" content="{escape(run)}">\n' if run else ""
    data_script = f'<script type="application/json" id="report-data">{data}</script>\n' if data else ""
    colours = (f"--{name}: light-dark({light}, {dark});" for name, (light, dark) in COLOURS.items())
    nav = "\n".join(f'    <a href="#{escape(key)}">{escape(name)}</a>' for key, name in links)
    return template("page.html").format(
        mark=mark,
        title=escape(title),
        colours=" ".join(colours),
        style="".join(map(template, styles)),
        nav=nav,
        body=body,
        held=data_script,
        script="".join(map(template, scripts)),
    )


@cache
def template(name: str) -> str:
    """Text of a file among the templates."""
    return (TEMPLATES / name).read_text(encoding="utf-8")


def opening(result: Result, more: str = "") -> str:
    """Title, headline, notices and facts; `more` is the place of further notices."""
    link = f'<li><a href="#{escape(more)}">More notes</a></li>\n' if more else ""
    notices = notice_list(result.notices, link)
    return (
        f"<h1>{text(result.title)} <span>{text(result.subtitle)}</span></h1>\n"
        f'<p class="headline">{text(unbroken(result.headline))}</p>\n{notices}{_facts(result.facts)}'
    )


def notice_list(notices: Sequence[str], more: str = "") -> str:
    """Notices as a list, with further items; nothing if there is none."""
    items = "".join(f"<li>{text(notice)}</li>\n" for notice in notices) + more
    return f'<ul class="notices">\n{items}</ul>\n' if items else ""


def _facts(facts: Iterable[Part]) -> str:
    """Values above their names."""
    seen = [fact for fact in facts if isinstance(fact, SeenFact)]
    rows = "".join(
        f"  <div><dt>{text(fact.label)}</dt><dd>{text(fact.written)}</dd></div>\n" for fact in seen
    )
    return f'<dl class="facts">\n{rows}</dl>\n' if rows else ""


def parts_html(parts: Sequence[Part], numbers: PartNumbers, level: int = 2) -> str:
    """Write parts in order, sections with a heading of that level; facts in a row stand together."""
    out: list[str] = []
    for are_facts, alike in groupby(parts, lambda part: isinstance(part, AnyFact)):
        if are_facts:
            out.append(_facts(alike))
            continue
        for part in alike:
            if isinstance(part, Table):
                out.append(table_html(part, numbers))
            elif isinstance(part, Drawing):
                out.append(drawing_html(part, numbers))
            elif isinstance(part, Equations):
                out.append(_equations(part))
            elif isinstance(part, Section):
                mark = f' id="{escape(part.key)}"' if part.key else ""
                head = f"<h{level}>{text(part.title)}</h{level}>\n" if part.title else ""
                inside = parts_html(part.parts, numbers, level + 1)
                out.append(f"<section{mark}>\n{head}{paragraphs(part.note)}{inside}</section>\n")
    return "".join(out)


def paragraphs(note: str, kind: str = "") -> str:
    """A text, a paragraph per line."""
    mark = f' class="{kind}"' if kind else ""
    return "".join(f"<p{mark}>{text(line)}</p>\n" for line in note.split("\n") if line)


def table_html(table: Table, numbers: PartNumbers) -> str:
    """A table that scrolls if it is wide and can be sorted if it is long."""
    if not is_seen(table):
        return ""
    columns = table.shown(on_page=True)
    sortable = len(columns[0][2]) > _FEWEST_SORTABLE_ROWS
    heads = []
    for column, unit, _ in columns:
        name = text(column.label) + (Markup(f" <small>{text(unit)}</small>") if unit else "")
        name = Markup(f'<button type="button">{name}</button>') if sortable else name
        title = f' title="{escape(column.meaning)}"' if column.meaning else ""
        heads.append(f'<th scope="col"{_side(column)}{title}>{name}</th>')
    cells = [_cells(column, written, sortable) for column, _, written in columns]
    rows = "".join(f"<tr>{''.join(row)}</tr>\n" for row in zip(*cells, strict=True))
    caption = f"{numbers.of_table(table.key)}{text(table.title)}"
    return (
        f'<div class="scroll" role="group" aria-label="{escape(table.title)}" tabindex="0">\n'
        f'<table class="data{" sortable" if sortable else ""}" id="table-{escape(table.key)}">\n'
        f"<caption><span>{caption}</span></caption>\n<thead><tr>{''.join(heads)}</tr></thead>\n"
        f"<tbody>\n{rows}</tbody>\n</table>\n</div>\n{paragraphs(table.note, 'small')}"
    )


def _cells(column: SeenColumn, written: Sequence[str], sortable: bool) -> Iterator[str]:
    """Cells as elements of a row; a name heads its row."""
    all_drawn = column.drawn or [None] * len(written)
    for value, drawn, cell in zip(column.values, all_drawn, map(text, written), strict=False):
        sorts = f' data-v="{float(value):.6g}"' if sortable and isinstance(value, int | float) else ""
        if drawn is not None:
            yield f"<td>{_mark(drawn) if isinstance(drawn, Mark) else maths(drawn)}</td>"
        elif column.shown == "share":
            share = 0.0 if value is None else min(max(float(value), 0.0), 1.0)
            yield f'<td{sorts}><span class="share" style="--share:{share:.4g}">{cell}</span></td>'
        elif column.shown == "name":
            yield f'<th scope="row">{cell}</th>'
        else:
            yield f"<td{_side(column)}{sorts}>{signed(cell)}</td>"


def _mark(mark: Mark) -> Markup:
    return Markup('<span class="kept {}">{}</span>').format(mark.effect, text(mark.text))


def _side(column: SeenColumn) -> str:
    """Words on the left, figures on the right."""
    return "" if column.is_text or column.shown == "share" else ' class="value"'


def drawing_html(drawing: Drawing, numbers: PartNumbers) -> str:
    """Panels of a figure with legend and caption; empty places keep the shape of a matrix."""
    figure: Figure = drawing.figure
    panels = []
    for r, c, panel in figure.places:
        place = f' style="grid-area:{r + 1}/{c + 1}"' if None in figure.rows[r] else ""
        panels.append(f"<div{place}>{panel_svg(panel, figure)}</div>\n")
    # A panel as wide as a page scrolls where the screen is narrower.
    is_wide = figure.columns == 1 and figure.width >= FIGURE_WIDTH
    wide = f' scroll" role="group" aria-label="{escape(drawing.title)}" tabindex="0' if is_wide else ""
    return (
        f'<figure class="drawing" id="figure-{escape(drawing.key)}">\n{legend_html(figure.legend)}'
        f'<div class="panels{wide}" style="--columns:{figure.columns}">\n{"".join(panels)}</div>\n'
        f"<figcaption>{caption_html(drawing, numbers)}</figcaption>\n</figure>\n"
    )


def legend_html(keys: Iterable[LegendKey]) -> str:
    """Looks and their meanings; nothing without keys."""
    entries = "".join(f"<span>{key_svg(key)}{text(key.label)}</span> " for key in keys)
    return f'<p class="legend">{entries}</p>\n' if entries else ""


def caption_html(drawing: Drawing, numbers: PartNumbers) -> Markup:
    """Number, title and note of a figure."""
    return Markup("{}{} {}").format(numbers.of_figure(drawing.key), text(drawing.title), text(drawing.note))


def _equations(part: Equations) -> str:
    """Formulas, with line breaks between summands, and the meaning of their letters."""
    if part.formulas:
        lines = "".join(f'<p class="equation">{maths(formula)}</p>\n' for formula in part.formulas)
    else:
        lines = "".join(f'<p class="equation"><code>{text(line)}</code></p>\n' for line in part.lines)
    title = f"<h3>{text(part.title)}</h3>\n" if part.title else ""
    return f"{title}{paragraphs(part.note, 'small')}{lines}{meanings_html(part.legend)}"


def meanings_html(legend: Legend | None) -> str:
    """Meaning of the letters in formulas."""
    entries = "".join(f"<span>{meaning}</span> " for meaning in (_MATHS.legend(legend) if legend else ()))
    return f'<p class="legend">{entries}</p>\n' if entries else ""


def provenance_html(provenance: Mapping[str, str]) -> str:
    """Origin of a result."""
    rows = "".join(
        f"  <div><dt>{text(label.replace('_', ' '))}</dt><dd>{text(value or 'not stated')}</dd></div>\n"
        for label, value in provenance.items()
    )
    return (
        f'<section id="provenance">\n<h2>Provenance</h2>\n<dl class="provenance">\n{rows}</dl>\n</section>'
        if rows
        else ""
    )


def maths(value: Any) -> Markup:
    """A symbol, a formula, or several, as MathML; other values as text."""
    if isinstance(value, Symbol):
        return Markup(f"<math>{_MATHS.symbol(value)}</math>")
    if isinstance(value, Formula):
        pieces = "".join(f"<span>{piece}</span> " for piece in _MATHS.elements(value))
        left = _MATHS.left(value) if value.left.letter else ""
        return Markup(f"{left} {pieces}")
    if isinstance(value, tuple | list):
        return Markup(", ").join(map(maths, value))
    return text("" if value is None else str(value))


def text(words: object) -> Markup:
    """The program's words as HTML; text between backquotes is code."""
    pieces = str(escape(pretty(str(words)))).split("`")
    if len(pieces) % 2 == 0:  # a backquote without its partner
        pieces[-2:] = ["`".join(pieces[-2:])]
    marked = (
        f"<code>{piece}</code>" if k % 2 else _OPTION.sub(_WHOLE, unbroken(piece))
        for k, piece in enumerate(pieces)
    )
    return Markup("".join(marked))
