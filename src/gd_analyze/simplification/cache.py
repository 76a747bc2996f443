"""A folder of the user's that keeps between runs what takes long to make.

An entry is a JSON value under a key, which is all that the value depends on. Nothing here is needed: without
the folder, or with a damaged one, everything is made anew and is the same to the last bit. So no failure of
it is told. Whoever reads an entry checks the value before believing it.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from gd_analyze.files import read_at_most
from gd_analyze.version import __version__

VARIABLE = "GD_ANALYZE_CACHE"
# Of an entry, and of the folder: what is older goes, until half of that is left.
_LARGEST, MOST = 2_000_000, 20_000_000
_SUFFIX = ".gd.json"

# Variable that says where, and where otherwise.
_PLACES = {"win32": ("LOCALAPPDATA", "AppData/Local"), "darwin": ("", "Library/Caches")}

_off: ContextVar[bool] = ContextVar("without the cache", default=False)


@contextmanager
def without_cache() -> Iterator[None]:
    """Neither read nor write the cache while the block lasts."""
    before = _off.set(True)
    try:
        yield
    finally:
        _off.reset(before)


def folder() -> Path | None:
    """Where entries are kept; None where they are not.

    The variable GD_ANALYZE_CACHE names another place, or is "off" or empty. Otherwise it is where the system
    keeps such things: XDG_CACHE_HOME or ~/.cache, ~/Library/Caches, LOCALAPPDATA.
    """
    if _off.get():
        return None
    named = os.environ.get(VARIABLE)
    if named is not None:
        return None if named.lower() in ("", "off") else Path(named)
    variable, beside_home = _PLACES.get(sys.platform, ("XDG_CACHE_HOME", ".cache"))
    # One that is not absolute shall be ignored, says the XDG base directory specification.
    for place in (Path(os.environ.get(variable, "")), Path("~", beside_home)):
        with suppress(RuntimeError):  # there is no home
            if place.expanduser().is_absolute():
                return place.expanduser() / "gd-analyze"
    return None


def name_of(key: Any) -> str:
    """Name of the entry under a key, which is a JSON value; the version of gd-analyze is part of it."""
    return hashlib.sha256(json.dumps([__version__, key]).encode()).hexdigest()


def kept(name: str) -> Any:
    """Value of an entry as it was written; None where there is none, or what is there is damaged."""
    place = folder()
    if place is None:
        return None
    path = place / (name + _SUFFIX)
    # Whoever else may have written there: what is no JSON, too deep, too large or another's is no entry.
    with suppress(OSError, ValueError, RecursionError):
        content = read_at_most(path, _LARGEST) or b""
        digest, _, body = content.partition(b"\n")
        if digest.decode("ascii") == _digest(name, body):
            value = json.loads(body)
            with suppress(OSError):  # what is used stays, where that can be noted
                os.utime(path)
            return value
    return None


def keep(name: str, value: Any) -> None:
    """Write an entry, whole or not at all; another process may do the same at the same time."""
    place = folder()
    if place is None:
        return
    body = json.dumps(value, allow_nan=False).encode()
    with suppress(OSError):
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        # Of an unused name, so that no other process writes there, and one that goes when room is made.
        temporary = place / f"{name}-{os.getpid()}{_SUFFIX}"
        try:
            temporary.write_bytes(_digest(name, body).encode() + b"\n" + body)
            temporary.replace(place / (name + _SUFFIX))
        finally:
            temporary.unlink(missing_ok=True)
        if name < "1":  # as every sixteenth is
            _make_room(place)


def _digest(name: str, body: bytes) -> str:
    return hashlib.sha256(name.encode() + body).hexdigest()


def _make_room(place: Path) -> None:
    """Remove the entries not used for longest once there are too many, and nothing that is no entry."""
    entries = []
    for path in place.glob("*" + _SUFFIX):
        with suppress(OSError):  # another process has removed it
            known = path.lstat()
            entries.append((known.st_mtime, known.st_size, path))
    total = sum(size for _, size, _ in entries)
    if total <= MOST:
        return
    for _, size, path in sorted(entries):
        with suppress(OSError):
            path.unlink()
        total -= size
        if total <= MOST // 2:
            return
