"""Gains by bandwidth and damping, and how far an error of them can be driven.

Each joint's error obeys e'' + 2 zeta w e' + w^2 e = a for whatever acceleration a the controller did not
expect. Its impulse response is g(t) = exp(-zeta w t) sin(w_d t) / w_d with w_d = w sqrt(1 - zeta^2), so that
from rest abs(e) <= sup abs(a) * integral of abs(g), and some a reaches it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Gains:
    """Gains of every joint's error.

    Parameters
    ----------
    bandwidth
        Natural frequency w, rad/s.
    damping
        zeta; 1 is critical.
    """

    bandwidth: float
    damping: float

    @property
    def stiffness(self) -> float:
        """K_p = w^2, 1/s^2: times an inertia, N m per rad."""
        return self.bandwidth**2

    @property
    def damper(self) -> float:
        """K_d = 2 zeta w, 1/s."""
        return 2.0 * self.damping * self.bandwidth

    @property
    def error_per_acceleration(self) -> float:
        """Integral of abs(g) over all time, s^2: the most error per unexpected acceleration.

        1 / w^2 where nothing swings (zeta >= 1), as g then has one sign and its integral is that of the
        stationary error; else coth(pi zeta / (2 sqrt(1 - zeta^2))) times that, half waves of alternating
        sign being summed as a geometric series.
        """
        if self.damping >= 1.0:
            return 1.0 / self.stiffness
        half_wave = math.pi * self.damping / math.sqrt(1.0 - self.damping**2)
        return 1.0 / (math.tanh(0.5 * half_wave) * self.stiffness)

    @property
    def rate_per_acceleration(self) -> float:
        """Integral of abs(dg/dt), s: the most error of rate per unexpected acceleration.

        It is how far g goes up and down: twice its peak, and twice those of all half waves that follow.
        """
        w, zeta = self.bandwidth, self.damping
        if zeta == 1.0:
            return 2.0 / (math.e * w)
        if zeta > 1.0:
            root = math.sqrt(zeta**2 - 1.0)
            fast, slow = w * (zeta + root), w * (zeta - root)
            when = math.log(fast / slow) / (fast - slow)
            return 2.0 * (math.exp(-slow * when) - math.exp(-fast * when)) / (fast - slow)
        a = zeta / math.sqrt(1.0 - zeta**2)
        return 2.0 * math.exp(-a * math.acos(zeta)) / (w * (1.0 - math.exp(-a * math.pi)))

    @property
    def margins(self) -> tuple[float, float, float]:
        """Most error of position, rate and acceleration per unexpected acceleration, s^2, s and 1."""
        error, rate = self.error_per_acceleration, self.rate_per_acceleration
        return error, rate, 1.0 + self.damper * rate + self.stiffness * error
