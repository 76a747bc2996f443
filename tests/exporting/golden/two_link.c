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
    const double cos_q1 = cos(q1);
    const double t4 = 19.612 * cos_q1;
    const double t5 = 1.667 * qdd1;
    const double t6 = t4 + t5;
    const double cos_q2 = cos(q2);
    const double t8 = 0.5 * cos_q2;
    const double t9 = t2 * t8;
    const double t10 = t6 + t9;
    const double t11 = t1 * t1;
    const double sin_q2 = sin(q2);
    const double t13 = 0.5 * sin_q2;
    const double t14 = t11 * t13;
    const double t15 = t10 - t14;
    const double t16 = q1 + q2;
    const double cos_t16 = cos(t16);
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
    const double cos_q2 = cos(q2);
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
    const double sin_q2 = sin(q2);
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
    const double cos_q1 = cos(q1);
    const double t2 = 19.612 * cos_q1;
    const double t3 = q1 + q2;
    const double cos_t3 = cos(t3);
    const double t5 = 4.903 * cos_t3;
    const double t6 = t2 + t5;
    c[0] = t6;
    c[1] = t5;
}

enum { lanes = 32 };

/* sines and cosines, as many as there are lanes */
static void sines_cosines(const double *x, double *sine, double *cosine)
{
    double near[lanes];
    size_t l;
    for (l = 0; l < lanes; l++)
        near[l] = fabs(x[l]) <= 1000000.0 ? x[l] : 0.0;
    for (l = 0; l < lanes; l++) {
        const double y = near[l];
        const double half = y < 0.0 ? (-0.5) : 0.5;
        const int turns = (int)(y * 0.6366197723675814 + half);
        const double k = (double)turns;
        const double r = ((y - k * 1.5707963267341256) - k * 6.077100506303966e-11) - k * 2.0222662487959506e-21;
        const double z = r * r;
        const double s = r + r * z * ((-0.16666666666666632) + z * (0.00833333333332249 + z * ((-0.0001984126982985795) + z * (2.7557313707070068e-06 + z * ((-2.5050760253406863e-08) + z * (1.58969099521155e-10))))));
        const double c = 1.0 - 0.5 * z + z * z * (0.0416666666666666 + z * ((-0.001388888888887411) + z * (2.480158728947673e-05 + z * ((-2.7557314351390663e-07) + z * (2.087572321298175e-09 + z * ((-1.1359647557788195e-11)))))));
        const double odd = (double)(turns & 1);
        const double even = 1.0 - odd;
        const double of_sine = 1.0 - (double)(turns & 2);
        const double of_cosine = 1.0 - (double)((turns + 1) & 2);
        sine[l] = of_sine * (even * s + odd * c);
        cosine[l] = of_cosine * (even * c + odd * s);
    }
    for (l = 0; l < lanes; l++) {
        if (!(fabs(x[l]) <= 1000000.0))
            sine[l] = cosine[l] = (double)NAN;
    }
}

static void take(size_t some, const double *from, double *to)
{
    size_t l;
    for (l = 0; l < some; l++)
        to[l] = from[l];
    for (; l < lanes; l++)
        to[l] = 0.0;
}

void two_link_torque_many(size_t count, const double *q, const double *qd, const double *qdd, double *tau)
{
    double in_q1[lanes];
    double in_q2[lanes];
    double in_qd1[lanes];
    double in_qd2[lanes];
    double in_qdd1[lanes];
    double in_qdd2[lanes];
    double in_t16[lanes];
    double in_sin_q1[lanes], in_cos_q1[lanes];
    double in_sin_q2[lanes], in_cos_q2[lanes];
    double in_sin_t16[lanes], in_cos_t16[lanes];
    double out[2][lanes];
    size_t start, some, l;
    int j;
    for (start = 0; start < count; start += lanes) {
        some = count - start < lanes ? count - start : lanes;
        take(some, q + 0 * count + start, in_q1);
        take(some, q + 1 * count + start, in_q2);
        take(some, qd + 0 * count + start, in_qd1);
        take(some, qd + 1 * count + start, in_qd2);
        take(some, qdd + 0 * count + start, in_qdd1);
        take(some, qdd + 1 * count + start, in_qdd2);
        for (l = 0; l < lanes; l++) {
            const double q1 = in_q1[l];
            const double q2 = in_q2[l];
            const double t16 = q1 + q2;
            in_t16[l] = t16;
        }
        sines_cosines(in_q1, in_sin_q1, in_cos_q1);
        sines_cosines(in_q2, in_sin_q2, in_cos_q2);
        sines_cosines(in_t16, in_sin_t16, in_cos_t16);
        for (l = 0; l < lanes; l++) {
            const double qd1 = in_qd1[l];
            const double qd2 = in_qd2[l];
            const double qdd1 = in_qdd1[l];
            const double qdd2 = in_qdd2[l];
            const double cos_q1 = in_cos_q1[l];
            const double sin_q2 = in_sin_q2[l];
            const double cos_q2 = in_cos_q2[l];
            const double cos_t16 = in_cos_t16[l];
            const double t1 = qd1 + qd2;
            const double t2 = qdd1 + qdd2;
            const double t4 = 19.612 * cos_q1;
            const double t5 = 1.667 * qdd1;
            const double t6 = t4 + t5;
            const double t8 = 0.5 * cos_q2;
            const double t9 = t2 * t8;
            const double t10 = t6 + t9;
            const double t11 = t1 * t1;
            const double t13 = 0.5 * sin_q2;
            const double t14 = t11 * t13;
            const double t15 = t10 - t14;
            const double t18 = 4.903 * cos_t16;
            const double t19 = 0.333 * t2;
            const double t20 = t18 + t19;
            const double t21 = qd1 * qd1;
            const double t22 = t13 * t21;
            const double t23 = t20 + t22;
            const double t24 = qdd1 * t8;
            const double t25 = t23 + t24;
            const double t26 = t15 + t25;
            out[0][l] = t26;
            out[1][l] = t25;
        }
        for (j = 0; j < 2; j++)
            for (l = 0; l < some; l++)
                tau[(size_t)j * count + start + l] = out[j][l];
    }
}
