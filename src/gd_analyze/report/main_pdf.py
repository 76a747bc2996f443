"""The main report as a PDF: a first page that answers, the model, the trade-off, and appendices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from gd_analyze.report.main_report import MainReport, main_report
from gd_analyze.report.model_sections import model_parts
from gd_analyze.report.numbering import Numbers
from gd_analyze.report.pdf import drawings_of, parts_data, result_data, typeset
from gd_analyze.result import Drawing, Part, Table
from gd_analyze.results.findings import Findings
from gd_analyze.results.run_result import margins, tube_bound

# What a bar of the chart of errors shows of what the budget allows, at most.
_LONGEST = 3.0


def prepare_pdf(findings: Findings, report: MainReport | None = None) -> Callable[[], bytes]:
    """Do all but the typesetting, which leaves the interpreter free for other threads.

    The callable typesets: of the same findings the same bytes.
    """
    opening, first, appendices, numbers = report or main_report(findings)
    rest = parts_data(appendices, numbers)
    for section, part in zip(appendices, rest, strict=True):
        part["key"] = section.key
    data = result_data(opening) | {
        "errors": _errors(findings, first, numbers),
        "first": {
            part.key: value
            for part, value in zip(first[:2], parts_data(first[:2], numbers), strict=True)
            if isinstance(part, Drawing)
        },
        "trade_off": parts_data(
            [part for part in first[2:] if part.key == "trade_off" and isinstance(part, Drawing | Table)],
            numbers,
        ),
        "model": parts_data(model_parts(findings), numbers),
        "appendices": rest,
        "small": findings.arm.n_joints < 4,
    }
    drawings = drawings_of((*first, *appendices))
    return partial(typeset, "report.typ", data, drawings, findings.provenance["created"])


def _errors(findings: Findings, first: Sequence[Part], numbers: Numbers) -> dict[str, Any]:
    """Bars and figures of every joint's error, sampled and proven, against the budget."""
    (table,) = (part for part in first if part.key == "errors")
    model, proven = findings.model, tube_bound(findings)
    allowed, noise = model.accuracy.allowed, findings.round_off
    used = [
        _used(float(error), float(a), noise)
        for error, a in zip(model.accuracy.errors.largest, allowed, strict=True)
    ]
    bounds = None
    if proven is not None:
        bounds = [_used(float(error), float(a), noise) for error, a in zip(proven, allowed, strict=True)]
    near = "the motion" if proven is None else f"{margins(findings)} of the motion"
    return {
        "table": parts_data([table], numbers)[0],
        "used": used,
        "proven": bounds,
        "longest": max([1.25, *used, *(bounds or [])]),
        "near": near,
        "budget": model.accuracy.budget,
    }


def _used(error: float, allowed: float, noise: float) -> float:
    """Part of the allowed error that an error takes; nothing where it is round-off."""
    return min(error / allowed, _LONGEST) if error > noise and allowed > 0.0 else 0.0
