"""Files: read up to a size, written whole or not at all, shipped with the package, marked by their run."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import platform
import re
import select
import shutil
import stat
import sys
import tempfile
import time
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from gd_analyze.errors import (
    Location,
    OutputError,
    StorageError,
    UsageError,
    require_type,
    warn_caller,
)

RESULT_FILES = {
    "h5": "analysis.h5",
    "json": "model.json",
    "csv": "dominance.csv",
    "html": "report.html",
    "pdf": "report.pdf",
}

# Another place helps against these; all else is the machine's failure.
_BAD_PLACE = {
    errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST,
    errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL, errno.EXDEV,
}  # fmt: skip

_BYTES_AT_ONCE = 2**20  # bytes read at once
_BEGIN = 1 << 12  # bytes that hold what tells a file's kind
# Prefix of what a process writes for the time being. Remains of a killed process are removed by the next one
# that writes there on the same machine.
_TEMPORARY = ".gd-analyze."
# Seconds in which somebody must begin to write to a named pipe that is read.
WRITER_WITHIN_SECONDS = 5.0
# Seconds after which any process removes them.
_ABANDONED_AFTER_SECONDS = 86400.0
_MACHINE = f"{zlib.crc32(platform.node().encode()):08x}"

# Searched for in the bytes of any kind of file.
_MARK = re.compile(rb"gd-run:[0-9a-f]{8}-[0-9a-f]{16}")
_ASKED = len("gd-run:") + 8


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path, put in the place of `path` when the block ends well."""
    with replacing_together([path_of(path)]) as (temporary,):
        yield temporary


@contextmanager
def replacing_together(paths: Sequence[Path]) -> Iterator[tuple[Path, ...]]:
    """Yield temporary paths, put in the places of `paths` one after another when the block ends well.

    All are of one folder, which is made where there is none, and removed again if nothing comes into it.
    Whatever stood there stays until then, and stays for good if the block raises or the process is killed.
    All content is on the disk before the first file is replaced, so no file is ever half written. A process
    killed between two replacements leaves files of both sets, which `warn_of_others` notices. An
    `OutputError` says that the place is unsuitable, a `StorageError` that the machine failed.
    """
    if not paths:
        yield ()
        return
    folder, where = paths[0].parent, paths[0] if len(paths) == 1 else paths[0].parent
    temporaries = tuple(folder / f"{_own_prefix()}{path.name}" for path in paths)
    for path in paths:
        _require_no_obstacle(path)
    new_folders = [place for place in (folder, *folder.parents) if not place.exists()]
    try:
        with _named("cannot write there", where):
            folder.mkdir(parents=True, exist_ok=True)
            _remove_abandoned(folder)
            for temporary in temporaries:
                temporary.touch()
        with _named("writing failed", where):
            yield temporaries
            for temporary in temporaries:
                with temporary.open("r+b") as written:
                    os.fsync(written.fileno())
            for temporary, path in zip(temporaries, paths, strict=True):
                temporary.replace(path)
    finally:
        for temporary in temporaries:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
        for place in new_folders:
            with suppress(OSError):  # which a folder with files raises
                place.rmdir()


def write_together(contents: Mapping[Path, bytes]) -> None:
    """Write files of one folder, all or none, see `replacing_together`."""
    with replacing_together([*contents]) as temporaries:
        for temporary, content in zip(temporaries, contents.values(), strict=True):
            temporary.write_bytes(content)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield a folder in the system's place for temporary files, removed at the end; or by another process."""
    _remove_abandoned(Path(tempfile.gettempdir()))
    with tempfile.TemporaryDirectory(prefix=_own_prefix()) as place:
        yield Path(place)


@contextmanager
def appending_alone(path: Path) -> Iterator[BinaryIO]:
    """Open a file to append, for this process alone; an OutputError where another one has it.

    The system ends the lock with the process, however that ends.
    """
    with path.open("ab") as file:
        try:
            if sys.platform == "win32":
                import msvcrt

                file.seek(2**62)  # a byte that nobody writes
                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
            else:
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            is_locked = error.errno in (errno.EAGAIN, errno.EACCES, errno.EDEADLK)
            raise OutputError(
                "another run writes there" if is_locked else "the file cannot be locked",
                where=Location(path),
                found=None if is_locked else error.strerror,
                next_step=f"{'wait for its end, or ' if is_locked else ''}choose another folder",
            ) from None
        yield file


