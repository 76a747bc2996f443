"""Libraries that only some logs need."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from gd_analyze.errors import Location, TrajectoryError


def required(module: str, library: str, path: str | Path) -> Any:
    """Import a module of the extra `logs`.

    Raises
    ------
    TrajectoryError
        If it is not installed; the message says how to.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise TrajectoryError(
            f"this log needs the library {library}",
            where=Location(path),
            expected=f"{library} beside gd-analyze",
            found="it is not installed",
            next_step=f"pip install {library}",
        ) from None
