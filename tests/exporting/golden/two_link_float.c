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

enum { lanes = 8 };

static const float largest = 8000.0f;

/* sine and cosine of an angle up to that */
static inline void polynomials(float x, float *sine, float *cosine)
{
    const int turns = (int)(x * 0.63661975f + (x < 0.0f ? (-0.5f) : 0.5f));
    const float k = (float)turns;
    const float r = ((x - k * 1.5703125f) - k * 0.0004837513f) - k * 7.54979e-08f;
    const float z = r * r;
    const float s = r + r * z * ((-0.16666655f) + z * (0.008332161f + z * ((-0.00019515296f))));
    const float c = 1.0f - 0.5f * z + z * z * (0.041666646f + z * ((-0.0013887316f) + z * (2.4433157e-05f)));
    const float odd = (float)(turns & 1);
    const float even = 1.0f - odd;
    const float of_sine = 1.0f - (float)(turns & 2);
    const float of_cosine = 1.0f - (float)((turns + 1) & 2);
    *sine = of_sine * (even * s + odd * c);
    *cosine = of_cosine * (even * c + odd * s);
}

/* sines and cosines of as many angles as there are lanes, those of too large ones by the library */
static void sines_cosines(const float *restrict x, float *restrict sine, float *restrict cosine)
{
    float y[lanes];
    int far = 0, l;
    for (l = 0; l < lanes; l++)
        y[l] = fabsf(x[l]) <= largest ? x[l] : 0.0f;
    for (l = 0; l < lanes; l++) {
        float s, c;
        polynomials(y[l], &s, &c);
        sine[l] = s;
        cosine[l] = c;
    }
    for (l = 0; l < lanes; l++)
        far |= !(fabsf(x[l]) <= largest);
    if (!far)
        return;
    for (l = 0; l < lanes; l++) {
        if (!(fabsf(x[l]) <= largest)) {
            sine[l] = sinf(x[l]);
            cosine[l] = cosf(x[l]);
        }
    }
}

void two_link_torque(const float q[2], const float qd[2], const float qdd[2], float tau[2])
{
    float angle[8] = { 0.0f }, sine[8], cosine[8];
    {
        const float q1 = q[0];
        const float q2 = q[1];
        const float t1 = q1 + q2;
        angle[0] = q1;
        angle[1] = q2;
        angle[2] = t1;
    }
    sines_cosines(&angle[0], &sine[0], &cosine[0]);
    {
        const float cos1 = cosine[0];
        const float cos2 = cosine[1];
        const float cos3 = cosine[2];
        const float qd1 = qd[0];
        const float qd2 = qd[1];
        const float qdd1 = qdd[0];
        const float qdd2 = qdd[1];
        const float sin2 = sine[1];
        const float t1 = qd1 + qd2;
        const float t2 = qdd1 + qdd2;
        const float t3 = 19.612f * cos1;
        const float t4 = 1.667f * qdd1;
        const float t5 = t3 + t4;
        const float t6 = 0.5f * cos2;
        const float t7 = t2 * t6;
        const float t8 = t5 + t7;
        const float t9 = t1 * t1;
        const float t10 = 0.5f * sin2;
        const float t11 = t9 * t10;
        const float t12 = t8 - t11;
        const float t13 = 4.903f * cos3;
        const float t14 = 0.333f * t2;
        const float t15 = t13 + t14;
        const float t16 = qd1 * qd1;
        const float t17 = t10 * t16;
        const float t18 = t15 + t17;
        const float t19 = qdd1 * t6;
        const float t20 = t18 + t19;
        const float t21 = t12 + t20;
        tau[0] = t21;
        tau[1] = t20;
    }
}

void two_link_inertia(const float q[2], float D[4])
{
    float angle[8] = { 0.0f }, sine[8], cosine[8];
    {
        const float q2 = q[1];
        angle[0] = q2;
    }
    sines_cosines(&angle[0], &sine[0], &cosine[0]);
    {
        const float cos1 = cosine[0];
        const float t1 = 0.5f * cos1;
        const float t2 = 1.667f + t1;
        const float t3 = 0.333f + t1;
        const float t4 = t2 + t3;
        D[0] = t4;
        D[1] = t3;
        D[2] = t3;
        D[3] = 0.333f;
    }
}

