"""URDF and MJCF of small robots, and Pinocchio's torques of the raw file to hold an arm against."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.types import RobotArm, States

INERTIA = {"ixx": 0.03, "iyy": 0.04, "izz": 0.05, "ixy": 0.001, "ixz": -0.002, "iyz": 0.003}


def link(
    name: str,
    mass: float | None = 2.0,
    xyz: str = "0.1 0.02 -0.03",
    rpy: str = "0.3 -0.2 0.5",
    **inertia: float,
) -> str:
    """A link whose inertial frame is turned; without mass one that states no inertia."""
    if mass is None:
        return f'<link name="{name}"/>'
    moments = " ".join(f'{key}="{value!r}"' for key, value in (INERTIA | inertia).items())
    return (
        f'<link name="{name}"><inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{mass!r}"/>'
        f"<inertia {moments}/></inertial></link>"
    )


def joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "revolute",
    *,
    xyz: str = "0.1 0.2 0.3",
    rpy: str = "0.1 0.7 -0.4",
    axis: str = "0 0 1",
    limit: str = 'lower="-2" upper="1.5" effort="40" velocity="3"',
    rest: str = "",
) -> str:
    moves = "" if kind in ("fixed", "floating") else f'<axis xyz="{axis}"/><limit {limit}/>'
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/><parent link="{parent}"/>'
        f'<child link="{child}"/>{moves}{rest}</joint>'
    )


def urdf(*elements: str, name: str = "bench arm") -> str:
    """A file with one element per line."""
    return "\n".join([f'<robot name="{name}">', *elements, "</robot>"])


def chain(start: str, side: str, length: int) -> list[str]:
    """Links and joints of a branch."""
    names = [start, *(f"{side}{i}" for i in range(1, length + 1))]
    joints = [joint(f"{side}_{i}", *names[i : i + 2]) for i in range(length)]
    return [*map(link, names[1:]), *joints]


TWO_ARMS = urdf(link("torso"), *chain("torso", "left", 3), *chain("torso", "right", 3))


def two_joints(*more: str) -> str:
    """Base, upper and lower, with joints shoulder and elbow."""
    return urdf(
        link("base"),
        link("upper"),
        link("lower", 1.0),
        joint("shoulder", "base", "upper"),
        joint("elbow", "upper", "lower", axis="0 1 0"),
        *more,
    )


def fingers() -> tuple[str, ...]:
    """Two fingers on the lower link of `two_joints`."""
    return (
        link("left", 0.1),
        link("right", 0.1),
        joint("left_finger", "lower", "left", "prismatic"),
        joint("right_finger", "lower", "right", "prismatic"),
    )


INERTIAL = '<inertial pos="0.02 0.1 0.03" quat="1 0.2 0.3 0.1" mass="2" diaginertia="0.03 0.04 0.05"/>'


def mjcf(body: str, before: str = '<compiler angle="radian"/>', after: str = "") -> str:
    """A file of MJCF whose bodies begin at line 4."""
    return f'<mujoco model="bench">\n{before}\n<worldbody>\n{body}\n</worldbody>\n{after}\n</mujoco>'


def two_bodies(elbow: str = "", after: str = "") -> str:
    """Two bodies; `elbow` are more attributes of the second one's joint."""
    return (
        f'<body name="base" pos="0 0 1"><body name="upper" pos="0 0 0.2" euler="0.2 0.3 0.4">{INERTIAL}\n'
        f'<joint name="shoulder" axis="0 1 1" range="-1 2" armature=".1" damping=".5" frictionloss=".2"/>\n'
        f'<body name="lower" pos="0.3 0 0" quat="0.9 0.1 0.2 0.3">{INERTIAL}\n'
        f'<joint name="elbow" pos="0.01 0.02 0" {elbow}/>{after}</body></body></body>'
    )


def raw_torque(path: Path, arm: RobotArm, states: States, held: Mapping[str, float] | None = None) -> Any:
    """Torques by Pinocchio's rnea of the file as it is: all its joints, those not of the arm held."""
    model = (pin.buildModelFromUrdf if path.suffix == ".urdf" else pin.buildModelFromMJCF)(str(path))
    model.gravity.linear = np.array(arm.gravity_vector)
    model.armature = np.zeros(model.nv)  # of the drives, not of the links
    data, torques = model.createData(), []
    ids = [model.getJointId(one.name) for one in arm.joints]
    fixed = {model.getJointId(name): value for name, value in (held or {}).items()}
    for position, rate, acceleration in zip(*states.arrays, strict=True):
        q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for index, value in [*zip(ids, position, strict=True), *fixed.items()]:
            at, turns = model.idx_qs[index], model.nqs[index] == 2
            q[at : at + model.nqs[index]] = (math.cos(value), math.sin(value)) if turns else value
        for index, one, two in zip(ids, rate, acceleration, strict=True):
            v[model.idx_vs[index]], a[model.idx_vs[index]] = one, two
        torques.append(pin.rnea(model, data, q, v, a)[[model.idx_vs[index] for index in ids]].copy())
    return np.array(torques)


def assert_same_torque(
    path: Path,
    arm: RobotArm,
    states: States,
    held: Mapping[str, float] | None = None,
    *,
    merged: int = 5,
    askew: float = 0.0,
) -> None:
    """The arm's torques are those of the file's robot.

    A body that is fixed to another passes as many roundings on its way there as a link does on its way over
    a joint, so that `merged` bodies count as joints in the bound of round-off. A rotation that was made right
    by `askew` rad turns forces and lever arms of whatever is beyond by as much, twice for an inertia between
    two axes, in every joint of the way.
    """
    ours, theirs = pinocchio_dynamics(arm, *states.arrays)["torque"], raw_torque(path, arm, states, held)
    bounds = round_off_bounds(arm, *states.arrays)["torque"]
    eps = np.finfo(float).eps
    magnitude = bounds / (20 * arm.n_joints * eps)
    allowed = bounds * (1 + merged / arm.n_joints) + 2 * arm.n_joints * askew * magnitude
    assert np.abs(ours - theirs).max() <= allowed
