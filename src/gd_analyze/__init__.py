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
from typing import Any

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Import the public names when the first is used, so that the command line answers at once."""
    if name == "__all__":
        return __dir__()
    if not name.startswith("_"):
        public = importlib.import_module("gd_analyze.public")
        if hasattr(public, name):
            return getattr(public, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    public = importlib.import_module("gd_analyze.public")
    return sorted(["__version__", *(name for name in vars(public) if not name.startswith("_"))])
