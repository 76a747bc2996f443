"""An arm file to change, and where its text stands."""

from __future__ import annotations

import numpy as np

from gd_analyze.types import Link

ARM = """\
format = "gd-analyze arm 1"
name = "mine"
gravity = [0.0, 0.0, -9.81]

[[joints]]
name = "turn"
alpha_deg = -90.0
a_mm = 500.0
range_deg = [-90.0, 90.0]
velocity_limit = 2.0

[[joints]]
name = "slide"
kind = "prismatic"
range = [0.0, 0.5]

[[links]]
name = "first"
mass = 2.0
com = [0.0, 0.0, 0.1]
inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }

[[links]]
name = "second"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.01, yy = 0.01, zz = 0.01, xy = 0.001 }

[[drives]]
inertia = 0.5

[[drives]]
inertia = 0.25
"""

PLACED = """\
format = "gd-analyze arm 1"
name = "askew"
convention = "placement"

[[joints]]
name = "shoulder"
xyz = [0.0, 0.0, 0.3]
rpy = [0.1, -0.2, 0.3]
axis = [0.6, 0.0, 0.8]
range_deg = [-90.0, inf]

[[joints]]
name = "lift"
kind = "prismatic"
xyz_mm = [400.0, 0.0, 0.0]
rotation = [
    [1.0, 0.0, 0.0],
    [0.0, 0.0, -1.0],
    [0.0, 1.0, 0.0],
]

[[links]]
mass = 3.0
com = [0.2, 0.0, 0.0]
inertia = { xx = 0.002, yy = 0.04, zz = 0.04 }

[[links]]
frame_xyz_mm = [350.0, 0.0, 0.0]
frame_rpy_deg = [0.0, 0.0, 180.0]
mass = 1.5
com = [0.15, 0.0, 0.0]
inertia = { xx = 0.001, yy = 0.015, zz = 0.015 }
"""


def line_of(text: str, needle: str, occurrence: int = 0) -> int:
    return [i for i, line in enumerate(text.splitlines(), start=1) if needle in line][occurrence]


def link(**changes: object) -> Link:
    """A link to change one thing of."""
    return Link(**{"name": "l", "mass": 1.0, "com": np.zeros(3), "inertia_com": 0.1 * np.eye(3)} | changes)
