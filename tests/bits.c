// bits.c - a checksum over the bits of everything that many lookups give out. test_compile.sh
// compares it between compilers and levels of optimisation, long/test_wasm.sh with WebAssembly,
// where there is no libc and so nothing is printed. C99 and C++11. SPDX-License-Identifier: MIT
#if __STDC_HOSTED__
#include <stdio.h>
#endif

#include <stddef.h>

#include "sss_resample.h"

static uint32_t checksum = 2166136261u;
static uint32_t added = 0;
static uint32_t strange = 0;

static void add_bits(uint32_t bits) {
    checksum = (checksum ^ bits) * 16777619u;
    checksum ^= checksum >> 15;
}

static void add(float x) {
    add_bits(sssi_bits(x));
    ++added;
    if (!(x - x == 0.0f)) ++strange; // NaN or Inf
}

static void add_vector(sss_vec3 v) {
    add(v.x);
    add(v.y);
    add(v.z);
}

static sss_vec3 some_vector(uint32_t seed) {
    sss_vec3 v;
    v.x = 2.0f * sssi_unit(sss_hash(seed, 1)) - 1.0f;
    v.y = 2.0f * sssi_unit(sss_hash(seed, 2)) - 1.0f;
    v.z = 2.0f * sssi_unit(sss_hash(seed, 3)) - 1.0f;
    return v;
}

// Two hits on each probe, at places and with normals of no particular surface: only the bits matter
// here. Walks meet the surface on one segment of four, and scatter.
static void add_probe(sss_resampler *s, const sss_probe *probe, uint32_t seed) {
    add_vector(probe->origin);
    add_vector(probe->direction);
    add(probe->length);
    for (int i = 0; i < (s->walks && seed % 4u ? 0 : 2); ++i) {
        uint32_t name = sss_hash(seed, (uint32_t)i);
        float t = probe->length * sssi_unit(name);
        sss_vec3 n = some_vector(name);
        sss_vec3 p =
            sssi_add(probe->origin, sssi_mul(probe->direction, t)); // which no compiler may fuse
        add(sss_intensity(s, p, n));
        sss_add_hit(s, p, n, (name & 1u) ? 1.0f : 4.0f * sssi_unit(sss_hash(name, 4)));
    }
}

// The exit's weight for its own entry and for others nearby: more than there are lanes, of one
// medium and of two.
static void add_share(const sss_medium *m, const sss_exit *exit, sss_vec3 x, uint32_t seed) {
    enum { GROUP = 11 };
    sss_entry group[GROUP];
    sss_medium other = *m;
    for (int i = 0; i < GROUP; ++i) {
        sss_vec3 off = some_vector(seed + 10u + (uint32_t)i);
        group[i].position = sssi_add(x, sssi_mul(off, 0.1f * (float)i));
        group[i].medium = m;
    }

    float weight[GROUP][3];
    for (int media = 1; media <= 2; ++media) {
        if (media == 2) group[3].medium = &other;
        sss_share(exit, group, GROUP, 0, 0.1f, weight);
        for (int i = 0; i < GROUP; ++i) {
            for (int c = 0; c < 3; ++c) add(weight[i][c]);
        }
    }
}

static void add_lookup(const sss_medium *m, const sss_plan *plan, uint32_t seed) {
    sss_resampler s;
    sss_vec3 x = some_vector(seed), n = some_vector(seed + 1u);
    int probes = 0;
    add_bits((uint32_t)sss_begin_sample(&s, m, plan, x, n, seed, seed & 3u));
    sss_probe probe;
    while (sss_next_probe(&s, &probe)) add_probe(&s, &probe, sss_hash(seed, (uint32_t)++probes));
    sss_exit exits[SSS_MAX_EXITS];
    int count = sss_finish(&s, exits);
    add_bits((uint32_t)count);
    for (int i = 0; i < count; ++i) {
        add_vector(exits[i].position);
        add_vector(exits[i].normal);
        for (int c = 0; c < 3; ++c) add(exits[i].weight[c]);
        add_bits((uint32_t)exits[i].hit);
        add(exits[i].mass);
        if (seed % 4u == 0u) add_share(m, &exits[i], x, seed);
    }
}

static void add_plans(const sss_medium *m, uint32_t seed) {
    static const int counts[] = {0, 1, 2, 3, 7, 8, 13, 16};
    enum { COUNTS = sizeof counts / sizeof *counts, SETS = 18 };
    for (unsigned set = 0; set < SETS; ++set) {
        for (unsigned i = 0; i < 2u * COUNTS; ++i) {
            sss_plan plan;
            plan.candidates = counts[i / 2u];
            plan.exits = (int)((set + i) % (SSS_MAX_EXITS + 1u));
            plan.techniques = set < 16u ? set : 1u << (set - 12u); // SSS_WALK, SSS_LAMBERT alone
            plan.independent = (int)(i % 2u);
            plan.per_channel = (int)(i % 3u == 0u); // refused with several exits
            plan.tile = 0;
            add_lookup(m, &plan, sss_hash(seed, 16u * i + set));
        }
    }
    add_lookup(m, NULL, seed);
}

static void add_medium(const sss_medium *m) {
    static const float radius[] = {0.0f, 1e-9f, 1e-4f, 0.01f, 0.1f, 0.3f,
                                   1.0f, 2.5f,  7.0f,  30.0f, 1e3f, 1e20f};
    for (int c = 0; c < 3; ++c) {
        add(m->albedo[c]);
        add(m->length[c]);
        add(m->zv[c]);
        add(m->sigma[c]);
        add(m->flux[c]);
        add(m->fluence[c]);
        add(m->extinction[c]);
        add(m->similarity[c]);
        for (unsigned i = 0; i < sizeof radius / sizeof *radius; ++i) {
            add(sss_profile(m, c, radius[i]));
            add(sss_within(m, c, radius[i]));
        }
    }
    add(m->r_max);
}

