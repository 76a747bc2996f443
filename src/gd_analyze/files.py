"""Reading files up to a stated size, and writing them: each appears whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from gd_analyze.errors import Location, OutputError, UsageError

_PIECE = 2**20  # bytes read at once


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`, put in its place when the block ends well.

    Whatever stood at `path` stays until then, and stays for good if the block raises or the process is
    killed; a killed process leaves at most a hidden temporary file, never a half `path`.

    Raises
    ------
    OutputError
        If the folder cannot be made or written to.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise IsADirectoryError(None, "is a folder")
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=path.suffix)
    except OSError as error:
        raise OutputError(
            "cannot write there",
            where=Location(path),
            found=error.strerror or str(error),
            next_step="choose a file in a folder you may write to",
        ) from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # mkstemp's 0600 would hide results from colleagues
        temporary.replace(path)
    except OSError as error:
        raise OutputError(
            "writing failed", where=Location(path), found=error.strerror or str(error)
        ) from None
    finally:
        temporary.unlink(missing_ok=True)


def read_at_most(source: str | Path | BinaryIO, most: int) -> bytes | None:
    """Read a text's bytes; None where there are more than `most`, however many.

    A text holds no zero byte, so reading ends soon after one: what is read of /dev/zero is one piece.

    Parameters
    ----------
    source
        A path or an open file; a pipe or a device will do.
    most
        Largest size, bytes.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    if isinstance(source, str | Path):
        with Path(source).open("rb") as file:
            return read_at_most(file, most)
    data = bytearray()
    while piece := source.read(min(_PIECE, most + 1 - len(data))):
        data += piece
        if len(data) > most:
            return None
        if b"\0" in piece:
            break
    return bytes(data)


def megabytes(size: int) -> str:
    """Write a size as messages give it."""
    return f"{size / 1e6:g} MB"


def write_text(path: str | Path, text: str) -> None:
    """Write a text file atomically, in UTF-8."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def require_formats(formats: Collection[str], files: Mapping[str, str]) -> None:
    """Raise a UsageError where a format is none of those that `files` are written in."""
    unknown = sorted(set(formats) - set(files))
    if unknown:
        raise UsageError(
            f"there is no format {unknown[0]!r}", where="formats", expected=", ".join(files), found=unknown[0]
        )
