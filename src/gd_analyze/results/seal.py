"""A digest at the end of a file, checked before anything reads the file.

A damaged HDF5 file can make the HDF5 library loop for ever, so damage has to be seen before the library
looks. The digest follows the HDF5 data as one line of text. Readers of HDF5 know from its head how long the
data are and take no notice of what follows; a program that edits the file loses or invalidates the line.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import BinaryIO

from gd_analyze.results.refusal import refusal

_HDF5 = b"\x89HDF\r\n\x1a\n"
_MARK = b"\ngd-analyze sha256 "
# The mark, a digest in hexadecimal, the end of the line.
SEAL_LENGTH = len(_MARK) + 64 + 1
# Bytes read at a time: the memory that checking takes, whatever the length of the file.
_BLOCK = 2**20


def seal(path: Path) -> None:
    """Append the digest of all that a file holds."""
    with path.open("r+b") as file:
        digest = _digest(file, os.fstat(file.fileno()).st_size)
        file.seek(0, os.SEEK_END)
        file.write(_MARK + digest + b"\n")


def require_sealed(path: Path) -> None:
    """Check that a file ends in the digest of what comes before.

    Raises
    ------
    StoreError
        If it does not: it is no HDF5 file, or cut short, or changed.
    OSError
        If it cannot be read.
    """
    with path.open("rb") as file:
        if file.read(len(_HDF5)) != _HDF5:
            raise refusal(path, "the results file is damaged or not HDF5", "another kind of file")
        length = os.fstat(file.fileno()).st_size - SEAL_LENGTH
        file.seek(max(length, 0))
        line = file.read(SEAL_LENGTH)
        if length < 0 or not line.startswith(_MARK):
            found = "no digest at its end: cut short, edited since, or written by another program or version"
            raise refusal(path, "this HDF5 file is not as gd-analyze wrote it", found)
        if line != _MARK + _digest(file, length) + b"\n":
            raise refusal(
                path, "the results file is damaged, or was edited since it was written", "another digest"
            )


def _digest(file: BinaryIO, length: int) -> bytes:
    """SHA-256 of the first bytes of a file, in hexadecimal."""
    digest = hashlib.sha256()
    file.seek(0)
    while length > 0 and (block := file.read(min(length, _BLOCK))):
        digest.update(block)
        length -= len(block)
    return digest.hexdigest().encode()
