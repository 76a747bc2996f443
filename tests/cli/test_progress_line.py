"""The line that shows progress says how long it will take yet, where that is known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gd_analyze.cli.terminal import left_column


@pytest.mark.parametrize(
    ("task", "said"),
    [
        ({"total": 10, "time_remaining": 75.4, "finished": False}, "0:01:15 left"),
        ({"total": 10, "time_remaining": None, "finished": False}, ""),
        ({"total": None, "time_remaining": None, "finished": False}, ""),
        ({"total": 10, "time_remaining": 0.0, "finished": True}, ""),
    ],
)
def test_what_is_left(task: dict[str, Any], said: str) -> None:
    # What a task tells of itself, without the clock that a real one would run on.
    told: Any = SimpleNamespace(**task)
    assert left_column().render(told).plain == said
