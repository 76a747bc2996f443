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

Every function takes arrays of shape (..., 2), with any leading axes.
"""

import numpy as np

JOINTS = ('shoulder', 'elbow')
# largest torque error at the states the model was fitted on
SAMPLED_ERROR = np.array([0.0, 0.0])
# no state within the box has a larger torque error
ERROR_BOUND = np.array([0.1, 0.433334])
# the box: lowest positions
LOWER = np.array([-0.7, -0.7])
# the box: highest positions
UPPER = np.array([1.1, 1.1])
# the box: largest velocities, either way
VELOCITY = np.array([2.3, 2.3])
# the box: largest accelerations, either way
ACCELERATION = np.array([3.3, 3.3])


def _states(*arrays):
    arrays = [np.asarray(array, dtype=float) for array in arrays]
    for array in arrays:
        if array.shape[-1:] != (2,):
            raise ValueError(f"a state has 2 joints, in the last axis: shape (..., 2), not {array.shape}")
    return np.broadcast_arrays(*arrays)


def _stacked(like, shape, values):
    rows = np.broadcast_arrays(*values, like[..., 0])[:-1]
    return np.stack(rows, axis=-1).reshape(*like.shape[:-1], *shape)


def is_within(q, qd, qdd):
    """Whether states lie within the box, shape (...)."""
    q, qd, qdd = _states(q, qd, qdd)
    inside = (q >= LOWER) & (q <= UPPER) & (np.abs(qd) <= VELOCITY) & (np.abs(qdd) <= ACCELERATION)
    return inside.all(axis=-1)


def torque(q, qd, qdd):
    """generalized torque tau = D(q) qdd + h(q, qd) + c(q).

    tau has shape (..., 2).
    """
    q, qd, qdd = _states(q, qd, qdd)
    q1 = q[..., 0]
    q2 = q[..., 1]
    qd1 = qd[..., 0]
    qd2 = qd[..., 1]
    qdd1 = qdd[..., 0]
    qdd2 = qdd[..., 1]
    t1 = qd1 + qd2
    t2 = qdd1 + qdd2
    cos_q1 = np.cos(q1)
    t4 = 19.612 * cos_q1
    t5 = 1.667 * qdd1
    t6 = t4 + t5
    cos_q2 = np.cos(q2)
    t8 = 0.5 * cos_q2
    t9 = t2 * t8
    t10 = t6 + t9
    t11 = t1 * t1
    sin_q2 = np.sin(q2)
    t13 = 0.5 * sin_q2
    t14 = t11 * t13
    t15 = t10 - t14
    t16 = q1 + q2
    cos_t16 = np.cos(t16)
    t18 = 4.903 * cos_t16
    t19 = 0.333 * t2
    t20 = t18 + t19
    t21 = qd1 * qd1
    t22 = t13 * t21
    t23 = t20 + t22
    t24 = qdd1 * t8
    t25 = t23 + t24
    t26 = t15 + t25
    tau = _stacked(q, (2,), [
        t26,
        t25,
    ])
    return tau


def inertia(q):
    """inertia matrix D(q), its rows one after another.

    D has shape (..., 2, 2).
    """
    q, = _states(q)
    q2 = q[..., 1]
    cos_q2 = np.cos(q2)
    t2 = 0.5 * cos_q2
    t3 = 1.667 + t2
    t4 = 0.333 + t2
    t5 = t3 + t4
    D = _stacked(q, (2, 2,), [
        t5,
        t4,
        t4,
        0.333,
    ])
    return D


def coriolis_centrifugal(q, qd):
    """Coriolis and centrifugal torque h(q, qd).

    h has shape (..., 2).
    """
    q, qd = _states(q, qd)
    q2 = q[..., 1]
    qd1 = qd[..., 0]
    qd2 = qd[..., 1]
    t1 = qd1 + qd2
    t2 = t1 * t1
    sin_q2 = np.sin(q2)
    t4 = 0.5 * sin_q2
    t5 = qd1 * qd1
    t6 = t2 + t2
    t7 = t4 * t6
    t8 = t5 + t5
    t9 = t4 * t8
    t10 = t9 - t7
    t11 = 0.5 * t10
    t12 = 0.5 * t9
    h = _stacked(q, (2,), [
        t11,
        t12,
    ])
    return h


def gravity_loading(q):
    """gravity loading c(q).

    c has shape (..., 2).
    """
    q, = _states(q)
    q1 = q[..., 0]
    q2 = q[..., 1]
    cos_q1 = np.cos(q1)
    t2 = 19.612 * cos_q1
    t3 = q1 + q2
    cos_t3 = np.cos(t3)
    t5 = 4.903 * cos_t3
    t6 = t2 + t5
    c = _stacked(q, (2,), [
        t6,
        t5,
    ])
    return c
