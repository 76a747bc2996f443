/* See two_link.h for its content and errors. */
#include "two_link.h"

#include <math.h>

#if defined(__FAST_MATH__) && !defined(GD_ANALYZE_ALLOW_FAST_MATH)
#error "-ffast-math hides nan and breaks the reduction of angles: omit it, or define GD_ANALYZE_ALLOW_FAST_MATH"
#endif

const double two_link_sampled_error[2] = {
    0.0, 0.0
};
const double two_link_error_bound[2] = {
    0.1, 0.433334
};
const double two_link_lower[2] = {
    (-0.7), (-0.7)
};
const double two_link_upper[2] = {
    1.1, 1.1
};
const double two_link_velocity[2] = {
    2.3, 2.3
};
const double two_link_acceleration[2] = {
    3.3, 3.3
};

int two_link_is_within(const double q[2], const double qd[2], const double qdd[2])
{
    int j;
    for (j = 0; j < 2; j++) {
        if (!(q[j] >= two_link_lower[j] && q[j] <= two_link_upper[j]))
            return 0;
        if (!(fabs(qd[j]) <= two_link_velocity[j] && fabs(qdd[j]) <= two_link_acceleration[j]))
            return 0;
    }
    return 1;
}

enum { block = 4, lanes = 8 };

/* the library's sines and cosines, for angles of which any is far */
static void by_library(const double *x, double *sine, double *cosine, int count)
{
    int l;
    for (l = 0; l < count; l++) {
        sine[l] = sin(x[l]);
        cosine[l] = cos(x[l]);
    }
}

/* whether an angle is far: nan, or larger than 1e+06 rad */
static inline int any_far(const double *x, int count)
{
    int far = 0, l;
    for (l = 0; l < count; l++)
        far |= !(fabs(x[l]) <= 1000000.0);
    return far;
}

/* sines and cosines of angles, none of which is far; gcc does not vectorize loops that it unrolls */
static inline void polynomials(const double *restrict x, double *restrict sine, double *restrict cosine, int count)
{
    int l;
#if defined(__GNUC__) && __GNUC__ >= 8 && !defined(__clang__)
#pragma GCC unroll 1
#endif
    for (l = 0; l < count; l++) {
        const int turns = (int)(x[l] * 0.3183098861837907 + 400000.5);
        const double k = (double)(turns) - 400000.0;
        const double sign = 1.0 - (double)(2 * (turns & 1));
        const double r = (x[l] - k * 3.1415926534682512) - k * 1.2154201013012384e-10;
        const double z = r * r;
        const double s = r + r * z * ((-0.16666666666666666) + z * (0.008333333333333115 + z * ((-0.00019841269841185965) + z * (2.755731920778734e-06 + z * ((-2.5052106606669523e-08) + z * (1.6058927837871089e-10 + z * ((-7.642712960186641e-13) + z * (2.7184966738811603e-15))))))));
        const double c = 1.0 - 0.5 * z + z * z * (0.04166666666666583 + z * ((-0.001388888888883005) + z * (2.4801587285783927e-05 + z * ((-2.7557317068508415e-07) + z * (2.0876592592219086e-09 + z * ((-1.1463635426822e-11) + z * (4.61613491167436e-14)))))));
        sine[l] = sign * s;
        cosine[l] = sign * c;
    }
}


void two_link_torque(const double q[2], const double qd[2], const double qdd[2], double tau[2])
{
    double angle[4], sine[4], cosine[4];
    {
        const double q1 = q[0];
        const double q2 = q[1];
        const double t1 = q1 + q2;
        angle[0] = q1;
        angle[1] = q2;
        angle[2] = t1;
        angle[3] = 0.0;
    }
    if (any_far(angle, 4)) {
        by_library(angle, sine, cosine, 4);
    } else {
        polynomials(&angle[0], &sine[0], &cosine[0], block);
    }
    {
        const double qd1 = qd[0];
        const double qd2 = qd[1];
        const double qdd1 = qdd[0];
        const double qdd2 = qdd[1];
        const double sin2 = sine[1];
        const double cos1 = cosine[0];
        const double cos2 = cosine[1];
        const double cos3 = cosine[2];
        const double t1 = qd1 + qd2;
        const double t2 = qdd1 + qdd2;
        const double t3 = 19.612 * cos1;
        const double t4 = 0.5 * sin2;
        const double t5 = 0.5 * cos2;
        const double t6 = 4.903 * cos3;
        const double t7 = t1 * t4;
        const double t8 = t1 * t7;
        const double t9 = t3 - t8;
        const double t10 = t2 * t5;
        const double t11 = t9 + t10;
        const double t12 = 1.667 * qdd1;
        const double t13 = t11 + t12;
        const double t14 = qd1 * t4;
        const double t15 = qd1 * t14;
        const double t16 = t6 + t15;
        const double t17 = qdd1 * t5;
        const double t18 = t16 + t17;
        const double t19 = 0.333 * t2;
        const double t20 = t18 + t19;
        const double t21 = t13 + t20;
        tau[0] = t21;
        tau[1] = t20;
    }
}

void two_link_inertia(const double q[2], double D[4])
{
    double angle[4], sine[4], cosine[4];
    {
        const double q2 = q[1];
        angle[0] = q2;
        angle[1] = 0.0;
        angle[2] = 0.0;
        angle[3] = 0.0;
    }
    if (any_far(angle, 4)) {
        by_library(angle, sine, cosine, 4);
    } else {
        polynomials(&angle[0], &sine[0], &cosine[0], block);
    }
    {
        const double cos1 = cosine[0];
        const double t1 = 0.5 * cos1;
        const double t2 = 1.667 + t1;
        const double t3 = 0.333 + t1;
        const double t4 = t2 + t3;
        D[0] = t4;
        D[1] = t3;
        D[2] = t3;
        D[3] = 0.333;
    }
}

