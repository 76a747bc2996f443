"""What a reader of a PDF can copy from it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest


def read(pdf: bytes, folder: Path, *options: str) -> str:
    """What a reader can select and copy, without line ends."""
    program = shutil.which("pdftotext")
    if program is None:
        pytest.skip("pdftotext (poppler-utils) is not installed")
    path = folder / "report.pdf"
    path.write_bytes(pdf)
    done = subprocess.run([program, *options, str(path), "-"], capture_output=True, check=True, text=True)
    return " ".join(done.stdout.replace("\f", " \f ").split(" ")).replace("\n", " ")
