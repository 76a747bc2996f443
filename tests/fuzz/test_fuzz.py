"""Reading changed files: a sound value or a clear refusal, in a short run; `run.py` is the long one."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from changes import Plan
from fuzz_formats import FORMATS
from hypothesis import given

from strategies import examples


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    """A folder in memory where there is one."""
    memory = Path("/dev/shm")
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as name:
        yield Path(name)


def _held_against(plan: Plan, name: str, folder: Path) -> bool:
    path = folder / f"case.{name}"
    FORMATS[name].write(plan, path)
    return FORMATS[name].judged(path)


@pytest.mark.parametrize("name", FORMATS)
def test_what_is_not_changed_is_read(name, folder):
    for base in range(FORMATS[name].bases):
        assert _held_against(Plan(base, ()), name, folder)


@pytest.mark.hypothesis
@pytest.mark.parametrize("name", FORMATS)
def test_changed_files_are_read_soundly_or_refused(name, folder):
    @examples(400)
    @given(FORMATS[name].cases)
    def held(plan: Plan) -> None:
        _held_against(plan, name, folder)

    held()
