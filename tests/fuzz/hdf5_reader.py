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

from gd_analyze.report.html import render_html
from gd_analyze.results import Findings, load_findings

# Not a number where there is none: parts that do not act, and arms that state no uncertainty.
MAY_LACK = {("parts", "torque_peak"), ("parts", "torque_share"), ("beyond", "uncertainty")}


def use(findings: Findings) -> None:
    """What is read holds numbers, and the report can be made of it."""
    for name, table in findings.tables.items():
        for variable, array in table.variables.items():
            if array.dtype.kind == "f" and (name, variable) not in MAY_LACK:
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
