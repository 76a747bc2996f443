"""The regressor: times the parameters it is the torque, and Pinocchio has the same one."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from hypothesis import given

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import newton_euler_link
from gd_analyze.dynamics.pinocchio_check import pinocchio_model, round_off_bounds
from gd_analyze.dynamics.regressor import PARAMETERS, inertial_parameters, parameters_of, regressor
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Placement
from strategies import arms_with_states, examples

EPS = float(np.finfo(float).eps)


def size(arm: RobotArm, states) -> float:
    """Largest sum of magnitudes that any regressor's row adds up, per unit of a parameter.

    Motion of a link frame is the sum over joints of velocities and accelerations times levers; the reach of a
    prismatic joint grows with its position.
    """
    reach = (
        1.0
        + arm.reach
        + np.abs(states.q).sum(axis=1).max()
        + np.linalg.norm(arm.joints[0].placement.translation)
    )
    velocities, accelerations = (np.abs(x).sum(axis=1).max() for x in (states.qd, states.qdd))
    return float(reach**2 * (3 * velocities**2 + accelerations + np.linalg.norm(arm.gravity)))


@examples(25)
@given(arms_with_states())
def test_times_the_parameters_it_is_the_torque(case):
    arm, states = case
    q, qd, qdd = states.last
    per_unit = regressor(arm, q, qd, qdd)
    assert per_unit.shape == (arm.n_joints, arm.n_joints, len(PARAMETERS), q.shape[1])
    torque = np.einsum("ispn,sp->in", per_unit, parameters_of(arm))
    expected = newton_euler_link.torque(arm, q, qd, qdd)
    # Inertia about the origin is that about the centre of mass and m r r, taken off again by the first
    # moments' share: twice the bound of either program, and each is off by as much as two formulations are.
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["torque"]
    assert np.abs(torque - expected).max() <= 8 * bound


@examples(25)
@given(arms_with_states(max_joints=6))
def test_it_is_pinocchios(case):
    """Column by column; Pinocchio's are of the joint's frame, in which our parameters are moved ones."""
    arm, states = case
    ours = np.moveaxis(regressor(arm, *states.last), -1, 0)
    model = pinocchio_model(arm)
    data = model.createData()
    moved = np.array([into_joint_frame(link.frame) for link in arm.links])
    # Some 20 roundings per joint of what a row adds up, here and there, and of moving a column.
    allowed = 80 * arm.n_joints * EPS * size(arm, states)
    for found, q, qd, qdd in zip(ours, states.q, states.qd, states.qdd, strict=True):
        theirs = pin.computeJointTorqueRegressor(model, data, q, qd, qdd)
        columns = theirs.reshape(arm.n_joints, arm.n_joints, 10)
        assert np.abs(np.einsum("isk,skp->isp", columns, moved) - found).max() <= allowed


def into_joint_frame(placement: Placement) -> FloatArray:
    """Parameters in the joint's frame from those in the link's, (10, 10), by 4x4 pseudo-inertias."""
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = placement.rotation, placement.translation
    return np.column_stack([of_pseudo(frame @ pseudo(unit) @ frame.T) for unit in np.eye(10)])


def pseudo(parameters: FloatArray) -> FloatArray:
    mass, *first = parameters[:4]
    xx, xy, yy, xz, yz, zz = parameters[4:]
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    out = np.empty((4, 4))
    out[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    out[:3, 3] = out[3, :3] = first
    out[3, 3] = mass
    return out


def of_pseudo(matrix: FloatArray) -> FloatArray:
    second = matrix[:3, :3]
    return inertial_parameters(matrix[3, 3], matrix[:3, 3], np.trace(second) * np.eye(3) - second)
