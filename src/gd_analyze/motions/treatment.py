"""How the readings of a measured motion are treated."""

from __future__ import annotations

from dataclasses import dataclass

from gd_analyze.errors import UsageError
from gd_analyze.text import LARGEST


@dataclass(frozen=True, kw_only=True)
class Treatment:
    """What a user decides about a log; by default rules decide, see docs/trajectories.md.

    Parameters
    ----------
    cutoff
        Cut-off frequency of the low-pass, Hz: one for all joints, or one each; None: by rule.
    largest_gap
        Longest time between two readings, s, across which a motion is taken to go on; None: by rule.
    use_rates
        Whether measured rates, where the log has them, may be what accelerations come from; by rule they are
        where they leave less noise than the positions.

    Raises
    ------
    UsageError
        If a number is not positive and finite.
    """

    cutoff: float | tuple[float, ...] | None = None
    largest_gap: float | None = None
    use_rates: bool = True

    def __post_init__(self) -> None:
        for name, given in (("cutoff", self.cutoff), ("largest_gap", self.largest_gap)):
            for value in () if given is None else given if isinstance(given, tuple) else (given,):
                if not 0.0 < value <= LARGEST:
                    raise UsageError(
                        f"{name} cannot be that",
                        where=f"Treatment, {name}",
                        expected="a number above 0, in Hz" if name == "cutoff" else "a number above 0, in s",
                        found=f"{value:g}",
                    )
