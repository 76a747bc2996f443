"""How much time goes into writing a program, and how much a search may do."""

from __future__ import annotations

from typing import Any, NamedTuple


class Effort(NamedTuple):
    """How much time goes into a program of few operations.

    Up to `shared` torque terms it is looked for what rows share. `rearranging` times the operations there are
    is how many rearrangements are tried; with none at all, other ways are not tried either.
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


# About a minute on one core of a machine of 2025: a billion a second.
USUAL = 60e9
# Of a linear program: multiplications per iteration and coefficient, by what both took on such a machine.
_SIMPLEX = 3.0


class Work:
    """What is left of an effort, a share of the usual one."""

    def __init__(self, effort: float = 1.0) -> None:
        self.effort, self.spent = effort * USUAL, 0.0
        self.was_short = False

    def affords(self, amount: float) -> bool:
        """Whether so much is left; noted where not, as a better result may then have been missed."""
        enough = self.spent + amount <= self.effort
        self.was_short |= not enough
        return enough

    def spend(self, amount: float) -> None:
        """Note what was done."""
        self.spent += amount

    def solve(self, solver: Any) -> bool:
        """Run a linear program as far as the effort goes; whether it came to an end of its own."""
        import highspy

        left = self.effort - self.spent
        coefficients = _SIMPLEX * max(solver.getNumNz(), 1)
        if not self.affords(coefficients):
            return False
        solver.setOptionValue("simplex_iteration_limit", int(min(left / coefficients, 2**31 - 1)))
        solver.run()
        self.spend(coefficients * (1 + max(solver.getInfo().simplex_iteration_count, 0)))
        if solver.getModelStatus() == highspy.HighsModelStatus.kIterationLimit:
            self.was_short = True
            return False
        return True
