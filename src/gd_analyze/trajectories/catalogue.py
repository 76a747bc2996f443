"""The trajectories shipped with the package."""

from __future__ import annotations

from pathlib import Path

from gd_analyze.resources import shipped


def shipped_trajectories() -> dict[str, Path]:
    """Shipped trajectory files by name, in alphabetical order."""
    return shipped("trajectories", ".csv")
