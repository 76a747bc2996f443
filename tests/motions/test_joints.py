"""What names of columns say, and which joint of the log is which of the arm; never silently by place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.names import column_name
from log_arms import UR, arm_of, log_of

# Names by role and kind; the last digit is the joint's number.
NUMBERED = {
    ("q", ""): "q1, state.q[0], points[0].positions[1], Position1, pos_joint1, joint_3, theta_4, A6, "
    "Joint 2 [deg], fer_joint2_pos, joint_a1, E1",
    ("qd", ""): "qd1_deg, state.dq[6], field.velocity3, joint_1_vel, q_dot_2 (rad/s)",
    ("torque", ""): "state.tau_J[2], TorqueCur3",
    ("q", "measured"): "actual_q_0, AXIS_ACT_A5",
    ("qd", "measured"): "actual_qd_5, /controller/state/actual/velocities[2]",
    ("q", "target"): "state.q_d[0], /controller/state/desired/positions[2], PositionCmptd7, qdes1",
    ("qd", "target"): "state.dq_d[6]",
    ("qdd", "target"): "target_qdd_3, state.ddq_d[0], AccCmptd2",
    ("torque", "target"): "target_moment_0, state.tau_J_d[2]",
}
LABELS = {"E1": ("e",), "fer_joint2_pos": ("fer",), "joint_a1": ("a",)}
UNITS = {"qd1_deg": "deg", "Joint 2 [deg]": "deg", "q_dot_2 (rad/s)": "rad/s"}
# Role, number of the arm's joint or label of others.
NAMED_JOINTS = {
    "/joint_states/shoulder_pan_joint/position": ("q", 0, ()),
    "/joint_states/wrist_2_joint/effort": ("torque", 4, ()),
    "wrist_1_joint.accelerations": ("qdd", 3, ()),
    "elbow_joint": ("q", 2, ()),
    "torque_s": ("torque", None, ("s",)),
    "shoulder velocity": ("qd", None, ("shoulder",)),
}
TIMES = {
    **dict.fromkeys(("time", "__time", "%time", "timestamp", "time_from_start", "t"), ("time", "")),
    **{"field.header.stamp": ("time", ""), "Time [s]": ("time", "s"), "time_ms": ("time", "ms")},
    **{"stamp_ns": ("time", "ns"), "/joint_states/header/stamp/sec": ("sec", ""), "sample": ("index", "")},
    **dict.fromkeys(("/joint_states/header/stamp/nanosec", "nsecs"), ("nanosec", "")),
}
# Of nothing that is wanted.
OTHERS = (
    "actual_TCP_pose_0 actual_TCP_speed_2 joint_temperatures_3 speed_scaling Temp1 "
    "state.tau_ext_hat_filtered[0] state.dtau_J[0] state.O_T_EE[3] state.joint_contact[1] "
    "header.frame_id points[1].positions[0] /controller/state/error/positions[0] torque_limit_1 "
    "elbow_joint_enabled"
)


def test_what_names_say():
    known = JointNames.of(UR)
    for role_and_kind, names in NUMBERED.items():
        for name in names.split(", "):
            meaning = column_name(name, known)
            assert (meaning.role, meaning.kind) == role_and_kind, name
            number = int([sign for sign in name if sign.isdigit()][-1])
            assert (meaning.number, meaning.joint) == (number, None), name
            assert (meaning.label, meaning.unit) == (LABELS.get(name, ()), UNITS.get(name, "")), name
    for name, (role, joint, label) in NAMED_JOINTS.items():
        meaning = column_name(name, known)
        assert (meaning.role, meaning.joint, meaning.label, meaning.number) == (role, joint, label, None), (
            name
        )
    for name in [*TIMES, *OTHERS.split(), ""]:
        meaning = column_name(name, known)
        assert (meaning.role, meaning.unit) == TIMES.get(name, ("other", "")), name


PANDA = [f"panda_joint{k}" for k in range(1, 4)]


@pytest.mark.parametrize(
    ("names", "arm", "order"),
    [
        ("q1 q2 q3", PANDA, [0, 1, 2]),
        ("q0 q1 q2", PANDA, [0, 1, 2]),
        ("q3 q1 q2", UR[:3], [1, 2, 0]),
        ("panda_joint3 panda_joint1 panda_joint2", PANDA, [1, 2, 0]),
        ("panda_joint3_pos finger_joint1_pos panda_joint1_pos panda_joint2_pos", PANDA, [2, 3, 0]),
        ("elbow_joint shoulder_lift_joint shoulder_pan_joint", UR[:3], [2, 1, 0]),
        ("elbow/position shoulder_lift/position shoulder_pan/position", UR[:3], [2, 1, 0]),
        ("elbow_joint/position pan_joint/position", ["left_pan_joint", "left_elbow_joint"], [1, 0]),
        ("r1_elbow_joint.pos r1_pan_joint.pos r1_grip_joint.pos", ["pan_joint", "elbow_joint"], [1, 0]),
        ("joint_1 joint_2 joint_3 joint_4", ["joint_2", "joint_4"], [1, 3]),
        ("q0 q1 q2 q3", ["joint2", "joint4"], [1, 3]),
        ("J1 J2", ["1", "2"], [0, 1]),
        ("angle", ["hip"], [0]),
        ("wrist_3_joint wrist_1_joint wrist_2_joint", UR[3:], [1, 2, 0]),
    ],
)
def test_matched(names, arm, order, read):
    np.testing.assert_array_equal(read(log_of(names), arm_of(*arm)).q[0], order)


def test_other_names_that_count_are_matched_by_number_and_said_so(read, warned):
    with warned() as texts:
        logged = read(log_of("fer_joint2_pos fer_joint1_pos fer_joint3_pos"), arm_of(*PANDA))
    np.testing.assert_array_equal(logged.q[0], [1, 0, 2])
    (text,) = texts
    assert all(f"fer_joint{k}_pos is panda_joint{k}" in text for k in (1, 3))
    assert "--map 'q=fer_joint*_pos'" in text


def test_as_the_user_says(read, warned):
    mapping = ["joints=arm_a2,arm_a3,arm_a1"]
    with warned() as texts:
        logged = read(log_of("arm_a1 arm_a2 arm_a3"), arm_of(*UR[:3]), map=mapping)
    np.testing.assert_array_equal(logged.q[0], [1, 2, 0])
    assert not texts
    text = "clock,a,b,c,q1,q2\n0,1,2,5,3,4\n0.5,1,2,5,3,4\n"
    logged = read(text, arm_of("hip", "knee"), map=["time=clock", "q:knee=a", "qd:hip=#3", "qd:2=c"])
    np.testing.assert_array_equal(logged.q[0], [3, 1])
    np.testing.assert_array_equal(logged.qd[0], [2, 5])
    text = "time,q1,qd1,tau1\n0,1,2,3\n0.5,1,2,3\n"
    assert read(text, arm_of("hip"), map=["qd=none"]).qd is None
    assert read(text, arm_of("hip"), map=["qd:hip=qd1", "qd=none"]).qd is None
    assert read(text, arm_of("hip")).qd is not None


def test_what_is_set_beside_log_of(read):
    text = "time,/left/hip/position,/left/knee/position,/right/hip/velocity,/right/knee/velocity\n"
    logged = read(text + "0,1,2,3,4\n0.1,1,2,3,4\n", arm_of("hip", "knee"))
    np.testing.assert_array_equal(logged.q[0], [1, 2])
    assert logged.qd is None  # of another topic
    text = "time,q1,q2,torque_sensor1,torque_sensor2\n0,1,2,3,4\n1,1,2,3,4\n"
    np.testing.assert_array_equal(read(text, arm_of(*UR[:2]), map=["time=1Hz"]).torque[0], [3, 4])
    for word in ("model", "ff", "gravity", "residual"):  # worked out, no reading
        assert read(f"time,q1,tau_{word}_1\n0,1,2\n0.1,1,2\n", arm_of("hip")).torque is None


def test_more_joints_than_the_arm_has_are_told(read, warned):
    with warned() as texts:
        logged = read(log_of("pos_0 pos_1 pos_2"), arm_of("hip", "knee"))
    np.testing.assert_array_equal(logged.q[0], [0, 1])
    (text,) = texts
    assert all(fact in text for fact in ("3 joints", "2 in arm made", "pos_2"))
    assert "pos_1" not in text


NAMED = "time,name[0],name[1],position[0],position[1]\n0.0,knee,hip,1,2\n0.1,,,3,4\n"


def test_names_in_cells(read, refused):
    logged = read(NAMED + "0.2,knee,hip,5,6\n", arm_of("hip", "knee"))
    np.testing.assert_array_equal(logged.q, [[2, 1], [4, 3], [6, 5]])
    # Messages of two senders, or of one that sorts anew, would be read in the order of the first.
    later = "".join(f"{0.1 * k},knee,hip,1,2\n" for k in range(2, 300))  # beyond what the head shows
    refused("line 302, column 2", NAMED + later + "30.0,hip,knee,1,2\n", arm_of("hip", "knee"))


TWO_TOPICS = " ".join(
    f"/{side}/joint_states/{joint}/position" for side in ("left", "right") for joint in UR[:2]
)
TWICE = log_of("position_1 position_2 position_2")
TWO_TORQUES = "time,q1,tau_a_1,tau_b_1\n0,1,2,3\n0.1,1,2,3\n"
# Content, names of joints, what is asked for, and what the message must name.
CASES: dict[str, tuple[str, Sequence[str], dict[str, object], str]] = {
    "names that disagree": (log_of("joint_a1 joint_a2 joint_a3"), UR[:3], {}, "found: joint_a1, joint_a2"),
    "a joint too few": (log_of("q1 q2"), UR[:3], {}, "--map q:elbow_joint=COLUMN"),
    "two topics": (
        log_of(TWO_TOPICS),
        UR[:2],
        {},
        "--map 'q=/left/joint_states/*/position' or --map 'q=/right/joint_states/*/position'",
    ),
    "two torques": (TWO_TORQUES, ["joint1"], {}, "--map 'torque=tau_a_*' or --map 'torque=tau_b_*'"),
    "a name twice": (TWICE, UR[:2], {}, "line 1, column 4"),
    "nothing known": ("time,alpha,beta\n0,1,2\n", UR[:2], {}, "--map q=alpha,beta"),
    "no such pattern": (
        log_of("actual_q_0 target_q_0"),
        ["hip"],
        {"map": ["q=planned_*"]},
        "no column 'planned_*'",
    ),
    "a joint's name too few": (log_of("a b"), UR[:2], {"map": ["joints=a"]}, "joints: 1 names"),
    "no such column": (log_of("Position1"), ["hip"], {"map": ["time=Postion1"]}, "--map; "),
    "a column for two joints": (
        log_of("a b"),
        UR[:2],
        {"map": ["q:1=a", "q:2=a"]},
        "q shoulder_pan_joint and q shoulder_lift_joint",
    ),
    "a column for two": (log_of("q1 q2"), UR[:2], {"map": ["q:1=q2"]}, "line 1, column 3"),
    "time for a joint": (log_of("q1"), ["hip"], {"map": ["q:hip=time"]}, "time and q hip"),
    "a column of two": ("time,a,a\n0,1,2\n1,1,2\n", ["hip"], {"map": ["q:hip=a"]}, "#2"),
    "no such joint": (log_of("q1"), ["hip"], {"map": ["q:hipp=q1"]}, "did you mean hip?"),
    "no such role": (log_of("q1"), ["hip"], {"map": ["speed:hip=q1"]}, "with :JOINT"),
    "some joints only": (log_of("q1 q2 a"), UR[:2], {"map": ["qd:1=a"]}, "--map qd:shoulder_lift_joint="),
    "degrees of a joint that slides": (log_of("q1_deg q2"), ["slide", "turn"], {}, "line 1, column 2"),
    "a list that is too short": (
        log_of("q1 q2 a"),
        UR[:2],
        {"map": ["q=q1"]},
        "q is given for some joints only",
    ),
    "a long line": ("time,q_0\n0,1\n1,2,3\n2\n", ["hip"], {}, "line 3, column 3"),
    "a short line of blanks": ("time q_0\n0 1\n1\n", ["hip"], {}, "line 3, column 2"),
    "names that change": ("1,2,,a,b,1,2\n1,3,,a,b,1,2\n1,4,,b,a,1,2\n", ["a", "b"], {}, "line 3, column 4"),
    "a name of a page": ("time," + "q" * 300 + "\n0,1\n", ["hip"], {}, "column 2"),
}


@pytest.mark.parametrize("case", CASES)
def test_refusals(case, refused):
    content, names, asked, says = CASES[case]
    kinds = ["prismatic" if name == "slide" else "revolute" for name in names]
    refused(says, content, arm_of(*names, kinds=kinds), **asked)


def test_what_the_messages_advise_settles_it(read):
    np.testing.assert_array_equal(
        read(log_of(TWO_TOPICS), arm_of(*UR[:2]), map=["q=/right/joint_states/*/position"]).q[0], [2, 3]
    )
    np.testing.assert_array_equal(read(TWO_TORQUES, arm_of("joint1"), map=["torque=tau_b_*"]).torque[0], [3])
    logged = read(TWICE, arm_of(*UR[:2]), map=["q:shoulder_lift_joint=#4"])
    np.testing.assert_array_equal(logged.q[0], [0, 2])


RAIL = ["rail", "joint_a1", "joint_a2"]


@pytest.mark.parametrize(
    ("names", "arm", "order"),
    [
        ("E1 A1 A2", RAIL, [0, 1, 2]),
        ("A1 A2 E1", RAIL, [2, 0, 1]),
        ("AXIS_ACT_A1 AXIS_ACT_A2 AXIS_ACT_E1", RAIL, [2, 0, 1]),
        ("joint_a2 joint_a1 E1", RAIL, [2, 1, 0]),
        ("rail A2 A1", RAIL, [0, 2, 1]),
        ("E1 A1 A2 A3", RAIL, [0, 1, 2]),  # an arm whose tip is chosen
        ("joint_e1 joint_a1 joint_a2", ["joint_e1", "joint_a1", "joint_a2"], [0, 1, 2]),
        ("slide_pos pos0 pos1", ["slide", "panda_joint1", "panda_joint2"], [0, 1, 2]),
    ],
)
def test_a_rail_below_numbered_joints_takes_none_of_their_numbers(names, arm, order, read, warned):
    kinds = ["prismatic", "revolute", "revolute"]
    with warned() as texts:
        logged = read(log_of(names), arm_of(*arm, kinds=kinds))
    np.testing.assert_array_equal(logged.q[0], order)
    assert any("E1" in text and "--map q:rail=" in text for text in texts) == ("E1" in names)


def test_a_rail_that_the_log_lacks_is_missed_and_no_joint_is_moved_to_it(refused):
    kinds = ["prismatic", "revolute", "revolute"]
    for names in ("A1 A2 A3", "pos1 pos2", "joint_a1 joint_a2"):
        refused("no position of joint rail", log_of(names), arm_of(*RAIL, kinds=kinds))


@pytest.mark.parametrize(
    ("role", "column", "kind"),
    [
        *(("q", "pos1_deg", "prismatic"), ("q", "pos1 [mm]", "revolute"), ("qd", "vel1 [rpm]", "prismatic")),
        *(("torque", "tau1 [Nm]", "prismatic"), ("torque", "tau1 [N]", "revolute")),
    ],
)
def test_a_unit_that_contradicts_the_kind_of_its_joint_is_refused(role, column, kind, refused):
    names = column if role == "q" else f"pos1,{column}"
    values = ",".join("1" for _ in names.split(","))
    text, arm = f"time,{names}\n0,{values}\n0.1,{values}\n", arm_of("axis", kinds=[kind])
    refused(f"is {kind}", text, arm)
    refused(f"is {kind}", text, arm, map=[f"{role}:1={column}"])


def test_the_printed_names_of_joints_are_those_of_the_columns(refused):
    """Words of the kind stand among those of the joint; the names are typed by `refused`."""
    strangers = "left_ACT_hip_joint left_ACT_knee_joint left_ACT_foot_joint"
    advice = "--map joints=left_hip,left_knee,left_foot"
    refused(advice, log_of(strangers), arm_of(*UR[:3]))


def test_numbers_of_set_points_are_those_of_the_chain_and_a_notice_says_where_that_is_odd(read):
    arm = arm_of("joint_1", "joint_3", "joint_2")
    text = "time,q1,q2,q3\n0,1,2,3\n0.1,1,2,3\n"
    with pytest.warns(GdAnalyzeWarning, match="q2 is used for joint_3, joint 2 of the chain"):
        logged = read(text, arm)
    np.testing.assert_array_equal(logged.q[0], [1, 2, 3])


def test_a_column_given_beside_numbers_that_are_not_those_of_the_chain(read):
    arm = arm_of("joint_1", "joint_3", "joint_2")
    with pytest.warns(GdAnalyzeWarning, match="pos2 is used for joint_2, joint 3 of the chain"):
        logged = read(log_of("pos1 pos2 other"), arm, map=["q:joint_3=other"])
    np.testing.assert_array_equal(logged.q[0], [0, 2, 1])
