/* See two_link.h for what this is, and how exact. */
#include "two_link.h"

#include <math.h>

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
const double two_link_rate[2] = {
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
        if (!(fabs(qd[j]) <= two_link_rate[j] && fabs(qdd[j]) <= two_link_acceleration[j]))
            return 0;
    }
    return 1;
}

static const double largest = 1000000.0;

/* sine and cosine of an angle up to that */
static inline void polynomials(double x, double *sine, double *cosine)
{
    const int turns = (int)(x * 0.6366197723675814 + (x < 0.0 ? (-0.5) : 0.5));
    const double k = (double)turns;
    const double r = ((x - k * 1.5707963267341256) - k * 6.077100506303966e-11) - k * 2.0222662487959506e-21;
    const double z = r * r;
    const double s = r + r * z * ((-0.16666666666666632) + z * (0.00833333333332249 + z * ((-0.0001984126982985795) + z * (2.7557313707070068e-06 + z * ((-2.5050760253406863e-08) + z * (1.58969099521155e-10))))));
    const double c = 1.0 - 0.5 * z + z * z * (0.0416666666666666 + z * ((-0.001388888888887411) + z * (2.480158728947673e-05 + z * ((-2.7557314351390663e-07) + z * (2.087572321298175e-09 + z * ((-1.1359647557788195e-11)))))));
    const double odd = (double)(turns & 1);
    const double even = 1.0 - odd;
    const double of_sine = 1.0 - (double)(turns & 2);
    const double of_cosine = 1.0 - (double)((turns + 1) & 2);
    *sine = of_sine * (even * s + odd * c);
    *cosine = of_cosine * (even * c + odd * s);
}

/* sine and cosine of any angle */
static void sine_cosine(double x, double *sine, double *cosine)
{
    if (fabs(x) <= largest) {
        polynomials(x, sine, cosine);
    } else {
        *sine = sin(x);
        *cosine = cos(x);
    }
}

void two_link_torque(const double q[2], const double qd[2], const double qdd[2], double tau[2])
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qdd1 = qdd[0];
    const double qdd2 = qdd[1];
    const double t1 = qd1 + qd2;
    const double t2 = qdd1 + qdd2;
    double sin_q1, cos_q1;
    sine_cosine(q1, &sin_q1, &cos_q1);
    const double t4 = 19.612 * cos_q1;
    const double t5 = 1.667 * qdd1;
    const double t6 = t4 + t5;
    double sin_q2, cos_q2;
    sine_cosine(q2, &sin_q2, &cos_q2);
    const double t8 = 0.5 * cos_q2;
    const double t9 = t2 * t8;
    const double t10 = t6 + t9;
    const double t11 = t1 * t1;
    const double t13 = 0.5 * sin_q2;
    const double t14 = t11 * t13;
    const double t15 = t10 - t14;
    const double t16 = q1 + q2;
    double sin_t16, cos_t16;
    sine_cosine(t16, &sin_t16, &cos_t16);
    const double t18 = 4.903 * cos_t16;
    const double t19 = 0.333 * t2;
    const double t20 = t18 + t19;
    const double t21 = qd1 * qd1;
    const double t22 = t13 * t21;
    const double t23 = t20 + t22;
    const double t24 = qdd1 * t8;
    const double t25 = t23 + t24;
    const double t26 = t15 + t25;
    tau[0] = t26;
    tau[1] = t25;
}

void two_link_inertia(const double q[2], double D[4])
{
    const double q2 = q[1];
    double sin_q2, cos_q2;
    sine_cosine(q2, &sin_q2, &cos_q2);
    const double t2 = 0.5 * cos_q2;
    const double t3 = 1.667 + t2;
    const double t4 = 0.333 + t2;
    const double t5 = t3 + t4;
    D[0] = t5;
    D[1] = t4;
    D[2] = t4;
    D[3] = 0.333;
}

void two_link_coriolis_centrifugal(const double q[2], const double qd[2], double h[2])
{
    const double q2 = q[1];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double t1 = qd1 + qd2;
    const double t2 = t1 * t1;
    double sin_q2, cos_q2;
    sine_cosine(q2, &sin_q2, &cos_q2);
    const double t4 = 0.5 * sin_q2;
    const double t5 = qd1 * qd1;
    const double t6 = t2 + t2;
    const double t7 = t4 * t6;
    const double t8 = t5 + t5;
    const double t9 = t4 * t8;
    const double t10 = t9 - t7;
    const double t11 = 0.5 * t10;
    const double t12 = 0.5 * t9;
    h[0] = t11;
    h[1] = t12;
}

