"""Where a result comes from: versions, time and command, as flat strings."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Sequence
from importlib.metadata import version as installed_version
from typing import Any

from gd_analyze import __version__
from gd_analyze.files import mark_of

_PASSING = ("created", "command")


def provenance(command: str) -> dict[str, str]:
    """Flat description of where a result comes from, stored with it and shown in every report."""
    return {
        "gd_analyze": __version__,
        "created": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "command": command,
        "python": platform.python_version(),
        "numpy": installed_version("numpy"),
        "pinocchio": installed_version("pin"),
    }


def provenance_of_run(
    command: str, asked: Sequence[Any], everything: Any, *, repeats: bool
) -> dict[str, str]:
    """Describe a run that writes several files, and mark it: the mark is the entry "run".

    `repeats` says whether the same inputs give the same results, and so the same mark.
    """
    source = provenance(command)
    lasting = {key: value for key, value in source.items() if not repeats or key not in _PASSING}
    return source | {"run": mark_of(asked, [everything, lasting])}
