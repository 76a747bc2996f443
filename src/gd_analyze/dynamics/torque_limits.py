"""Warn of torques beyond the drives' limits, which reveal wrong units, noise or a payload."""

from __future__ import annotations

import warnings

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.errors import GdAnalyzeWarning, TorqueLimitWarning, warn_caller
from gd_analyze.motions.limits import ROUNDING, joint_label
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.motions.units_by_numbers import out_of_reach
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number

# Number of poses in which the arm holds its own weight.
_DRAWN_POSES = 500
# Industrial arms accelerate by some tens of rad/s^2 (m/s^2): larger ones are of a wrong unit, or noise.
_USUAL_ACCELERATION = 100.0


def warn_of_torque_limits(arm: RobotArm, states: States, torque: FloatArray | None = None) -> None:
    """Warn of the joint whose torque, (N, n), exceeds its drive's limit most, with the likeliest cause."""
    limits = np.array([drive.torque_limit or np.inf for drive in arm.drives])
    if not np.isfinite(limits).any():
        return
    factors = np.abs(torque_of(arm, states) if torque is None else torque).max(axis=0) / limits
    joint = int(factors.argmax())
    if factors[joint] <= 1.0 + ROUNDING:
        return
    limit, unit = float(limits[joint]), arm.joints[joint].effort_unit
    reached = f"{joint_label(joint + 1, arm.joints[joint].name)} needs {factors[joint] * limit:.4g} {unit}"
    text = f"{reached}, {number(factors[joint])} times its limit of {limit:g} {unit}"
    text += f"; {_likeliest_cause(arm, states, joint, limit, factors[joint])}"
    warn_caller(TorqueLimitWarning(text))


def warn_of_weight(arm: RobotArm) -> None:
    """Warn of the joint whose drive is too weak for the arm's weight, in poses within its ranges."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # if ranges are assumed
        q = states_in_box(arm, _DRAWN_POSES).q
    warn_of_torque_limits(arm, States(q, np.zeros_like(q), np.zeros_like(q)))


def _likeliest_cause(arm: RobotArm, states: States, joint: int, limit: float, factor: float) -> str:
    """Cause to check first: the arm at rest, then units of angle and time, then noise."""
    q, qd, qdd = states.arrays
    doubtful = np.array(arm.is_revolute) & out_of_reach(arm, np.abs(q).max(axis=0))
    rated = arm.limits("velocity_limit")
    is_rated = np.isfinite(rated) & (rated > 0.0)
    speed = (np.abs(qd).max(axis=0)[is_rated] / rated[is_rated]).max(initial=0.0)
    still = np.zeros_like(q)
    at_rest = np.abs(torque_of(arm, States(q, still, still))[:, joint]).max() / limit
    if doubtful.any():
        reach = np.abs(q[:, doubtful]).max()
        return f"positions reach {reach:.4g} rad: are they degrees, encoder counts or motor angles?"
    if at_rest > 1.0:
        return f"at rest {number(at_rest)} times: check masses, gravity, payload and the limit"
    if speed > 2.0:
        excess = number(speed)
        return f"velocities reach {excess} times their limits: check the units of time and angle (--map)"
    most = np.abs(qdd).max()
    if factor > 2.0 and most > _USUAL_ACCELERATION:
        reached = f"accelerations reach {most:.4g} per s^2"
        return f"{reached}: check the unit of time (--map), and noise (--measured)"
    return "the motion is too fast, the load too heavy or the limit too low"
