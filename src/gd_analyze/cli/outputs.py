"""What a verb is about to write: where it could not, or would write over what it reads, it fails at once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from gd_analyze.cli.options import FILE, NameOrFile
from gd_analyze.errors import UsageError


def require_outputs(*paths: Path | None, option: str = "--out") -> None:
    """Refuse outputs that cannot be written, or that the verb reads, before it computes anything."""
    from gd_analyze.files import require_writable

    inputs = list(_inputs(click.get_current_context()))
    for path in filter(None, paths):
        require_writable(path, option)
        for word, status in inputs:
            if path.exists() and os.path.samestat(path.stat(), status):
                raise UsageError(
                    "the output would replace an input",
                    where=str(path),
                    found=f"the same file as {word}",
                    next_step=f"choose another name with {option}",
                )


def _inputs(context: click.Context) -> Iterator[tuple[str, os.stat_result]]:
    """Words of the command that name what it reads, and the files they stand for."""
    for parameter in context.command.params:
        given: Any = context.params.get(parameter.name or "")
        if given is None or not (isinstance(parameter.type, NameOrFile) or parameter.type is FILE):
            continue
        for word in given if isinstance(given, tuple) else (given,):
            path = parameter.type.path_of(word) if isinstance(parameter.type, NameOrFile) else Path(word)
            try:
                yield str(word), os.fstat(0) if str(path) == "-" else path.stat()
                # A folder stands for the files in it.
                yield from ((str(one), one.stat()) for one in (path.iterdir() if path.is_dir() else ()))
            except (OSError, ValueError):
                continue  # what cannot be read is for the reader to say
