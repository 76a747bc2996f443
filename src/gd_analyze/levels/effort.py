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
        Whether that is rearranged, too, and other ways are tried.
    """

    shared: int
    thorough: bool = False


# Milliseconds, and hundredths of a second, within a search; with the last all is written that is shown.
ROUGH = Effort(0)
COUNTING = Effort(80)
THOROUGH = Effort(600, thorough=True)
