/* Fresnel factors, and next-event estimation at the exit. The header leaves both to the renderer.

   At the entry multiply by Ft(o), the transmittance towards the camera. At the exit replace white
   Lambert's 1 / pi by Ft(i) / (c pi), where c is the mean of Ft over cosine-distributed directions.
   What is not transmitted is reflected: F(o) belongs to your specular lobe. Then white light leaves
   a white object as it came, F + (1 - F) = 1; with a bare Ft(i) the object is c times as bright.
   Seen from the other side it is the same: Ft(o) Ft(i) / c is symmetric.

   The exit is lit by a square lamp in a white sky. One direction comes from the lamp, one from the
   cosine; the balance heuristic joins them. SPDX-License-Identifier: MIT */
#include "renderer.h"

#define ETA  1.33f
#define VIEW 0.4f /* cosine of the direction to the camera */

/* Reflectance of unpolarised light that comes from outside. */
static float fresnel(float cosine, float eta) {
    float inside = sqrtf(1.0f - (1.0f - cosine * cosine) / (eta * eta));
    float s = (cosine - eta * inside) / (cosine + eta * inside);
    float p = (eta * cosine - inside) / (eta * cosine + inside);

    return 0.5f * (s * s + p * p);
}

/* 1 - 2 * the first moment of that reflectance, for eta > 1 (Walsh 1926). Once for each
   material. */
static float mean_transmittance(double n) {
    double n2 = n * n, n4 = n2 * n2;
    double reflected =
        0.5 + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0)) +
        n2 * (n2 - 1.0) * (n2 - 1.0) / pow(n2 + 1.0, 3.0) * log((n - 1.0) / (n + 1.0)) -
        2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0)) +
        8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0) * (n4 - 1.0)) * log(n);

    return (float)(1.0 - reflected);
}

/* A random number for each use. */
static float uniform(uint32_t *state) {
    *state = sss_hash(*state, 1);
    return (float)(*state >> 8) / 16777216.0f;
}

/* The scene: a sky of radiance 1 everywhere, and in it a lamp, a patch of directions that is one
   square of side LAMP on the plane z = 1 and twice as bright. */
#define LAMP 0.5f
static int meets_lamp(sss_vec3 w) {
    return w.z > 0.0f && fabsf(w.x / w.z) < 0.5f * LAMP && fabsf(w.y / w.z) < 0.5f * LAMP;
}
static float radiance(sss_vec3 w) { return meets_lamp(w) ? 2.0f : 1.0f; }

/* Densities over solid angle. */
static float lamp_density(sss_vec3 w) {
    return meets_lamp(w) ? 1.0f / (LAMP * LAMP * w.z * w.z * w.z) : 0.0f;
}
static float cosine_density(float cosine) { return cosine > 0.0f ? cosine / PI : 0.0f; }

static sss_vec3 lamp_direction(float u, float v) {
    float x = LAMP * (u - 0.5f), y = LAMP * (v - 0.5f),
          inverse = 1.0f / sqrtf(1.0f + x * x + y * y);

    return vec(x * inverse, y * inverse, inverse);
}
static sss_vec3 cosine_direction(float up, float u, float v) { /* up: the sign of the normal's z */
    float r = sqrtf(u), turn = 2.0f * PI * v;

    return vec(r * cosf(turn), r * sinf(turn), up * sqrtf(1.0f - u));
}

/* One direction's part of the light that goes in at the exit: f cosine L / (sum of densities). */
static float lit(sss_vec3 w, float up, float c) {
    float cosine = up * w.z;

    if (!(cosine > 0.0f)) return 0.0f;
    float f = (1.0f - fresnel(cosine, ETA)) / (c * PI); /* white Lambert would be 1 / PI */
    return f * cosine * radiance(w) / (lamp_density(w) + cosine_density(cosine));
}
static float light_in(const sss_exit *exit, float c, uint32_t *state) {
    float up = exit->normal.z > 0.0f ? 1.0f : -1.0f;
    float u = uniform(state), v = uniform(state);
    float from_lamp = lit(lamp_direction(u, v), up, c);

    u = uniform(state);
    v = uniform(state);
    return from_lamp + lit(cosine_direction(up, u, v), up, c);
}

/* The sky gives 1; the lamp adds the integral of f cosine over itself, by the midpoint rule. */
static double lamp_adds(float c) {
    double sum = 0.0;
    int n = 256;

    for (int i = 0; i < n * n; ++i) {
        sss_vec3 w =
            lamp_direction(((float)(i % n) + 0.5f) / (float)n, ((float)(i / n) + 0.5f) / (float)n);

        sum += (double)((1.0f - fresnel(w.z, ETA)) / (c * PI) * w.z / lamp_density(w));
    }
    return sum / (double)(n * n);
}

int main(void) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, dmfp[3] = {0.2f, 0.2f, 0.2f};
    static tally transmitted, seen;
    float c = mean_transmittance((double)ETA);
    float reflected = fresnel(VIEW, ETA); /* the renderer's specular lobe in a white sky */
    sss_medium m;

    if (sss_burley(&m, white, dmfp) != SSS_OK) return 1;
    for (uint32_t i = 0; i < 4u * LOOKUPS; ++i) {
        uint32_t state = sss_hash(sss_hash(4, i), 1);
        float inside = 0.0f;
        sss_resampler s;
        sss_probe probe;
        sss_exit exit;
        ray_hit hit;

        sss_begin(&s, &m, NULL, entry_position(), entry_normal(), sss_hash(4, i));
        while (sss_next_probe(&s, &probe)) {
            float least = 0.0f;

            while (closest_hit(SLAB, probe.origin, probe.direction, least, probe.length, &hit)) {
                sss_add_hit(&s, hit.position, hit.normal, 1.0f);
                least = nextafterf(hit.t, HUGE_VALF);
            }
        }
        if (sss_finish(&s, &exit)) inside = exit.weight[0] * light_in(&exit, c, &state);
        tally_add(&seen, (double)(reflected + (1.0f - reflected) * inside));

        tally_add(&transmitted, (double)(1.0f - fresnel(sqrtf(uniform(&state)), ETA)));
    }
    tally_print(&transmitted, "mean transmittance", (double)c);
    tally_print(&seen, "sky and lamp", 1.0 + (double)(1.0f - reflected) * lamp_adds(c));
    return 0;
}
