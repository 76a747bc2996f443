"""The mark of a run, which each of its files carries: by it a folder of results holds one run alone."""

from __future__ import annotations

import hashlib
import json
import re
import warnings
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

from gd_analyze.errors import GdAnalyzeWarning, Location, OutputError

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


def mark_of(asked: Sequence[Any], everything: Any = None) -> str:
    """Mark a run; the same arguments give the same mark.

    Parameters
    ----------
    asked
        What the run was asked for, as JSON values: names of the arm and the motion, options. The mark's first
        part.
    everything
        What the results depend on and state besides: inputs, versions.
    """
    first, second = (
        hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
        for value in (list(asked), [list(asked), everything])
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


def require_one_run(
    folder: Path, files: Collection[str], written: Collection[str], mark: str, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Check that a folder will hold files of one run, before anything is computed or written.

    What was asked for once may be asked for again, and replaces what it gave before. Anything else that the
    set's names stand for stays, unless it shall be overwritten.

    Parameters
    ----------
    folder
        Where to write.
    files
        The names of a set of files.
    written
        Those of them that the run at hand will write.
    mark
        Its mark; of a run that no other repeats, one of which only the first part counts.
    overwrite
        Replace whatever is there.

    Returns
    -------
    tuple of Path
        What does not belong to the run, to be removed when its files are written.

    Raises
    ------
    OutputError
        If the folder holds files of a run that was asked for something else, or of none, or if it would then
        hold files of two runs.
    """
    there = {name: marks_in(folder / name) for name in files if (folder / name).is_file()}
    strangers = [name for name, marks in there.items() if not _same_asked(marks, mark)]
    left = [name for name, marks in there.items() if name not in written and mark not in marks]
    if not overwrite and strangers:
        raise OutputError(
            f"the folder {folder} holds files of another run",
            where=Location(folder),
            expected="none, or those of a run of the same arm, motion and options",
            found=", ".join(strangers),
            next_step="choose another folder with --out, or replace the other run with --overwrite",
        )
    if not overwrite and left:
        raise OutputError(
            f"the folder {folder} would hold files of two runs",
            where=Location(folder),
            expected=f"none but {', '.join(written)}, or those of a run of just the same inputs",
            found=", ".join(left),
            next_step="write every format, choose another folder with --out, or remove them with --overwrite",
        )
    return tuple(folder / name for name in left)


def _same_asked(marks: Collection[str], mark: str) -> bool:
    """Whether a file is of a run that was asked for the same."""
    return any(found[:_OF_WHAT] == mark[:_OF_WHAT] for found in marks)


def _are_not(names: Sequence[str]) -> str:
    return f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} not"


def _warn(text: str) -> None:
    warnings.warn(text, GdAnalyzeWarning, stacklevel=4)
