"""What the names of columns say: role, joint, number, unit, and whose value it is."""

from __future__ import annotations

import pytest
from log_arms import UR

from gd_analyze.motions.roles import known_joints, meaning_of

KNOWN = known_joints(UR)

# name: role, label of the joint, number, number of the arm's joint, kind, unit
NAMES = {
    "q1": ("q", (), 1, None, "plain", ""),
    "qd1_deg": ("qd", (), 1, None, "plain", "deg"),
    "actual_q_0": ("q", (), 0, None, "measured", ""),
    "actual_qd_5": ("qd", (), 5, None, "measured", ""),
    "target_qdd_3": ("qdd", (), 3, None, "target", ""),
    "target_moment_0": ("torque", (), 0, None, "target", ""),
    "state.q[0]": ("q", (), 0, None, "plain", ""),
    "state.q_d[0]": ("q", (), 0, None, "target", ""),
    "state.dq[6]": ("qd", (), 6, None, "plain", ""),
    "state.dq_d[6]": ("qd", (), 6, None, "target", ""),
    "state.ddq_d[0]": ("qdd", (), 0, None, "target", ""),
    "state.tau_J[2]": ("torque", (), 2, None, "plain", ""),
    "state.tau_J_d[2]": ("torque", (), 2, None, "target", ""),
    "/joint_states/shoulder_pan_joint/position": ("q", (), None, 0, "plain", ""),
    "/joint_states/wrist_2_joint/effort": ("torque", (), None, 4, "plain", ""),
    "wrist_1_joint.accelerations": ("qdd", (), None, 3, "plain", ""),
    "points[0].positions[1]": ("q", (), 1, None, "plain", ""),
    "field.velocity3": ("qd", (), 3, None, "plain", ""),
    "/controller/state/desired/positions[2]": ("q", (), 2, None, "target", ""),
    "/controller/state/actual/velocities[2]": ("qd", (), 2, None, "measured", ""),
    "Position1": ("q", (), 1, None, "plain", ""),
    "PositionCmptd7": ("q", (), 7, None, "target", ""),
    "AccCmptd2": ("qdd", (), 2, None, "target", ""),
    "TorqueCur3": ("torque", ("cur",), 3, None, "plain", ""),
    "pos_joint1": ("q", (), 1, None, "plain", ""),
    "joint_1_vel": ("qd", (), 1, None, "plain", ""),
    "joint_3": ("q", (), 3, None, "plain", ""),
    "fer_joint2": ("q", ("fer",), 2, None, "plain", ""),
    "theta_4": ("q", (), 4, None, "plain", ""),
    "A6": ("q", (), 6, None, "plain", ""),
    "Joint 2 [deg]": ("q", (), 2, None, "plain", "deg"),
    "q_dot_2 (rad/s)": ("qd", (), 2, None, "plain", "rad/s"),
    "qdes1": ("q", (), 1, None, "target", ""),
    "torque_s": ("torque", ("s",), None, None, "plain", ""),
    "joint_a1": ("q", ("a",), 1, None, "plain", ""),
    "elbow_joint": ("q", (), None, 2, "plain", ""),
    "shoulder velocity": ("qd", ("shoulder",), None, None, "plain", ""),
}


@pytest.mark.parametrize("name", NAMES)
def test_columns_of_joints(name: str) -> None:
    found = meaning_of(name, KNOWN)
    assert (found.role, found.label, found.number, found.joint, found.kind, found.unit) == NAMES[name]


TIMES = {
    **dict.fromkeys(("time", "__time", "%time", "timestamp", "time_from_start", "t"), ("time", "")),
    **{"field.header.stamp": ("time", ""), "Time [s]": ("time", "s"), "time_ms": ("time", "ms")},
    **{"stamp_ns": ("time", "ns"), "/joint_states/header/stamp/sec": ("sec", ""), "sample": ("index", "")},
    **dict.fromkeys(("/joint_states/header/stamp/nanosec", "nsecs"), ("nanosec", "")),
}
# Of nothing that is wanted.
OTHERS = [
    *(
        "Zeit",
        "actual_current_0",
        "actual_TCP_pose_0",
        "actual_TCP_speed_2",
        "joint_temperatures_3",
        "speed_scaling",
        "Temp1",
    ),
    *("Cur1", "state.tau_ext_hat_filtered[0]", "state.dtau_J[0]", "state.O_T_EE[3]"),
    *("state.joint_contact[1]", "header.frame_id", "points[1].positions[0]"),
    *("/controller/state/error/positions[0]", "torque_limit_1", "elbow_joint_enabled", "E1"),
]


@pytest.mark.parametrize("name", [*TIMES, *OTHERS, ""])
def test_other_columns(name: str) -> None:
    found = meaning_of(name, KNOWN)
    assert (found.role, found.unit) == TIMES.get(name, ("other", ""))