def read_at_most(source: str | Path | BinaryIO, most: int) -> bytes | None:
    """Read a text's bytes from a path, a pipe or a device; None where there are more than `most`.

    A text holds no zero byte, so reading ends soon after one: what is read of /dev/zero is one piece.
    """
    if isinstance(source, str | Path):
        with _opened(Path(source)) as file:
            return read_at_most(file, most)
    data = bytearray()
    while piece := source.read(min(_BYTES_AT_ONCE, most + 1 - len(data))):
        data += piece
        if len(data) > most:
            return None
        if b"\0" in piece:
            break
    return bytes(data)


def _opened(path: Path) -> BinaryIO:
    """Open a file to read; OSError for a named pipe to which nobody writes within some seconds.

    Opened as other files are, it would wait for a writer, maybe for ever. A pipe under a path of the system's
    has one.
    """
    if not path.is_fifo() or path.parts[:2] in (("/", "dev"), ("/", "proc")):
        return path.open("rb")
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    if not select.select([descriptor], [], [], WRITER_WITHIN_SECONDS)[0]:
        os.close(descriptor)
        message = f"a named pipe to which nobody wrote within {WRITER_WITHIN_SECONDS:g} s"
        raise OSError(errno.ETIMEDOUT, f"{message}; `cat PIPE > FILE` makes a file of it")
    os.set_blocking(descriptor, True)
    return os.fdopen(descriptor, "rb")


def megabytes(size: int) -> str:
    """Write a size in megabytes."""
    return f"{size / 1e6:g} MB"


def path_of(path: str | Path) -> Path:
    """Take a path; a UsageError for anything else."""
    require_type(path, (str, os.PathLike), "path", "the path of a file")
    return Path(path)


