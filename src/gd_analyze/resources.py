"""Finds the data files: inside an installed wheel, or beside `src` in a checkout."""

from __future__ import annotations

from pathlib import Path


def data_folder(kind: str) -> Path:
    """Folder of the shipped "robots", "trajectories" or "references"."""
    package = Path(__file__).parent
    packaged = package / "data" / kind
    return packaged if packaged.is_dir() else package.parent.parent / "data" / kind


def shipped(kind: str, suffix: str) -> dict[str, Path]:
    """Shipped files of a kind by their stem, in alphabetical order."""
    return {path.stem: path for path in sorted(data_folder(kind).glob(f"*{suffix}"))}
