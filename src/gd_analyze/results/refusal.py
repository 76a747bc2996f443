"""How a results file is refused: one form, whoever finds out what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gd_analyze.errors import GdAnalyzeError, Location, StoreError


def refusal(path: str | Path, what: str, found: str) -> StoreError:
    """Error for a file that is not as we wrote it."""
    return StoreError(
        what,
        where=Location(path),
        expected="a file as gd-analyze wrote it, e.g. analysis.h5",
        found=found,
        next_step="take a copy that was not changed, or run the analysis again",
    )


@contextmanager
def damage_named(path: str | Path) -> Iterator[None]:
    """Turn whatever reading a damaged file raises, which has no common class, into an error of the file."""
    try:
        yield
    except Exception as error:
        if isinstance(error, StoreError) and "where" in error.details:
            raise
        found = error.what if isinstance(error, GdAnalyzeError) else str(error) or type(error).__name__
        raise refusal(path, "the results file is damaged", found.splitlines()[0]) from None
