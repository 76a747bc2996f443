"""Full turns that a log takes from a joint's angle, given back."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import named_joints

_TURN = 2 * math.pi
# A jump that differs from full turns by more than this, rad, is none of a wrapped angle.
_NEAR = math.pi / 2


def unwrapped(q: FloatArray, arm: RobotArm, stretches: Sequence[slice]) -> tuple[FloatArray, tuple[str, ...]]:
    """Undo jumps of full turns within each stretch, of joints that turn.

    Across a gap angles stay as they were logged, but where that is outside a joint's limits and full turns
    put the whole stretch within.

    Parameters
    ----------
    q
        Joint variables, rad (m), shape (N, n).
    arm, stretches
        Whose joints, and the set points of each stretch.

    Returns
    -------
    q, told
        The same without jumps, and what was done, in a sentence or none.
    """
    out = q.copy()
    jumped: dict[int, int] = {}
    for i in np.flatnonzero(arm.is_revolute).tolist():
        lower, upper = arm.limits("lower")[i], arm.limits("upper")[i]
        for stretch in stretches:
            steps = np.diff(out[stretch, i])
            turns = np.round(steps / _TURN)
            turns[np.abs(steps - _TURN * turns) > _NEAR] = 0.0
            if turns.any():
                jumped[i + 1] = jumped.get(i + 1, 0) + int(np.count_nonzero(turns))
                out[stretch.start + 1 : stretch.stop, i] -= _TURN * np.cumsum(turns)
            out[stretch, i] += _TURN * _turns_into(out[stretch, i], lower, upper)
    if not jumped:
        return out, ()
    total = sum(jumped.values())
    return out, (
        f"{total} jump{'s' * (total > 1)} of full turns undone ({named_joints([*jumped], arm.n_joints)})",
    )


def _turns_into(angle: FloatArray, lower: float, upper: float) -> int:
    """Full turns that put angles within limits they are outside of; 0 where none do."""
    low, high = float(angle.min()), float(angle.max())
    if not (math.isfinite(lower) and math.isfinite(upper)) or (lower <= low and high <= upper):
        return 0
    turns = math.ceil((lower - low) / _TURN) if low < lower else -math.ceil((high - upper) / _TURN)
    return turns if lower <= low + _TURN * turns and high + _TURN * turns <= upper else 0
