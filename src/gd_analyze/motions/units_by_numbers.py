"""Units that a log's numbers say: positions against integrated velocities, and what a joint can reach."""

from __future__ import annotations

import math
from collections.abc import Container

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.velocities import velocity_factors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS

_DEGREE = math.pi / 180.0
# Velocities of real arms, filtered or from a sensor of their own, miss the derivative by up to this share;
# the factors told apart differ by 17 at least.
_FACTOR_TOLERANCE = 0.1
# Share of the farthest joint's travel below which a joint's velocities say nothing.
_STILL_SHARE = 0.05
# Angles are in degrees where a joint reaches so many times the end of its range, or turns so often without
# one, and every joint is within its range if they are.
_BEYOND_RANGE = 3.0
_MOST_TURNS = 4.0 * 2.0 * math.pi
_RANGE_MARGIN = 1.05
# Share of the rows that say how far a joint reaches, and the most rows that are looked at.
_USUAL_SHARE = 0.95
_MOST_ROWS = 10_000
# Digits of a rate of samples that velocities tell.
_DIGITS_OF_RATE = 3


def units_of_derivatives(
    instants: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    arm: RobotArm,
    *,
    unstated: Container[str],
    time: bool,
) -> dict[str, str] | None:
    """Units with which velocities are the derivative of positions, of those that are not stated.

    Parameters
    ----------
    instants, q, qd
        As logged, (N,) and (N, n): in SI units but for what is not stated.
    arm
        The arm.
    unstated
        Roles, "q" and "qd", whose angles may be in degrees.
    time
        Whether the unit of the instants is not stated.

    Returns
    -------
    dict
        "time", its unit; "q" or "qd", "deg" where one of them is in degrees and the other is not; or "rate",
        about so many instants per second. Empty where no joint moves enough to tell; None where no unit makes
        most joints agree.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        factors = velocity_factors(instants, q, qd)
    turns, travel = np.array(arm.is_revolute), np.ptp(q, axis=0) if len(q) else np.zeros(arm.n_joints)
    moving = (turns if turns.any() else ~turns) & (travel > _STILL_SHARE * travel.max(initial=0.0))
    factors = np.abs(factors[moving])
    if not len(factors):
        return {}
    # Velocities are too large by the size of a position's unit over those of a velocity's and of the time's.
    angles: list[tuple[dict[str, str], float]] = [({}, 1.0)]
    angles += [({"q": "deg"}, _DEGREE)] if "q" in unstated else []
    angles += [({"qd": "deg"}, 1.0 / _DEGREE)] if "qd" in unstated else []
    for unit, second in TIME_UNITS.items() if time else [("s", 1.0)]:
        for in_degrees, size in angles:
            agree = np.abs(factors * second / size - 1.0) < _FACTOR_TOLERANCE
            if 2 * agree.sum() > len(factors):
                return in_degrees | ({"time": unit} if time else {})
    middle = float(np.median(factors))
    if time and (np.abs(factors / middle - 1.0) < _FACTOR_TOLERANCE).all():
        return {"rate": f"{float(f'{middle:.{_DIGITS_OF_RATE}g}'):g}Hz"}
    return None


def joint_in_degrees(q: FloatArray, arm: RobotArm) -> int | None:
    """Joint, from 0, that shows positions (N, n) of all that turn to be in degrees; None if none does.

    Most joints that move are beyond their range, and within it if these are degrees, but not if these are
    positions of motors in front of the file's gears.
    """
    turns, reach = np.array(arm.is_revolute), usual_reach(q)
    ends = np.maximum(np.abs(arm.limits("lower")), np.abs(arm.limits("upper")))
    limited = np.isfinite(ends) & (ends > 0.0)
    ends = np.where(limited, ends, _MOST_TURNS)
    far = np.flatnonzero(turns & (reach > np.where(limited, _BEYOND_RANGE, 1.0) * ends))
    moving = turns & (reach > 0.0)
    ratios = np.array([abs(drive.gear_ratio) for drive in arm.drives] or [1.0] * arm.n_joints)
    in_degrees, of_motors = (
        (x <= _RANGE_MARGIN * ends)[turns].all() for x in (_DEGREE * reach, reach / ratios)
    )
    is_most = 2 * (reach > ends)[moving].sum() > moving.sum()
    return int(far[0]) if len(far) and is_most and in_degrees and not of_motors else None


def usual_reach(q: FloatArray) -> FloatArray:
    """How far from zero each joint is in all but a few of the rows, (n,), which may be corrupt."""
    rows = np.abs(q[:: max(len(q) // _MOST_ROWS, 1)])
    known = np.where(np.isfinite(rows), rows, 0.0)
    return np.quantile(known, _USUAL_SHARE, axis=0) if len(known) else np.zeros(q.shape[1])
