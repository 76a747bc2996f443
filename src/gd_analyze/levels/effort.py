"""How much time goes into writing a program."""

from __future__ import annotations

from typing import NamedTuple


class Effort(NamedTuple):
    """How much time goes into a program of few operations.

    Parameters
    ----------
    shared
        Number of torque terms up to which what the rows share is looked for.
    thorough
        Whether that is rearranged, too, and other ways are tried: about a second.
    alone
        Whether, where it is looked for, no other way is held against it.
    """

    shared: int
    thorough: bool = False
    alone: bool = False


# Milliseconds; hundredths of a second, many times in a search; tenths; for good.
ROUGH = Effort(0)
COUNTING = Effort(80, alone=True)
QUICK = Effort(250)
THOROUGH = Effort(600, thorough=True)
