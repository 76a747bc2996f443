"""Standard streams that whoever started the process has closed, as `>&-` and `<&-` do in a shell."""

from __future__ import annotations

import errno
import io
import os
import sys


class _Closed(io.TextIOBase):
    """A stream that can be neither read nor written, and says so."""

    def __init__(self, name: str) -> None:
        self._told = f"standard {name} is closed"

    encoding = "utf-8"

    @property
    def buffer(self) -> _Closed:
        """Itself: what reads or writes bytes fails alike."""
        return self

    def read(self, size: int | None = -1) -> str:
        raise OSError(errno.EBADF, self._told)

    def write(self, text: str) -> int:
        raise OSError(errno.EBADF, self._told)


def fill_closed_streams() -> None:
    """Put something in the place of standard streams that are closed.

    Their numbers are taken, so that no file opened later gets the number that libraries print to. What reads
    or writes the closed stream fails by name; messages that cannot be told are dropped, and the exit code
    says it.
    """
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(number)
    if sys.stdin is None:
        sys.stdin = _Closed("input")
    if sys.stdout is None:
        sys.stdout = _Closed("output")
    if sys.stderr is None:
        sys.stderr = io.StringIO()
