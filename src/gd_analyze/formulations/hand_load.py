"""What the hand exerts on the world; the arm has to carry it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gd_analyze.robots.parts import constant
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True, eq=False)
class HandLoad:
    """Force and moment that the last link exerts on the world at its frame's origin, in the base frame.

    [FGL87] Tables 3.2 and 3.3: f_{n+1} and n_{n+1}.

    Parameters
    ----------
    force
        N, shape (3,).
    moment
        N m, shape (3,).
    """

    force: FloatArray = field(default_factory=lambda: np.zeros(3))
    moment: FloatArray = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        for name in ("force", "moment"):
            value = constant(getattr(self, name), (3,), f"the {name} of the hand's load", "hand load")
            object.__setattr__(self, name, value)


NO_LOAD = HandLoad()
