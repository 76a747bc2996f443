"""A file that HDF5 can write without ever meeting a failure, because it does not survive one."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class _SoundFile(io.FileIO):
    """Keeps the first failure to write for itself, and takes everything after it as written."""

    failure: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of `data`, unless a write has failed before."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while self.failure is None and left:
                left = left[super().write(left) :]
        except OSError as error:
            self.failure = error
        return size

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file, unless a write has failed before."""
        try:
            return super().truncate(size) if self.failure is None else size or 0
        except OSError as error:
            self.failure = error
            return size or 0


@contextmanager
def sound_file(path: Path) -> Iterator[io.FileIO]:
    """Open a file to be given to h5py in place of its path.

    Where a write fails, on a full disk, HDF5 cannot close the file any more: h5py raises errors of other
    kinds, and the process ends in a segmentation fault (HDF5 1.14). Here it is told that all went well, and
    the failure is raised when it has closed the file.

    Raises
    ------
    OSError
        The first failure to write.
    """
    with _SoundFile(path, "w+") as file:
        try:
            yield file
        except Exception:
            # What came after a failure to write is no more than its consequence.
            if file.failure is None:
                raise
        if file.failure is not None:
            raise file.failure
