"""Where a result comes from: versions, time and command, as flat strings."""

from __future__ import annotations

import datetime
import platform
from collections.abc import Sequence
from importlib.metadata import version as installed_version
from typing import Any

from gd_analyze import __version__
from gd_analyze.files import mark_of


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
    """The same with the mark of a run as "run": of one that `repeats`, time and command do not count."""
    source = provenance(command)
    passing = ("created", "command") if repeats else ()
    lasting = {key: value for key, value in source.items() if key not in passing}
    return source | {"run": mark_of(asked, [everything, lasting])}
