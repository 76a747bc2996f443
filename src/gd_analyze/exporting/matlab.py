"""MATLAB: one file that GNU Octave runs, too, and a MATLAB Function block of Simulink takes."""

from __future__ import annotations

from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.statements import Notation, body
from gd_analyze.exporting.templating import filled
from gd_analyze.exporting.told import told


def matlab_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a function file; states are columns, and there may be many."""
    text = filled(
        "model.m.jinja",
        subject=subject,
        name=subject.name,
        lines=told(subject),
        functions=[(each, body(each, Notation(times=".*"))) for each in subject.functions],
        listed=lambda values: "; ".join(map(repr, values)),
    )
    return (text,)
