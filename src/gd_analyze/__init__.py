"""Split a robot arm's dynamics by effect, rank the parts, drop what the torque budget allows.

>>> import gd_analyze as gd
>>> arm = gd.load_arm("puma560")
>>> trajectory = gd.read_trajectory("pick-and-place", arm)
>>> dataset = gd.decompose(arm, trajectory)
>>> ranking = gd.rank(dataset)
>>> model = gd.simplify(arm, trajectory, "1%")
"""

from __future__ import annotations

import importlib
import re
from pathlib import Path

__version__ = "0.2.0"

# The stub lists what is public, with the module of each name.
_HOMES = {
    name: home
    for home, name in re.findall(
        r"^from (\S+) import (\w+)", Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"), re.M
    )
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> object:
    """Import a public name when it is first used, so that no command loads what it does not need."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
