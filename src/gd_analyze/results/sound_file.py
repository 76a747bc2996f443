"""A file that HDF5 can write without ever meeting a failure, because it does not survive one."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

_PAGE = 1 << 16


class SoundFile(io.FileIO):
    """Takes every write; what comes after one that failed is kept in memory, so that it can be read again.

    Whoever writes much should look at `failure` now and then, and stop.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.failure: OSError | None = None
        self._kept: dict[int, bytearray] = {}

    def write(self, data: Any) -> int:
        """Write all of `data` where the file stands."""
        whole = memoryview(data).cast("B")
        start, left = self.tell(), whole
        try:
            while self.failure is None and left:
                left = left[super().write(left) :]
        except OSError as error:
            self.failure = error
        if self.failure is not None:
            self._keep(start, whole)
        self.seek(start + len(whole))
        return len(whole)

    def readinto(self, buffer: Any) -> int:
        """Read what was written, zeros where nothing was."""
        if self.failure is None:
            return super().readinto(buffer) or 0
        start, whole = self.tell(), memoryview(buffer).cast("B")
        done = 0
        while done < len(whole):
            number, within = divmod(start + done, _PAGE)
            piece = self._page(number)[within : within + len(whole) - done]
            whole[done : done + len(piece)] = piece
            done += len(piece)
        self.seek(start + done)
        return done

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file, which only matters as long as all can be written."""
        try:
            if self.failure is None:
                return super().truncate(size)
        except OSError as error:
            self.failure = error
        return size or 0

    def _keep(self, start: int, data: memoryview) -> None:
        done = 0
        while done < len(data):
            number, within = divmod(start + done, _PAGE)
            page = self._kept.setdefault(number, self._page(number))
            piece = data[done : done + _PAGE - within]
            page[within : within + len(piece)] = piece
            done += len(piece)

    def _page(self, number: int) -> bytearray:
        """A page as it was kept, or as it is on the disk and filled up with zeros."""
        if number in self._kept:
            return self._kept[number]
        page = bytearray(_PAGE)
        self.seek(number * _PAGE)
        super().readinto(page)
        return page


@contextmanager
def sound_file(path: Path) -> Iterator[SoundFile]:
    """Open a file to be given to h5py in place of its path.

    Where a write fails, on a full disk, HDF5 cannot close the file any more: h5py raises errors of other
    kinds, and the process ends in a segmentation fault (HDF5 1.14). Here it is told that all went well, and
    the failure is raised when it has closed the file.

    Raises
    ------
    OSError
        The first failure to write.
    """
    with SoundFile(path) as file:
        yield file
    if file.failure is not None:
        raise file.failure
