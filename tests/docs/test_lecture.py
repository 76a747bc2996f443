"""The lecture runs, and prints what is stored in it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from markdown_pages import ROOT

pytest.importorskip("nbclient", reason="the lecture is executed by nbclient, of the extra dev")
pytest.importorskip("ipykernel", reason="the lecture is executed by ipykernel, of the extra dev")

import lecture

MOST_BYTES = 900_000


def texts(notebook: Any) -> list[tuple[str, list[str]]]:
    """Source and texts of every cell of code: printed, warned, equations and tables, but no figures."""
    found = []
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        # A stream may come in pieces.
        printed = [
            f"{output.name}: {output.text}" for output in cell.outputs if output.output_type == "stream"
        ]
        shown = ["".join(printed).replace("stdout: ", "")]
        for output in cell.outputs:
            data = output.get("data", {})
            if data and "image/png" not in data:
                shown.append(data.get("text/latex", data.get("text/plain", "")))
        found.append((cell.source, shown))
    return found


@pytest.mark.slow
def test_it_prints_what_is_stored(tmp_path: Path) -> None:
    for old, new in zip(texts(lecture.stored()), texts(lecture.executed(tmp_path)), strict=True):
        assert new == old, "run `python tests/docs/lecture.py` if the new output is right"


def test_what_is_stored_is_clean() -> None:
    notebook = lecture.stored()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert outputs
    for output in outputs:
        assert output.output_type in ("stream", "display_data", "execute_result")
        assert output.get("name") != "stderr", output.text
    page = lecture.PAGE.read_text(encoding="utf-8")
    assert len(page.encode()) <= MOST_BYTES
    assert str(Path.home()) not in page
    assert "site-packages" not in page


def test_it_is_told_of() -> None:
    for page in ("README.md", "docs/python.md"):
        assert "tutorials/lecture.ipynb" in (ROOT / page).read_text(encoding="utf-8")
