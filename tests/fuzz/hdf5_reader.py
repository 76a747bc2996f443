"""Reads results files in a process of its own: a damaged file can stop the HDF5 library for good.

Requests are lines with a path; each is answered with a line of JSON.
"""

from __future__ import annotations

import atexit
import json
import select
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from verdict import SECONDS, BrokenError, judge

from gd_analyze import load_findings
from gd_analyze.report.main_page import render_html
from gd_analyze.schema import GROUPS
from gd_analyze.types import Findings


def use(findings: Findings) -> None:
    """What is read holds numbers, and the report can be made of it."""
    for name, table in findings.tables.items():
        for variable, array in table.data_vars.items():
            if array.dtype.kind == "f" and not GROUPS[name][str(variable)].besides:
                assert np.isfinite(array.values).all(), f"{name}/{variable} is not finite"
    assert render_html(findings).startswith("<!doctype html>")


def answer(path: Path) -> dict[str, Any]:
    try:
        return {"read": judge(path, load_findings, use)}
    except BrokenError as error:
        return {"cause": error.cause, "detail": error.detail}


# On a machine that does other things as well, a case takes longer than the time it may take for itself.
PATIENCE = 10 * SECONDS


class Process:
    """This file in a process of its own, started when it is first asked, and again if it hangs or dies."""

    def __init__(self) -> None:
        self._running: subprocess.Popen[str] | None = None
        atexit.register(self.stop)

    def read(self, path: Path) -> dict[str, Any]:
        """Answer of the process; a BrokenError if there is none in time."""
        if self._running is None:
            self._running = subprocess.Popen(
                [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
        assert self._running.stdin is not None
        assert self._running.stdout is not None
        self._running.stdin.write(f"{path}\n")
        self._running.stdin.flush()
        # Its own clock stops the process earlier, unless it is inside a library.
        ready, _, _ = select.select([self._running.stdout], [], [], PATIENCE)
        line = self._running.stdout.readline() if ready else ""
        if not line:
            died = self._running.wait() if ready else None
            self.stop()
            raise BrokenError("hangs" if died is None else f"process died with {died}", "reading")
        return json.loads(line)

    def stop(self) -> None:
        """End the process."""
        if self._running is not None:
            with self._running as process:
                process.kill()
            self._running = None


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(answer(Path(line.rstrip("\n")))), flush=True)
