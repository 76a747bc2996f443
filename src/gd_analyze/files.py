"""Reading files up to a stated size, and writing them: whole or not at all, and those of a set together."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from gd_analyze.errors import Location, OutputError, StorageError, UsageError
from gd_analyze.held_signals import signals_held
from gd_analyze.staging import locked, staging

# What the choice of another place mends; all else is the machine's failure.
_BAD_PLACE = {
    errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST,
    errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL, errno.EXDEV,
}  # fmt: skip

_PIECE = 2**20  # bytes read at once


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path, put in the place of `path` when the block ends well."""
    with replacing_together([Path(path)]) as (temporary,):
        yield temporary


@contextmanager
def replacing_together(paths: Sequence[Path]) -> Iterator[tuple[Path, ...]]:
    """Yield temporary paths of the same names, put in the places of `paths` when the block ends well.

    Whatever stood there stays until then, and stays for good if the block raises or the process is killed.
    All content is on the disk before the first file is renamed. The renames follow each other in the order of
    `paths`, with nothing in between that could fail for want of space; two processes that write into one
    folder do so one after the other. A process killed between two renames leaves files of both sets, and one
    killed at any time a hidden folder, which the next to write there removes.

    Parameters
    ----------
    paths
        Files of one folder, which is made where there is none. Without files nothing is done.

    Raises
    ------
    OutputError
        If the folder cannot be made or written to, or something other than a file is in the way.
    StorageError
        If the machine fails: a full disk, a quota, a broken device.
    """
    if not paths:
        yield ()
        return
    folder, where = paths[0].parent, paths[0] if len(paths) == 1 else paths[0].parent
    for path in paths:
        _require_no_obstacle(path)
    with ExitStack() as until_done:
        with _named("cannot write there", where):
            folder.mkdir(parents=True, exist_ok=True)
            place = until_done.enter_context(staging(folder))
            temporaries = tuple(place / path.name for path in paths)
            for temporary in temporaries:
                temporary.touch()
        with _named("writing failed", where):
            yield temporaries
            for temporary in temporaries:
                with temporary.open("r+b") as written:
                    os.fsync(written.fileno())
            _put_in_place(temporaries, paths)


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


def require_writable(path: Path, option: str = "--out") -> None:
    """Fail early, before any computing, when a file could not be written.

    Raises
    ------
    OutputError
        If something other than a file is in the way, or its folder cannot be written to or made.
    """
    _require_no_obstacle(path)
    existing = path.parent
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir() or not os.access(existing, os.W_OK | os.X_OK):
        raise OutputError(
            "cannot write the results there",
            where=Location(path),
            expected="a folder that exists or can be made",
            found=f"{existing} is {'not writable' if existing.is_dir() else 'not a folder'}",
            next_step=f"choose another place with {option}",
        )


def require_formats(formats: Collection[str], files: Mapping[str, str]) -> None:
    """Raise a UsageError where a format is none of those that `files` are written in."""
    unknown = sorted(set(formats) - set(files))
    if unknown:
        raise UsageError(
            f"there is no format {unknown[0]!r}", where="formats", expected=", ".join(files), found=unknown[0]
        )


def _require_no_obstacle(path: Path) -> None:
    """Refuse to put a file in the place of a folder, a device or a pipe, or under a name that cannot be."""
    with _named("cannot write there", path):
        try:
            mode = path.stat().st_mode
        except (FileNotFoundError, NotADirectoryError):
            return
        if not stat.S_ISREG(mode):
            kind = "is a folder" if stat.S_ISDIR(mode) else "is a device or a pipe, not a file"
            raise OSError(errno.EISDIR, kind)


def _put_in_place(temporaries: Sequence[Path], paths: Sequence[Path]) -> None:
    """Rename all, and see the names to the disk."""
    folder = paths[0].parent
    with _serialised(folder), _kept_open(paths), signals_held():
        for done, (temporary, path) in enumerate(zip(temporaries, paths, strict=True)):
            try:
                temporary.replace(path)
            except OSError as error:
                if not done:
                    raise
                names = [each.name for each in paths]
                raise _named_error(
                    f"only {', '.join(names[:done])} could be put in place; "
                    f"{', '.join(names[done:])} are still those of before",
                    path,
                    error,
                ) from None


@contextmanager
def _kept_open(paths: Sequence[Path]) -> Iterator[None]:
    """Keep open what is to be replaced.

    To give free the space of a file takes a hundred times as long as to rename one, and would come between
    two renames. On Windows a file that is open cannot be replaced.
    """
    with ExitStack() as kept:
        for path in () if sys.platform == "win32" else paths:
            with suppress(OSError):  # there is none, or none that this user may read: slower, and as good
                kept.callback(os.close, os.open(path, os.O_RDONLY))
        yield


@contextmanager
def _serialised(folder: Path) -> Iterator[None]:
    """Let one process at a time rename in a folder, and see its names to the disk; neither is for Windows."""
    if sys.platform == "win32":
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        locked(descriptor, wait=True)
        yield
        with suppress(OSError):  # of a file system that knows no such thing; the renames are done
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def _named(what: str, where: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise _named_error(what, where, error) from None


def _named_error(what: str, where: Path, error: OSError) -> OutputError:
    bad_place = error.errno in _BAD_PLACE
    return (OutputError if bad_place else StorageError)(
        what,
        where=Location(where),
        found=error.strerror or str(error),
        next_step="choose a file in a folder you may write to"
        if bad_place
        else "see to the disk, or choose another place",
    )
