"""Control laws: settings, gains, tolerance, the desired motion, and the torque of every controller.

All laws are u = M (K_d e' + K_p e) + b, with the error e = q_d - q of positions:

- computed torque ([FGL87] section 5.3): M is the model's D, and b its torque D a + h + c for the desired
  acceleration a, or that without h;
- the same with fixed gains: M is a constant for each joint;
- PD with gravity compensation: M is that constant, and b the model's c.

The constant is the mean of D's diagonal along the motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from gd_analyze.arguments import require_flags_of
from gd_analyze.arrays import FloatArray
from gd_analyze.certification.between import Between
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import Batch, Program
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.text import LARGEST
from gd_analyze.units import Quantity

CONTINUOUS = math.inf
"""The rate of a loop without a sample period."""

_MOST_COMPARED = 8  # rates, and speeds, in one study
_SAMPLED_INSTANTS = 500  # evenly spaced, of a whole motion
_TOLERANCE_FIELDS = {"angle": "revolute", "length": "prismatic"}  # by the kind of quantity


@dataclass(frozen=True)
class Gains:
    """Gains of every joint's error, and the resulting bound on the error.

    The error obeys e'' + 2 zeta w e' + w^2 e = a, where a is the acceleration that the controller did not
    expect. Its impulse response is g(t) = exp(-zeta w t) sin(w_d t) / w_d with w_d = w sqrt(1 - zeta^2), so
    that from rest abs(e) <= sup abs(a) * integral of abs(g), and some a reaches it.
    """

    bandwidth: float  # natural frequency w, rad/s
    damping: float  # zeta; 1 is critical

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
        """Integral of abs(g) over all time, s^2: the largest error per unexpected acceleration.

        1 / w^2 where g has one sign (zeta >= 1); otherwise half waves add a geometric series.
        """
        if self.damping >= 1.0:
            return 1.0 / self.stiffness
        half_wave = math.pi * self.damping / math.sqrt(1.0 - self.damping**2)
        return 1.0 / (math.tanh(0.5 * half_wave) * self.stiffness)

    @property
    def velocity_per_acceleration(self) -> float:
        """Integral of abs(dg/dt), s: the largest velocity error per unexpected acceleration.

        The total variation of g: twice its peak, plus twice the peaks of all half waves that follow.
        """
        w, zeta = self.bandwidth, self.damping
        if zeta == 1.0:
            return 2.0 / (math.e * w)
        if zeta > 1.0:
            root = math.sqrt(zeta**2 - 1.0)
            fast, slow = w * (zeta + root), w * (zeta - root)
            peak_time = math.log(fast / slow) / (fast - slow)
            return 2.0 * (math.exp(-slow * peak_time) - math.exp(-fast * peak_time)) / (fast - slow)
        a = zeta / math.sqrt(1.0 - zeta**2)
        return 2.0 * math.exp(-a * math.acos(zeta)) / (w * (1.0 - math.exp(-a * math.pi)))

    @property
    def margins(self) -> FloatArray:
        """Largest error of position, velocity and acceleration per unexpected acceleration: s^2, s and 1."""
        error, velocity = self.error_per_acceleration, self.velocity_per_acceleration
        return np.array([error, velocity, 1.0 + self.damper * velocity + self.stiffness * error])


@dataclass(frozen=True)
class Tolerance:
    """Acceptable tracking error: of revolute joints, rad, and of prismatic joints, m.

    Raises
    ------
    UsageError
        If an error is not positive.
    """

    revolute: float = math.radians(0.1)
    prismatic: float = 1e-3
    # Kinds of joints for which a text states it, and the option of that text, for messages
    stated: tuple[str, ...] = field(default=(), compare=False, repr=False)
    where: str = field(default="--within", compare=False, repr=False)

    def __post_init__(self) -> None:
        for value in (self.revolute, self.prismatic):
            if not 0.0 < value <= LARGEST:
                message, expected = "the tolerance is out of range", f"above 0, up to {LARGEST:g}"
                where = self.where if self.stated else "tolerance"
                raise UsageError(message, where=where, expected=expected, found=f"{value:g}")

    @classmethod
    def parse(cls, text: str, where: str = "--within") -> Tolerance:
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
        errors: dict[str, float] = {}
        for place, entry in enumerate(text.split(","), start=1):
            quantity = Quantity.parse(entry)
            name = None if quantity is None else _TOLERANCE_FIELDS.get(quantity.kind)
            if quantity is None or name is None or quantity.si < 0.0 or name in errors:
                raise UsageError(
                    "the tolerance is given twice" if name in errors else "the tolerance is not understood",
                    where=f"{where}, entry {place}",
                    expected="an angle such as 0.1deg or 2mrad, a length such as 1mm, or both with a comma",
                    found=repr(entry.strip()),
                )
            errors[name] = quantity.si
        return cls(**errors, stated=tuple(errors), where=where)

    def require_joint_of(self, arm: RobotArm) -> None:
        """Raise a UsageError if an arm has no joint of a kind for which the tolerance is stated."""
        if self.stated and set(self.stated).isdisjoint(joint.kind for joint in arm.joints):
            kind, motion = ("a length", "turns") if "prismatic" in self.stated else ("an angle", "slides")
            example = "0.1deg" if motion == "turns" else "1mm"
            raise UsageError(
                "the tolerance applies to no joint",
                where=self.where,
                expected=f"such as {example}: every joint {motion}",
                found=kind,
            )

    def of(self, arm: RobotArm) -> FloatArray:
        """Tolerance of every joint, rad (m), shape (n,)."""
        return np.where(np.array(arm.is_revolute), self.revolute, self.prismatic)

    def in_words(self, arm: RobotArm) -> str:
        """Write it, for the kinds of joints that an arm has."""
        angle, length = f"{math.degrees(self.revolute):.4g}°", f"{1e3 * self.prismatic:.4g} mm"
        return " or ".join(text for text in (angle, length) if (text == angle) in arm.is_revolute)


@dataclass(frozen=True)
class ControlSettings:
    """Settings of a control study.

    Parameters
    ----------
    bandwidth, damping
        Natural frequency of every joint's error, rad/s, and its damping ratio.
    rates
        Loop rates, Hz; torque is held over a period. `CONTINUOUS` is a loop without sampling.
    speeds
        Speeds of the motion, as multiples of the planned one.
    limits
        Torque limits as a multiple of the drives' limits; None leaves torque unlimited.
    friction
        Whether the drives' friction acts on the arm; no controller knows it.
    tolerance
        Acceptable tracking error.

    Raises
    ------
    UsageError
        If a number is out of range, or the lowest rate is unstable for the bandwidth.
    """

    bandwidth: float = 20.0
    damping: float = 1.0
    rates: tuple[float, ...] = (CONTINUOUS, 500.0, 100.0)
    speeds: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0)
    limits: float | None = 1.0
    friction: bool = False
    tolerance: Tolerance = field(default_factory=Tolerance)

    def __post_init__(self) -> None:
        require_flags_of(self)
        periodic = [rate for rate in self.rates if rate != CONTINUOUS]
        for name, values, low, high, unit in (
            ("bandwidth", [self.bandwidth], 0.01, 1e4, "rad/s"),
            ("damping", [self.damping], 0.05, 20.0, ""),
            ("rates", periodic, 1.0, 1e5, "Hz"),
            ("speeds", self.speeds, 0.01, 100.0, "times the planned one"),
            ("limits", [] if self.limits is None else [self.limits], 1e-3, 1e3, "times the arm's"),
        ):
            for value in values:
                if not low <= value <= high:
                    message, expected = f"the setting {name} is out of range", f"{low:g} to {high:g} {unit}"
                    raise UsageError(message, where=name, expected=expected.rstrip(), found=f"{value:g}")
        for name, values in (("rates", self.rates), ("speeds", self.speeds)):
            if not 1 <= len(values) <= _MOST_COMPARED or len(set(values)) < len(values):
                message = f"wrong number of {name} to compare"
                expected = f"1 to {_MOST_COMPARED} different ones"
                numbers = ", ".join(f"{value:g}" for value in values) or "none"
                raise UsageError(message, where=name, expected=expected, found=numbers)
        if min(self.rates) < self.bandwidth:
            raise UsageError(
                "the loop is too slow for its bandwidth: it cannot be stable",
                where="rates",
                expected=f"{self.bandwidth:g} Hz or more, a radian of the bandwidth per period",
                found=f"{min(self.rates):g} Hz",
                next_step="take a higher rate or a lower bandwidth",
            )

    @property
    def usual_rate(self) -> float:
        """The highest finite loop rate, or `CONTINUOUS` if there is none."""
        return max((rate for rate in self.rates if rate != CONTINUOUS), default=CONTINUOUS)

    @property
    def usual_speed(self) -> float:
        """The speed nearest to the planned one."""
        return min(self.speeds, key=lambda speed: abs(math.log(speed)))

    @property
    def gains(self) -> Gains:
        """The gains."""
        return Gains(self.bandwidth, self.damping)


class Controller(NamedTuple):
    """A control law, what it knows of the arm, and its name in tables."""

    law: Literal["computed_torque", "fixed_gains", "pd"]
    knows: Literal["without_h", "simplified", "exact"]
    title: str


EXACT = Controller("computed_torque", "exact", "exact model")
SIMPLIFIED = Controller("computed_torque", "simplified", "simplified model")
FIXED_GAINS = Controller("fixed_gains", "simplified", "simplified, fixed gains")
WITHOUT_H = Controller("computed_torque", "without_h", "without h")
PD = Controller("pd", "simplified", "PD, simplified c")
CONTROLLERS = (EXACT, SIMPLIFIED, FIXED_GAINS, WITHOUT_H, PD)


@dataclass(frozen=True, eq=False)
class Reference:
    """Polynomials of fifth degree through q, qd and qdd of set points: twice differentiable."""

    time: FloatArray  # of the set points, s, from 0, (N,)
    coefficients: FloatArray  # of powers of the share of an interval, (N - 1, 6, n)

    @classmethod
    def of(cls, motion: Trajectory) -> Reference:
        """Fit the polynomials to a trajectory that can be tracked, see `control.followable`."""
        between = Between.of(motion, np.zeros((2, motion.n_joints)), slice(None))
        return cls(motion.time - motion.time[0], between.coefficients[:, :, 0, 0])

    @property
    def duration(self) -> float:
        """How long it lasts as planned, s."""
        return float(self.time[-1])

    def at(self, time: FloatArray, speed: FloatArray | float = 1.0) -> tuple[FloatArray, ...]:
        """Return q, qd and qdd, shape (n, ...), at instants, s, of the motion run at a speed."""
        planned = np.clip(time * speed, 0.0, self.duration)
        k = np.clip(np.searchsorted(self.time, planned, side="right") - 1, 0, len(self.coefficients) - 1)
        width = np.diff(self.time)[k]
        s = (planned - self.time[k]) / width
        c = np.moveaxis(self.coefficients[k], (-2, -1), (0, 1))
        derivatives = [polyval(s, polyder(c, order), tensor=False) for order in range(3)]
        return tuple(x * (speed / width) ** order for order, x in enumerate(derivatives))

    @property
    def instants(self) -> FloatArray:
        """Evenly spaced instants, s, of the motion as planned."""
        return np.linspace(0.0, self.duration, _SAMPLED_INSTANTS)

    def sampled(self, speed: float = 1.0) -> tuple[FloatArray, ...]:
        """Return q, qd and qdd, shape (n, K), at evenly spaced instants and all set points."""
        instants = np.unique(np.concatenate([self.instants, self.time]))
        return self.at(instants / speed, speed)


@dataclass(frozen=True, eq=False)
class World:
    """Inputs that all loops share: the arm that moves, the controllers' models, gains, motion and limits."""

    plant: ExactForm
    exact: Program  # exact torque as controllers know it, without a payload
    simplified: Program
    diagonal: FloatArray  # mean of D's along the motion, kg m^2 (kg), (n,)
    gains: Gains
    reference: Reference
    limits: FloatArray  # of torque, N m (N), infinite where there are none, (n,)
    friction: bool = False

    @cached_property
    def resistance(self) -> Callable[[FloatArray], FloatArray]:
        """Friction that the torque has to overcome, N m (N), at velocities (m, n)."""
        return Drivetrain(friction=self.friction).resistance_of(self.plant.arm)


