"""A link to change one thing of."""

from __future__ import annotations

import numpy as np

from gd_analyze.robots.parts import Link


def link(**changes) -> Link:
    return Link(**{"name": "l", "mass": 1.0, "com": np.zeros(3), "inertia_com": 0.1 * np.eye(3)} | changes)
