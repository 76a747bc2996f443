"""Split a robot arm's dynamics by effect, rank the parts, drop what the torque budget allows.

>>> import gd_analyze as gd
>>> arm = gd.load_arm("puma560")
>>> trajectory = gd.read_trajectory("pick-and-place", arm)
>>> dataset = gd.decompose(arm, trajectory)
>>> ranking = gd.rank(dataset)
>>> model = gd.simplify(arm, trajectory, "1%")
"""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
from typing import Any

# What is public stands in the stub beside this file, once: home and name there, name here.
_PUBLIC = {
    entry.asname or entry.name: (node.module or "", entry.name)
    for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    if isinstance(node, ast.ImportFrom)
    for entry in node.names
}

__all__ = list(_PUBLIC)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that the command line answers at once."""
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home, there = _PUBLIC[name]
    return getattr(importlib.import_module(home), there)


def __dir__() -> list[str]:
    return sorted(_PUBLIC)
