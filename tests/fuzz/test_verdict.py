"""The property the fuzzing holds can fail, in each of its ways."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from verdict import TAKEN, BrokenError, bounded, judge

from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning

NAME = "case.csv"


class UnkemptError(GdAnalyzeError):
    """One whose text nothing tidied up on the way."""

    def __init__(self, *lines: str) -> None:
        super().__init__("")
        self.args = lines

    def __str__(self) -> str:
        return "\n".join(self.args)


def raising(error: Exception):
    def read(path: Path) -> None:
        raise error

    return read


def telling(*texts: str, category: type[Warning] = GdAnalyzeWarning):
    return lambda path: [warnings.warn(text, category, stacklevel=1) for text in texts]


def slow(path: Path) -> None:
    with bounded(seconds=0.01):
        deadline = time.monotonic() + 30.0
        while time.monotonic() < deadline:
            pass


BROKEN = {
    "KeyError": raising(KeyError("mass")),
    "AssertionError": raising(AssertionError("not finite")),
    "message without the file": raising(UnkemptError("somewhere: wrong")),
    "message of many lines": raising(UnkemptError(NAME, *["wrong"] * 9)),
    "wide message": raising(UnkemptError(NAME, "x" * 1100)),
    "message with a letter that is not seen": raising(UnkemptError(NAME, "\x1b[31mred")),
    "RuntimeWarning": telling("overflow", category=RuntimeWarning),
    "a warning told twice": telling("odd", "odd"),
    "TooSlowError": slow,
} | ({"MemoryError": lambda path: np.zeros(2**34, dtype=np.uint8)} if TAKEN.exists() else {})


@pytest.mark.parametrize(("kind", "read"), BROKEN.items(), ids=BROKEN)
def test_what_breaks_it(kind, read):
    # numpy raises a subclass of MemoryError of its own.
    with pytest.raises(BrokenError) as caught:
        judge(Path(NAME), read, lambda value: None)
    assert kind.removeprefix("Memory") in caught.value.cause[0]


def test_what_holds():
    assert judge(Path(NAME), telling("odd"), lambda value: None)
    assert not judge(Path(NAME), raising(UnkemptError(NAME, "wrong")), lambda value: None)
