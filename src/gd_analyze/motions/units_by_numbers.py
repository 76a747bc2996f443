"""Units that numbers show: by velocities against positions, by what a joint can reach, and by steps of time.

A log whose names state no unit is read in them; anything else is read as stated, and a warning says so.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.motions.mapping import map_option
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS, UNITS

_DEGREE = UNITS["angle"]["deg"]
# Velocities of real arms, filtered or from a sensor of their own, miss the derivative by up to this share;
# the factors told apart differ by 17 at least.
FACTOR_TOLERANCE = 0.1
# Rates of samples below which an estimate is none, and its digits.
_LOWEST_RATE, _DIGITS_OF_RATE = 5.0, 3
# Few motions in degrees stay as near to zero in every joint; in radians, all within half a turn do.
_LEAST_DEGREES = 3.15
# Joints nearer to zero, rad, say nothing of their unit.
_AWAY_FROM_ZERO = 0.1
# Positions of a joint that turns are doubtful outside its range and beyond a turn; without a range beyond
# two, as it may turn several times; and those of a slide beyond ten times its range.
_ONE_TURN, _MANY_TURNS = 2.0 * math.pi, 4.0 * math.pi
_MANY_TRAVELS = 10.0
# A decision needs more than a doubt: a joint beyond so many times the end of its range (twice two turns).
_SURELY_BEYOND = 3.0
# Share of its range that a joint in degrees may reach.
_RANGE_MARGIN = 1.05
# Share of the rows, at either side, that may be corrupt, and the most rows that are looked at.
_UNUSUAL_SHARE = 0.05
_MOST_ROWS = 10_000
# Steps of most logs, s, 2 kHz to 2 Hz: any number is one in a single unit.
_SHORTEST_USUAL_STEP, LONGEST_USUAL_STEP = 5e-4, 0.5
# Velocities up to this share of the limits are usual; only joints that move farther, rad or m, show theirs.
_USUAL_VELOCITY_SHARE = 1.5
_MOVING_SPAN = 0.1


def units_of_factors(
    factors: FloatArray, x: str = "q", v: str = "qd", *, unstated: Container[str]
) -> dict[str, str] | None:
    """Units with which v is the derivative of x.

    Parameters
    ----------
    factors
        Those by which v is too large, joint by joint, read in SI units; nan where it is no multiple.
    x, v
        Roles of positions and of velocities, or of velocities and of accelerations.
    unstated
        Of "time" and these two, those that may be in another unit.

    Returns
    -------
    dict
        The unit of "time", and "deg" for x or v if one of them is in degrees and the other is not. Empty
        without factors; None where no unit makes most joints agree.
    """
    if not len(factors):
        return {}
    for second in TIME_UNITS if "time" in unstated else ["s"]:
        for role in ("", x, v):
            if role and role not in unstated:
                continue
            units = ({role: "deg"} if role else {}) | {"time": second}
            agree = np.abs(factors / factor_of_units(units, v) - 1.0) < FACTOR_TOLERANCE
            if 2 * agree.sum() > len(factors):
                return units
    return None


def factor_of_units(units: Mapping[str, str], v: str) -> float:
    """Factor by which v is too large to be a derivative if what is in these units is read in SI units."""
    factor = 1.0
    for role, unit in units.items():
        size = TIME_UNITS[unit] if role == "time" else UNITS["angle"][unit]
        factor = factor * size if role not in ("time", v) else factor / size
    return factor


def rate_of_factors(factors: FloatArray) -> str:
    """Rate of the samples that are counted in place of time, "250Hz", if all joints agree in one; or "" ."""
    middle = float(np.median(factors)) if len(factors) else 0.0
    agree = (np.abs(factors - middle) < FACTOR_TOLERANCE * middle).all()
    return f"{float(f'{middle:.{_DIGITS_OF_RATE}g}'):g}Hz" if agree and middle >= _LOWEST_RATE else ""


def options_of(units: Mapping[str, str]) -> str:
    """Options that state units of roles."""
    return " ".join(map_option(f"{role}=:{unit}") for role, unit in units.items())


def out_of_reach(arm: RobotArm, low: FloatArray, high: FloatArray) -> Array:
    """Joints, (n,), whose extreme positions no such joint has: in another unit, or before the gears."""
    ends = _ends(arm)
    outside = (low < arm.limits("lower")) | (high > arm.limits("upper")) | np.isinf(ends)
    turned = np.where(np.isinf(ends), _MANY_TURNS, _ONE_TURN)
    return np.asarray(
        outside & (np.maximum(-low, high) > np.where(arm.is_revolute, turned, _MANY_TRAVELS * ends))
    )


def look_like_degrees(arm: RobotArm, low: FloatArray, high: FloatArray) -> Array:
    """Joints that turn, (n,), whose extreme positions are out of reach, but not if they are in degrees."""
    within = _DEGREE * np.maximum(-low, high) <= _RANGE_MARGIN * _ends(arm)
    return np.asarray(arm.is_revolute) & within & out_of_reach(arm, low, high)


def joint_in_degrees(q: FloatArray, arm: RobotArm) -> int | None:
    """Joint, from 0, that shows positions (N, n) of all that turn to be in degrees; None if none does.

    Most joints away from zero look like degrees, and all are within their range if these are degrees, but not
    if these are positions of motors in front of the file's gears.
    """
    low, high = usual_extremes(q)
    turns, reach, ends = np.array(arm.is_revolute), np.maximum(-low, high), _ends(arm)
    suspects = look_like_degrees(arm, low, high)
    surely = suspects & (reach > np.where(np.isinf(ends), 2.0 * _MANY_TURNS, _SURELY_BEYOND * ends))
    is_most = 2 * suspects.sum() > (turns & (reach > _AWAY_FROM_ZERO)).sum()
    ratios = np.array([abs(drive.gear_ratio) for drive in arm.drives] or [1.0] * arm.n_joints)
    farthest = _RANGE_MARGIN * np.where(np.isinf(ends), 2.0 * _MANY_TURNS, ends)
    in_degrees, of_motors = ((x <= farthest)[turns].all() for x in (_DEGREE * reach, reach / ratios))
    return int(surely.argmax()) if surely.any() and is_most and in_degrees and not of_motors else None


def _ends(arm: RobotArm) -> FloatArray:
    """How far from zero each joint's range reaches, (n,); infinite without one."""
    return np.maximum(np.abs(arm.limits("lower")), np.abs(arm.limits("upper")))


