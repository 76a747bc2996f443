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
PATH = Path(NAME)


class UnkemptError(GdAnalyzeError):
    """One whose text nothing tidied up on the way."""

    def __str__(self) -> str:
        return "\n".join(map(str, self.args))


def refusing(*lines: str):
    def read(path: Path) -> None:
        error = UnkemptError("")
        error.args = lines
        raise error

    return read


def telling(*texts: str, category: type[Warning] = GdAnalyzeWarning):
    def read(path: Path) -> None:
        for text in texts:
            warnings.warn(text, category, stacklevel=1)

    return read


def not_finite(value: object) -> None:
    assert np.isfinite(np.nan), "not finite"


def hungry(path: Path) -> None:
    np.zeros(2**34, dtype=np.uint8)


def raising(path: Path) -> None:
    raise KeyError("mass")


BROKEN = {
    "KeyError": raising,
    "message without the file": refusing("wrong", "where: somewhere"),
    "message of many lines": refusing(NAME, *["wrong"] * 9),
    "wide message": refusing(NAME, "x" * 1100),
    "message with a letter that is not seen": refusing(NAME, "\x1b[31mred"),
    "RuntimeWarning": telling("overflow", category=RuntimeWarning),
    "a warning told twice": telling("odd", "odd"),
} | ({"MemoryError": hungry} if TAKEN.exists() else {})


@pytest.mark.parametrize(("kind", "read"), BROKEN.items(), ids=BROKEN)
def test_what_breaks_it(kind, read):
    # numpy raises a subclass of MemoryError of its own.
    with pytest.raises(BrokenError) as caught:
        judge(PATH, read, lambda value: None)
    assert kind.removeprefix("Memory") in caught.value.cause[0]


def test_a_value_that_is_not_sound_breaks_it():
    with pytest.raises(BrokenError) as caught:
        judge(PATH, lambda path: None, not_finite)
    assert caught.value.cause[0] == "AssertionError"


def test_time_runs_out():
    def read(path: Path) -> None:
        with bounded(seconds=0.01):
            deadline = time.monotonic() + 30.0
            while time.monotonic() < deadline:
                pass

    with pytest.raises(BrokenError, match="TooSlowError"):
        judge(PATH, read, lambda value: None)


def test_what_holds():
    assert judge(PATH, telling("odd"), lambda value: None)
    assert not judge(PATH, refusing(NAME, "wrong"), lambda value: None)