void two_link_gravity_loading(const double q[2], double c[2])
{
    const double q1 = q[0];
    const double q2 = q[1];
    double sin_q1, cos_q1;
    sine_cosine(q1, &sin_q1, &cos_q1);
    const double t2 = 19.612 * cos_q1;
    const double t3 = q1 + q2;
    double sin_t3, cos_t3;
    sine_cosine(t3, &sin_t3, &cos_t3);
    const double t5 = 4.903 * cos_t3;
    const double t6 = t2 + t5;
    c[0] = t6;
    c[1] = t5;
}

enum { lanes = 16 };

/* sines and cosines of x; none of angles too large */
static void sines_cosines(const double *x, double *sine, double *cosine)
{
    double y[lanes], none[lanes];
    size_t l;
    for (l = 0; l < lanes; l++)
        y[l] = fabs(x[l]) <= largest ? x[l] : 0.0;
    for (l = 0; l < lanes; l++)
        none[l] = fabs(x[l]) <= largest ? 0.0 : (double)NAN;
    for (l = 0; l < lanes; l++) {
        double s, c;
        polynomials(y[l], &s, &c);
        sine[l] = s + none[l];
        cosine[l] = c + none[l];
    }
}

/* the torque of as many states as there are lanes; from joint to joint it is a stride */
static void torque_of_lanes(size_t stride, const double *q, const double *qd, const double *qdd, double *tau)
{
    double angle[lanes], sine[2][lanes], cosine[2][lanes];
    double out[2][lanes];
    size_t j, l;
    for (l = 0; l < lanes; l++) {
        const double q1 = q[0 * stride + l];
        angle[l] = q1;
    }
    sines_cosines(angle, sine[0], cosine[0]);
    for (l = 0; l < lanes; l++) {
        const double q2 = q[1 * stride + l];
        angle[l] = q2;
    }
    sines_cosines(angle, sine[1], cosine[1]);
    for (l = 0; l < lanes; l++) {
        const double cos1 = cosine[0][l];
        const double cos2 = cosine[1][l];
        const double qd1 = qd[0 * stride + l];
        const double qd2 = qd[1 * stride + l];
        const double qdd1 = qdd[0 * stride + l];
        const double qdd2 = qdd[1 * stride + l];
        const double sin1 = sine[0][l];
        const double sin2 = sine[1][l];
        const double t1 = qd1 + qd2;
        const double t2 = qdd1 + qdd2;
        const double t3 = 19.612 * cos1;
        const double t4 = 1.667 * qdd1;
        const double t5 = t3 + t4;
        const double t6 = 0.5 * cos2;
        const double t7 = t2 * t6;
        const double t8 = t5 + t7;
        const double t9 = t1 * t1;
        const double t10 = 0.5 * sin2;
        const double t11 = t9 * t10;
        const double t12 = t8 - t11;
        const double t13 = cos1 * cos2;
        const double t14 = sin1 * sin2;
        const double t15 = t13 - t14;
        const double t16 = 4.903 * t15;
        const double t17 = 0.333 * t2;
        const double t18 = t16 + t17;
        const double t19 = qd1 * qd1;
        const double t20 = t10 * t19;
        const double t21 = t18 + t20;
        const double t22 = qdd1 * t6;
        const double t23 = t21 + t22;
        const double t24 = t12 + t23;
        out[0][l] = t24;
        out[1][l] = t23;
    }
    for (j = 0; j < 2; j++)
        for (l = 0; l < lanes; l++)
            tau[j * stride + l] = out[j][l];
}

void two_link_torque_many(size_t count, const double *q, const double *qd, const double *qdd, double *tau)
{
    double rest[4][2 * lanes];
    const size_t whole = count - count % lanes;
    size_t start, j, l;
    for (start = 0; start < whole; start += lanes)
        torque_of_lanes(count, q + start, qd + start, qdd + start, tau + start);
    if (whole == count)
        return;
    for (j = 0; j < 2; j++) {
        for (l = 0; l < lanes; l++) {
            const size_t from = j * count + (whole + l < count ? whole + l : whole);
            rest[0][j * lanes + l] = q[from];
            rest[1][j * lanes + l] = qd[from];
            rest[2][j * lanes + l] = qdd[from];
        }
    }
    torque_of_lanes(lanes, rest[0], rest[1], rest[2], rest[3]);
    for (j = 0; j < 2; j++)
        for (l = 0; whole + l < count; l++)
            tau[j * count + whole + l] = rest[3][j * lanes + l];
}
