"""Reads what the tests need from the project's Markdown files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Block:
    """A fenced block; `line` counts from 1, `marked` is what the comment on the line before it says."""

    language: str
    text: str
    line: int
    marked: str = ""


def blocks(path: Path) -> Iterator[Block]:
    """All fenced blocks of a file, in order."""
    lines = path.read_text(encoding="utf-8").splitlines()
    start: int | None = None
    for k, line in enumerate(lines):
        if not line.startswith("```"):
            continue
        if start is None:
            start = k
            continue
        before = re.fullmatch(r"<!-- (.*) -->", lines[start - 1]) if start else None
        text = "\n".join(lines[start + 1 : k]) + "\n"
        yield Block(lines[start][3:].strip(), text, start + 1, before[1] if before else "")
        start = None
    assert start is None, f"{path}: the block of line {start} is not closed"


def tables(path: Path, heading: str) -> list[dict[str, str]]:
    """Rows of the table under a heading, by column."""
    _, found, rest = path.read_text(encoding="utf-8").partition(f"# {heading}\n")
    assert found, f"{path} has no heading {heading!r}"
    section = re.split(r"^#", rest, maxsplit=1, flags=re.MULTILINE)[0]
    rows = [
        [cell.strip() for cell in line.strip().strip("|").split("|")]
        for line in section.splitlines()
        if line.startswith("|")
    ]
    header, _, *body = rows
    return [dict(zip(header, row, strict=True)) for row in body]


def code(cell: str) -> str:
    """What stands between the backquotes of a cell."""
    match = re.fullmatch(r"`([^`]+)`", cell)
    assert match, f"{cell!r} is not one code name"
    return match[1]
