"""Time to spend on writing a program of few operations."""

from __future__ import annotations

from typing import NamedTuple


class Effort(NamedTuple):
    """Time to spend on a program of few operations."""

    shared: int  # most torque terms for which common parts of rows are searched
    rearranging: int = 0  # rearrangements tried, times the operations; 0 disables other forms, too


# Milliseconds, within a search.
ROUGH: Effort = Effort(0)
# Hundredths of a second, within a search.
COUNTING: Effort = Effort(80)
# Hundredths of a second, for intermediate models, such as the points of a curve.
POINT: Effort = Effort(600)
# Some tenths of a second, for a result: 3 to 6 % fewer operations.
THOROUGH: Effort = Effort(600, 15_000)


# Most terms of D, h and c that a person reads; of more, a program is not searched for shared parts.
READABLE = 250


def effort_for(terms: int) -> Effort:
    """Effort worth spending on a program of this many terms."""
    return POINT if terms <= READABLE else ROUGH
