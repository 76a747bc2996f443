/*
 * Simplified torque model of Two-link planar arm, by gd-analyze VERSION.
 *
 * Level energy: 5 of 5 energy terms; budget 1 N m.
 * torque: generalized torque tau = D(q) qdd + h(q, qd) + c(q);
 *   22 (12 mult + 10 add), 4 sin and cos.
 * inertia: inertia matrix D(q), its rows one after another;
 *   4 (1 mult + 3 add), 1 sin and cos.
 * coriolis_centrifugal: Coriolis and centrifugal torque h(q, qd);
 *   11 (7 mult + 4 add), 1 sin and cos.
 * gravity_loading: gravity loading c(q);
 *   4 (2 mult + 2 add), 2 sin and cos.
 * The exact torque takes 5 (3 mult + 2 add), 1 sin and cos.
 * Inertia of the drives: left out.
 * Units: rad and m, s, N m and N. Friction is not included.
 * Arm two_link, SHA-256 of all that affects its torque:
 *   187bf5c5c5eed8fce5b8ab617b4b82c548c4e2e83b09ba06363becbb363e8f7f
 * SHA-256 of the model file:
 *   HASH
 *
 * Joints in their order, with their names where these differ:
 *   1: shoulder, revolute: q in rad, tau in N m
 *   2: elbow, revolute: q in rad, tau in N m
 * Links: upper rod, fore rod
 *
 * Torque errors, sampled where the model was fitted:
 *   box drawn, states 5, seed 0
 *   joint  peak torque  allowed  largest  RMS
 *       1            1        1        0    0
 *       2            1        1        0    0
 * Proven: no state of the following box (a box) has an error above the bound.
 *   joint  q from  q to  |qd| up to  |qdd| up to     bound
 *       1    -0.7   1.1         2.3          3.3       0.1
 *       2    -0.7   1.1         2.3          3.3  0.433334
 *
 * Every function is a template on the scalar T: double, float, or a type that differentiates itself and has
 * sin and cos. It takes pointers to as many numbers as its comment says, and allocates nothing. An output
 * array may be an input array. Where Eigen is included before this file, functions of its vectors are declared.
 */
#ifndef GD_ANALYZE_TWO_LINK_HPP
#define GD_ANALYZE_TWO_LINK_HPP

#include <cmath>

