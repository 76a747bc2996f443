"""Files to be refused, or warned of, by every verb."""

from __future__ import annotations

HEADER = "time,q1,q2"
ROWS = tuple(f"{0.25 * k},{0.02 * k * k},{-0.01 * k * k}" for k in range(9))
ARM = """\
format = "gd-analyze arm 1"
name = "own"
[[joints]]
a = 1.0
[[joints]]
a = 1.0
[[links]]
mass = 2.0
com = [-0.5, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.2, zz = 0.2 }
[[links]]
mass = 1.0
com = [-0.5, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.1, zz = 0.1 }
"""


def csv(*rows: str, header: str = HEADER) -> str:
    return "\n".join([header, *rows]) + "\n"