static void add_advice(const sss_medium *m, float footprint, float curvature, float cost) {
    sss_need need;
    need.footprint = footprint;
    need.curvature_radius = curvature;
    need.shading_cost = cost;
    need.tolerance = 0.1f * cost;
    need.hinted = cost > 1.0f;
    sss_plan plan = sss_plan_for(m, &need);
    add_bits((uint32_t)plan.candidates);
    add_bits((uint32_t)plan.exits);
    add_bits(plan.techniques);
    add_bits((uint32_t)plan.per_channel);
    add_bits((uint32_t)plan.tile);
}

static void add_profile(int profile, const float *albedo, const float *length, float eta,
                        uint32_t seed) {
    sss_medium m;
    sss_result result = SSS_OK;
    if (profile == 0) result = sss_burley(&m, albedo, length);
    else if (profile == 1) result = sss_burley_mfp(&m, albedo, length);
    else if (profile == 2)
        result = sss_dipole(&m, albedo, length, eta); // albedo and length as coefficients
    else if (profile == 3) result = sss_better_dipole(&m, albedo, length, eta);
    else if (profile == 4) result = sss_dipole_from_albedo(&m, albedo, length, eta);
    else result = sss_better_dipole_from_albedo(&m, albedo, length, eta);
    add_bits((uint32_t)result);
    add_medium(&m);
    add_plans(&m, seed);
    add_advice(&m, 0.01f, 1.0f, 10.0f);
    add_advice(&m, 100.0f, 0.1f, 0.0f);
}

// The limits that a user may set: the greatest count works, one more is refused.
static int limits_hold(void) {
    static const float albedo[3] = {0.9f, 0.5f, 0.2f}, length[3] = {1.0f, 0.5f, 0.2f};
    sss_medium m;
    sss_plan plan;
    sss_vec3 x = {0.0f, 0.0f, 0.0f}, n = {0.0f, 0.0f, 1.0f};
    int good = sss_burley(&m, albedo, length) == SSS_OK, probes = 0;
    plan.candidates = SSS_MAX_CANDIDATES;
    plan.exits = SSS_MAX_EXITS;
    plan.techniques = SSS_CHORD;
    plan.independent = 0;
    plan.per_channel = 0;
    plan.tile = 0;
    sss_resampler s;
    good &= sss_begin(&s, &m, &plan, x, n, 1u) == SSS_OK;
    sss_probe probe;
    while (sss_next_probe(&s, &probe)) ++probes;
    good &= probes == SSS_MAX_CANDIDATES;
    plan.candidates = SSS_MAX_CANDIDATES + 1;
    good &= sss_begin(&s, &m, &plan, x, n, 1u) == SSS_BAD_PLAN;
    plan.candidates = SSS_MAX_CANDIDATES;
    plan.exits = SSS_MAX_EXITS + 1;
    good &= sss_begin(&s, &m, &plan, x, n, 1u) == SSS_BAD_PLAN;
    sss_need need;
    need.footprint = 0.0f;
    need.curvature_radius = 0.9f * m.r_max; // neither flat nor so small that it is walked
    need.tolerance = 0.9f;
    need.hinted = 1;
    need.shading_cost = 1e6f; // wants as many candidates as there can be: no more than are allowed
    plan = sss_plan_for(&m, &need);
    good &= plan.candidates > SSS_MAX_CANDIDATES / 2;
    good &= sss_begin(&s, &m, &plan, x, n, 1u) == SSS_OK;
    return good && sss_result_string(SSS_BAD_PLAN)[0] != '\0';
}

static void add_all(void) {
    static const float albedo[4][3] = {
        {0.8f, 0.8f, 0.8f}, {0.95f, 0.6f, 0.2f}, {0.9f, 0.0f, 0.5f}, {0.999f, 0.3f, 0.7f}};
    static const float length[4][3] = {
        {1.0f, 1.0f, 1.0f}, {1.0f, 0.3f, 0.05f}, {0.2f, 2.0f, 0.7f}, {3.0f, 0.0f, 0.01f}};
    static const float eta[4] = {1.0f, 1.33f, 0.8f, 1.5f};
    for (uint32_t i = 0; i < 24u; ++i) {
        add_profile((int)(i / 4u), albedo[i % 4u], length[i % 4u], eta[i % 4u], 1000u * i);
    }
}

#if __STDC_HOSTED__
int main(void) {
    add_all();
    printf("%08lx over %lu numbers\n", (unsigned long)checksum, (unsigned long)added);
    if (strange) fprintf(stderr, "%lu of them are not finite\n", (unsigned long)strange);
    if (!limits_hold()) {
        fprintf(stderr, "the limits on candidates or exits do not hold\n");
        return 1;
    }
    return strange != 0;
}
#else
__attribute__((export_name("checksum"))) uint32_t bits_checksum(void);
__attribute__((export_name("numbers"))) uint32_t bits_numbers(void);

// 0 if a number is not finite, or a limit does not hold.
uint32_t bits_checksum(void) {
    add_all();
    return strange || !limits_hold() ? 0u : checksum;
}

uint32_t bits_numbers(void) { return added; }
#endif
