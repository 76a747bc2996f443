"""Lines of a long text, cut out where they are asked for: a million strings take as much memory again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import overload

import numpy as np
from numpy.typing import NDArray


class Lines(Sequence[str]):
    """Lines of a text in UTF-8, however they end.

    Parameters
    ----------
    data
        The text, which can be decoded; a byte order mark before it is no part of it.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        breaks = np.flatnonzero(np.frombuffer(self._data, dtype=np.uint8) == ord("\n"))
        self._first = np.concatenate([[0], breaks + 1])
        self._last = np.append(breaks, len(self._data))

    def __len__(self) -> int:
        return len(self._first)

    @overload
    def __getitem__(self, which: int) -> str: ...
    @overload
    def __getitem__(self, which: slice) -> Lines: ...
    def __getitem__(self, which: int | slice) -> str | Lines:
        if isinstance(which, slice):
            return self.at(np.arange(len(self))[which])
        return self._data[self._first[which] : self._last[which]].decode()

    def __iter__(self) -> Iterator[str]:
        for first, last in zip(self._first.tolist(), self._last.tolist(), strict=True):
            yield self._data[first:last].decode()

    def at(self, which: Sequence[int] | NDArray[np.intp]) -> Lines:
        """Some of the lines, from 0."""
        chosen = Lines.__new__(Lines)
        chosen._data, places = self._data, np.asarray(which, dtype=np.intp)
        chosen._first, chosen._last = self._first[places], self._last[places]
        return chosen
