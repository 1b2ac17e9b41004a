// pixel.h - a pixel of the head, for C and for OpenCL C: the appendix of the tutorial compiles it
// by both. SPDX-License-Identifier: MIT
#include "sss_resample.h"

// [languages]
#if defined(__OPENCL_VERSION__)
#define TABLE __constant
#define sqrtf sqrt
#else
#define TABLE static const
#endif
// [/languages]

// Change these and see what happens.
TABLE float ball[4][4] = {{0, -0.15f, 0, 0.85f},
                          {-0.64f, 0.55f, 0, 0.36f},
                          {0.64f, 0.55f, 0, 0.36f},
                          {0, -0.35f, 0.68f, 0.34f}};
enum { BALLS = 4, SIDE = 240, SAMPLES = 4 };
#define TO_SUN vector(-0.8295614f, 0.5184759f, 0.2073903f)
#define SUN    5.0f
#define SKY    0.4f

typedef struct crossing {
    float t;
    sss_vec3 y, n;
} crossing;

static sss_vec3 vector(float x, float y, float z) { return (sss_vec3){x, y, z}; }
static float inner(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static float squared(sss_vec3 a) { return inner(a, a); }
static sss_vec3 move(sss_vec3 o, sss_vec3 w, float t) {
    return vector(o.x + t * w.x, o.y + t * w.y, o.z + t * w.z);
}
static sss_vec3 centre(int i) { return vector(ball[i][0], ball[i][1], ball[i][2]); }

static int inside_another(sss_vec3 y, int own) {
    for (int i = 0; i < BALLS; i++)
        if (i != own && squared(move(y, centre(i), -1.0f)) <= ball[i][3] * ball[i][3]) return 1;
    return 0;
}
static int all_hits(sss_vec3 o, sss_vec3 w, float t0, float t1, crossing *hits) {
    int count = 0;

    for (int i = 0; i < 2 * BALLS; i++) {
        sss_vec3 from = move(o, centre(i / 2), -1.0f);
        float r = ball[i / 2][3], b = inner(from, w), rest = r * r - squared(move(from, w, -b));
        if (rest <= 0.0f) continue;

        float t = (i % 2 ? sqrtf(rest) : -sqrtf(rest)) - b;
        sss_vec3 y = move(o, w, t);
        if (t < t0 || t > t1 || inside_another(y, i / 2)) continue;
        hits[count++] = (crossing){t, y, move(y, centre(i / 2), -1.0f)};
    }
    return count;
}
static crossing first_hit(sss_vec3 o, sss_vec3 w) {
    crossing hits[2 * BALLS], best = {-1.0f, {0, 0, 0}, {0, 0, 0}};
    int count = all_hits(o, w, 1e-3f, 1e9f, hits);

    for (int i = 0; i < count; i++)
        if (best.t < 0.0f || hits[i].t < best.t) best = hits[i];
    return best;
}
static float facing(crossing h) {
    float cosine = inner(h.n, TO_SUN);

    return cosine > 0.0f ? cosine / sqrtf(squared(h.n)) : 0.0f;
}
static float irradiance(crossing h) {
    return first_hit(h.y, TO_SUN).t < 0.0f ? SUN * facing(h) + SKY : SKY;
}

// [pixel]
static float number(uint32_t seed, uint32_t i) {
    return (float)(sss_hash(seed, i) >> 8) / 16777216.0f;
}

// The sum of a pixel's samples.
static sss_vec3 pixel(sss_medium wax, uint32_t i) {
    sss_vec3 sum = vector(0.0f, 0.0f, 0.0f), eye = vector(0.0f, 0.0f, 7.0f);

    for (uint32_t k = 0; k < SAMPLES; k++) {
        uint32_t seed = sss_hash(i, k);
        float x = 0.36f * (((float)(i % SIDE) + number(seed, 1)) / SIDE - 0.5f);
        float y = 0.36f * (0.5f - ((float)(i / SIDE) + number(seed, 2)) / SIDE);
        float far = sqrtf(x * x + y * y + 1.0f);
        crossing hits[2 * BALLS], entry = first_hit(eye, vector(x / far, y / far, -1.0f / far));
        sss_resampler s;
        sss_probe p;
        sss_exit e;
        if (entry.t < 0.0f) sum = move(sum, vector(0.05f, 0.055f, 0.07f), 1.0f);
        if (entry.t < 0.0f) continue;

        sss_begin(&s, &wax, 0, entry.y, entry.n, seed);
        while (sss_next_probe(&s, &p)) {
            int count = all_hits(p.origin, p.direction, 0.0f, p.length, hits);
            for (int j = 0; j < count; j++)
                sss_add_hit(&s, hits[j].y, hits[j].n, SUN * facing(hits[j]) + SKY);
        }
        if (!sss_finish(&s, &e)) continue;

        crossing exit_point = {0.0f, e.position, e.normal};
        sss_vec3 weight = vector(e.weight[0], e.weight[1], e.weight[2]);
        sum = move(sum, weight, irradiance(exit_point) / 3.14159265f);
    }
    return sum;
}
// [/pixel]

#if defined(__OPENCL_VERSION__)
// [kernel]
__kernel void render(sss_medium wax, __global sss_vec3 *picture) {
    picture[get_global_id(0)] = pixel(wax, (uint)get_global_id(0));
}
// [/kernel]
#endif
