"""Headers as robots, simulators and people write them: what each column is, of an arm of six joints."""

from __future__ import annotations

import numpy as np
import pytest

from log_arms import UR, arm_of, log_of

KUKA = [f"joint_a{k}" for k in range(1, 7)]
SIX = [f"joint{k}" for k in range(1, 7)]


def six(pattern: str, first: int = 1) -> str:
    return " ".join(pattern.replace("*", str(k)) for k in range(first, first + 6))


def by_name(pattern: str) -> str:
    return " ".join(pattern.replace("*", name) for name in UR)


# Columns in the order q, qd, qdd, torque as far as they are there, then others, which are left out.
CASES: dict[str, tuple[list[str], str, str]] = {
    "rtde": (list(UR), f"{six('actual_q_*', 0)} {six('actual_qd_*', 0)}", six("actual_current_*", 0)),
    "rtde, commanded beside": (list(UR), six("actual_q_*", 0), six("target_q_*", 0)),
    "plotjuggler": (
        list(UR),
        f"{by_name('/joint_states/*/position')} {by_name('/joint_states/*/velocity')}",
        "",
    ),
    "moveit": (
        list(UR),
        f"{by_name('*.positions')} {by_name('*.velocities')} {by_name('*.accelerations')}",
        "",
    ),
    "ros2_control": (
        list(UR),
        by_name("/dynamic_joint_states/*/position"),
        by_name("/dynamic_joint_states/*/temp"),
    ),
    "kuka rsi": (KUKA, six("AIPos.A*"), six("MACur.A*")),
    "kuka trace": (KUKA, six("AXIS_ACT_A*"), six("Temp_A*")),
    "abb": (SIX, six("Joint*_position"), six("Joint*_current")),
    "fanuc": (SIX, six("J*"), ""),
    "denso": (SIX, f"{six('pos_j*')} {six('vel_j*')}", six("load_j*")),
    "franka": (SIX, f"{six('q[*]', 0)} {six('dq[*]', 0)}", six("theta[*]", 0)),
    "libfranka": (SIX, f"{six('state.q[*]', 0)} {six('state.dq[*]', 0)}", six("state.tau_ext[*]", 0)),
    "kinova": (SIX, f"{six('Position*')} {six('Velocity*')}", six("PositionCmptd*")),
    "gazebo": (SIX, f"{six('joint*_angle')} {six('joint*_rate')}", ""),
    "mujoco": (SIX, f"{six('qpos_*', 0)} {six('qvel_*', 0)} {six('qacc_*', 0)}", six("ctrl_*", 0)),
    "lerobot": (list(UR), by_name("*.pos"), by_name("action.*.pos")),
    "matlab": (SIX, f"{six('q*')} {six('q_dot_*')} {six('q_ddot_*')}", ""),
    "german": (KUKA, f"{six('Istwinkel_A*')} {six('Istgeschwindigkeit_A*')}", six("Sollwinkel_A*")),
    "german, spelt out": (
        SIX,
        f"{six('Winkel_Achse_*')} {six('Drehzahl_Achse_*')}",
        six("Temperatur_Achse_*"),
    ),
    "french": (SIX, f"{six('angle_articulation_*')} {six('vitesse_articulation_*')}", six("courant_*")),
    "spanish": (SIX, f"{six('posición_*')} {six('velocidad_*')}", six("corriente_*")),
    "greek": (SIX, six("θ*"), ""),
    "one word": (SIX, f"{six('qact*')} {six('qdact*')}", six("qdes*")),
    "with a robot's prefix": (SIX, f"{six('left_arm/joint*/pos')} {six('left_arm/joint*/vel')}", ""),
}


@pytest.mark.parametrize("case", CASES)
def test_headers(case, read, warned):
    joints, used, unused = CASES[case]
    with warned():
        logged = read(log_of(f"{used} {unused}".strip()), arm_of(*joints))
    values = [x for x in (logged.q, logged.qd, logged.qdd, logged.torque) if x is not None]
    expected = np.arange(6 * len(values))
    if "kuka rsi" in case:
        expected = np.radians(expected)
    np.testing.assert_allclose(np.concatenate([x[0] for x in values]), expected, rtol=1e-15)
    assert 6 * len(values) == len(used.split())
