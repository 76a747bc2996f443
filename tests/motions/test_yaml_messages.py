"""Messages as `ros2 topic echo` and `rostopic echo` print them."""

from __future__ import annotations

import numpy as np
import pytest

from log_arms import arm_of

TWO = arm_of("hip", "knee")
STATE = """\
header: {{stamp: {{sec: 1700000000, nanosec: {nano}}}}}
name: [knee, hip]
position:
- {knee}
- 0.5
velocity: [1.0, 2]
effort: []
---
"""
POINT = "- {positions: [%g, 2.0], velocities: [3.0, 4.0], accelerations: [5.0, 6.0], effort: [7.0, 8.0],\n"
TRAJECTORY = (
    "header: {stamp: {sec: 0, nanosec: 0}}\njoint_names: [knee, hip]\npoints:\n"
    f"{POINT % 1.0}   time_from_start: {{sec: 0, nanosec: 0}}}}\n"
    f"{POINT % 1.5}   time_from_start: {{sec: 0, nanosec: 8000000}}}}\n---\n"
)


def test_joint_states(read):
    text = "".join(STATE.format(nano=8000001 * k, knee=0.1 * k) for k in range(3))
    logged = read(text, TWO, "states.yaml")
    np.testing.assert_array_equal(logged.q, [[0.5, 0.0], [0.5, 0.1], [0.5, 0.2]])
    np.testing.assert_array_equal(logged.qd, [[2, 1]] * 3)
    np.testing.assert_allclose(logged.time, [0, 0.008000001, 0.016000002], rtol=1e-15)
    assert (logged.torque, logged.measured) == (None, True)


def test_a_trajectory_is_a_plan(read):
    logged = read(TRAJECTORY, TWO, "plan.yml")
    np.testing.assert_array_equal(logged.q, [[2, 1], [2, 1.5]])
    np.testing.assert_array_equal(logged.qdd[0], [6, 5])
    np.testing.assert_array_equal(logged.torque[0], [8, 7])
    np.testing.assert_allclose(logged.time, [0, 0.008], rtol=1e-15)
    assert not logged.measured


def test_ros_1_and_a_gripper_among_the_joints(read):
    """Two publishers on one topic: of the joints that a message lacks nothing is known at its instant."""
    head = "header: {seq: 1, stamp: {secs: 15, nsecs: %d}}\n"
    arm = head + 'name: ["hip", "knee"]\nposition: [%d.5, 2]\nvelocity: []\neffort: [3, 4]\n---\n'
    grip = head + "name: [finger]\nposition: [0.0]\n---\n"
    logged = read("".join(grip % (2 * k) + arm % (2 * k + 1, k) for k in range(4)), TWO, "both.yaml")
    np.testing.assert_array_equal(logged.q[:, 0], [0.5, 1.5, 2.5, 3.5])
    np.testing.assert_array_equal(logged.torque[0], [3, 4])
    np.testing.assert_allclose(logged.time, [0, 2e-9, 4e-9, 6e-9], rtol=1e-12)


def test_state_of_a_controller(read):
    text = "".join(
        f"header: {{stamp: {{sec: 0, nanosec: {k}}}}}\njoint_names: [hip, knee]\n"
        f"reference: {{positions: [1, {k}]}}\nfeedback: {{positions: [3, {k}], velocities: [5, 6]}}\n"
        f"error: {{positions: [7, 8]}}\n---\n"
        for k in range(3)
    )
    measured, planned = read(text, TWO, "a.yaml"), read(text, TWO, "a.yaml", family="reference")
    np.testing.assert_array_equal(measured.q[2], [3, 2])
    np.testing.assert_array_equal(measured.qd[2], [5, 6])
    np.testing.assert_array_equal(planned.q[2], [1, 2])
    assert (measured.measured, planned.measured) == (True, False)


CASES: dict[str, tuple[str, str]] = {
    "no YAML": ("a: [1, 2\nb: 3\n", "line 2, column"),
    "something else": ("- 1\n- 2\n", "other than JointState, JointTrajectory"),
    "cut short": (STATE.format(nano=0, knee=0.1).replace("- 0.5\n", "- 0.5\n- '...'\n"), "--full-length"),
    "another length": (STATE.format(nano=0, knee=0).replace(", 2]", "]"), "1 of velocity for 2 joints"),
    "no stamp": (STATE.format(nano="soon", knee=0), "a stamp without sec and nanosec"),
    "no rows": ("---\n---\n", "found: no message"),
    "two plans": (TRAJECTORY * 2, "found: 2, 2 points"),
    "lists without end": ("a: " + "[" * 100_000 + "\n", "line 1"),
    "code": ("!!python/object/apply:os.system ['true']\n", "line 1"),
}


@pytest.mark.parametrize("case", CASES)
def test_refusals(case, refused):
    content, says = CASES[case]
    refused(says, content, TWO, "bad.yaml")
