"""The formats that are read: how a changed file of each is written, and how it is judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import csv_cases
import hdf5_cases
import json_cases
import log_cases
import toml_cases
import xml_cases
from hypothesis import strategies as st
from plans import Plan
from verdict import judge


@dataclass(frozen=True)
class Format:
    """A format.

    Parameters
    ----------
    bases
        Number of valid files.
    cases
        Plans of changed files.
    write
        Carries a plan out and writes the file.
    judged
        Whether the file was read; a BrokenError where the property does not hold.
    """

    bases: int
    cases: st.SearchStrategy[Plan]
    write: Callable[[Plan, Path], None]
    judged: Callable[[Path], bool]


def _text_format(cases: ModuleType) -> Format:
    def write(plan: Plan, path: Path) -> None:
        path.write_bytes(cases.made(plan))

    def judged(path: Path) -> bool:
        return judge(path, cases.read, cases.use)

    return Format(len(cases.BASES), cases.cases, write, judged)


FORMATS = {
    "csv": _text_format(csv_cases),
    "log": _text_format(log_cases),
    "toml": _text_format(toml_cases),
    "xml": _text_format(xml_cases),
    "json": _text_format(json_cases),
    "h5": Format(1, hdf5_cases.cases, hdf5_cases.write, hdf5_cases.judged),
}
