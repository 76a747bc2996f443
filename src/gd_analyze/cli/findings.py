"""What the main job found, as terminal and JSON show it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from gd_analyze.cli.output import Output

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings


def print_findings(
    findings: Findings, folder: Path, formats: tuple[str, ...], output: Output, top: int
) -> None:
    """Print what was found and which files hold it; `top` rows of the ranking for people."""
    from gd_analyze.motions.states import states_of
    from gd_analyze.result import Section
    from gd_analyze.results.recursion_parts import recursion_parts
    from gd_analyze.results.run_result import run_result
    from gd_analyze.simplification.recursive import RECURSIVE
    from gd_analyze.studies.main_job_files import FILES

    model = findings.model
    result = run_result(findings, top)
    if model.level is RECURSIVE and output.as_json:
        parts = recursion_parts(model, states_of(findings.trajectory), 3)
        result = replace(result, parts=(*result.parts, Section("recursion", "", parts)))
    output.warnings[:] = dict.fromkeys([*findings.warnings, *output.warnings])
    output.give(result, wrote=[folder / FILES[name] for name in formats])
