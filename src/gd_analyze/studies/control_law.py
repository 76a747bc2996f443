"""Control laws: settings, gains, tolerance, and the torque that every controller asks for.

All laws are u = M (K_d e' + K_p e) + b, with the error e = q_d - q of positions:

- computed torque ([FGL87] section 5.3): M is the model's D, and b its torque D a + h + c for the desired
  acceleration a, or the part that the controller knows;
- the same with fixed gains: M is a constant for each joint;
- PD with gravity compensation: M is that constant, and b the model's c.

The constant is the mean of D's diagonal along the motion. It replaces D where a controller of computed torque
knows none.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import Batch, Program
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, UNSIGNED

CONTINUOUS = math.inf
"""The rate of a loop without a sample period."""

_MOST = 8

_UNITS = {
    "deg": ("revolute", math.pi / 180),
    "mrad": ("revolute", 1e-3),
    "rad": ("revolute", 1.0),
    "mm": ("prismatic", 1e-3),
    "m": ("prismatic", 1.0),
}

Law = Literal["computed_torque", "fixed_gains", "pd"]
Knows = Literal["nothing", "gravity", "without_h", "simplified", "exact"]


@dataclass(frozen=True)
class Gains:
    """Gains of every joint's error, and the error that they allow.

    The error obeys e'' + 2 zeta w e' + w^2 e = a, with a the acceleration that the controller did not
    expect. Its impulse response is g(t) = exp(-zeta w t) sin(w_d t) / w_d with w_d = w sqrt(1 - zeta^2), so
    that from rest abs(e) <= sup abs(a) * integral of abs(g), and some a reaches it.

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

        1 / w^2 without overshoot (zeta >= 1), as g then has one sign and its integral is that of the
        stationary error; else coth(pi zeta / (2 sqrt(1 - zeta^2))) times that, half waves of alternating
        sign being summed as a geometric series.
        """
        if self.damping >= 1.0:
            return 1.0 / self.stiffness
        half_wave = math.pi * self.damping / math.sqrt(1.0 - self.damping**2)
        return 1.0 / (math.tanh(0.5 * half_wave) * self.stiffness)

    @property
    def velocity_per_acceleration(self) -> float:
        """Integral of abs(dg/dt), s: the most velocity error per unexpected acceleration.

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
        """Most error of position, velocity and acceleration per unexpected acceleration, s^2, s and 1."""
        error, velocity = self.error_per_acceleration, self.velocity_per_acceleration
        return error, velocity, 1.0 + self.damper * velocity + self.stiffness * error


@dataclass(frozen=True)
class Tolerance:
    """Largest tracking error that counts as good, of revolute joints, rad, and prismatic ones, m."""

    revolute: float = math.radians(0.1)
    prismatic: float = 1e-3

    def __post_init__(self) -> None:
        for value in (self.revolute, self.prismatic):
            if not 0.0 < value <= LARGEST:
                raise UsageError(
                    "no error is within this tolerance",
                    where="tolerance",
                    expected="a positive angle or length",
                    found=f"{value:g}",
                )

    @classmethod
    def parse(cls, text: str) -> Tolerance:
        """Read "0.1deg,1mm", or one of these; the other keeps its default.

        Raises
        ------
        UsageError
            If an entry is not understood or is given twice.

        Examples
        --------
        >>> Tolerance.parse("2mrad").revolute
        0.002
        """
        given: dict[str, float] = {}
        for place, entry in enumerate(text.split(","), start=1):
            match = re.fullmatch(rf"({UNSIGNED}) ?(deg|mrad|rad|mm|m)", entry.strip())
            name, worth = _UNITS[match[2]] if match else ("", 0.0)
            if match is None or name in given:
                raise UsageError(
                    "the tolerance is given twice" if match else "the tolerance is not understood",
                    where=f"--within, entry {place}",
                    expected="an angle such as 0.1deg or 2mrad, a length such as 1mm, or both with a comma",
                    found=repr(entry.strip()),
                )
            given[name] = float(match[1]) * worth
        return cls(**given)

    def of(self, arm: RobotArm) -> FloatArray:
        """Tolerance of every joint, rad (m), shape (n,)."""
        return np.where(np.array(arm.is_revolute), self.revolute, self.prismatic)

    def in_words(self, arm: RobotArm) -> str:
        """Write it, for the kinds of joints that an arm has."""
        kinds = {
            "revolute": f"{math.degrees(self.revolute):.4g}°",
            "prismatic": f"{1e3 * self.prismatic:.4g} mm",
        }
        there = {joint.kind for joint in arm.joints}
        return " or ".join(words for kind, words in kinds.items() if kind in there)


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
            f"the setting {name} is out of range",
            where=name,
            expected=f"{low:g} to {high:g} {unit}".rstrip(),
            found=f"{value:g}",
        )


