/* See two_link.h for what this is, and how exact. */
#include "two_link.h"

#include <math.h>

const float two_link_sampled_error[2] = {
    0.0f, 0.0f
};
const float two_link_error_bound[2] = {
    0.1f, 0.43333402f
};
const float two_link_lower[2] = {
    (-0.7f), (-0.7f)
};
const float two_link_upper[2] = {
    1.0999999f, 1.0999999f
};
const float two_link_rate[2] = {
    2.3f, 2.3f
};
const float two_link_acceleration[2] = {
    3.3f, 3.3f
};

int two_link_is_within(const float q[2], const float qd[2], const float qdd[2])
{
    int j;
    for (j = 0; j < 2; j++) {
        if (!(q[j] >= two_link_lower[j] && q[j] <= two_link_upper[j]))
            return 0;
        if (!(fabsf(qd[j]) <= two_link_rate[j] && fabsf(qdd[j]) <= two_link_acceleration[j]))
            return 0;
    }
    return 1;
}

void two_link_torque(const float q[2], const float qd[2], const float qdd[2], float tau[2])
{
    const float q1 = q[0];
    const float q2 = q[1];
    const float qd1 = qd[0];
    const float qd2 = qd[1];
    const float qdd1 = qdd[0];
    const float qdd2 = qdd[1];
    const float t1 = qd1 + qd2;
    const float t2 = qdd1 + qdd2;
    const float cos_q1 = cosf(q1);
    const float t4 = 19.612f * cos_q1;
    const float t5 = 1.667f * qdd1;
    const float t6 = t4 + t5;
    const float cos_q2 = cosf(q2);
    const float t8 = 0.5f * cos_q2;
    const float t9 = t2 * t8;
    const float t10 = t6 + t9;
    const float t11 = t1 * t1;
    const float sin_q2 = sinf(q2);
    const float t13 = 0.5f * sin_q2;
    const float t14 = t11 * t13;
    const float t15 = t10 - t14;
    const float t16 = q1 + q2;
    const float cos_t16 = cosf(t16);
    const float t18 = 4.903f * cos_t16;
    const float t19 = 0.333f * t2;
    const float t20 = t18 + t19;
    const float t21 = qd1 * qd1;
    const float t22 = t13 * t21;
    const float t23 = t20 + t22;
    const float t24 = qdd1 * t8;
    const float t25 = t23 + t24;
    const float t26 = t15 + t25;
    tau[0] = t26;
    tau[1] = t25;
}

void two_link_inertia(const float q[2], float D[4])
{
    const float q2 = q[1];
    const float cos_q2 = cosf(q2);
    const float t2 = 0.5f * cos_q2;
    const float t3 = 1.667f + t2;
    const float t4 = 0.333f + t2;
    const float t5 = t3 + t4;
    D[0] = t5;
    D[1] = t4;
    D[2] = t4;
    D[3] = 0.333f;
}

void two_link_coriolis_centrifugal(const float q[2], const float qd[2], float h[2])
{
    const float q2 = q[1];
    const float qd1 = qd[0];
    const float qd2 = qd[1];
    const float t1 = qd1 + qd2;
    const float t2 = t1 * t1;
    const float sin_q2 = sinf(q2);
    const float t4 = 0.5f * sin_q2;
    const float t5 = qd1 * qd1;
    const float t6 = t2 + t2;
    const float t7 = t4 * t6;
    const float t8 = t5 + t5;
    const float t9 = t4 * t8;
    const float t10 = t9 - t7;
    const float t11 = 0.5f * t10;
    const float t12 = 0.5f * t9;
    h[0] = t11;
    h[1] = t12;
}

void two_link_gravity_loading(const float q[2], float c[2])
{
    const float q1 = q[0];
    const float q2 = q[1];
    const float cos_q1 = cosf(q1);
    const float t2 = 19.612f * cos_q1;
    const float t3 = q1 + q2;
    const float cos_t3 = cosf(t3);
    const float t5 = 4.903f * cos_t3;
    const float t6 = t2 + t5;
    c[0] = t6;
    c[1] = t5;
}

enum { lanes = 32 };

