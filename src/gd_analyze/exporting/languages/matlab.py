"""MATLAB: one file that GNU Octave runs, too, and a MATLAB Function block of Simulink takes."""

from __future__ import annotations

from typing import ClassVar

from gd_analyze.exporting.language import Language

_RESERVED = """
break case catch classdef continue else elseif end for function global if otherwise parfor persistent return
spmd switch try while arguments enumeration events methods properties do until endfunction endif endfor
endwhile endswitch end_try_catch end_unwind_protect unwind_protect unwind_protect_cleanup pi eye zeros ones
reshape size nargin nargout
"""


class Matlab(Language):
    """A function file; states are columns, and there may be many."""

    files: ClassVar = {".m": "matlab.m.jinja"}
    comment = ("", "%", "")
    operators: ClassVar = {"add": "+", "subtract": "-", "multiply": ".*"}
    separator = "; "
    reserved = frozenset(_RESERVED.split())


LANGUAGE = Matlab
