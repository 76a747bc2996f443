"""A joint beside a word of unknown meaning is no position; one option gives such columns a role."""

from __future__ import annotations

import string
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gd_analyze import read_log, read_trajectory
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError, in_options
from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.names import column_name
from gd_analyze.motions.vocabulary import meanings_of
from log_arms import UR, arm_of, log_of
from remedies import remedies, typed

KUKA = [f"joint_a{k}" for k in range(1, 4)]
PANDA = [f"panda_joint{k}" for k in range(1, 4)]
# Where a word may stand beside a joint, with the joint's name or number.
PLACES = ("{word}.A{k}", "{word}_joint_{k}", "joint_{k}_{word}", "{word}{k}", "J{k}.{word}", "{word}/{name}")
ARMS = {"kuka": KUKA, "panda": PANDA, "ur": list(UR[:3])}


def log_with(names, more=()):
    """Columns of these names, with numbers that tell them apart."""
    columns = [*names, *more]
    rows = [[0.1 * row, *(np.sin(0.3 * row + k) + k for k in range(len(columns)))] for row in range(40)]
    return "\n".join(
        [",".join(["time", *columns]), *(",".join(map(repr, map(float, row))) for row in rows), ""]
    )


@example("macur", PLACES[0], "kuka")
@example("temp", PLACES[1], "ur")
@example("volt", PLACES[2], "panda")
@example("pwm", PLACES[3], "ur")
@example("robot", PLACES[5], "kuka")
@given(
    st.text(string.ascii_lowercase, min_size=3, max_size=7),
    st.sampled_from(PLACES),
    st.sampled_from(sorted(ARMS)),
)
def test_an_unknown_word_beside_a_joint_is_no_position(tmp_path_factory, word, place, kind):
    """Alone it is refused, and what the refusal prints reads it; beside positions it is left out."""
    arm, path = arm_of(*ARMS[kind]), tmp_path_factory.mktemp("unknown") / "log.csv"
    names = [place.format(word=word, k=k + 1, name=name) for k, name in enumerate(ARMS[kind])]
    is_of_motion = any(column_name(name, JointNames({})).role != "other" for name in names if "/" not in name)
    if is_of_motion or meanings_of((word,)):
        return  # a word that is known, such as "pos" or "robot"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        path.write_text(log_with(names, ["AIPos.A1", "AIPos.A2", "AIPos.A3"]))
        assert {use.column for use in read_log(path, arm).columns if use.role == "q"} == {
            f"AIPos.A{k}" for k in (1, 2, 3)
        }
        path.write_text(log_with(names))
        with pytest.raises(TrajectoryError) as caught:
            read_log(path, arm)
        options = [
            words for words, complete in remedies(in_options(caught.value.details["next"])) if complete
        ]
        if not options:  # a quantity that is known, and is no position: temperature, current
            assert not column_name(names[0], JointNames({})).is_unclear
            return
        (words,) = options
        assert len(words) == 2  # one option for all joints
        q = read_log(path, arm, typed(words)).q
    np.testing.assert_array_equal(q[0], [np.sin(k) + k for k in range(3)])


@pytest.mark.parametrize(
    ("names", "joints"),
    [
        (["J1_A", "J2_A", "J3_A"], KUKA),
        (["joint_1_a", "joint_2_a", "joint_3_a"], KUKA),
        (["A1_I", "A2_I", "A3_I"], KUKA),
        (["volt_pan_axis", "volt_lift_axis", "volt_elbow_axis"], ["pan_joint", "lift_joint", "elbow_joint"]),
        (["pan_volt", "lift_volt", "elbow_volt"], ["pan_joint", "lift_joint", "elbow_joint"]),
        (
            ["volt/pan_joint", "volt/lift_joint", "volt/elbow_joint"],
            ["pan_joint", "lift_joint", "elbow_joint"],
        ),
        (["actual_1", "actual_2", "actual_3"], PANDA),
        (["fer_joint1", "fer_joint2", "fer_joint3"], PANDA),
    ],
)
def test_letters_prefixes_and_topics_are_words_as_well(names, joints, refused):
    """The names of the arm's joints share letters and words with them; the option printed is typed."""
    refused("--map 'q=", log_with(names), arm_of(*joints))


