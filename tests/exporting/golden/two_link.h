/*
 * Simplified torque model of Two-link planar arm, by gd-analyze VERSION.
 *
 * Level energy: 5 of 5 energy terms; budget 1 N m.
 * torque: generalized torque tau = D(q) qdd + h(q, qd) + c(q);
 *   22 (12 mult + 10 add), 4 sin and cos.
 * inertia: mass matrix D(q), row by row;
 *   4 (1 mult + 3 add), 1 sin and cos.
 * coriolis_centrifugal: Coriolis and centrifugal torque h(q, qd);
 *   7 (5 mult + 2 add), 1 sin and cos.
 * gravity_loading: gravity loading c(q);
 *   4 (2 mult + 2 add), 2 sin and cos.
 * The exact torque takes 22 (12 mult + 10 add), 4 sin and cos,
 *   exact D, h and c, each a function of its own, 3 + 7 + 4 operations,
 *   4 sin and cos.
 * Inertia of the drives: none in the arm's file.
 * Units: rad and m, s, N m and N. Friction is not included.
 * Arm two_link, SHA-256 of all that affects its torque:
 *   187bf5c5c5eed8fce5b8ab617b4b82c548c4e2e83b09ba06363becbb363e8f7f
 * SHA-256 of the model file:
 *   HASH
 *
 * Joints in order, with their original names if these differ:
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
 * Call every function with arrays of as many numbers as it declares. It allocates nothing, has no state and
 * may be called from several threads. An output array may be an input array.
 * two_link_torque_many takes count states at once, in arrays that hold joint 1 of all states, then
 * joint 2: q[joint * count + state]. Compilers vectorize it (gcc -O3 -march=native).
 */
#ifndef GD_ANALYZE_TWO_LINK_H
#define GD_ANALYZE_TWO_LINK_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { two_link_joints = 2 };
enum {
    two_link_joint_shoulder = 0,
    two_link_joint_elbow = 1
};

/* largest torque error at the states the model was fitted on */
extern const double two_link_sampled_error[2];
/* bound on the torque error at all states within the box */
extern const double two_link_error_bound[2];
/* the box: lowest positions */
extern const double two_link_lower[2];
/* the box: highest positions */
extern const double two_link_upper[2];
/* the box: largest velocities in both directions */
extern const double two_link_velocity[2];
/* the box: largest accelerations in both directions */
extern const double two_link_acceleration[2];
/* 1 if a state lies within the box, 0 if not, or for nan */
int two_link_is_within(const double q[2], const double qd[2], const double qdd[2]);

/* generalized torque tau = D(q) qdd + h(q, qd) + c(q) */
void two_link_torque(const double q[2], const double qd[2], const double qdd[2], double tau[2]);
/* mass matrix D(q), row by row */
void two_link_inertia(const double q[2], double D[4]);
/* Coriolis and centrifugal torque h(q, qd) */
void two_link_coriolis_centrifugal(const double q[2], const double qd[2], double h[2]);
/* gravity loading c(q) */
void two_link_gravity_loading(const double q[2], double c[2]);
/* torque of many states */
void two_link_torque_many(size_t count, const double *q, const double *qd, const double *qdd, double *tau);

#ifdef __cplusplus
}
#endif

#endif
