"""Cases of a test that the long tests alone run, where one of a kind is enough otherwise."""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import Any

import pytest


def long(*values: Any) -> Any:
    """One case, run by `.ci/long`."""
    return pytest.param(*values, marks=pytest.mark.slow)


def long_but(quick: Container[Any], cases: Iterable[Any]) -> list[Any]:
    """All cases; `.ci/long` runs those that are not quick."""
    return [case if case in quick else long(case) for case in cases]
