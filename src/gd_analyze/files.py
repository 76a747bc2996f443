"""Reading files up to a stated size, and writing them: whole or not at all, and those of a set together."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
import shutil
import signal
import stat
import sys
import tempfile
import threading
import warnings
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

from gd_analyze.errors import GdAnalyzeWarning, Location, OutputError, StorageError, UsageError

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

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


if sys.platform != "win32":
    import fcntl

# Of the hidden folder, of the file in it that is locked, and of the folder in it that is yielded.
_PREFIX, _LOCK, _NEW = ".gd-analyze.", "lock", "new"


@contextmanager
def staging(folder: Path) -> Iterator[Path]:
    """Yield an empty folder inside `folder`, so on its file system; it is gone when the block ends.

    What killed processes left in `folder` is removed first. That an owner lives is told by the lock it holds
    on a file: the kernel gives it up with the process, however that ends. The number of a process would be
    another's after a while, and means nothing to another machine or container.

    Raises
    ------
    OSError
        If the folder cannot be read or written.
    """
    for left in list(folder.glob(f"{_PREFIX}*")):
        _remove_if_abandoned(left)
    place, lock = _held(folder)
    try:
        (place / _NEW).mkdir()
        yield place / _NEW
    finally:
        os.close(lock)
        with suppress(OSError):
            _remove(place)


def locked(descriptor: int, *, wait: bool = False) -> bool:
    """Take the lock on an open file or folder; False where another holds it.

    A file system without locks counts as granting them to a writer. On Windows nothing is locked: a file that
    is open cannot be removed there.
    """
    if sys.platform != "win32":
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            return False
        except OSError:
            return True
    return True


def _held(folder: Path) -> tuple[Path, int]:
    """Make a folder that no other process takes for abandoned, and the descriptor that holds it."""
    while True:
        place = Path(tempfile.mkdtemp(dir=folder, prefix=_PREFIX))
        try:
            lock = os.open(place / _LOCK, os.O_RDWR | os.O_CREAT, 0o600)
        except FileNotFoundError:
            continue  # another process removed it in the moment before it was held
        except OSError:
            place.rmdir()
            raise
        if locked(lock) and os.fstat(lock).st_nlink:
            return place, lock
        os.close(lock)


def _remove(place: Path) -> None:
    """Remove a temporary folder, its lock last: who is killed meanwhile leaves one known to be ours."""
    shutil.rmtree(place / _NEW, ignore_errors=True)
    (place / _LOCK).unlink(missing_ok=True)
    place.rmdir()


def _remove_if_abandoned(place: Path) -> None:
    """Remove a temporary folder unless its owner lives or cannot be known to be gone."""
    if sys.platform == "win32":
        with suppress(OSError):
            (place / _LOCK).unlink()  # refused while its owner has it open
            (place / _LOCK).touch()
            _remove(place)
        return
    try:
        lock = os.open(place / _LOCK, os.O_RDWR | os.O_NOFOLLOW)
    except FileNotFoundError:
        with suppress(OSError):  # not empty: not ours
            place.rmdir()
        return
    except OSError:
        return  # another user's
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _remove(place)
    except OSError:
        pass  # held; or on a file system without locks, which cannot tell
    finally:
        os.close(lock)


_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")


@contextmanager
def signals_held() -> Iterator[None]:
    """Let requests to end wait until the block has ended; they are answered then.

    Python answers signals in its main thread only, so that in another there is nothing to hold.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    numbers = [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]
    # A handler that is not Python's own could not be put back.
    before = {number: handler for number in numbers if (handler := signal.getsignal(number)) is not None}
    for number in before:
        signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in came:
            signal.raise_signal(number)


def data_folder(kind: str) -> Path:
    """Folder of the shipped "robots", "trajectories" or "references"."""
    package = Path(__file__).parent
    packaged = package / "data" / kind
    return packaged if packaged.is_dir() else package.parent.parent / "data" / kind


def shipped(kind: str, suffix: str) -> dict[str, Path]:
    """Shipped files of a kind by their stem, in alphabetical order."""
    return {path.stem: path for path in sorted(data_folder(kind).glob(f"*{suffix}"))}


RESULT_FILES = {
    "h5": "analysis.h5",
    "json": "model.json",
    "csv": "dominance.csv",
    "html": "report.html",
    "pdf": "report.pdf",
}

# What follows is searched for in the bytes of any kind of file, so it must stand there as it is, and say by
# itself what it is.
_MARK_PREFIX = "gd-run:"
_MARK = re.compile(rb"gd-run:[0-9a-f]{8}-[0-9a-f]{16}")
_OF_WHAT = len(_MARK_PREFIX) + 8
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
    return f"{_MARK_PREFIX}{first[:8]}-{second[:16]}"


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
