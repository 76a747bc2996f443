"""How a value shows in a notebook: a title, a small table and a sentence, as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from markupsafe import escape

from gd_analyze.visible import visible

_WORDS = "text-align: left"


def html_of(
    title: str, headings: Sequence[str], rows: Iterable[Sequence[str]], note: str = "", more: str = ""
) -> str:
    """Write a value as HTML; names in it may be anybody's, and are escaped.

    Parameters
    ----------
    title, headings, rows
        Its table; cells that begin with a letter stand on the left.
    note
        A sentence below.
    more
        Lines that are folded away.

    Examples
    --------
    >>> html_of("an arm", ["joint"], [["1 <waist>"]])
    '<table><caption>an arm</caption><tr><th>joint</th></tr><tr><td>1 &lt;waist&gt;</td></tr></table>'
    """
    head = "".join(f"<th>{_text(heading)}</th>" for heading in headings)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    table = f"<table><caption>{_text(title)}</caption><tr>{head}</tr>{body}</table>"
    below = f"<p>{_text(note)}</p>" if note else ""
    lines = "\n".join(_text(line) for line in more.splitlines())
    folded = f"<details><summary>equations</summary><pre>{lines}</pre></details>" if more else ""
    return table + below + folded


def _cell(text: str) -> str:
    style = f' style="{_WORDS}"' if text[:1].isalpha() else ""
    return f"<td{style}>{_text(text)}</td>"


def _text(text: str) -> str:
    return str(escape(visible(text)))
