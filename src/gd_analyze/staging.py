"""Temporary folders beside what they are to replace, and the removal of those that a killed process left."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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
