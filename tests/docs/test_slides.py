"""One command makes the six slides of the lecture."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest
from markdown_pages import ROOT

PAGE = ROOT / "docs" / "lecture.md"


def size(path: Path) -> tuple[int, int]:
    """Width and height in pixels, from the head of a PNG."""
    head = path.read_bytes()[:24]
    assert head.startswith(b"\x89PNG\r\n\x1a\n")
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def test_the_page_shows_the_stored_slides() -> None:
    stored = sorted((ROOT / "docs" / "lecture").glob("*.png"))
    assert len(stored) == 6
    text = PAGE.read_text(encoding="utf-8")
    for path in stored:
        assert size(path) == (1600, 900)
        assert f"(lecture/{path.name})" in text


@pytest.mark.slow
def test_the_script_makes_them(tmp_path: Path) -> None:
    made = import_module("lecture_slides").write(tmp_path)
    stored = [path.name for path in sorted((ROOT / "docs" / "lecture").glob("*.png"))]
    assert [path.name for path in made] == stored
    assert {size(path) for path in made} == {(1600, 900)}
