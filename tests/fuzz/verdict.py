"""The one property of reading: a sound value, or an error that says what to mend; never anything else."""

from __future__ import annotations

import resource
import signal
import traceback
import unicodedata
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from gd_analyze.errors import GdAnalyzeError, GdAnalyzeWarning

SECONDS = 5.0
# Cases are a few kilobytes.
MEGABYTES = 1024
# Place and fact, what is expected, what to do; the longest advise how to rename all columns of a log.
MOST_LINES, WIDEST = 3, 1010

# Pages of memory that this process has; only Linux tells, and only there memory is bounded.
TAKEN = Path("/proc/self/statm")

SOURCE = "gd_analyze/"


class BrokenError(AssertionError):
    """The property does not hold; what happened, and the line of the package where, tell causes apart."""

    def __init__(self, kind: str, place: str, detail: str = "") -> None:
        super().__init__(f"{kind} at {place}: {detail[:2000]}")
        self.cause = (kind, place)
        self.detail = detail


class TooSlowError(BaseException):
    """Raised by the clock; no `except Exception` on the way can hold it up."""


def judge(path: Path, read: Callable[[Path], Any], use: Callable[[Any], None]) -> bool:
    """Hold the property against one file: whether it was read, or refused; a BrokenError if neither.

    `use` asserts on a value that was read, and may name a fault of the package by a `GdAnalyzeError`. Also
    broken: a warning that is not the package's own, a message that does not name the file or is no short
    plain text, time or memory that runs out.
    """
    with warnings.catch_warnings(record=True) as recorded:
        warnings.simplefilter("always")
        try:
            with bounded():
                was_read = _read_and_use(path, read, use)
        except BrokenError:
            raise
        except (Exception, TooSlowError) as error:
            raise BrokenError(type(error).__name__, place_of(error), str(error)) from error
    _require_own_warnings(recorded, path)
    return was_read


def _read_and_use(path: Path, read: Callable[[Path], Any], use: Callable[[Any], None]) -> bool:
    try:
        value = read(path)
    except GdAnalyzeError as error:
        if path.name not in str(error):
            raise BrokenError("message without the file", place_of(error), str(error)) from error
        require_presentable(str(error), path, place_of(error))
        return False
    try:
        use(value)
    except GdAnalyzeError as error:
        require_presentable(str(error), path, place_of(error))
    return True


def _require_own_warnings(recorded: list[warnings.WarningMessage], path: Path) -> None:
    texts = [str(warning.message) for warning in recorded]
    for warning, text in zip(recorded, texts, strict=True):
        place = f"{_short(warning.filename)}:{warning.lineno}"
        if not issubclass(warning.category, GdAnalyzeWarning):
            raise BrokenError(warning.category.__name__, place, text)
        require_presentable(text, path, place)
        if texts.count(text) > 1:
            raise BrokenError("a warning told twice", place, text)


def require_presentable(text: str, path: Path, place: str) -> None:
    """Require few lines of bounded width, in which nothing can steer a terminal or hide."""
    lines = text.replace(str(path), path.name).split("\n")
    if len(lines) > MOST_LINES:
        raise BrokenError("message of many lines", place, text)
    if max(map(len, lines)) > WIDEST:
        raise BrokenError("wide message", place, text)
    for letter in text.replace("\n", ""):
        if unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Zl", "Zp"):
            raise BrokenError("message with a letter that is not seen", place, repr(text))


def place_of(error: BaseException) -> str:
    """Innermost line of the package that an exception passed, or of the tests where it passed none."""
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return "nowhere"
    of_package = [frame for frame in frames if SOURCE in frame.filename]
    innermost = (of_package or frames)[-1]
    return f"{_short(innermost.filename)}:{innermost.lineno}"


def _short(filename: str) -> str:
    return filename.rpartition(SOURCE)[2] if SOURCE in filename else Path(filename).name


@contextmanager
def bounded(seconds: float = SECONDS, megabytes: int = MEGABYTES) -> Iterator[None]:
    """Let what is inside take so much of the processor's time, and so much more memory than there is now.

    The clock goes on ticking, as an exception that it raises inside a destructor would be lost.
    """

    def stop(*_: object) -> None:
        raise TooSlowError(f"more than {seconds} s")

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    if TAKEN.exists():
        pages = int(TAKEN.read_text().split()[0])
        resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + megabytes * 2**20, hard))
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds, 1.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
