"""The state of the largest torque error that a search finds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.certification.box import Box
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.local_maximum import local_maximum
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True, eq=False)
class WorstState:
    """A torque error found, N m (N), and the state where it is: q, qd and qdd, shape (n,)."""

    error: float
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray

    @classmethod
    def none(cls, box: Box) -> WorstState:
        """No error, so as good as any state: at rest in the middle."""
        return cls(0.0, box.centre, np.zeros(box.n_joints), np.zeros(box.n_joints))


def worst_state(field: ErrorField, box: Box, starts: FloatArray) -> WorstState:
    """Climb from good positions (n, S), rates and accelerations being the worst at each."""
    q, _ = local_maximum(lambda q: field.motion.reached(field.waves(q)), box, starts)
    error, rates, pushes = field.motion.worst(field.waves(q[:, None])[:, 0])
    return WorstState(error, q, rates * box.rate, pushes * box.acceleration)
