"""The mark of a run, which each of its files carries, so that files of different runs are told apart."""

from __future__ import annotations

import hashlib
import json
import re
import warnings
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gd_analyze.errors import GdAnalyzeWarning

RESULT_FILES = {
    "h5": "analysis.h5",
    "json": "model.json",
    "csv": "dominance.csv",
    "html": "report.html",
    "pdf": "report.pdf",
}

# What follows is searched for in the bytes of any kind of file, so it must stand there as it is, and say by
# itself what it is.
_PREFIX = "gd-run:"
_MARK = re.compile(rb"gd-run:[0-9a-f]{8}-[0-9a-f]{16}")
_OF_WHAT = len(_PREFIX) + 8
_LENGTH = _OF_WHAT + 1 + 16
_BLOCK = 1 << 20


def mark_of(names: Sequence[str], everything: Any) -> str:
    """Mark a run; the same arguments give the same mark.

    Parameters
    ----------
    names
        Of the arm and the motion: the mark's first part.
    everything
        What the results depend on and state, as JSON values: inputs, options, versions.
    """
    first, second = (
        hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
        for value in (list(names), [list(names), everything])
    )
    return f"{_PREFIX}{first[:8]}-{second[:16]}"


def marks_in(path: Path) -> set[str]:
    """Marks in the first part of a file that has any; none where it is missing or no file.

    There may be more than one: a stored command may name a path that holds one.
    """
    if not path.is_file():
        return set()
    try:
        with path.open("rb") as file:
            before = b""
            while block := file.read(_BLOCK):
                if found := _MARK.findall(before + block):
                    return {mark.decode() for mark in found}
                before = block[-_LENGTH:]
    except OSError:  # nobody can read it, so nobody can take it for one of this run
        return set()
    return set()


def others(folder: Path, names: Iterable[str], mark: str) -> list[str]:
    """Those files of a folder that are not of the run; files without a mark are of a run without one."""
    found = {name: marks_in(folder / name) for name in names if (folder / name).is_file()}
    return [name for name, marks in found.items() if (mark not in marks if mark else bool(marks))]


def warn_of_others(path: Path, mark: str) -> None:
    """Warn where a file of results was read and others of its set, beside it, are not of its run.

    Warns
    -----
    GdAnalyzeWarning
        Naming them.
    """
    if path.name not in RESULT_FILES.values():
        return
    strangers = others(path.parent, [name for name in RESULT_FILES.values() if name != path.name], mark)
    if strangers:
        _warn(
            f"the folder {path.parent} holds files of different runs: {_are_not(strangers)} of the run of "
            f"{path.name}; `gd-analyze report` with the folder's analysis.h5 makes the others anew"
        )


def warn_of_what_was_there(
    folder: Path, before: Mapping[str, set[str]], written: Collection[str], mark: str
) -> None:
    """Warn after a folder was written to that held files of another run.

    Parameters
    ----------
    folder
        Where it was written.
    before
        The names of a set of files, and the marks that were in each.
    written
        The names of those that were replaced.
    mark
        Of the run that wrote.

    Warns
    -----
    GdAnalyzeWarning
        If files not written now are of another run, or those replaced were of another arm or motion.
    """
    remaining = others(folder, [name for name in before if name not in written], mark)
    if remaining:
        them = "it" if len(remaining) == 1 else "them"
        _warn(
            f"the folder {folder} now holds files of different runs: {_are_not(remaining)} of the run that "
            f"wrote {', '.join(written)}; remove {them}, or write every format"
        )
    replaced = [name for name in written if before[name] and not _same_names(before[name], mark)]
    if replaced:
        _warn(
            f"the folder {folder} held results of another arm or motion, now replaced: {', '.join(replaced)}"
        )


def _same_names(marks: Collection[str], mark: str) -> bool:
    """Whether a file is of a run on an arm and a motion of the same names."""
    return any(found[:_OF_WHAT] == mark[:_OF_WHAT] for found in marks)


def _are_not(names: Sequence[str]) -> str:
    return f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} not"


def _warn(text: str) -> None:
    warnings.warn(text, GdAnalyzeWarning, stacklevel=4)