def test_positions_and_set_points_of_a_telegram(read, warned):
    """As KUKA's RSI: actual and commanded axes, and motor currents, which must not be positions."""
    names = [f"{kind}.A{k}" for kind in ("MACur", "ASPos", "AIPos") for k in (1, 2, 3)]
    with warned() as texts:
        logged = read(log_with(names), arm_of(*KUKA))
    assert [(use.column, use.unit) for use in logged.columns if use.role == "q"] == [
        (name, "deg") for name in names[6:]
    ]
    assert logged.measured
    (text,) = texts
    assert "--map 'torque=MACur.A*'" in text
    with warned() as texts:
        planned = read(log_with(names), arm_of(*KUKA), map=["q=ASPos.A*"])
        logged = read(log_with(names), arm_of(*KUKA), map=["torque=MACur.A*:A"], torque_constant="2,3,4")
    assert [use.column for use in planned.columns if use.role == "q"] == names[3:6]
    np.testing.assert_allclose(logged.torque[0], [2 * np.sin(0), 3 * (np.sin(1) + 1), 4 * (np.sin(2) + 2)])
    assert [use.unit for use in logged.columns if use.role == "torque"] == ["A"] * 3
    assert not texts


def test_a_pattern_reads_names_numbers_and_units(read, warned):
    text = log_with([f"{name}_winkel" for name in UR[:3]])
    degrees = read(text, arm_of(*UR[:3]), map=["q=*_winkel:deg"])
    np.testing.assert_allclose(degrees.q[0], np.radians([np.sin(k) + k for k in range(3)]), rtol=1e-15)
    # Numbers from 0 as well, in any order, and a column of another quantity beside them is left out.
    logged = read(log_of("x2_pos x0_pos x1_pos x_pos"), arm_of(*UR[:3]), map=["q=x*_pos"])
    np.testing.assert_array_equal(logged.q[0], [1, 2, 0])
    # A star alone: joints by name, and the time stays the time.
    logged = read(log_of("elbow_joint shoulder_pan_joint shoulder_lift_joint"), arm_of(*UR[:3]), map=["q=*"])
    np.testing.assert_array_equal(logged.q[0], [1, 2, 0])
    # A rail in mm and an arm in degrees, by two patterns.
    rail = arm_of("rail", "joint_a1", "joint_a2", kinds=["prismatic", "revolute", "revolute"])
    with warned():
        logged = read(log_of("lin.E1 rot.A1 rot.A2"), rail, map=["q=lin.*:mm", "q=rot.*:deg"])
    np.testing.assert_allclose(logged.q[0], [0.0, np.radians(1), np.radians(2)], atol=1e-15)
    # A unit may be given for one column, for a list, and for the time.
    logged = read(
        "clock,a1,a2\n0,90,1\n2000,0,1\n", arm_of("hip", "knee"), map=["q=a1..a2:deg", "time=clock:us"]
    )
    np.testing.assert_allclose(logged.q[0], np.radians([90, 1]), rtol=1e-15)
    assert logged.time[1] == pytest.approx(0.002, rel=1e-15)


@pytest.mark.parametrize(
    ("names", "mapping", "says"),
    [
        ("foo1 foo2", ["q=foo*"], "no position of joint foot"),
        ("q1 q2 q3 foo1", ["torque=foo*"], "no torque of joint knee"),
        ("q1 q2 q3", ["torque=foo*"], "no column 'foo*'"),
        ("foo1 foo2 foo3", ["q=foo*:furlong"], "found: 'furlong'"),
        ("foo1 foo2 foo3", ["q=foo*:Nm"], "found: 'Nm'"),
        ("q1 q2 q3 cur1 cur2 cur3", ["torque=cur*:A"], "--torque-constant"),
        ("q1 q2 q3", ["time=q*"], "no column 'q*'"),
    ],
)
def test_patterns_that_do_not_fit(names, mapping, says, refused):
    refused(says, log_of(names), arm_of("hip", "knee", "foot"), map=mapping)


def test_torques_by_abbreviations(read, warned):
    """tq is torque; eff may be anything, and its option is printed."""
    arm = arm_of(*PANDA)
    positions = [f"actual_q_{k}" for k in range(3)]
    logged = read(log_with(positions, [f"measured_tq_{k}" for k in range(3)]), arm)
    assert logged.torque is not None
    for names in ([f"panda_joint{k}_eff" for k in (1, 2, 3)], [f"eff_{k}" for k in range(3)]):
        with warned() as texts:
            assert read(log_with(positions, names), arm).torque is None
        ((words, complete),) = remedies(texts[0])
        assert complete
        with warned() as texts:
            path_log = read(log_with(positions, names), arm, map=[words[1]])
        np.testing.assert_array_equal(path_log.torque[0], [np.sin(k) + k for k in (3, 4, 5)])
        assert not texts


