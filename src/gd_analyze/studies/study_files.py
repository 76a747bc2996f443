"""Studies as files of one folder: checked before any computing, written together."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from gd_analyze.files import mark_of, replacing_together, require_formats, require_one_run


def require_folder(
    folder: Path,
    formats: Collection[str],
    files: Mapping[str, str],
    names: Sequence[str],
    *,
    overwrite: bool = False,
) -> tuple[Path, ...]:
    """Check that a study may go there, see `gd_analyze.files.require_one_run`.

    Parameters
    ----------
    folder, formats
        Where to, and which of the files.
    files
        Names of the study's files by format.
    names
        What the study was asked for.
    overwrite
        Whether a run of something else may be replaced.
    """
    written = [files[name] for name in formats]
    return require_one_run(folder, files.values(), written, mark_of(names), overwrite=overwrite)


def write_study(
    make: Mapping[str, Callable[[], bytes]],
    files: Mapping[str, str],
    folder: Path,
    formats: Collection[str],
    strangers: Collection[Path] = (),
) -> None:
    """Write the chosen files, all together when the last is made, and remove those of another run.

    Raises
    ------
    UsageError
        If there is no such format.
    OutputError
        If the folder cannot be written to.
    """
    require_formats(formats, files)
    made = {name: make[name]() for name in formats}
    with replacing_together([folder / files[name] for name in made]) as temporaries:
        for temporary, content in zip(temporaries, made.values(), strict=True):
            temporary.write_bytes(content)
    for path in strangers:
        path.unlink(missing_ok=True)


def as_json(document: Mapping[str, Any]) -> bytes:
    """Write a study's document."""
    return (json.dumps(document, indent=2, allow_nan=False) + "\n").encode()
