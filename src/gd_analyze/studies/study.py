"""What a study of control found: loop by loop, and what is known of all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.bounds import CertifiedTracking, FeedbackLeft
from gd_analyze.studies.controllers import Controller
from gd_analyze.studies.settings import ControlSettings


@dataclass(frozen=True, eq=False)
class TrackedLoop:
    """How one loop tracked the motion; n joints.

    Parameters
    ----------
    controller, rate, speed
        Law and knowledge; Hz; times as fast as planned.
    peak_error, rms_error
        Tracking error, rad (m), shape (n,); infinite where the loop lost the motion.
    peak_torque, rms_torque
        N m (N), shape (n,).
    saturated
        Share of the time for which the torque asked for was beyond its limit, shape (n,).
    expected
        Error that the torque the controller lacks along the motion causes at most, to first order, rad (m),
        shape (n,).
    lost_at
        When the error passed a turn (6.28 m), s; None where it did not.
    work, dissipated, energy_residual
        Of the torque, by friction, and energy gained less work plus what was dissipated, J: the last is zero
        but for the integrator.
    time, error
        History: s, shape (K,), and signed error, shape (K, n); nan where lost.
    """

    controller: Controller
    rate: float
    speed: float
    peak_error: FloatArray
    rms_error: FloatArray
    peak_torque: FloatArray
    rms_torque: FloatArray
    saturated: FloatArray
    expected: FloatArray
    lost_at: float | None
    work: float
    dissipated: float
    energy_residual: float
    time: FloatArray
    error: FloatArray

    def within(self, tolerance: FloatArray) -> bool:
        """Whether every joint stays within a tolerance (n,)."""
        return bool((self.peak_error <= tolerance).all())


@dataclass(frozen=True, eq=False)
class ControlStudy:
    """A motion tracked by every controller at every rate and speed.

    Parameters
    ----------
    model
        What the simplified controllers know.
    arm
        The arm that moves: the model's own, or one that carries a payload.
    motion, settings
        What was asked for.
    diagonal
        Mean of D's diagonal along the motion, kg m^2 (kg), shape (n,): M of controllers that know no D.
    limits
        Torque limits that held, N m (N), infinite where there are none, shape (n,).
    loops
        What came of each.
    certified
        By speed, what is proven of the simplified model; empty where nothing is.
    feedback
        What computed torque with the simplified model leaves of the feedback along the motion.
    fixed_excess
        How many times what they should be fixed gains are in some direction of the motion.
    at_rest
        By what PD knows, the error it rests with at worst, rad (m), shape (n,).
    warnings
        What is suspicious about the input, in sentences.
    provenance
        Versions, time, command.
    """

    model: SimplifiedModel
    arm: RobotArm
    motion: Trajectory
    settings: ControlSettings
    diagonal: FloatArray
    limits: FloatArray
    loops: tuple[TrackedLoop, ...]
    certified: Mapping[float, CertifiedTracking]
    feedback: FeedbackLeft
    fixed_excess: float
    at_rest: Mapping[Controller, FloatArray]
    warnings: tuple[str, ...] = ()
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"ControlStudy({self.arm.name!r}, {self.motion.name!r}, {len(self.loops)} loops)"

    @cached_property
    def tolerance(self) -> FloatArray:
        """Tracking error that counts as good, rad (m), shape (n,)."""
        return self.settings.tolerance.of(self.arm)

    @property
    def stiffness(self) -> FloatArray:
        """Of PD, N m per rad (N/m), shape (n,)."""
        return self.settings.gains.stiffness * self.diagonal

    def loop(self, controller: Controller, rate: float, speed: float) -> TrackedLoop:
        """Find one of them."""
        return next(x for x in self.loops if (x.controller, x.rate, x.speed) == (controller, rate, speed))

    @property
    def too_slow_for_fixed_gains(self) -> tuple[float, ...]:
        """Rates at which fixed gains cannot be stable: a held e'' = -k e' grows where k is 2 per period."""
        damper = self.settings.gains.damper * self.fixed_excess
        return tuple(rate for rate in self.settings.rates if damper >= 2.0 * rate)

    @property
    def usual_rate(self) -> float:
        """Rate at which loops are told of first, see `ControlSettings`."""
        return self.settings.usual_rate

    @property
    def usual_speed(self) -> float:
        """Speed at which loops are told of first."""
        return self.settings.usual_speed

    @cached_property
    def fastest_within_limits(self) -> float:
        """How many times as fast the arm's rate and acceleration limits allow; infinite if none."""
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = self.arm.limits("velocity_limit") / np.abs(self.motion.qd).max(axis=0)
            acceleration = self.arm.limits("acceleration_limit") / np.abs(self.motion.qdd).max(axis=0)
        return float(np.nanmin([*rate, *np.sqrt(acceleration), np.inf]))

    def tracks_up_to(self, controller: Controller, rate: float) -> float | None:
        """Speed up to which every joint stays within the tolerance.

        Errors between two speeds are taken to grow with a power of the speed. Infinite where the tolerance
        holds at every speed tried, None where it holds at none.
        """
        speeds = sorted(self.settings.speeds)
        shares = [
            float((self.loop(controller, rate, speed).peak_error / self.tolerance).max()) for speed in speeds
        ]
        beyond = next((k for k, share in enumerate(shares) if share > 1.0), None)
        if beyond is None:
            return np.inf
        if not beyond:
            return None
        low, high = shares[beyond - 1], shares[beyond]
        if not np.isfinite(high) or not low:
            return speeds[beyond - 1]
        power = np.log(high / low) / np.log(speeds[beyond] / speeds[beyond - 1])
        return float(speeds[beyond - 1] * low ** (-1.0 / power))