def test_commands_of_demonstrations(read):
    """action.X.pos beside X.pos, as in data sets of demonstrations; in a topic, action is no command."""
    names = [f"{of}{name}.pos" for of in ("", "action.") for name in UR[:2]]
    assert [
        use.column for use in read(log_of(" ".join(names)), arm_of(*UR[:2])).columns if use.role == "q"
    ] == names[:2]
    commanded = read(log_of(" ".join(names)), arm_of(*UR[:2]), map=["q=action.*.pos"])
    assert [use.column for use in commanded.columns if use.role == "q"] == names[2:]
    assert not commanded.measured
    topic = "/arm/follow/_action/feedback/actual/positions"
    assert read(log_of(f"{topic}[0] {topic}[1]"), arm_of(*UR[:2])).measured


def test_one_angle_in_two_units(read, refused, warned):
    """Degrees beside radians of the same names are the same angle, said once; other names are asked for."""
    q = np.array([[0.1 * k, 1.0 - 0.1 * k] for k in range(10)])
    table = np.column_stack([np.arange(10) * 0.1, np.degrees(q), q])
    rows = "\n".join([*(",".join(f"{x:.8g}" for x in row) for row in table), ""])
    header = "t,q0_deg,q1_deg,q0_rad,q1_rad\n"
    for text in (header + rows, "# joint path\n# columns: " + header + rows):
        with warned() as texts:
            logged = read(text, arm_of("hip", "knee"))
        np.testing.assert_allclose(logged.q, q, rtol=1e-7, atol=1e-12)
        (said,) = texts
        assert "q0_deg" in said
        assert "q0_rad" in said
    with warned():
        logged = read(header + rows, arm_of("hip", "knee"), map=["q=q*_deg"])
    np.testing.assert_allclose(logged.q, q, rtol=1e-7, atol=1e-7)
    named = header.replace("q0_rad,q1_rad", "position_0,position_1") + rows
    refused("--map 'q=q*_deg' or --map 'q=position_*'", named, arm_of("hip", "knee"))


def test_degrees_of_positions_alone_are_told_by_one_option(log, warned):
    """Beside velocities in rad/s, whose unit is another; the option is typed as it is printed."""
    time = 0.004 * np.arange(1000)
    q = np.column_stack([0.8 * np.sin(2.0 * time + k) for k in range(2)])
    qd = np.column_stack([1.6 * np.cos(2.0 * time + k) for k in range(2)])
    joints = tuple(replace(joint, lower=-2.0, upper=2.0) for joint in arm_of("hip", "knee").joints)
    arm = replace(arm_of("hip", "knee"), joints=joints)
    for names in ("J1.pos,J2.pos", "hip.pos,knee.pos", "actual_q_0,actual_q_1"):
        header = ",".join(["stamp", names, names.replace(".pos", ".vel").replace("_q_", "_qd_")])
        table = np.column_stack([time, np.degrees(q), qd])
        path = log("\n".join([header, *(",".join(map(repr, row)) for row in table.tolist()), ""]))
        with warned() as texts:
            read_trajectory(path, arm)
        (option,) = {
            words[1]
            for text in texts
            for words, _ in remedies(text)
            if "--map" in words and "NAME" not in text
        }
        with warned() as texts:
            motion = read_trajectory(path, arm, typed(["--map", option]))
        assert not texts
        assert np.abs(motion.q - q).max() < 0.01  # smoothed


def test_joints_of_the_log_of_which_some_have_numbers(read):
    """w1 to w3 are no first joints where three others stand before them."""
    words = ("base", "shoulder", "elbow", "w1", "w2", "w3")
    with pytest.raises(TrajectoryError) as caught:
        read(log_with([f"pos_{word}" for word in words]), arm_of(*(f"j{k}" for k in range(1, 7))))
    names = "base,shoulder,elbow,w_1,w_2,w_3"
    assert caught.value.details["next"].endswith(f"`map='joints={names}'`")
    logged = read(
        log_with([f"pos_{word}" for word in words]), arm_of(*names.split(",")), map=[f"joints={names}"]
    )
    assert [use.column for use in logged.columns if use.role == "q"] == [f"pos_{word}" for word in words]


def test_joints_that_have_the_arms_names_are_not_renamed(read):
    """The flange alone is unknown: the others keep their joints."""
    names = [f"joint_a{k}" for k in range(1, 7)]
    with pytest.raises(TrajectoryError) as caught:
        read(log_with(["flange_pos", *(f"{name}_pos" for name in names[:5])]), arm_of(*names))
    assert "joints=" not in caught.value.details["next"]
    assert "`map='q:joint_a6=COLUMN'`" in caught.value.details["next"]