def write_text(path: str | Path, text: str) -> None:
    """Write a text file atomically, in UTF-8."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def replaces_own(path: Path, sign: str, kind: str) -> bool:
    """Whether a file of a kind, which has a sign near its beginning, would be replaced by one written there.

    Raises
    ------
    OutputError
        If the file there is neither of that kind nor empty.
    """
    if not path.is_file() or not path.stat().st_size:
        return False
    with suppress(OSError), path.open("rb") as file:
        if sign.encode() in file.read(_BEGIN):
            return True
    raise OutputError(
        f"the {kind} would replace a file that is not a {kind}",
        where=Location(path),
        expected=f"a new name, or a {kind} that gd-analyze wrote",
        next_step="choose another name, or remove the file",
    )


def require_writable(path: Path, option: str = "") -> None:
    """Raise an OutputError early, before any computing, where a file could not be written."""
    _require_no_obstacle(path)
    existing = path.parent
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    found = "" if existing.is_dir() else f"{existing} is not a folder"
    if not found:
        try:  # permissions do not tell of read-only disks, or of what the system alone may write
            Path(tempfile.mkdtemp(prefix=_own_prefix(), dir=existing)).rmdir()
        except OSError:
            found = f"{existing} is not writable"
    if found:
        raise OutputError(
            "cannot write the results there",
            where=Location(path),
            expected="a folder that exists or can be made",
            found=found,
            next_step=f"choose another folder with {option}" if option else "choose another folder",
        )


def data_folder(kind: str) -> Path:
    """Folder of a kind of shipped files, such as "robots": in a wheel, or beside src."""
    package = Path(__file__).parent
    packaged = package / "data" / kind
    return packaged if packaged.is_dir() else package.parent.parent / "data" / kind


def shipped(kind: str, suffix: str) -> dict[str, Path]:
    """Shipped files of a kind by their stem, in alphabetical order."""
    return {path.stem: path for path in sorted(data_folder(kind).glob(f"*{suffix}"))}


def mark_of(inputs: Sequence[Any], everything: Any = None) -> str:
    """Mark of a run, which each of its files carries; the same JSON values give the same mark.

    Its first part identifies what was asked for: names of the arm and the motion, options. The second part
    also covers what else the results depend on and state: inputs, versions.
    """
    first, second = (
        hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
        for value in (list(inputs), [list(inputs), everything])
    )
    return f"gd-run:{first[:8]}-{second[:16]}"


def mark_in(path: Path) -> str:
    """First mark in a file; "" where it has none, is missing or cannot be read."""
    with suppress(OSError), path.open("rb") as file:
        before = b""
        while piece := file.read(_BYTES_AT_ONCE):
            if match := _MARK.search(before + piece):
                return match[0].decode()
            before = piece[-40:]  # longer than a mark
    return ""


def warn_of_others(path: Path, mark: str) -> None:
    """Warn where a file of results was read and others of its set, beside it, are not of its run."""
    if path.name not in RESULT_FILES.values():
        return
    foreign = _others(path.parent, [name for name in RESULT_FILES.values() if name != path.name], mark)
    if foreign:
        warn_caller(
            f"files of different runs in {path.parent}: {', '.join(foreign)} differ from {path.name}; "
            "`gd-analyze report` with the folder's analysis.h5 rebuilds them"
        )


def require_one_run(
    folder: Path, files: Mapping[str, str], formats: Collection[str], mark: str, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Check that `formats` of a set of `files` can be written and that their folder will hold one run.

    A repeated run replaces its own files: only the first part of the mark is compared. Other files under the
    set's names raise an `OutputError`, unless `overwrite` is set. Returns the files of other runs, to be
    removed when this run's are written.
    """
    for unknown in sorted(set(formats) - set(files)):
        raise UsageError(f"there is no format {unknown!r}", where="formats", expected=", ".join(files))
    written = [files[name] for name in formats]
    for name in written:
        require_writable(folder / name)
    foreign = _others(folder, files.values(), mark)
    asked_else = [name for name in foreign if mark_in(folder / name)[:_ASKED] != mark[:_ASKED]]
    remaining = [name for name in foreign if name not in written]
    if (asked_else or remaining) and not overwrite:
        raise OutputError(
            f"the folder {folder} holds files of another run",
            where=Location(folder),
            expected="no files, or those of a run with the same arm, motion and options",
            found=", ".join(asked_else or remaining),
            next_step=f"choose another folder{'' if asked_else else ', write all formats'}, "
            "or replace them with overwrite=True",
        )
    return tuple(folder / name for name in remaining)


def _others(folder: Path, names: Iterable[str], mark: str) -> list[str]:
    """Those files of a folder that are not of the run; files without a mark are of a run without one."""
    return [name for name in names if (folder / name).is_file() and mark_in(folder / name) != mark]


def _own_prefix() -> str:
    return f"{_TEMPORARY}{_MACHINE}.{os.getpid()}."


def _remove_abandoned(folder: Path) -> None:
    for path in folder.glob(f"{_TEMPORARY}*"):
        with suppress(OSError):
            if _is_dead(path.name) or time.time() - path.lstat().st_mtime > _ABANDONED_AFTER_SECONDS:
                shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()


def _is_dead(name: str) -> bool:
    """Whether the process that a temporary name states ran on this machine and has ended."""
    machine, _, process = name.removeprefix(_TEMPORARY).partition(".")
    number = process.partition(".")[0]
    # On Windows a signal of 0 would end the process.
    if os.name != "posix" or machine != _MACHINE or not number.isdecimal():
        return False
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        return False  # another user's
    return False


def _require_no_obstacle(path: Path) -> None:
    """Refuse to put a file in the place of a folder, a device or a pipe, or under an impossible name."""
    with _named("cannot write there", path):
        try:
            mode = path.stat().st_mode
        except (FileNotFoundError, NotADirectoryError):
            return
        if not stat.S_ISREG(mode):
            kind = "is a folder" if stat.S_ISDIR(mode) else "is a device or a pipe, not a file"
            raise OSError(errno.EISDIR, kind)


@contextmanager
def _named(message: str, where: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        bad_place = error.errno in _BAD_PLACE
        raise (OutputError if bad_place else StorageError)(
            message,
            where=Location(where),
            found=error.strerror or str(error),
            next_step="choose another folder, one you may write to"
            if bad_place
            else "free space on the disk, or choose another place",
        ) from None