/* sines and cosines, as many as there are lanes */
static void sines_cosines(const float *x, float *sine, float *cosine)
{
    float near[lanes];
    size_t l;
    for (l = 0; l < lanes; l++)
        near[l] = fabsf(x[l]) <= 8000.0f ? x[l] : 0.0f;
    for (l = 0; l < lanes; l++) {
        const float y = near[l];
        const float half = y < 0.0f ? (-0.5f) : 0.5f;
        const int turns = (int)(y * 0.63661975f + half);
        const float k = (float)turns;
        const float r = ((y - k * 1.5703125f) - k * 0.0004837513f) - k * 7.54979e-08f;
        const float z = r * r;
        const float s = r + r * z * ((-0.16666655f) + z * (0.008332161f + z * ((-0.00019515296f))));
        const float c = 1.0f - 0.5f * z + z * z * (0.041666646f + z * ((-0.0013887316f) + z * (2.4433157e-05f)));
        const float odd = (float)(turns & 1);
        const float even = 1.0f - odd;
        const float of_sine = 1.0f - (float)(turns & 2);
        const float of_cosine = 1.0f - (float)((turns + 1) & 2);
        sine[l] = of_sine * (even * s + odd * c);
        cosine[l] = of_cosine * (even * c + odd * s);
    }
    for (l = 0; l < lanes; l++) {
        if (!(fabsf(x[l]) <= 8000.0f))
            sine[l] = cosine[l] = (float)NAN;
    }
}

static void take(size_t some, const float *from, float *to)
{
    size_t l;
    for (l = 0; l < some; l++)
        to[l] = from[l];
    for (; l < lanes; l++)
        to[l] = 0.0f;
}

void two_link_torque_many(size_t count, const float *q, const float *qd, const float *qdd, float *tau)
{
    float in_q1[lanes];
    float in_q2[lanes];
    float in_qd1[lanes];
    float in_qd2[lanes];
    float in_qdd1[lanes];
    float in_qdd2[lanes];
    float in_t16[lanes];
    float in_sin_q1[lanes], in_cos_q1[lanes];
    float in_sin_q2[lanes], in_cos_q2[lanes];
    float in_sin_t16[lanes], in_cos_t16[lanes];
    float out[2][lanes];
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
            const float q1 = in_q1[l];
            const float q2 = in_q2[l];
            const float t16 = q1 + q2;
            in_t16[l] = t16;
        }
        sines_cosines(in_q1, in_sin_q1, in_cos_q1);
        sines_cosines(in_q2, in_sin_q2, in_cos_q2);
        sines_cosines(in_t16, in_sin_t16, in_cos_t16);
        for (l = 0; l < lanes; l++) {
            const float qd1 = in_qd1[l];
            const float qd2 = in_qd2[l];
            const float qdd1 = in_qdd1[l];
            const float qdd2 = in_qdd2[l];
            const float cos_q1 = in_cos_q1[l];
            const float sin_q2 = in_sin_q2[l];
            const float cos_q2 = in_cos_q2[l];
            const float cos_t16 = in_cos_t16[l];
            const float t1 = qd1 + qd2;
            const float t2 = qdd1 + qdd2;
            const float t4 = 19.612f * cos_q1;
            const float t5 = 1.667f * qdd1;
            const float t6 = t4 + t5;
            const float t8 = 0.5f * cos_q2;
            const float t9 = t2 * t8;
            const float t10 = t6 + t9;
            const float t11 = t1 * t1;
            const float t13 = 0.5f * sin_q2;
            const float t14 = t11 * t13;
            const float t15 = t10 - t14;
            const float t18 = 4.903f * cos_t16;
            const float t19 = 0.333f * t2;
            const float t20 = t18 + t19;
            const float t21 = qd1 * qd1;
            const float t22 = t13 * t21;
            const float t23 = t20 + t22;
            const float t24 = qdd1 * t8;
            const float t25 = t23 + t24;
            const float t26 = t15 + t25;
            out[0][l] = t26;
            out[1][l] = t25;
        }
        for (j = 0; j < 2; j++)
            for (l = 0; l < some; l++)
                tau[(size_t)j * count + start + l] = out[j][l];
    }
}
