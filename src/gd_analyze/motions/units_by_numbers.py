"""Units that numbers show: by velocities against positions, by what a joint can reach, and by steps of time.

A log whose names state no unit is read in them; anything else is read as stated, and a warning says so.
"""

from __future__ import annotations

import math
from collections.abc import Container, Mapping

import numpy as np

from gd_analyze.arrays import Array, FloatArray
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
# Positions are doubtful where a joint that turns goes beyond its range and a turn, or without a range beyond
# two, and a slide beyond ten times its range: all by more than a small share.
_ONE_TURN, _TWO_TURNS, _MANY_TRAVELS = 2.0 * math.pi, 4.0 * math.pi, 10.0
_RANGE_MARGIN = 1.05
# A decision comes later than a warning: for degrees, a joint must go beyond so many times its range.
_FAR_BEYOND = 3.0
# Share of the rows that say how far a joint reaches, and the most rows that are looked at.
_USUAL_SHARE, _MOST_ROWS = 0.95, 10_000
# Steps of most logs, s, 2 kHz to 2 Hz: any number is one in a single unit.
_SHORTEST_USUAL_STEP, LONGEST_USUAL_STEP = 5e-4, 0.5
# Velocities up to this share of the limits are usual; only joints that move farther, rad or m, show theirs.
_USUAL_VELOCITY_SHARE = 1.5
_MOVING_SPAN = 0.1


def units_of_factors(
    factors: FloatArray, x: str = "q", v: str = "qd", *, unstated: Container[str]
) -> dict[str, str] | None:
    """Unit of "time", and "deg" for x or v if that alone is in degrees, with which v is the derivative of x.

    `factors` are those by which v is too large, joint by joint, if all is read in SI units; `unstated` says
    which of "time", x and v may be in another unit. Empty without factors; None where no unit makes most
    joints agree.
    """
    if not len(factors):
        return {}
    angles: list[dict[str, str]] = [{}, *({role: "deg"} for role in (x, v) if role in unstated)]
    for second in TIME_UNITS if "time" in unstated else ["s"]:
        for in_degrees in angles:
            units = in_degrees | {"time": second}
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
    return " ".join(f"--map {role}=:{unit}" for role, unit in units.items())


def out_of_reach(arm: RobotArm, reach: FloatArray) -> Array:
    """Joints, (n,), that come no such distance from zero: in another unit, or before the gears."""
    ends = _ends(arm)
    most = np.where(arm.is_revolute, np.maximum(_ONE_TURN, ends), _MANY_TRAVELS * ends)
    return np.asarray(reach > _RANGE_MARGIN * most)


def look_like_degrees(arm: RobotArm, reach: FloatArray) -> Array:
    """Joints that turn, (n,), whose distance from zero is out of reach, but not if it is in degrees."""
    unlimited = ~np.isfinite(arm.limits("upper") - arm.limits("lower"))
    within = unlimited | (_DEGREE * reach <= _RANGE_MARGIN * _ends(arm))
    return np.asarray(arm.is_revolute) & within & out_of_reach(arm, reach)


def joint_in_degrees(arm: RobotArm, reach: FloatArray) -> int | None:
    """Joint, from 0, that shows positions of all that turn to be in degrees; None if none does.

    A decision needs more than a doubt: most joints away from zero look like degrees, one by far, and all are
    within their range if these are degrees, but not if these are positions of motors in front of the file's
    gears.
    """
    turns, ends, suspects = np.array(arm.is_revolute), _ends(arm), look_like_degrees(arm, reach)
    far = suspects & (reach > _FAR_BEYOND * ends)
    is_most = 2 * suspects.sum() > (turns & (reach > _AWAY_FROM_ZERO)).sum()
    ratios = np.array([abs(drive.gear_ratio) for drive in arm.drives] or [1.0] * arm.n_joints)
    in_degrees, of_motors = (
        (x <= _RANGE_MARGIN * ends)[turns].all() for x in (_DEGREE * reach, reach / ratios)
    )
    return int(far.argmax()) if far.any() and is_most and in_degrees and not of_motors else None


def _ends(arm: RobotArm) -> FloatArray:
    """How far from zero each joint's range reaches, (n,); without one a joint may turn twice."""
    ends = np.maximum(np.abs(arm.limits("lower")), np.abs(arm.limits("upper")))
    return np.where(np.isinf(ends) & arm.is_revolute, _TWO_TURNS, ends)


def usual_reach(q: FloatArray) -> FloatArray:
    """How far from zero each joint is in all but a few of the rows, (n,), which may be corrupt."""
    rows = np.abs(q[:: max(len(q) // _MOST_ROWS, 1)])
    known = np.where(np.isfinite(rows), rows, 0.0)
    return np.quantile(known, _USUAL_SHARE, axis=0) if len(known) else np.zeros(q.shape[1])


def look_like_radians(reach: FloatArray) -> bool:
    """Whether no angle goes farther from zero than few motions in degrees do."""
    return bool(reach.max(initial=0.0) <= _LEAST_DEGREES)


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
