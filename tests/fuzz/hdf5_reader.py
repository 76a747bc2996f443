"""A process that reads results files for another: a damaged file can stop the HDF5 library for good.

Requests are lines with a path; each is answered with a line of JSON.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from verdict import BrokenError, judge

from gd_analyze.report.main_page import render_html
from gd_analyze.results.findings import Findings
from gd_analyze.results.store import load_findings
from gd_analyze.schema import GROUPS

# Not a number where none is known, infinite where nothing is shared or needed.
NOT_ALWAYS_FINITE = {
    "beyond": {"certified", "worst_found", "within_limits", "mass_within_budget", "uncertainty"},
    "dominance": {"change_without"},
    "parts": {"torque_peak"},
    "measured_torque": {name for name, declared in GROUPS["measured_torque"].items() if declared.besides},
}


def use(findings: Findings) -> None:
    """What is read holds numbers, and the report can be made of it."""
    for name, table in findings.tables.items():
        for variable, array in table.variables.items():
            is_share = str(variable).endswith("_share")
            if array.dtype.kind == "f" and variable not in NOT_ALWAYS_FINITE.get(name, ()) and not is_share:
                assert np.isfinite(array.values).all(), f"{name}/{variable} is not finite"
    assert render_html(findings).startswith("<!doctype html>")


def answer(path: Path) -> dict[str, Any]:
    try:
        return {"read": judge(path, load_findings, use)}
    except BrokenError as error:
        return {"cause": error.cause, "detail": error.detail}


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(answer(Path(line.rstrip("\n")))), flush=True)
