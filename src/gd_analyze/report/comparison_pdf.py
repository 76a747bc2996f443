"""The comparison of formulations, typeset: numbers as JSON, charts as SVG, layout by Typst."""

from __future__ import annotations

import datetime
import json
from typing import Any

from gd_analyze.formatting import figures, pretty
from gd_analyze.report.comparison import SHORT, ComparisonContext, Count
from gd_analyze.report.comparison_chart import PAPER, growth_chart
from gd_analyze.report.pdf import TEMPLATES, typeset


def render_comparison_pdf(context: ComparisonContext, created: str) -> bytes:
    """Typeset one comparison.

    Parameters
    ----------
    context
        The comparison's numbers.
    created
        Date and time, ISO 8601; the same context and time give the same bytes.

    Raises
    ------
    GdAnalyzeError
        If the document cannot be typeset.
    """
    when = datetime.datetime.fromisoformat(created)
    inputs = {
        "data": json.dumps(_document(context, when), ensure_ascii=False, allow_nan=False),
        "executed": growth_chart(context, "executed", PAPER),
        "folded": growth_chart(context, "folded", PAPER),
    }
    return typeset(TEMPLATES / "comparison.typ", inputs, when)


def _document(context: ComparisonContext, when: datetime.datetime) -> dict[str, Any]:
    """Words and formatted numbers of the template."""
    return {
        "title": context.title,
        "subtitle": context.subtitle,
        "headline": pretty(context.headline),
        "date": [when.year, when.month, when.day],
        "facts": [{"value": _powers(value), "caption": pretty(caption)} for value, caption in context.facts],
        "warnings": list(context.warnings),
        "n_joints": context.n_joints,
        "unit": "N m" if context.all_turning else "N m or N",
        "set_points": context.timed_set_points,
        "repeats": context.timed_repeats,
        "sines_cosines": context.methods[0].executed.sines_cosines,
        "methods": [
            {
                "title": row.title,
                "source": row.source,
                "kinematics": row.kinematics,
                "form": row.form,
                "order": _powers(row.order),
                "executed": _pair(row.executed),
                "folded": _pair(row.folded),
                "text": _pair(row.text),
                "time": _microseconds(row.seconds),
                "difference": figures(row.difference),
                "slopes": [
                    "–" if slope is None else f"{slope:.2f}"
                    for slope in (row.exponent, row.exponent_folded, row.exponent_text)
                ],
                "explanation": row.explanation,
            }
            for row in context.methods
        ],
        "pinocchio": {
            "time": _microseconds(context.seconds_pinocchio),
            "difference": figures(max(context.torque_differences[-1])),
        },
        "sizes": [str(n) for n in context.sizes],
        "curves": [
            {
                "title": row.title,
                "lines": [
                    {"label": label, "values": [str(count.total) for count in counts]}
                    for label, counts in (
                        ("as executed", curve.executed),
                        ("folded", curve.folded),
                        ("the text", curve.text),
                    )
                    if counts
                ],
            }
            for row, curve in zip(context.methods, context.curves, strict=True)
        ],
        "names": [SHORT[name] for name in context.names],
        "differences": [
            ["–" if i == j else figures(value) for j, value in enumerate(row)]
            for i, row in enumerate(context.torque_differences)
        ],
        "from_pinocchio": [
            [SHORT[name], *(figures(value) for value in values)] for name, *values in context.from_pinocchio
        ],
        "bounds": [figures(value) for value in context.bounds],
        "agrees": context.agrees,
        "polynomials": [
            [title, table, _powers(multiplications), _powers(additions), remark]
            for title, table, multiplications, additions, remark in context.polynomials
        ],
        "text_source": context.text_source,
        "text_remark": context.text_remark,
        "provenance": [[label.replace("_", " "), value] for label, value in context.provenance],
    }


def _pair(count: Count | None) -> list[str]:
    return ["–", "–"] if count is None else [str(count.multiplications), str(count.additions)]


def _microseconds(seconds: float) -> str:
    return f"{1e6 * seconds:.2f}"


def _powers(text: str) -> list[dict[str, Any]] | str:
    """Text with carets as pieces, raised or not; plain text as it is."""
    text = text.replace(" - ", " − ")
    if "^" not in text:
        return pretty(text)
    pieces: list[dict[str, Any]] = []
    for k, part in enumerate(text.split("^")):
        raised = ""
        while k and part and (part[0].isdigit() or (part[0] == "." and part[1:2].isdigit())):
            raised, part = raised + part[0], part[1:]
        if raised:
            pieces.append({"text": raised, "raised": True})
        pieces.append({"text": part, "raised": False})
    return pieces