class Controller(NamedTuple):
    """A law and what it knows of the arm."""

    law: Law
    knows: Knows

    @property
    def title(self) -> str:
        """Name it: computed torque by what it knows, PD as such."""
        if self.law == "computed_torque":
            words = {"gravity": "gravity only", "without_h": "without h", "nothing": "nothing"}
            return words.get(self.knows, f"{self.knows} model")
        if self.law == "fixed_gains":
            return f"{self.knows}, fixed gains"
        of = {"nothing": "alone", "gravity": "exact c", "simplified": "simplified c"}
        return f"PD, {of[self.knows]}"

    @property
    def knows_inertia(self) -> bool:
        """Whether its torque for the wanted acceleration is a model's."""
        return self.law != "pd" and self.knows in ("without_h", "simplified", "exact")

    @property
    def multiplies(self) -> bool:
        """Whether its M is a model's D."""
        return self.law == "computed_torque" and self.knows_inertia

    @property
    def knows_velocities(self) -> bool:
        """Whether it compensates h."""
        return self.law != "pd" and self.knows in ("simplified", "exact")


# PD with the exact model, or with that without h, is PD with the exact gravity.
CONTROLLERS = (
    Controller("computed_torque", "exact"),
    Controller("computed_torque", "simplified"),
    Controller("fixed_gains", "simplified"),
    Controller("computed_torque", "without_h"),
    Controller("computed_torque", "gravity"),
    Controller("computed_torque", "nothing"),
    Controller("pd", "gravity"),
    Controller("pd", "simplified"),
    Controller("pd", "nothing"),
)


@dataclass(frozen=True, eq=False)
class Knowledge:
    """The models that controllers may use: torque programs, and the mean of D's diagonal along the motion."""

    exact: Program
    simplified: Program
    diagonal: FloatArray


class _Model:
    """One model's torque for those of several controllers that use it."""

    def __init__(self, program: Program, controllers: Sequence[Controller], n: int, simplified: bool) -> None:
        uses = [(c.knows == "simplified") == simplified and c.knows != "nothing" for c in controllers]
        self.chosen = np.flatnonzero(uses)
        chosen = [controller for controller, is_used in zip(controllers, uses, strict=True) if is_used]
        if not chosen:
            return
        self._batch = Batch(program, len(chosen))
        factors = {
            "q": np.ones(len(chosen)),
            "qd": np.array([float(c.knows_velocities) for c in chosen]),
            "qdd": np.array([float(c.knows_inertia) for c in chosen]),
        }
        self._rows = [(self._batch.rows(name, n), factor) for name, factor in factors.items()]

    def add(self, torque: FloatArray, *state: FloatArray) -> None:
        """Add what it makes of states and wanted accelerations, shape (n, controllers)."""
        if not len(self.chosen):
            return
        for (rows, factor), values in zip(self._rows, state, strict=True):
            for i, row in rows:
                np.multiply(values[i, self.chosen], factor, out=row)
        torque[:, self.chosen] += self._batch.run()


class Bank:
    """Several controllers, m, at work at the same time."""

    def __init__(self, controllers: Sequence[Controller], knowledge: Knowledge, gains: Gains) -> None:
        n = len(knowledge.diagonal)
        self._gains = gains
        self._diagonal = knowledge.diagonal[:, None]
        # Of the wanted acceleration and of the feedback what is multiplied by the constants, and what by D.
        self._constant = [
            np.array([float(c.law == "computed_torque" and not c.knows_inertia) for c in controllers]),
            np.array([float(not c.multiplies) for c in controllers]),
        ]
        self._by_model = np.array([float(c.multiplies) for c in controllers])
        self._models = [
            _Model(program, controllers, n, simplified)
            for program, simplified in ((knowledge.exact, False), (knowledge.simplified, True))
        ]

    def torque(self, q: FloatArray, qd: FloatArray, wanted: Sequence[FloatArray]) -> FloatArray:
        """Torque asked for, N m (N), shape (n, m), at states and wanted q, qd and qdd, all of that shape."""
        gains, (q_d, qd_d, qdd_d) = self._gains, wanted
        feedback = gains.damper * (qd_d - qd) + gains.stiffness * (q_d - q)
        forward, back = self._constant
        torque = self._diagonal * (forward * qdd_d + back * feedback)
        acceleration = qdd_d + self._by_model * feedback
        for model in self._models:
            model.add(torque, q, qd, acceleration)
        return torque
