"""Executes the lecture; as a script, stores its outputs."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import nbformat
from markdown_pages import ROOT
from nbclient import NotebookClient

PAGE = ROOT / "docs" / "tutorials" / "lecture.ipynb"


def stored() -> Any:
    """The notebook as it is in the repository."""
    return nbformat.read(PAGE, as_version=4)


def executed(folder: Path) -> Any:
    """The notebook with new outputs, run in a folder of its own."""
    notebook = stored()
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=300, record_timing=False, resources=resources).execute()
    notebook.metadata.language_info = {"name": "python"}  # without the version that ran it
    return notebook


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        nbformat.write(executed(Path(place)), PAGE)