class Bank:
    """Several controllers, m, evaluated at the same time."""

    def __init__(self, controllers: Sequence[Controller], world: World) -> None:
        def indicator(holds: Callable[[Controller], bool]) -> FloatArray:
            return np.array([float(holds(controller)) for controller in controllers])

        self._gains, self._diagonal = world.gains, world.diagonal[:, None]
        # Constants multiply the feedback of a law without a model's D.
        self._multiplies = indicator(lambda c: c.law == "computed_torque")
        inertia = indicator(lambda c: c.law != "pd")
        velocities = indicator(lambda c: c.law != "pd" and c.knows != "without_h")
        by_simplified = indicator(lambda c: c.knows == "simplified")
        self._models = []
        for program, uses in ((world.exact, 1.0 - by_simplified), (world.simplified, by_simplified)):
            chosen = np.flatnonzero(uses)
            if len(chosen):
                batch = Batch(program, len(chosen))
                factors = {"q": np.ones(len(chosen)), "qd": velocities[chosen], "qdd": inertia[chosen]}
                inputs = [(batch.rows(x, len(world.diagonal)), factor) for x, factor in factors.items()]
                self._models.append((chosen, batch, inputs))

    def torque(self, q: FloatArray, qd: FloatArray, desired: Sequence[FloatArray]) -> FloatArray:
        """Commanded torque, N m (N), shape (n, m), at states and desired q, qd and qdd, all of that shape."""
        q_d, qd_d, qdd_d = desired
        feedback = self._gains.damper * (qd_d - qd) + self._gains.stiffness * (q_d - q)
        torque = self._diagonal * (1.0 - self._multiplies) * feedback
        states = (q, qd, qdd_d + self._multiplies * feedback)
        for chosen, batch, inputs in self._models:
            for (rows, factor), values in zip(inputs, states, strict=True):
                for i, row in rows:
                    np.multiply(values[i, chosen], factor, out=row)
            torque[:, chosen] += batch.run()
        return torque