void two_link_coriolis_centrifugal(const float q[2], const float qd[2], float h[2])
{
    float angle[8] = { 0.0f }, sine[8], cosine[8];
    {
        const float q2 = q[1];
        angle[0] = q2;
    }
    sines_cosines(&angle[0], &sine[0], &cosine[0]);
    {
        const float qd1 = qd[0];
        const float qd2 = qd[1];
        const float sin1 = sine[0];
        const float t1 = qd1 + qd2;
        const float t2 = t1 * t1;
        const float t3 = 0.5f * sin1;
        const float t4 = qd1 * qd1;
        const float t5 = t2 + t2;
        const float t6 = t3 * t5;
        const float t7 = t4 + t4;
        const float t8 = t3 * t7;
        const float t9 = t8 - t6;
        const float t10 = 0.5f * t9;
        const float t11 = 0.5f * t8;
        h[0] = t10;
        h[1] = t11;
    }
}

void two_link_gravity_loading(const float q[2], float c[2])
{
    float angle[8] = { 0.0f }, sine[8], cosine[8];
    {
        const float q1 = q[0];
        const float q2 = q[1];
        const float t1 = q1 + q2;
        angle[0] = q1;
        angle[1] = t1;
    }
    sines_cosines(&angle[0], &sine[0], &cosine[0]);
    {
        const float cos1 = cosine[0];
        const float cos2 = cosine[1];
        const float t1 = 19.612f * cos1;
        const float t2 = 4.903f * cos2;
        const float t3 = t1 + t2;
        c[0] = t3;
        c[1] = t2;
    }
}

/* the torque of as many states as there are lanes; from joint to joint it is a stride */
static void torque_of_lanes(size_t stride, const float *q, const float *qd, const float *qdd, float *tau)
{
    float angle[2][lanes], sine[2][lanes], cosine[2][lanes];
    float out[2][lanes];
    size_t j, l;
    for (l = 0; l < lanes; l++) {
        const float q1 = q[0 * stride + l];
        const float q2 = q[1 * stride + l];
        angle[0][l] = q1;
        angle[1][l] = q2;
    }
    for (j = 0; j < 2; j++)
        sines_cosines(angle[j], sine[j], cosine[j]);
    for (l = 0; l < lanes; l++) {
        const float cos1 = cosine[0][l];
        const float cos2 = cosine[1][l];
        const float qd1 = qd[0 * stride + l];
        const float qd2 = qd[1 * stride + l];
        const float qdd1 = qdd[0 * stride + l];
        const float qdd2 = qdd[1 * stride + l];
        const float sin1 = sine[0][l];
        const float sin2 = sine[1][l];
        const float t1 = qd1 + qd2;
        const float t2 = qdd1 + qdd2;
        const float t3 = 19.612f * cos1;
        const float t4 = 1.667f * qdd1;
        const float t5 = t3 + t4;
        const float t6 = 0.5f * cos2;
        const float t7 = t2 * t6;
        const float t8 = t5 + t7;
        const float t9 = t1 * t1;
        const float t10 = 0.5f * sin2;
        const float t11 = t9 * t10;
        const float t12 = t8 - t11;
        const float t13 = cos1 * cos2;
        const float t14 = sin1 * sin2;
        const float t15 = t13 - t14;
        const float t16 = 4.903f * t15;
        const float t17 = 0.333f * t2;
        const float t18 = t16 + t17;
        const float t19 = qd1 * qd1;
        const float t20 = t10 * t19;
        const float t21 = t18 + t20;
        const float t22 = qdd1 * t6;
        const float t23 = t21 + t22;
        const float t24 = t12 + t23;
        out[0][l] = t24;
        out[1][l] = t23;
    }
    for (j = 0; j < 2; j++)
        for (l = 0; l < lanes; l++)
            tau[j * stride + l] = out[j][l];
}

void two_link_torque_many(size_t count, const float *q, const float *qd, const float *qdd, float *tau)
{
    float rest[4][2 * lanes];
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