namespace two_link {

enum { joints = 2 };
enum joint {
    joint_shoulder = 0,
    joint_elbow = 1
};

/* largest torque error at the states the model was fitted on */
constexpr double sampled_error[2] = {
    0.0, 0.0
};
/* no state within the box has a larger torque error */
constexpr double error_bound[2] = {
    0.1, 0.433334
};
/* the box: lowest positions */
constexpr double lower[2] = {
    -0.7, -0.7
};
/* the box: highest positions */
constexpr double upper[2] = {
    1.1, 1.1
};
/* the box: largest velocities, either way */
constexpr double velocity[2] = {
    2.3, 2.3
};
/* the box: largest accelerations, either way */
constexpr double acceleration[2] = {
    3.3, 3.3
};

/* whether a state lies within the box; no if it is no number */
template <class T>
bool is_within(const T *q, const T *qd, const T *qdd)
{
    for (int j = 0; j < joints; j++) {
        if (!(q[j] >= T(lower[j]) && q[j] <= T(upper[j]) && qd[j] <= T(velocity[j]) && qd[j] >= T(-velocity[j])
              && qdd[j] <= T(acceleration[j]) && qdd[j] >= T(-acceleration[j])))
            return false;
    }
    return true;
}

/* generalized torque tau = D(q) qdd + h(q, qd) + c(q): 2 numbers tau */
template <class T>
void torque(const T *q, const T *qd, const T *qdd, T *tau)
{
    using std::cos;
    using std::sin;
    static_cast<void>(q);
    static_cast<void>(qd);
    static_cast<void>(qdd);
    const T q1 = q[0];
    const T q2 = q[1];
    const T qd1 = qd[0];
    const T qd2 = qd[1];
    const T qdd1 = qdd[0];
    const T qdd2 = qdd[1];
    const T t1 = qd1 + qd2;
    const T t2 = qdd1 + qdd2;
    const T cos_q1 = cos(q1);
    const T t4 = T(19.612) * cos_q1;
    const T t5 = T(1.667) * qdd1;
    const T t6 = t4 + t5;
    const T cos_q2 = cos(q2);
    const T t8 = T(0.5) * cos_q2;
    const T t9 = t2 * t8;
    const T t10 = t6 + t9;
    const T t11 = t1 * t1;
    const T sin_q2 = sin(q2);
    const T t13 = T(0.5) * sin_q2;
    const T t14 = t11 * t13;
    const T t15 = t10 - t14;
    const T t16 = q1 + q2;
    const T cos_t16 = cos(t16);
    const T t18 = T(4.903) * cos_t16;
    const T t19 = T(0.333) * t2;
    const T t20 = t18 + t19;
    const T t21 = qd1 * qd1;
    const T t22 = t13 * t21;
    const T t23 = t20 + t22;
    const T t24 = qdd1 * t8;
    const T t25 = t23 + t24;
    const T t26 = t15 + t25;
    tau[0] = t26;
    tau[1] = t25;
}

/* inertia matrix D(q), its rows one after another: 4 numbers D */
template <class T>
void inertia(const T *q, T *D)
{
    using std::cos;
    using std::sin;
    static_cast<void>(q);
    const T q2 = q[1];
    const T cos_q2 = cos(q2);
    const T t2 = T(0.5) * cos_q2;
    const T t3 = T(1.667) + t2;
    const T t4 = T(0.333) + t2;
    const T t5 = t3 + t4;
    D[0] = t5;
    D[1] = t4;
    D[2] = t4;
    D[3] = T(0.333);
}

/* Coriolis and centrifugal torque h(q, qd): 2 numbers h */
template <class T>
void coriolis_centrifugal(const T *q, const T *qd, T *h)
{
    using std::cos;
    using std::sin;
    static_cast<void>(q);
    static_cast<void>(qd);
    const T q2 = q[1];
    const T qd1 = qd[0];
    const T qd2 = qd[1];
    const T t1 = qd1 + qd2;
    const T t2 = t1 * t1;
    const T sin_q2 = sin(q2);
    const T t4 = T(0.5) * sin_q2;
    const T t5 = qd1 * qd1;
    const T t6 = t2 + t2;
    const T t7 = t4 * t6;
    const T t8 = t5 + t5;
    const T t9 = t4 * t8;
    const T t10 = t9 - t7;
    const T t11 = T(0.5) * t10;
    const T t12 = T(0.5) * t9;
    h[0] = t11;
    h[1] = t12;
}

/* gravity loading c(q): 2 numbers c */
template <class T>
void gravity_loading(const T *q, T *c)
{
    using std::cos;
    using std::sin;
    static_cast<void>(q);
    const T q1 = q[0];
    const T q2 = q[1];
    const T cos_q1 = cos(q1);
    const T t2 = T(19.612) * cos_q1;
    const T t3 = q1 + q2;
    const T cos_t3 = cos(t3);
    const T t5 = T(4.903) * cos_t3;
    const T t6 = t2 + t5;
    c[0] = t6;
    c[1] = t5;
}

#ifdef EIGEN_WORLD_VERSION
template <class T>
Eigen::Matrix<T, joints, 1> torque(const Eigen::Matrix<T, joints, 1> &q, const Eigen::Matrix<T, joints, 1> &qd, const Eigen::Matrix<T, joints, 1> &qdd)
{
    Eigen::Matrix<T, joints, 1> tau;
    torque(q.data(), qd.data(), qdd.data(), tau.data());
    return tau;
}
template <class T>
Eigen::Matrix<T, joints, joints> inertia(const Eigen::Matrix<T, joints, 1> &q)
{
    Eigen::Matrix<T, joints, joints, Eigen::RowMajor> D;
    inertia(q.data(), D.data());
    return D;
}
template <class T>
Eigen::Matrix<T, joints, 1> coriolis_centrifugal(const Eigen::Matrix<T, joints, 1> &q, const Eigen::Matrix<T, joints, 1> &qd)
{
    Eigen::Matrix<T, joints, 1> h;
    coriolis_centrifugal(q.data(), qd.data(), h.data());
    return h;
}
template <class T>
Eigen::Matrix<T, joints, 1> gravity_loading(const Eigen::Matrix<T, joints, 1> &q)
{
    Eigen::Matrix<T, joints, 1> c;
    gravity_loading(q.data(), c.data());
    return c;
}
#endif

}

#endif
