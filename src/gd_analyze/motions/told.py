"""How a log was understood, in words: which columns are what, and which are left out and why."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from gd_analyze.motions.logged import ColumnUse

_COUNTED = re.compile(r"(.*?)([0-9]{1,6})(\D*)")


def unused_told(columns: Iterable[ColumnUse]) -> list[str]:
    """Say which columns are left out, a sentence per reason.

    Examples
    --------
    >>> unused_told([ColumnUse(f"Temp{i}", "unused", why="no motion") for i in (1, 2, 3)])
    ['no motion: Temp1 .. Temp3']
    """
    by_reason: dict[str, list[str]] = {}
    for use in columns:
        if use.role == "unused":
            by_reason.setdefault(use.why, []).append(use.column)
    return [f"{why}: {', '.join(runs(names))}" for why, names in by_reason.items()]


def reasons_told(columns: Iterable[ColumnUse]) -> list[str]:
    """Say by what the columns that are used were understood, a sentence per reason."""
    by_reason: dict[str, list[str]] = {}
    for use in columns:
        if use.role != "unused" and use.role not in by_reason.setdefault(use.why, []):
            by_reason[use.why].append(use.role)
    return [f"{', '.join(roles)}: {why}" for why, roles in by_reason.items()]


def runs(names: Sequence[str]) -> list[str]:
    """Names with those that count on drawn together.

    Examples
    --------
    >>> runs(["Cur1", "Cur2", "Cur3", "mode"])
    ['Cur1 .. Cur3', 'mode']
    """
    drawn: list[list[str]] = []
    for name in names:
        if drawn and _follows(drawn[-1][-1], name):
            drawn[-1].append(name)
        else:
            drawn.append([name])
    return [run[0] if len(run) == 1 else f"{run[0]} .. {run[-1]}" for run in drawn]


def _follows(before: str, name: str) -> bool:
    first, second = _COUNTED.fullmatch(before), _COUNTED.fullmatch(name)
    if first is None or second is None:
        return False
    return (first[1], first[3]) == (second[1], second[3]) and int(second[2]) == int(first[2]) + 1
