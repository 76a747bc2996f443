"""MATLAB: one file that GNU Octave runs, too, and a MATLAB Function block of Simulink takes."""

from __future__ import annotations

from typing import ClassVar

from gd_analyze.exporting.language import Language


class Matlab(Language):
    """A function file; states are columns, and there may be many."""

    files: ClassVar = {".m": "matlab.m.jinja"}
    comment = ("", "%", "")
    operators: ClassVar = {"add": "+", "subtract": "-", "multiply": ".*"}
    separator = "; "


LANGUAGE = Matlab