void two_link_coriolis_centrifugal(const double q[2], const double qd[2], double h[2])
{
    double angle[4], sine[4], cosine[4];
    {
        const double q2 = q[1];
        angle[0] = q2;
        angle[1] = 0.0;
        angle[2] = 0.0;
        angle[3] = 0.0;
    }
    if (any_far(angle, 4)) {
        by_library(angle, sine, cosine, 4);
    } else {
        polynomials(&angle[0], &sine[0], &cosine[0], block);
    }
    {
        const double qd1 = qd[0];
        const double qd2 = qd[1];
        const double sin1 = sine[0];
        const double t1 = qd1 + qd2;
        const double t2 = 0.5 * sin1;
        const double t3 = t1 * t2;
        const double t4 = t1 * t3;
        const double t5 = qd1 * t2;
        const double t6 = qd1 * t5;
        const double t7 = t6 - t4;
        h[0] = t7;
        h[1] = t6;
    }
}

void two_link_gravity_loading(const double q[2], double c[2])
{
    double angle[4], sine[4], cosine[4];
    {
        const double q1 = q[0];
        const double q2 = q[1];
        const double t1 = q1 + q2;
        angle[0] = q1;
        angle[1] = t1;
        angle[2] = 0.0;
        angle[3] = 0.0;
    }
    if (any_far(angle, 4)) {
        by_library(angle, sine, cosine, 4);
    } else {
        polynomials(&angle[0], &sine[0], &cosine[0], block);
    }
    {
        const double cos1 = cosine[0];
        const double cos2 = cosine[1];
        const double t1 = 19.612 * cos1;
        const double t2 = 4.903 * cos2;
        const double t3 = t1 + t2;
        c[0] = t3;
        c[1] = t2;
    }
}

/* torque of as many states as there are lanes; from number to number it is a stride */
static void torque_of_lanes(size_t stride, const double *q, const double *qd, const double *qdd, double *tau)
{
    double angle[2 * lanes], sine[2 * lanes], cosine[2 * lanes];
    double out[2][lanes];
    size_t j, l;
    for (l = 0; l < lanes; l++) {
        const double q1 = q[0 * stride + l];
        const double q2 = q[1 * stride + l];
        angle[0 * lanes + l] = q1;
        angle[1 * lanes + l] = q2;
    }
    if (any_far(&angle[0], 2 * lanes)) {
        by_library(&angle[0], &sine[0], &cosine[0], 2 * lanes);
    } else {
        polynomials(&angle[0], &sine[0], &cosine[0], 2 * lanes);
    }
    for (l = 0; l < lanes; l++) {
        const double qd1 = qd[0 * stride + l];
        const double qd2 = qd[1 * stride + l];
        const double qdd1 = qdd[0 * stride + l];
        const double qdd2 = qdd[1 * stride + l];
        const double sin1 = sine[0 * lanes + l];
        const double sin2 = sine[1 * lanes + l];
        const double cos1 = cosine[0 * lanes + l];
        const double cos2 = cosine[1 * lanes + l];
        const double t1 = qd1 + qd2;
        const double t2 = qdd1 + qdd2;
        const double t3 = cos1 * cos2;
        const double t4 = sin1 * sin2;
        const double t5 = t3 - t4;
        const double t6 = 19.612 * cos1;
        const double t7 = 0.5 * sin2;
        const double t8 = 0.5 * cos2;
        const double t9 = 4.903 * t5;
        const double t10 = t1 * t7;
        const double t11 = t1 * t10;
        const double t12 = t6 - t11;
        const double t13 = t2 * t8;
        const double t14 = t12 + t13;
        const double t15 = 1.667 * qdd1;
        const double t16 = t14 + t15;
        const double t17 = qd1 * t7;
        const double t18 = qd1 * t17;
        const double t19 = t9 + t18;
        const double t20 = qdd1 * t8;
        const double t21 = t19 + t20;
        const double t22 = 0.333 * t2;
        const double t23 = t21 + t22;
        const double t24 = t16 + t23;
        out[0][l] = t24;
        out[1][l] = t23;
    }
    for (j = 0; j < 2; j++)
        for (l = 0; l < lanes; l++)
            tau[j * stride + l] = out[j][l];
}

void two_link_torque_many(size_t count, const double *q, const double *qd, const double *qdd, double *tau)
{
    double given[3][2 * lanes], of_tau[2 * lanes];
    const size_t whole = count - count % lanes;
    size_t start, j, l;
    for (start = 0; start < whole; start += lanes)
        torque_of_lanes(count, q + start, qd + start, qdd + start, tau + start);
    if (whole == count)
        return;
    for (j = 0; j < 2; j++) {
        for (l = 0; l < lanes; l++) {
            const size_t from = j * count + (whole + l < count ? whole + l : whole);
            given[0][j * lanes + l] = q[from];
            given[1][j * lanes + l] = qd[from];
            given[2][j * lanes + l] = qdd[from];
        }
    }
    torque_of_lanes(lanes, given[0], given[1], given[2], of_tau);
    for (j = 0; j < 2; j++)
        for (l = 0; whole + l < count; l++)
            tau[j * count + whole + l] = of_tau[j * lanes + l];
}
