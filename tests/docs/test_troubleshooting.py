"""The messages of docs/troubleshooting.md are still told."""

from __future__ import annotations

import pytest
from markdown_pages import ROOT, code, tables

ROWS = tables(ROOT / "docs" / "troubleshooting.md", "Troubleshooting")
SOURCE = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.py"))


@pytest.mark.parametrize("message", [code(row["message"]) for row in ROWS])
def test_the_message_is_told(message: str) -> None:
    assert message in SOURCE
