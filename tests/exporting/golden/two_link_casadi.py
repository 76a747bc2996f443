"""Simplified torque model of Two-link planar arm, by gd-analyze VERSION.

Level energy: 5 of 5 energy terms; budget 1 N m.
torque: generalized torque tau = D(q) qdd + h(q, qd) + c(q);
  22 (12 mult + 10 add), 4 sin and cos.
inertia: inertia matrix D(q), its rows one after another;
  4 (1 mult + 3 add), 1 sin and cos.
coriolis_centrifugal: Coriolis and centrifugal torque h(q, qd);
  11 (7 mult + 4 add), 1 sin and cos.
gravity_loading: gravity loading c(q);
  4 (2 mult + 2 add), 2 sin and cos.
The exact torque takes 5 (3 mult + 2 add), 1 sin and cos.
Inertia of the drives: left out.
Units: rad and m, s, N m and N. Friction is not included.
Arm two_link, SHA-256 of all that affects its torque:
  187bf5c5c5eed8fce5b8ab617b4b82c548c4e2e83b09ba06363becbb363e8f7f
SHA-256 of the model file:
  HASH

Joints in their order, with their names where these differ:
  1: shoulder, revolute: q in rad, tau in N m
  2: elbow, revolute: q in rad, tau in N m
Links: upper rod, fore rod

Torque errors, sampled where the model was fitted:
  box drawn, states 5, seed 0
  joint  peak torque  allowed  largest  RMS
      1            1        1        0    0
      2            1        1        0    0
Proven: no state of the following box (a box) has an error above the bound.
  joint  q from  q to  |qd| up to  |qdd| up to     bound
      1    -0.7   1.1         2.3          3.3       0.1
      2    -0.7   1.1         2.3          3.3  0.433334

Every function is a casadi.Function: call it with numbers or symbols, differentiate it, generate code of it.
"""

import casadi

JOINTS = ('shoulder', 'elbow')
# largest torque error at the states the model was fitted on
SAMPLED_ERROR = casadi.DM([0.0, 0.0])
# no state within the box has a larger torque error
ERROR_BOUND = casadi.DM([0.1, 0.433334])
# the box: lowest positions
LOWER = casadi.DM([-0.7, -0.7])
# the box: highest positions
UPPER = casadi.DM([1.1, 1.1])
# the box: largest velocities, either way
VELOCITY = casadi.DM([2.3, 2.3])
# the box: largest accelerations, either way
ACCELERATION = casadi.DM([3.3, 3.3])


def _torque():
    q = casadi.SX.sym("q", 2)
    qd = casadi.SX.sym("qd", 2)
    qdd = casadi.SX.sym("qdd", 2)
    q1 = q[0]
    q2 = q[1]
    qd1 = qd[0]
    qd2 = qd[1]
    qdd1 = qdd[0]
    qdd2 = qdd[1]
    t1 = qd1 + qd2
    t2 = qdd1 + qdd2
    cos_q1 = casadi.cos(q1)
    t4 = 19.612 * cos_q1
    t5 = 1.667 * qdd1
    t6 = t4 + t5
    cos_q2 = casadi.cos(q2)
    t8 = 0.5 * cos_q2
    t9 = t2 * t8
    t10 = t6 + t9
    t11 = t1 * t1
    sin_q2 = casadi.sin(q2)
    t13 = 0.5 * sin_q2
    t14 = t11 * t13
    t15 = t10 - t14
    t16 = q1 + q2
    cos_t16 = casadi.cos(t16)
    t18 = 4.903 * cos_t16
    t19 = 0.333 * t2
    t20 = t18 + t19
    t21 = qd1 * qd1
    t22 = t13 * t21
    t23 = t20 + t22
    t24 = qdd1 * t8
    t25 = t23 + t24
    t26 = t15 + t25
    tau = casadi.vertcat(
        t26,
        t25,
    )
    return casadi.Function(
        "two_link_torque",
        [q, qd, qdd],
        [tau],
        ["q", "qd", "qdd"],
        ["tau"],
    )


# generalized torque tau = D(q) qdd + h(q, qd) + c(q)
torque = _torque()


def _inertia():
    q = casadi.SX.sym("q", 2)
    q2 = q[1]
    cos_q2 = casadi.cos(q2)
    t2 = 0.5 * cos_q2
    t3 = 1.667 + t2
    t4 = 0.333 + t2
    t5 = t3 + t4
    D = casadi.vertcat(
        t5,
        t4,
        t4,
        0.333,
    )
    D = casadi.reshape(D, 2, 2).T
    return casadi.Function(
        "two_link_inertia",
        [q],
        [D],
        ["q"],
        ["D"],
    )


# inertia matrix D(q), its rows one after another
inertia = _inertia()


def _coriolis_centrifugal():
    q = casadi.SX.sym("q", 2)
    qd = casadi.SX.sym("qd", 2)
    q2 = q[1]
    qd1 = qd[0]
    qd2 = qd[1]
    t1 = qd1 + qd2
    t2 = t1 * t1
    sin_q2 = casadi.sin(q2)
    t4 = 0.5 * sin_q2
    t5 = qd1 * qd1
    t6 = t2 + t2
    t7 = t4 * t6
    t8 = t5 + t5
    t9 = t4 * t8
    t10 = t9 - t7
    t11 = 0.5 * t10
    t12 = 0.5 * t9
    h = casadi.vertcat(
        t11,
        t12,
    )
    return casadi.Function(
        "two_link_coriolis_centrifugal",
        [q, qd],
        [h],
        ["q", "qd"],
        ["h"],
    )


# Coriolis and centrifugal torque h(q, qd)
coriolis_centrifugal = _coriolis_centrifugal()


def _gravity_loading():
    q = casadi.SX.sym("q", 2)
    q1 = q[0]
    q2 = q[1]
    cos_q1 = casadi.cos(q1)
    t2 = 19.612 * cos_q1
    t3 = q1 + q2
    cos_t3 = casadi.cos(t3)
    t5 = 4.903 * cos_t3
    t6 = t2 + t5
    c = casadi.vertcat(
        t6,
        t5,
    )
    return casadi.Function(
        "two_link_gravity_loading",
        [q],
        [c],
        ["q"],
        ["c"],
    )


# gravity loading c(q)
gravity_loading = _gravity_loading()
