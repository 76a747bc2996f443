"""Logs in text files, however they are laid out: the numbers that come out, in SI units and by joint."""

from __future__ import annotations

import numpy as np
import pytest

from gd_analyze import read_log
from gd_analyze.errors import TrajectoryError
from log_arms import UR, arm_of, log_of
from told import Told

TWO = arm_of("hip", "knee")
TIME = np.arange(6) * 0.008
Q = np.column_stack([0.1 * np.arange(6) - 0.2, 1.0 / (1.0 + np.arange(6))])
QD = np.column_stack([np.full(6, 12.5), -np.arange(6) * 0.3])


def rows(*columns):
    return "".join(",".join(map(repr, row)) + "\n" for row in np.column_stack(columns).tolist())


BODY = rows(TIME, Q, QD)
TEXT = "t,hip_pos,knee_pos,hip_vel,knee_vel\n" + BODY
QUOTED = "".join(",".join(f'"{cell}"' for cell in line.split(",")) + "\n" for line in TEXT.split())
NOTED = (f"auto,{a},20,{b},ok\n" for a, b in zip(rows(TIME, Q).split(), rows(QD).split(), strict=True))
LAYOUTS = {
    "comma": TEXT,
    "semicolon": TEXT.replace(",", ";"),
    "tab": TEXT.replace(",", "\t"),
    "blanks": "  " + TEXT.replace(",", "   ").replace("\n", "\n  "),
    "decimal comma": TEXT.replace(",", ";").replace(".", ","),
    "decimal comma in quotes": QUOTED.replace(".", ","),
    "quotes": QUOTED,
    "comments": "# a robot\n\n" + TEXT.replace("\n0.016", "\n# here\n\n0.016"),
    "savetxt": "# " + TEXT.replace(",", " "),
    "CRLF": TEXT.replace("\n", "\r\n"),
    "CR": TEXT.replace("\n", "\r"),
    "byte order mark": "\ufeff" + TEXT,
    "no end": TEXT.rstrip("\n"),
    "a comma at the end": TEXT.replace("\n", ",\n"),
    "another order": "knee_vel,t,hip_pos,knee_pos,hip_vel\n" + rows(QD[:, 1], TIME, Q, QD[:, 0]),
    "extra columns": "mode,t,hip_pos,knee_pos,temp1,hip_vel,knee_vel,note\n" + "".join(NOTED),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts(layout, read):
    logged = read(LAYOUTS[layout], TWO)
    # Every digit is written, and read as it stands; of decimal commas pandas may miss the last place.
    ulp = 4 * np.finfo(float).eps if layout.startswith("decimal comma") else 0.0
    np.testing.assert_allclose(logged.time, TIME, rtol=ulp, atol=0)
    np.testing.assert_allclose(logged.q, Q, rtol=ulp, atol=0)
    np.testing.assert_allclose(logged.qd, QD, rtol=ulp, atol=0)
    assert (logged.qdd, logged.torque, logged.measured) == (None, None, True)


def test_blocks_are_put_together(log):
    """Files of tens of megabytes are read piece by piece."""
    lines = ["time [s],q1_deg,q2_deg" + "".join(f",note{k}" for k in range(300))]
    lines += [f"{k}.5,-0.1234567890123456789,0.25" + ",x" * 300 for k in range(14_000)]
    path = log("\n".join([*lines, "# here\n\n14000.5,0.5,0.25" + ",x" * 300, ""]))
    told = Told()
    logged = read_log(path, TWO, progress=told)
    np.testing.assert_array_equal(logged.time, np.arange(14_001.0))
    np.testing.assert_allclose(np.degrees(logged.q[[0, -1], 0]), [-0.1234567890123456789, 0.5], rtol=1e-15)
    size = path.stat().st_size
    assert told.stages == [("reading", size)]
    assert len(told.steps[0]) > 2
    assert sum(told.steps[0]) == size
    path.write_text(path.read_text().replace("\n14000.5,0.5", "\n14000.5,x"))
    with pytest.raises(TrajectoryError, match="line 14004, column 2"):
        read_log(path, TWO)


def test_empty_cells_are_no_numbers(read):
    logged = read(
        "time,hip,knee,tau1,tau2\n0,,0.5,1,2\n0.1,0.2,nan,3,NA\n,7,7,7,7\n0.3,,,5,6\n0.4,0.4,0.6,,8\n", TWO
    )
    np.testing.assert_array_equal(logged.time, [0.0, 0.1, 0.4])
    np.testing.assert_array_equal(logged.q, [[np.nan, 0.5], [0.2, np.nan], [0.4, 0.6]])
    np.testing.assert_array_equal(logged.torque, [[1, 2], [3, np.nan], [np.nan, 8]])
    assert "left out: 2" in logged.columns[0].why


TURN = 2 * np.pi
UNITS = {
    "in names": (
        "Time [ms],Joint 1 [deg],Joint 2 (deg),speed_1 [rpm],speed_2 [deg/s]\n0,90,180,60,45\n8,0,0,0,0\n",
        {"q": [TURN / 4, TURN / 2], "qd": [TURN, TURN / 8]},
    ),
    "of motors": (
        "t [ms],q1 [turns],q2 [turns],tau1 [Ncm],tau2 [Ncm]\n0,0.25,1,100,50\n8,0,0,0,0\n",
        {"q": [TURN / 4, TURN], "torque": [1, 0.5]},
    ),
    "below names": (
        "t;pos1;pos2;tau1;tau2;note\nms;deg;°;Nm;mNm;-\n5;90;180;1;2;x\n13;45;0;3;4;y\n",
        {"q": [TURN / 4, TURN / 2], "torque": [1, 0.002]},
    ),
}


@pytest.mark.parametrize("case", UNITS)
def test_units(case, read):
    content, expected = UNITS[case]
    logged = read(content, TWO)
    np.testing.assert_allclose(logged.time, [0, 0.008], rtol=1e-15)
    for role in ("q", "qd", "torque"):
        values = getattr(logged, role)
        assert (values is not None) == (role in expected)
        if values is not None:
            np.testing.assert_allclose(values[0], expected[role], rtol=1e-15)


@pytest.mark.parametrize(
    ("role", "name", "size"),
    [
        *(
            ("q", name, TURN / 360)
            for name in ("q_deg_1", "q1Deg", "angleDeg_1", "deg.J1", "q1/deg", "Deg J1")
        ),
        *(
            ("qd", name, TURN / 360)
            for name in ("qd_deg_s_1", "vel_deg_per_s_1", "qd1_deg/s", "velocity_degps_1")
        ),
        *(("qd", name, TURN / 60) for name in ("vel_rpm_1", "speed1 [rpm]")),
        *(("torque", name, 1e-3) for name in ("tau_mNm_1", "tau1/mNm", "tau1[Nmm]", "torque_1_mNm")),
        *(("torque", name, 1.0) for name in ("tau_Nm_1", "TAU1 [NM]", "tau1 [N*m]")),
        *(("torque", name, None) for name in ("tau1 [MNm]", "tau1 [furlong]", "torque_pct_1", "tau1 [mA]")),
        *(("qd", name, None) for name in ("vel_counts_1", "qd1 [furlong]", "qd1 [Nm]")),
    ],
)
def test_a_unit_stands_anywhere_in_a_name_and_an_unknown_one_is_not_read(role, name, size, read, warned):
    positions = f"{name},{name.replace('1', '2')}" if role == "q" else "hip,knee"
    others = "" if role == "q" else f",{name},{name.replace('1', '2')}"
    cells = ",3,4" if others else ""
    with warned() as texts:
        logged = read(f"t,{positions}{others}\n0,3,4{cells}\n0.1,3,4{cells}\n", TWO)
    values = getattr(logged, role)
    if size is None:
        assert values is None
        assert any(name in text for text in texts) == (role == "torque")
    else:
        np.testing.assert_allclose(values[0], [3 * size, 4 * size], rtol=1e-15)


def test_an_unknown_unit_of_positions_is_stated_by_one_option(refused, read):
    for unit in ("furlong", "Mrad"):
        text = f"t,q1 [{unit}],q2 [{unit}]\n0,1,2\n0.1,1,2\n"
        refused(f"is in {unit}", text, TWO)  # and what is printed is typed
        logged = read(text, TWO, map=[f"q=q* [{unit}]:deg"])
        np.testing.assert_allclose(logged.q[0], np.radians([1, 2]), rtol=1e-15)


@pytest.mark.parametrize("unit", ["ticks", "counts", "increments", "grad", "‰"])
def test_positions_in_units_that_are_not_known_are_none(unit, read, refused, warned):
    """Rates beside them must not let them pass for radians."""
    text = f"t,J1 pos [{unit}],J2 pos [{unit}],J1 vel,J2 vel\n0,1,2,3,4\n0.1,1,2,3,4\n"
    refused("no column is recognized as a joint position", text, TWO)
    with warned() as texts:
        assert read(f"t,q1,q2,tau1 [{unit}],tau2 [{unit}]\n0,1,2,3,4\n0.1,1,2,3,4\n", TWO).torque is None
    (text,) = texts
    assert f"tau1 [{unit}]" in text


def test_as_said(read):
    rail = arm_of("turn", "slide", kinds=["revolute", "prismatic"])
    logged = read("time,q0,q1,tau0,tau1\n0,90,0.25,3,4\n0.1,180,0.5,5,6\n", rail, map=["q=:deg"])
    np.testing.assert_allclose(logged.q, [[np.pi / 2, 0.25], [np.pi, 0.5]], rtol=1e-15)
    np.testing.assert_array_equal(logged.torque, [[3, 4], [5, 6]])
    assert [use.unit for use in logged.columns] == ["s", "deg", "m", "N m", "N"]
    body = "0,7,1,2\n0.1,7,3,4\n"  # without names
    logged = read(body, TWO, map=["time=#1", "q=#3..#4"])
    np.testing.assert_array_equal(logged.q, [[1, 2], [3, 4]])
    assert logged.measured
    text = "time,q_a_1,q_a_2,q_b_1,q_b_2\n0,1,2,3,4\n0.1,1,2,3,5\n"
    for asked in ("q=q_b_*", "q=q_b_1,q_b_2", "q=q_b_1..q_b_2", "q=#4..#5"):
        logged = read(text, arm_of("joint1", "joint2"), map=[asked])
        np.testing.assert_array_equal(logged.q, [[3, 4], [3, 5]])


def test_joint_states_of_plotjuggler(read):
    kinds = ("position", "velocity", "effort")
    names = [f"/joint_states/{name}/{kind}" for kind in kinds for name in reversed(UR)]
    stamp = [f"/joint_states/header/stamp/{field}" for field in ("sec", "nanosec")]
    values = np.arange(36.0).reshape(2, 18)
    lines = [",".join(["__time", *stamp, *names])]
    for k, row in enumerate(values):
        lines.append(f"{1.7e9 + 0.008 * k:.3f},1700000000,{8000000 * k},{','.join(map(str, row))}")
    logged = read("\n".join(lines), arm_of(*UR))
    np.testing.assert_array_equal(logged.q, values[:, 5::-1])
    np.testing.assert_array_equal(logged.qd, values[:, 11:5:-1])
    np.testing.assert_array_equal(logged.torque, values[:, 17:11:-1])
    # 1700000000.008 - 1700000000, from its digits: a double of that size is off by 1e-7 s.
    assert abs(logged.time[1] - 0.008) < 1e-15


def test_rostopic_echo(read):
    fields = "header.seq header.stamp header.frame_id name0 name1 position0 position1 velocity0 velocity1"
    header = ",".join(["%time", *(f"field.{of}" for of in f"{fields} effort0 effort1".split())])
    lines = [
        f"{15 * 10**17 + k * 8000123},{k},{15 * 10**17 + k * 8000000},,knee,hip,{k},{10 + k},1,2,3,4"
        for k in range(3)
    ]
    logged = read("\n".join([header, *lines, ""]), TWO)
    np.testing.assert_array_equal(logged.q, [[10, 0], [11, 1], [12, 2]])  # by the names in the rows
    np.testing.assert_array_equal(logged.torque[0], [4, 3])
    np.testing.assert_allclose(logged.time, [0, 0.008, 0.016], rtol=1e-15)  # the message's stamp


def test_ros2_topic_echo_csv(read):
    text = "".join(f"1700000000,{k * 8000001},base,knee,hip,{k},{10 + k},,3,4\n" for k in range(3))
    logged = read(text, TWO)
    np.testing.assert_array_equal(logged.q, [[10, 0], [11, 1], [12, 2]])
    assert logged.qd is None
    np.testing.assert_array_equal(logged.torque[0], [4, 3])
    np.testing.assert_allclose(logged.time, [0, 0.008000001, 0.016000002], rtol=1e-15)


def test_an_echoed_row_that_breaks_off_is_corrupt(read, warned):
    text = "".join(f"1700000000,{k * 8000000},base,knee,hip,{k},1,2,3,4,5\n" for k in range(3))
    with warned() as texts:
        logged = read(text + "1700000000,24000000,base,kn", TWO, drop_rows=True)
    (text,) = texts
    assert "line 4" in text
    np.testing.assert_array_equal(logged.q, [[1, 0], [1, 1], [1, 2]])


@pytest.mark.parametrize("name", ["states.yaml", "states.yml", "echo.txt"])
def test_echoed_yaml_is_sent_to_a_bag(refused, name):
    text = "header:\n  stamp:\n    sec: 1\n    nanosec: 0\nname: [knee, hip]\nposition: [0.1, 0.5]\n---\n"
    refused("`ros2 topic echo --csv`", text * 3, TWO, name)


def test_rtde_takes_what_was_measured(read, warned):
    kinds = "actual_q target_q actual_qd target_qd target_qdd actual_current target_moment"
    names = [f"{kind}_{joint}" for kind in kinds.split() for joint in (0, 1)]
    text = log_of(" ".join(names) + " actual_TCP_pose_0 speed_scaling runtime_state", "timestamp")
    planned = read(text, TWO, map=["q=target_q_*"])
    with warned() as texts:
        measured = read(text, TWO)
    assert "actual_current_0 ... are currents; --torque-constant LIST" in texts[0]
    np.testing.assert_array_equal([measured.q[0], measured.qd[0]], [[0, 1], [4, 5]])
    assert (measured.qdd, measured.torque, measured.measured) == (None, None, True)
    np.testing.assert_array_equal(
        [planned.q[0], planned.qdd[0], planned.torque[0]], [[2, 3], [8, 9], [12, 13]]
    )
    assert not planned.measured


def test_libfranka(read):
    kinds = "q q_d dq dq_d ddq_d tau_J tau_J_d dtau_J tau_ext_hat_filtered theta dtheta"
    names = [f"state.{kind}[{j}]" for kind in kinds.split() for j in range(2)]
    logged = read(log_of(" ".join(names), "time_ms", (0, 1)), arm_of("panda_joint1", "panda_joint2"))
    np.testing.assert_array_equal([logged.q[0], logged.qd[0], logged.torque[0]], [[0, 1], [4, 5], [10, 11]])
    assert (logged.qdd, logged.measured) == (None, True)
    assert logged.time[1] == 0.001


def test_families_of_zeros_are_left_out(read, warned):
    """As logs of a Gen3: torques of three kinds, of which only one is not 0 throughout."""
    names = "Position Velocity Torque TorqueSm TorqueCur PositionCmptd TorqueCmptd"
    header = ",".join(["Time", *(f"{name}{j}" for name in names.split() for j in (1, 2))])
    line = "1,2,3,4,0,0,0,0,9,10,11,12,0,0"
    with warned() as texts:
        logged = read(f"{header}\n0,{line}\n1,{line}\n", arm_of("joint_1", "joint_2"), map=["time=:1000Hz"])
    (text,) = texts
    assert all(fact in text for fact in ("Torque1, TorqueSm1 ...", "0 throughout", "from TorqueCur1"))
    np.testing.assert_array_equal(logged.torque[0], [9, 10])
    np.testing.assert_array_equal(logged.time, [0, 0.001])
    why = {use.column: use.why for use in logged.columns}
    assert why["Torque1"] == why["TorqueSm2"] == "0 throughout"
    assert "measured" in why["PositionCmptd1"]


def test_decimal_commas_between_commas_are_told(read):
    with pytest.raises(TrajectoryError) as caught:
        read("time,q1,q2\n" + "".join(f"{k},5,0,{k},-0,2{k}\n" for k in range(1, 9)), TWO)
    assert "decimal commas" in caught.value.what
    with pytest.raises(TrajectoryError) as slip:
        read("time,q1,q2\n" + "".join(f"{k},5,7\n" for k in range(8)) + "8,5,7,9\n", TWO)
    assert "decimal" not in slip.value.what
    assert "semicolons" in caught.value.details["next"]


def test_torques_of_zeros_are_told(read, warned):
    line = "1,2,0,0"
    with warned() as texts:
        logged = read(f"time,q1,q2,tau1,tau2\n0,{line}\n0.5,{line}\n", TWO)
    assert logged.torque is None
    assert [text.split(": ", 1)[1] for text in texts] == ["tau1 ... are 0 throughout; no torques are read"]
