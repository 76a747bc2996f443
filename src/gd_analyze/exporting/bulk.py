"""A function of many states at once: all angles first, then their sines and cosines, then the rest.

Each is a loop without a branch or a call, which is what compilers vectorise.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from gd_analyze.exporting.statements import Body, Statement


@dataclass(frozen=True)
class Bulk:
    """A function's inside in three parts.

    Parameters
    ----------
    before
        Steps that angles are made by.
    kept
        Those of them that are angles, or needed later.
    angles
        Names of what sine and cosine are taken of.
    after
        The other steps.
    needed
        What these and the results read.
    results
        Expressions of the torque.
    """

    before: tuple[Statement, ...]
    kept: tuple[str, ...]
    angles: tuple[str, ...]
    after: tuple[Statement, ...]
    needed: frozenset[str]
    results: tuple[str, ...]

    @property
    def needed_before(self) -> frozenset[str]:
        """What the steps before read."""
        return _words(*(step.value for step in self.before))


def in_bulk(whole: Body) -> Bulk:
    """Take a torque's statements apart."""
    angles = tuple(dict.fromkeys(step.angle for step in whole.statements if step.angle))
    wanted, before = set(angles), list[Statement]()
    for step in reversed(whole.statements):
        if step.name in wanted:
            wanted |= _words(step.value)
            before.insert(0, step)
    names = {step.name for step in before}
    after = tuple(step for step in whole.statements if not step.angle and step.name not in names)
    results = whole.results["tau"]
    needed = _words(*(step.value for step in after), *results)
    kept = tuple(step.name for step in before if step.name in needed.union(angles))
    return Bulk(tuple(before), kept, angles, after, needed, results)


def _words(*values: str) -> frozenset[str]:
    """Names in expressions."""
    return frozenset(word for value in values for word in re.findall(r"[a-z]\w*", value))
