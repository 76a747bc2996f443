"""The main job's answer in Python: printed as in a terminal, and as HTML in a notebook."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from markupsafe import escape

from gd_analyze.figures.svg import figure_svg
from gd_analyze.report.document import Document, result_document
from gd_analyze.report.main_report import NOTEBOOK, main_result
from gd_analyze.report.terminal import text_of
from gd_analyze.results.findings import Findings
from gd_analyze.text import html_of, pretty, visible


def printed_findings(findings: Findings) -> str:
    """What a terminal shows of the main job."""
    return text_of(result_document(main_result(findings))).rstrip("\n")


def notebook_view(findings: Findings) -> str:
    """The same as HTML, with the matrix of elements."""
    document = result_document(main_result(findings, NOTEBOOK))
    content = document.content
    head = f"<p><b>{_words(content['title'])}</b> {_words(content['subtitle'])}</p>"
    warnings = [f"Warning: {warning}." for warning in findings.warnings]
    parts = "".join(_parts(content["parts"], document))
    notices = _paragraphs([*content["notices"], *warnings])
    return f"{head}{_paragraphs([content['headline']])}{parts}{notices}"


def _parts(parts: Sequence[Mapping[str, Any]], document: Document) -> Iterator[str]:
    for part in parts:
        kind = part["kind"]
        if kind == "facts":
            yield html_of("", (), [(fact["label"], pretty(fact["text"])) for fact in part["facts"]])
        elif kind == "section":
            yield _paragraphs([part["title"], *part["note"]])
            yield from _parts(part["parts"], document)
        elif kind == "figure":
            # The colours are those of paper, whatever the notebook's are.
            drawn = figure_svg(document.figures[part["key"]])
            yield f'<div style="background: white; display: inline-block">{drawn}</div>'
            yield _paragraphs([f"{part['title']} {part['note']}"])
        elif kind == "equations":
            yield _paragraphs(part["note"])
            lines = [*part["lines"], *part["legend"]["lines"]]
            text = "\n".join(visible(line) for line in lines)
            yield f"<details><summary>equations</summary><pre>{escape(text)}</pre></details>"
        else:
            columns = [column for column in part["columns"] if not column["pages_only"]]
            headings = [", ".join(filter(None, (column["label"], column["unit"]))) for column in columns]
            rows = zip(*(column["cells"] for column in columns), strict=True)
            yield html_of(part["title"], headings, rows, " ".join(part["note"]))


def _paragraphs(texts: Sequence[str]) -> str:
    return "".join(f"<p>{_words(text)}</p>" for text in texts if text)


def _words(text: str) -> str:
    return str(escape(visible(pretty(text))))
