"""States near a motion: what is fitted to set points alone follows them, and goes astray beside them."""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.exact import ExactDynamics

# How far in position, joints that turn and that slide, and as shares of each joint's peak rate and
# acceleration; as the default of `certification.Margin`.
TURNING, SLIDING, RATE, ACCELERATION = math.radians(1.0), 1e-3, 0.02, 0.05
# How many are drawn, always the same. Of a budget of 1 % along 61 set points of a seven-joint arm the largest
# error within these margins was 27 % of peak torque with none, 1.8 % with 100 to 200, and 1.5 % with 1000.
_COUNT = 120


def joined_by_near_states(exact: ExactDynamics) -> ExactDynamics:
    """Add some states near those of a motion, that count like these; none to other states."""
    states = exact.states
    if "trajectory" not in states.described:
        return exact
    random = np.random.default_rng(0)
    some = np.linspace(0, len(states) - 1, _COUNT).round().astype(np.intp)
    turning = np.array([joint.kind == "revolute" for joint in exact.arm.joints])
    rate, acceleration = (np.abs(x).max(axis=0, initial=0.0) for x in (states.qd, states.qdd))
    margins = (np.where(turning, TURNING, SLIDING), RATE * rate, ACCELERATION * acceleration)

    def near(values: FloatArray, margin: FloatArray) -> FloatArray:
        return values[some] + margin * random.uniform(-1.0, 1.0, (_COUNT, len(margin)))

    q, qd, qdd = (near(values, margin) for values, margin in zip(states.arrays, margins, strict=True))
    weights = None if states.weights is None else states.weights[some]
    return exact.at(states.joined_by(q, qd, qdd, weights))