def usual_extremes(q: FloatArray) -> FloatArray:
    """Smallest and largest position of each joint, (2, n), without a few rows, which may be corrupt."""
    rows = q[:: max(len(q) // _MOST_ROWS, 1)]
    known = np.where(np.isfinite(rows), rows, 0.0)
    shares = [_UNUSUAL_SHARE, 1.0 - _UNUSUAL_SHARE]
    return np.quantile(known, shares, axis=0) if len(known) else np.zeros((2, q.shape[1]))


def look_like_radians(q: FloatArray) -> bool:
    """Whether angles stay as near to zero as few motions in degrees do."""
    return float(np.nanmax(np.abs(q), initial=0.0)) <= _LEAST_DEGREES


def usual_unit(step: float) -> str:
    """Unit of time in which a step is one of most logs; "s" if none is."""
    usual = (u for u, size in TIME_UNITS.items() if _SHORTEST_USUAL_STEP <= step * size <= LONGEST_USUAL_STEP)
    return next(usual, "s")


def slow_motion(arm: RobotArm, time: FloatArray, travel: FloatArray, speed: FloatArray) -> list[str]:
    """A warning if velocities, derived from instants, and steps would be usual in another unit of time.

    `travel` and `speed` are the largest of each joint, (n,).
    """
    moving = travel > _MOVING_SPAN
    limits = arm.limits("velocity_limit")[moving]
    unit = usual_unit(float(np.median(np.diff(time)))) if moving.any() else "s"
    if unit == "s" or not ((limits > 0.0) & np.isfinite(limits)).all():
        return []
    share = float((speed[moving] / limits).max())
    if not 0.0 < share <= _USUAL_VELOCITY_SHARE * TIME_UNITS["ms"]:
        return []
    slow = f"at most {100 * share:.2g} % of the arm's velocity limits, with time read as seconds"
    return [f"{slow}; if it is in {unit}: {options_of({'time': unit})}"]
