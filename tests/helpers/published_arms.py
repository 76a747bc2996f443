"""The arms of Table 1 of the paper on PSDM, which studies and tests share."""

from __future__ import annotations

from typing import Any

import numpy as np

from gd_analyze.robots.frames import standard_placements
from gd_analyze.types import DHRow, Joint, Link, RobotArm

# Largest magnitudes of velocities and accelerations, rad/s and rad/s^2 (m/s, m/s^2).
PROFILES = {"slow": (0.1, 1.0), "fast": (1.0, 10.0)}

# Table 1, standard Denavit-Hartenberg: d, a in mm, alpha in degrees; mass; centre of mass in mm and inertia
# about it, xx yy zz and xy xz yz, in the link's frame. The joint that slides has d for its variable.
TABLE_1 = {
    "KR6": """
        183   25 -90 7.60 -37.6  43.5   -7.6 .0430 .0449 .0490  .0125  .0022 -.0024
          0 -315   0 2.80 155.4  -6.2  114.8 .0060 .0393 .0415 -.0004 -.0012  .0001
          0  -35  90 7.00  45.0  -7.0    4.0 .0278 .0375 .0309  .0010  .0005 -.0002
        365    0 -90 2.90  -1.0 102.1   -2.8 .0138 .0058 .0123 -.0010  .0002  .0002
          0    0  90 0.94   0.1 -30.0   10.6 .0009 .0010 .0006  .0001  .0010  .0001
         80    0   0 3.00  -2.0 -19.0   67.0 .0045 .0050 .0060  .0001 -.0003  .0004""",
    "LBR7": """
        340    0 -90 3.95  -3.5   1.6  -31.4 .0046 .0045 .0003  0      0      0
          0    0  90 4.50  -7.7 166.8   -3.6 .0003 .0001 .0004  0      0      0
        400    0  90 2.45  -2.2 -34.9  -26.5 .0022 .0022 .0007 -.0001  .0001  .0001
          0    0 -90 2.61   0.2 -52.7   38.2 .0384 .0114 .0499  .0009 -.0011 -.0011
        400    0 -90 3.41   0.1  -2.4 -211.3 .0028 .0028 .0001  0      0      0
          0    0  90 3.39   0.5  20.2  -27.5 .0005 .0028 .0023 -.0001  0      0
        126    0   0 3.00  -2.0 -19.0   67.0 .0045 .0050 .0060  .0001 -.0003  .0004""",
    "SCARA": """
        160  350   0 6.25 209.6   0     44.7 .0104 .1355 .1413  0      .0056  0
          0  300 180 9.49 -166.2  0   -146.4 .0494 .1553 .1336  0     -.0129  0
          q    0   0 0.40   0     0   -175.1 .0069 .0069 0      0      0      0
          0    0   0 1.10   4.1 -12.4  -16.8 .0023 .0004 .0025  0      0      .0001""",
}


def arm_of(name: str, profile: str = "fast") -> RobotArm:
    """Make an arm of Table 1, its joints free to turn full circles, with the limits of a profile."""
    joints, links = [], []
    rate, acceleration = PROFILES[profile]
    for i, line in enumerate(TABLE_1[name].strip().splitlines(), start=1):
        words = line.split()
        kind: Any = "prismatic" if words[0] == "q" else "revolute"
        d, a, alpha, mass, *rest = (0.0 if word == "q" else float(word) for word in words)
        before, behind = standard_placements(kind, DHRow(0.0, d / 1000, a / 1000, np.deg2rad(alpha)))
        lower, upper = (-np.pi, np.pi) if kind == "revolute" else (0.0, 0.3)
        joints.append(
            Joint(
                f"joint {i}",
                kind,
                placement=before,
                lower=lower,
                upper=upper,
                velocity_limit=rate,
                acceleration_limit=acceleration,
            )
        )
        xx, yy, zz, xy, xz, yz = rest[3:]
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        # One inertia is indefinite as published.
        links.append(Link(f"link {i}", mass, np.array(rest[:3]) / 1000, inertia, behind, as_measured=True))
    return RobotArm(name, tuple(joints), tuple(links), np.array([0.0, 0.0, -9.81]))
