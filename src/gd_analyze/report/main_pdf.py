"""The main report as a PDF: a first page that answers, the model, the trade-off, and appendices."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.report.main_report import MainReport, main_report
from gd_analyze.report.model_sections import model_parts
from gd_analyze.report.pdf import drawings_of, parts_data, result_data, typeset
from gd_analyze.results.findings import Findings
from gd_analyze.results.run_result import margins, tube_bound

# What a bar of the chart of errors shows of what the budget allows, at most.
_LONGEST = 3.0


def prepare_pdf(findings: Findings, report: MainReport | None = None) -> Callable[[], bytes]:
    """Do all but the typesetting, which leaves the interpreter free for other threads.

    The callable typesets: of the same findings the same bytes.
    """
    report = report or main_report(findings)
    first, numbers = (report.arm, report.contributions), report.numbers
    data = result_data(report.opening) | {
        "errors": _errors(findings, report),
        "first": {part["key"]: part for part in parts_data(first, numbers)},
        "trade_off": parts_data(report.trade_off or (), numbers),
        "model": parts_data(model_parts(findings), numbers),
        "appendices": parts_data(report.appendices, numbers),
        "small": findings.arm.n_joints < 4,
    }
    drawings = drawings_of((*first, *(report.trade_off or ()), *report.appendices))
    return partial(typeset, "report.typ", data, drawings, findings.provenance["created"])


def _errors(findings: Findings, report: MainReport) -> dict[str, Any]:
    """Bars and figures of every joint's error, sampled and proven, against the budget."""
    accuracy, bound = findings.model.accuracy, tube_bound(findings)
    used = _used(findings, accuracy.errors.largest)
    proven = None if bound is None else _used(findings, bound)
    return {
        "table": parts_data([report.errors], report.numbers)[0],
        "used": used,
        "proven": proven,
        "longest": max([1.25, *used, *(proven or [])]),
        "near": "the motion" if bound is None else f"{margins(findings)} of the motion",
        "budget": accuracy.budget,
    }


def _used(findings: Findings, errors: FloatArray) -> list[float]:
    """Parts of the allowed errors that errors take; nothing where one is round-off."""
    allowed = findings.model.accuracy.allowed
    counts = (errors > findings.round_off) & (allowed > 0.0)
    used = np.divide(errors, allowed, out=np.zeros_like(allowed), where=counts)
    return np.minimum(used, _LONGEST).tolist()
