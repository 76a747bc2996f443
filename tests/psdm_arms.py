"""Arms of general make whose figures are published: Lloyd, Irani, Ahmadi, Mechanism and Machine Theory 2021.

Table 1: standard Denavit-Hartenberg, mm, degrees, kg, kg m^2 about the centre of mass. Limits are those of
the paper's fast profile.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import standard_placements
from gd_analyze.robots.parts import DHRow, Joint, Link, symmetric_tensor

# d, a, alpha; m; centre of mass; Ixx, Iyy, Izz; Ixy, Ixz, Iyz.
_Row = tuple[
    tuple[float, float, float],
    float,
    tuple[float, float, float],
    tuple[float, float, float],
    tuple[float, float, float],
]
_LAST = (3.0, (-2.0, -19.0, 67.0), (0.0045, 0.0050, 0.0060), (0.0001, -0.0003, 0.0004))
_KR6: tuple[_Row, ...] = (
    ((183, 25, -90), 7.6, (-37.6, 43.5, -7.6), (0.0430, 0.0449, 0.0490), (0.0125, 0.0022, -0.0024)),
    ((0, -315, 0), 2.8, (155.4, -6.2, 114.8), (0.0060, 0.0393, 0.0415), (-0.0004, -0.0012, 0.0001)),
    ((0, -35, 90), 7.0, (45.0, -7.0, 4.0), (0.0278, 0.0375, 0.0309), (0.0010, 0.0005, -0.0002)),
    ((365, 0, -90), 2.9, (-1.0, 102.1, -2.8), (0.0138, 0.0058, 0.0123), (-0.0010, 0.0002, 0.0002)),
    ((0, 0, 90), 0.94, (0.1, -30.0, 10.6), (0.0009, 0.0010, 0.0006), (0.0001, 0.0010, 0.0001)),
    ((80, 0, 0), *_LAST),
)


def kr6() -> RobotArm:
    """KUKA KR6, six revolute joints, full inertias; that of link 5 is indefinite as published."""
    return _arm("kr6", _KR6)


def _arm(name: str, rows: tuple[_Row, ...]) -> RobotArm:
    joints, links = [], []
    for i, ((d, a, alpha), mass, com, (xx, yy, zz), (xy, xz, yz)) in enumerate(rows, start=1):
        row = DHRow(0.0, d / 1000, a / 1000, np.deg2rad(alpha))
        placement, frame = standard_placements("revolute", row)
        limits = {"lower": -np.pi, "upper": np.pi, "velocity_limit": 1.0, "acceleration_limit": 10.0}
        joints.append(Joint(f"joint {i}", "revolute", placement, **limits))
        inertia = symmetric_tensor(xx, yy, zz, xy, xz, yz)
        links.append(Link(f"link {i}", mass, np.array(com) / 1000, inertia, frame, as_measured=True))
    return RobotArm(name, tuple(joints), tuple(links), np.array([0.0, 0.0, -9.81]))
