"""A robot and a log of it, as readers of the documentation have them: URDF, and CSV."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import gd_analyze as gd

_NAMES = ("shoulder", "elbow", "wrist")
_LENGTHS = (0.4, 0.35, 0.1)
_MASSES = (4.0, 2.5, 0.6)


def _link(name: str, mass: float, length: float) -> str:
    across, along = mass * 0.05**2 / 2, mass * length**2 / 12
    return f"""  <link name="{name}_link"><inertial><origin xyz="{length / 2} 0 0.01"/><mass value="{mass}"/>
    <inertia ixx="{across}" iyy="{along}" izz="{along}" ixy="0" ixz="0" iyz="0"/></inertial></link>
"""


def _joint(name: str, parent: str, place: str, axis: str) -> str:
    return f"""  <joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>
    <origin xyz="{place}"/><axis xyz="{axis}"/>
    <limit lower="-2.5" upper="2.5" velocity="3" effort="80"/></joint>
"""


def write_own_robot(folder: Path) -> None:
    """Write `my_robot.urdf`, and `log.csv` of it: readings at 125 Hz, with torques, noise and friction."""
    parts = ['<?xml version="1.0"?>\n<robot name="my_robot">\n  <link name="base_link"/>\n']
    parts += [_link(*of) for of in zip(_NAMES, _MASSES, _LENGTHS, strict=True)]
    parts += [
        _joint("shoulder", "base_link", "0 0 0.3", "0 0 1"),
        _joint("elbow", "shoulder_link", "0.4 0 0", "0 1 0"),
        _joint("wrist", "elbow_link", "0.35 0 0", "0 1 0"),
    ]
    path = folder / "my_robot.urdf"
    path.write_text("".join([*parts, "</robot>\n"]), encoding="utf-8")
    _write_log(gd.load_arm(path), folder / "log.csv")


def _write_log(arm: gd.RobotArm, path: Path) -> None:
    random = np.random.default_rng(7)
    time = np.arange(0.0, 6.0, 0.008)
    waves = np.outer(time, [1.7, 2.3, 2.9])
    q, qd = np.sin(waves), np.cos(waves) * [1.7, 2.3, 2.9]
    torque = gd.decompose_states(arm, gd.States(q, qd, -q * [1.7**2, 2.3**2, 2.9**2]))["torque"]
    torque = torque + 0.8 * np.tanh(qd / 0.02) + 0.3 * qd + random.normal(0.0, 0.05, q.shape)
    table = np.column_stack([time, q + random.normal(0.0, 1e-5, q.shape), torque])
    header = [
        "__time",
        *(f"/joint_states/{name}/{what}" for what in ("position", "effort") for name in _NAMES),
    ]
    rows = [",".join(f"{number:.7g}" for number in row) for row in table]
    path.write_text("\n".join([",".join(header), *rows]) + "\n", encoding="utf-8")
