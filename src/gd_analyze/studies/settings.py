"""What a study of control is asked for: gains, loop rates, speeds, limits and tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from gd_analyze.errors import UsageError
from gd_analyze.studies.gains import Gains
from gd_analyze.studies.tolerance import Tolerance

CONTINUOUS = math.inf
"""The rate of a loop without a sample period."""

_MOST = 8


@dataclass(frozen=True)
class ControlSettings:
    """How arms are controlled.

    Parameters
    ----------
    bandwidth, damping
        Natural frequency of every joint's error, rad/s, and its damping ratio.
    rates
        Of the control loop, Hz; torque is held over a period. `CONTINUOUS` holds nothing.
    speeds
        How many times as fast as planned the motion is run.
    limits
        Torque limits of the arm's drives are scaled by this; None leaves torque unlimited.
    friction
        Whether the drives' friction acts on the arm; no controller knows of it.
    tolerance
        Tracking error that counts as good.

    Raises
    ------
    UsageError
        If a number does not fit.
    """

    bandwidth: float = 20.0
    damping: float = 1.0
    rates: tuple[float, ...] = (CONTINUOUS, 500.0, 100.0)
    speeds: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0)
    limits: float | None = 1.0
    friction: bool = False
    tolerance: Tolerance = field(default_factory=Tolerance)

    def __post_init__(self) -> None:
        _require("bandwidth", self.bandwidth, 0.01, 1e4, "rad/s")
        _require("damping", self.damping, 0.05, 20.0, "")
        for name, values, low, high, unit in (
            ("rates", self.rates, 1.0, 1e5, "Hz"),
            ("speeds", self.speeds, 0.01, 100.0, "times the planned one"),
        ):
            if not 1 <= len(values) <= _MOST or len(set(values)) < len(values):
                raise UsageError(
                    f"these are no {name} to be compared",
                    where=name,
                    expected=f"1 to {_MOST} different ones",
                    found=", ".join(f"{value:g}" for value in values) or "none",
                )
            for value in values:
                if name != "rates" or value != CONTINUOUS:
                    _require(name, value, low, high, unit)
        for rate in self.rates:
            if rate < self.bandwidth:
                raise UsageError(
                    "the loop is too slow for its bandwidth: it cannot be stable",
                    where="rates",
                    expected=f"{self.bandwidth:g} Hz or more, a radian of the bandwidth per period",
                    found=f"{rate:g} Hz",
                    next_step="take a higher rate or a lower bandwidth",
                )
        if self.limits is not None:
            _require("limits", self.limits, 1e-3, 1e3, "times the arm's")

    @property
    def usual_rate(self) -> float:
        """The fastest loop rate that has a period, or none where no rate has one."""
        return max((rate for rate in self.rates if rate != CONTINUOUS), default=CONTINUOUS)

    @property
    def usual_speed(self) -> float:
        """The speed nearest to the planned one."""
        return min(self.speeds, key=lambda speed: abs(math.log(speed)))

    @property
    def gains(self) -> Gains:
        """The gains."""
        return Gains(self.bandwidth, self.damping)


def _require(name: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        raise UsageError(
            f"no control is made for this {name.removesuffix('s') if name != 'limits' else 'limit'}",
            where=name,
            expected=f"{low:g} to {high:g} {unit}".rstrip(),
            found=f"{value:g}",
        )
