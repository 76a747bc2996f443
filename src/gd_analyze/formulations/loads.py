"""What the actuators work against besides the inertia of the arm."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gd_analyze.robots.constants import keep
from gd_analyze.vectors import Array, FloatArray


@dataclass(frozen=True, eq=False)
class Loads:
    """Gravity, damping at the joints, and what the last link exerts on the world. [FGL87] Tables 3.2 and 3.3.

    Parameters
    ----------
    gravity
        Whether the arm's gravity acts.
    damping
        Viscous damping b_i at the joints, N m s (N s/m where the joint slides), shape (n,).
    force, moment
        f_{n+1} and n_{n+1} at the last link frame's origin, in the base frame, N and N m, shape (3,).
    """

    gravity: bool = True
    damping: FloatArray | None = None
    force: FloatArray = field(default_factory=lambda: np.zeros(3))
    moment: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        for name in ("force", "moment"):
            keep(self, name, (3,), f"the {name} of the hand's load", "hand load")

    def base_acceleration(self, gravity: Array, count: int) -> Array:
        """What the base accelerates by so that the links feel gravity, shape (3, N)."""
        return np.broadcast_to((-gravity if self.gravity else np.zeros(3))[:, None], (3, count))


GRAVITY = Loads()
