"""A user's folder that keeps slow results between runs.

An entry is a JSON value under a key that contains everything the value depends on. Without the folder, or
with a damaged entry, the result is computed again, equal to the last bit, so no failure is reported. Readers
check a value before using it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from gd_analyze import __version__
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.files import read_at_most, replacing

VARIABLE = "GD_ANALYZE_CACHE"
# Most bytes of an entry.
_LARGEST_ENTRY = 2_000_000
# Most bytes of the folder. Beyond it, the least recently used entries are removed, down to half of it.
LARGEST_CACHE = 20_000_000
_SUFFIX = ".gd.json"

_off: ContextVar[bool] = ContextVar("without the cache", default=False)


@contextmanager
def without_cache() -> Iterator[None]:
    """Neither read nor write the cache while the block lasts."""
    before = _off.set(True)
    try:
        yield
    finally:
        _off.reset(before)


def cache_folder() -> Path | None:
    """Folder of the entries; None if the cache is off.

    The variable GD_ANALYZE_CACHE names another folder, or is "off" or empty.
    """
    named = os.environ.get(VARIABLE)
    if _off.get() or (named is not None and named.lower() in ("", "off")):
        return None
    from platformdirs import user_cache_path

    return Path(named) if named else user_cache_path("gd-analyze", appauthor=False)


def name_of(key: Any) -> str:
    """Name of the entry for a key, a JSON value with arrays; it includes the version of gd-analyze."""

    def digest(array: Any) -> list[Any]:
        return [array.shape, array.dtype.str, hashlib.sha256(array.tobytes()).hexdigest()]

    return hashlib.sha256(json.dumps([__version__, key], default=digest).encode()).hexdigest()


def kept(name: str) -> Any:
    """Value of an entry as written; None if it is missing or damaged."""
    place = cache_folder()
    if place is None:
        return None
    path = place / (name + _SUFFIX)
    # Others may have written there: anything that is not JSON, too deep, too large or foreign is ignored.
    with suppress(Exception):
        digest, _, body = (read_at_most(path, _LARGEST_ENTRY) or b"").partition(b"\n")
        if digest.decode("ascii") == _digest(name, body):
            value = json.loads(body)
            with suppress(OSError):
                os.utime(path)
            return value
    return None


def keep(name: str, value: Any) -> None:
    """Write an entry atomically; another process may do the same at the same time."""
    place = cache_folder()
    if place is None:
        return
    body = json.dumps(value, allow_nan=False).encode()
    with suppress(OSError, GdAnalyzeError):
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        with replacing(place / (name + _SUFFIX)) as temporary:
            temporary.write_bytes(_digest(name, body).encode() + b"\n" + body)
        _make_room(place)


def _digest(name: str, body: bytes) -> str:
    return hashlib.sha256(name.encode() + body).hexdigest()


def _make_room(place: Path) -> None:
    entries = []
    for path in place.glob("*" + _SUFFIX):
        with suppress(OSError):  # another process has removed it
            status = path.lstat()
            entries.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in entries)
    allowed_size = LARGEST_CACHE if total <= LARGEST_CACHE else LARGEST_CACHE // 2
    for _, size, path in sorted(entries):
        if total <= allowed_size:
            return
        path.unlink(missing_ok=True)
        total -= size
