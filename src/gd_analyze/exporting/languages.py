"""The languages there are: a new one is a file here that prints a subject, and a line."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from gd_analyze.exporting.c import c_texts
from gd_analyze.exporting.cpp import cpp_texts
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.latex import latex_texts
from gd_analyze.exporting.matlab import matlab_texts
from gd_analyze.exporting.python import casadi_texts, jax_texts, python_texts


class Language(NamedTuple):
    """A language.

    Parameters
    ----------
    suffixes
        Of its files, behind the subject's name.
    texts
        What prints a subject, with numbers of a type: a text for each file.
    """

    suffixes: tuple[str, ...]
    texts: Callable[[ExportInput, str], tuple[str, ...]]

    def names(self, subject: str) -> tuple[str, ...]:
        """Names of the files of a subject."""
        return tuple(f"{subject}{suffix}" for suffix in self.suffixes)


LANGUAGES: dict[str, Language] = {
    "c": Language((".h", ".c"), c_texts),
    "cpp": Language((".hpp",), cpp_texts),
    "python": Language((".py",), python_texts),
    "matlab": Language((".m",), matlab_texts),
    "casadi": Language(("_casadi.py",), casadi_texts),
    "jax": Language(("_jax.py",), jax_texts),
    "latex": Language((".tex",), latex_texts),
}
