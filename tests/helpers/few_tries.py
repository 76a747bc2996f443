"""Programs of drawn arms with hardly any rearranging: as right as others, and written much sooner."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from gd_analyze.cache import without_cache
from gd_analyze.operations import sharing
from gd_analyze.simplification.kept_program import kept_programs
from gd_analyze.simplification.torque_program import _program_of_terms

# Of 400.
_TRIES = 10


@contextmanager
def few_tries() -> Iterator[None]:
    """Decorate tests of drawn arms that are about what is kept and promised, not how it is written.

    Most of the time of such a test would go into the last percents of operations. That rearranging keeps
    torques and saves operations is tested with the operations, and of exact programs with the levels.
    """
    with pytest.MonkeyPatch.context() as patch, without_cache():
        patch.setattr(sharing, "MOST_TRIES_OF_PROGRAM", _TRIES)
        forget()
        yield
    forget()


def forget() -> None:
    """Let every program be written again."""
    kept_programs.cache_clear()
    _program_of_terms.cache_clear()
