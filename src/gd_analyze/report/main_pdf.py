"""The typeset report: numbers as JSON, figures as SVG, layout by Typst."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.figures.arm import arm_figure, views_figure
from gd_analyze.figures.colours import COLOURS
from gd_analyze.figures.elements import inertia_figure, vector_figure
from gd_analyze.figures.figure import Figure
from gd_analyze.figures.motion import motion_figure, recording_figure
from gd_analyze.figures.svg import figure_svg
from gd_analyze.figures.torques import contributions_figure, error_figure, measured_figure, measured_joints
from gd_analyze.figures.trade_off import trade_off_figure
from gd_analyze.report.compiled_templates import TEMPLATES
from gd_analyze.report.document import document
from gd_analyze.results.findings import Findings
from gd_analyze.results.recording_words import is_recorded


def prepare_pdf(findings: Findings) -> Callable[[], bytes]:
    """Do all but the typesetting, which leaves the interpreter free for other threads.

    Parameters
    ----------
    findings
        What the main job found.

    Returns
    -------
    callable
        Typesets: gives a PDF file, of the same findings the same bytes, or raises a GdAnalyzeError.
    """
    data, figures, created = document(findings), report_figures(findings), findings.provenance["created"]
    return partial(typeset, TEMPLATES / "report.typ", data, figures, created)


def report_figures(findings: Findings) -> dict[str, str]:
    """Draw every figure of the report, as SVG by its name in the template."""
    makers: dict[str, Callable[[Findings], Figure]] = {
        "arm": arm_figure,
        "contributions": contributions_figure,
        "views": views_figure,
        "motion": motion_figure,
        "inertia": inertia_figure,
        "coriolis": partial(vector_figure, quantity="coriolis_centrifugal"),
        "gravity": partial(vector_figure, quantity="gravity_loading"),
        "torque": error_figure,
        "trade_off": trade_off_figure,
    }
    if is_recorded(findings):
        makers["recording"] = recording_figure
    if measured_joints(findings):
        makers["measured"] = measured_figure
    return {name: figure_svg(make(findings)) for name, make in makers.items()}


def typeset(template: Path, data: dict[str, Any], figures: Mapping[str, str], created: str) -> bytes:
    """Compile a Typst template that reads its data and its figures, SVG by name, from `sys.inputs`.

    The file is dated as created, in ISO 8601.

    Raises
    ------
    GdAnalyzeError
        With Typst's own message, if it does not compile.
    """
    import typst

    try:
        pdf = typst.compile(
            template,
            root=template.parent,
            ignore_system_fonts=True,
            sys_inputs={
                "data": json.dumps(data, ensure_ascii=False, allow_nan=False),
                "colours": json.dumps(COLOURS),
                **figures,
            },
            timestamp=datetime.datetime.fromisoformat(created),
        )
    except typst.TypstError as error:
        raise GdAnalyzeError(
            "the PDF report cannot be typeset",
            where=template.name,
            found=" ".join([error.message, *error.hints, error.diagnostic]),
            next_step="please report this with the arm file and the trajectory; --format html works without",
        ) from error
    return bytes(pdf)
