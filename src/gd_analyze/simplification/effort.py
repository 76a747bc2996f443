"""How much time goes into writing a program."""

from __future__ import annotations

from typing import NamedTuple


class Effort(NamedTuple):
    """How much time goes into a program of few operations.

    Parameters
    ----------
    shared
        Number of torque terms up to which what the rows share is looked for.
    rearranging
        Rearrangements of that to try, times the operations there are, as those of a long program take longer;
        with none at all, other ways are not tried either.
    """

    shared: int
    rearranging: int = 0


# Milliseconds, and hundredths of a second, within a search.
ROUGH = Effort(0)
COUNTING = Effort(80)
# Hundredths of a second for each of the models that are only looked at, as points of a curve, and some
# tenths for one that is given: 3 % fewer operations.
POINT = Effort(600, 2_000)
THOROUGH = Effort(600, 30_000)
