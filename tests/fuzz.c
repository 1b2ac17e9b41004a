// fuzz.c - drives the whole interface by hostile bytes and says what is wrong with what came out:
// NaN, infinity, a negative weight, a weight above the bound that the header states, a loop without
// end, something bad that was accepted or something good that was refused. libFuzzer's entry (make
// fuzz); tests/test_fuzz.c runs the same over a kept corpus and over numbers at random. What is
// good is decided here by comparisons in double precision, not by the header.
// SPDX-License-Identifier: MIT
#include <float.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "sss_resample.h"

#define FUZZ_LOOKUPS 4 // of the medium that a file names

enum { BURLEY, BURLEY_MFP, DIPOLE, BETTER, DIPOLE_FROM, BETTER_FROM, CONSTRUCTORS };

// ---- Bytes: those given, and behind their end without limit what a generator makes of the first
// four.
typedef struct bytes {
    const uint8_t *at;
    size_t left;
    uint64_t state;
} bytes;

static uint32_t draw(bytes *b, size_t count) { // 1 or 4 bytes
    uint32_t bits = 0;
    if (b->left < count) {
        uint64_t z = b->state += UINT64_C(0x9e3779b97f4a7c15); // splitmix64
        b->left = 0;
        z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
        return (uint32_t)(z >> 32) >> (32u - 8u * (uint32_t)count);
    }
    for (size_t i = 0; i < count; ++i) bits |= (uint32_t)b->at[i] << (8u * i);
    b->at += count;
    b->left -= count;
    return bits;
}
static int chance(bytes *b, uint32_t of) { return draw(b, 1) % of == 0; } // 1 in `of`
static float unit(bytes *b) { return (float)(draw(b, 4) >> 8) / 16777216.0f; }
static float between(bytes *b, int low,
                     int high) { // 2^low to 2^high, every size as likely as any other
    int exponent = low + (int)(draw(b, 1) % (uint32_t)(high - low));
    return sssi_float((uint32_t)(exponent + 127) << 23 | (draw(b, 4) & 0x7fffffu));
}
static float any_special(bytes *b) { // among them the ends of each range and what is next to them
    static const float special[] = {
        0.0f,           -0.0f,   1.0f,           1.0000001f, -1.0f,       0.99999994f,
        1e-45f,         -1e-45f, FLT_MIN,        FLT_MAX,    -FLT_MAX,    1e-12f,
        9.9999990e-13f, 1e12f,   1.00000007e12f, 0.2f,       0.19999999f, 5.0f,
        5.0000005f,     1e-30f,  1e19f,          INFINITY,   -INFINITY,   NAN};
    return special[draw(b, 1) % (sizeof special / sizeof *special)];
}
static float any_float(bytes *b) {
    uint32_t kind = draw(b, 1);
    float sign = kind & 8u ? -1.0f : 1.0f;
    switch (kind % 8u) {
    case 0:
    case 1: return sssi_float(draw(b, 4));
    case 2: return any_special(b);
    case 3:
    case 4: return sign * between(b, -43, 43);
    default: return sign * between(b, -8, 4);
    }
}
static sss_vec3 any_vector(bytes *b) {
    sss_vec3 v;
    v.x = any_float(b);
    v.y = any_float(b);
    v.z = any_float(b);
    return v;
}

// ---- What is good, by the header's words
static int is_finite(float x) { return fabs((double)x) <= (double)FLT_MAX; } // false for NaN
static int is_finite3(sss_vec3 v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }
static int is_normal(sss_vec3 v) {
    double x = (double)v.x, y = (double)v.y, z = (double)v.z;
    return is_finite3(v) && x * x + y * y + z * z > 0.0;
}
static int is_place(sss_vec3 v) { // of an entry
    return fabs((double)v.x) <= (double)1e30f && fabs((double)v.y) <= (double)1e30f &&
           fabs((double)v.z) <= (double)1e30f;
}
static int is_within(float x, double low, double high) {
    return (double)x >= low && (double)x <= high;
}
static int is_length(float x) {
    return (double)x == 0.0 || is_within(x, (double)1e-12f, (double)1e12f);
}
static int is_named(sss_result result) {
    return result >= SSS_OK && result <= SSS_BAD_PLAN && sss_result_string(result)[0] &&
           sss_result_string(result) != sss_result_string((sss_result)(SSS_BAD_PLAN + 1));
}

// A medium, and what the checks need to know of it.
typedef struct subject {
    sss_medium medium;
    double sup; // b of the bound in the header
    int live, lambert;
} subject;

// Three albedos or coefficients, three lengths or coefficients, eta. Of four media three are meant
// to be good, else all lookups would be black; of these, one in eight has a special value
// somewhere.
static void any_parameters(bytes *b, int by_albedo, float v[7]) {
    static const float albedos[] = {0.0f, 1.0f,   0.99999994f, 0.9999999f,
                                    0.5f, 1e-30f, 1e-4f,       1e-40f};
    int good = !chance(b, 4), alike = chance(b, 2), base = alike ? (int)(draw(b, 1) % 72u) - 36 : 0;
    for (int c = 0; c < 7 && !good; ++c) v[c] = any_float(b);
    for (int c = 0; c < 3 && good; ++c) {
        v[c] = !by_albedo ? between(b, -39, 39) : chance(b, 2) ? unit(b) : albedos[draw(b, 1) % 8u];
        v[c + 3] = chance(b, 16) ? 0.0f
                   : alike       ? between(b, base - 2, base + 2)
                                 : between(b, -39, 39);
    }
    if (good) v[6] = 0.2f + 4.8f * unit(b);
    if (good && chance(b, 8)) v[draw(b, 1) % 7u] = any_special(b);
}
static sss_result construct(uint32_t which, sss_medium *m, const float v[7]) {
    switch (which) {
    case BURLEY: return sss_burley(m, v, v + 3);
    case BURLEY_MFP: return sss_burley_mfp(m, v, v + 3);
    case DIPOLE: return sss_dipole(m, v, v + 3, v[6]);
    case BETTER: return sss_better_dipole(m, v, v + 3, v[6]);
    case DIPOLE_FROM: return sss_dipole_from_albedo(m, v, v + 3, v[6]);
    default: return sss_better_dipole_from_albedo(m, v, v + 3, v[6]);
    }
}
static const char *make_medium(bytes *b, subject *k) {
    uint32_t which = draw(b, 1) % CONSTRUCTORS;
    int by_albedo = which != DIPOLE && which != BETTER, good_albedo = 1, good_length = 1;
    float v[7];
    sss_medium *m = &k->medium;
    any_parameters(b, by_albedo, v);
    for (int c = 0; c < 3; ++c) {
        if (by_albedo) good_albedo &= is_within(v[c], 0.0, 1.0);
        else good_length &= is_length(v[c]);
        good_length &= is_length(v[c + 3]);
    }
    int good_eta = which <= BURLEY_MFP || is_within(v[6], (double)0.2f, 5.0);
    sss_result result = construct(which, m, v);
    if (!is_named(result)) return "a constructor's result has no name";
    if ((result == SSS_OK) != (good_albedo && good_length && good_eta))
        return "a medium accepted or refused wrongly";
    if (result == SSS_BAD_ALBEDO   ? good_albedo
        : result == SSS_BAD_LENGTH ? good_length
                                   : result != SSS_OK && good_eta)
        return "a medium refused by the wrong name";
    if (result > SSS_BAD_ETA) return "a result that no constructor has";
    k->sup = which <= BURLEY_MFP ? 1.0 : (double)v[6] <= 2.0 ? 3.3 : 8.3;
    k->live = k->lambert = 0;
    for (int c = 0; c < 3; ++c) {
        if (!is_within(m->albedo[c], 0.0, 1.0)) return "a medium's albedo";
        if (result != SSS_OK && m->albedo[c] != 0.0f) return "a refused medium is not black";
        k->live += m->albedo[c] > 0.0f && m->length[c] > 0.0f;
        k->lambert += m->albedo[c] > 0.0f && !(m->length[c] > 0.0f);
    }
    return is_within(m->r_max, k->live ? (double)FLT_MIN : 0.0, 1e30) ? NULL : "r_max";
}

static const char *check_numbers(bytes *b, const sss_medium *m) {
    for (int i = 0; i < 4; ++i) {
        float r = any_float(b);
        int c = (int)(draw(b, 1) % 5u) - 1, channel = c >= 0 && c < 3;
        float rd = sss_profile(m, c, r);
        float within = sss_within(m, c, r);
        if (!is_within(rd, 0.0, (double)FLT_MAX)) return "sss_profile";
        if (!is_within(within, 0.0, channel ? (double)m->albedo[c] : 0.0)) return "sss_within";
        if ((!channel || !((double)r >= 0.0)) && (rd != 0.0f || within != 0.0f))
            return "a radius or channel that is none";
    }
    return NULL;
}

// Mostly few candidates and exits; else more, out of range, or any bits at all.
static sss_plan any_plan(bytes *b) {
    uint32_t kind = draw(b, 1);
    sss_plan plan;
    plan.candidates = (int)(draw(b, 1) % 4u);
    plan.exits = (int)(draw(b, 1) % (SSS_MAX_EXITS + 1u));
    plan.techniques = draw(b, 1) % 16u;
    uint32_t choices = draw(b, 1);
    plan.independent = (int)(choices % 2u);
    plan.per_channel = choices / 2u % 4u == 0u;
    plan.tile = (int)choices - 128;
    if (plan.per_channel && choices / 8u % 8u) plan.exits = (int)(choices / 8u % 2u);
    if (kind % 8u == 7u) plan.techniques = kind & 64u ? SSS_LAMBERT : SSS_WALK;
    if (kind % 32u == 1u) plan.candidates = (int)(draw(b, 1) * (SSS_MAX_CANDIDATES + 8u) / 256u);
    if (kind % 32u == 2u) plan.exits = (int)(draw(b, 1) % 16u) - 8;
    if (kind % 32u == 3u) plan.techniques = 1u << draw(b, 1) % 32u;
    if (kind % 64u == 4u) plan.candidates = (int)(draw(b, 4) & 0x7fffffffu) - 0x3fffffff;
    if (kind % 64u == 5u) plan.exits = (int)(draw(b, 4) & 0x7fffffffu) - 0x3fffffff;
    if (kind % 64u == 6u) plan.independent = (int)(draw(b, 4) & 0x7fffffffu) - 0x3fffffff;
    return plan;
}
static int is_plan(const sss_plan *plan) {
    int exits = plan->per_channel ? 1 : SSS_MAX_EXITS;
    int alone = plan->techniques == SSS_WALK || plan->techniques == SSS_LAMBERT;

    if (plan->per_channel && SSS_MAX_EXITS < 3) return 0;
    return plan->candidates >= 0 && plan->candidates <= SSS_MAX_CANDIDATES && plan->exits >= 0 &&
           plan->exits <= exits && (alone || plan->techniques < 16u);
}
// The model that is good enough for a need: one of four, in a plan that is taken.
static const char *check_need(bytes *b, const subject *k, sss_plan *plan) {
    sss_need need;

    need.footprint = any_float(b);
    need.curvature_radius = any_float(b);
    need.shading_cost = any_float(b);
    need.tolerance = need.shading_cost;
    need.hinted = need.footprint > 1.0f;
    *plan = sss_plan_for(&k->medium, &need);
    int one_disk = plan->techniques == SSS_DISK && plan->candidates == 1;
    if (plan->techniques && !one_disk && plan->techniques != SSS_WALK &&
        plan->techniques != SSS_LAMBERT)
        return "the plan's techniques";
    return is_plan(plan) && plan->tile >= 0 ? NULL : "the plan's counts";
}

// ---- Lookups

// The channels as a lookup of this plan sees them: a walk needs a volume, and to Lambert's plan all
// are without a profile.
static subject as_seen(const subject *k, const sss_plan *plan) {
    subject seen = *k;

    seen.live = seen.lambert = 0;
    for (int c = 0; c < 3; ++c) {
        if (plan->techniques == SSS_LAMBERT) seen.medium.length[c] = 0.0f;
        if (plan->techniques == SSS_WALK && !(k->medium.extinction[c] > 0.0f))
            seen.medium.length[c] = 0.0f;
        seen.live += seen.medium.albedo[c] > 0.0f && seen.medium.length[c] > 0.0f;
        seen.lambert += seen.medium.albedo[c] > 0.0f && !(seen.medium.length[c] > 0.0f);
    }
    return seen;
}

// The hints of each exit's hits, their sum and ends: what a weight may be.
typedef struct tally {
    double light[SSS_MAX_EXITS], least[SSS_MAX_EXITS], greatest[SSS_MAX_EXITS];
    int hits[SSS_MAX_EXITS], accepted;
} tally;

// Anywhere on the probe, at the entry or anywhere at all, with any normal and mostly without a
// hint.
static const char *add_hit(bytes *b, sss_resampler *s, const sss_probe *probe, sss_vec3 entry,
                           int exit, tally *t) {
    uint32_t kind = draw(b, 1);
    float along = probe->length * unit(b), light = kind & 8u ? any_float(b) : 1.0f;
    sss_vec3 x = entry, n = any_vector(b);
    if (kind % 8u == 0u) x = any_vector(b);
    if (kind % 8u > 1u) x = sssi_add(probe->origin, sssi_mul(probe->direction, along));
    float mu = sss_intensity(s, x, n);
    if (!is_within(mu, 0.0, (double)FLT_MAX)) return "sss_intensity";
    sss_add_hit(s, x, n, light);
    if (is_finite3(x) && is_normal(n) &&
        is_within(light, (double)FLT_MIN * 1e-9, (double)FLT_MAX)) {
        double hint = fmin(fmax((double)light, ldexp(1.0, -30)), ldexp(1.0, 30));
        t->light[exit] += hint;
        t->least[exit] = t->hits[exit] ? fmin(t->least[exit], hint) : hint;
        t->greatest[exit] = fmax(t->greatest[exit], hint);
        ++t->hits[exit];
        ++t->accepted;
    }
    return s->walks || s->weighed + s->hits.count == t->accepted
               ? NULL
               : "a hit that is wrong was taken, or one that is right dropped";
}

// Chord's share of the probes; 0: no bound is stated, or it is that of Lambert, for which any share
// does.
static double chord_share(unsigned techniques) {
    int n = 0;
    if (techniques == SSS_LAMBERT) return 1.0;
    for (int t = 0; t < 4; ++t) n += (int)(techniques >> t & 1u);
    return !techniques ? 0.25 : techniques & SSS_CHORD ? 1.0 / n : 0.0;
}
/* The greatest weight in channel c. A hit's part is at most hit = 2 b / (share M) of the target,
   and the held one's profile at most `live` of it, over the held one's hint, which is at least the
   least. The first exit may bear Lambert channels: then it stands for the mean hint of `lambert /
   live` hits more, and the entry has its albedo over the chance to be taken. Roundings: one of each
   sum for each hit, and a few. */
static double greatest_weight(const subject *k, int c, const sss_plan *plan, const tally *t,
                              int exit) {
    double share = chord_share(plan->techniques), albedo = (double)k->medium.albedo[c];
    if (share == 0.0) return (double)FLT_MAX;
    double hit = 2.0 * k->sup / (share * (plan->candidates ? plan->candidates : 8));
    double most = t->hits[exit] ? k->live * hit * t->light[exit] / t->least[exit] : 0.0;
    if (exit == 0 && k->lambert && t->hits[0] && !plan->per_channel)
        most += k->lambert * t->greatest[0] / t->least[0];
    if (!(k->medium.length[c] > 0.0f))
        most = exit ? 0.0 : 1.0 + hit * t->hits[0] * k->live / fmax(k->lambert, 1);
    return albedo * most * (1.0 + 1e-5 + 6e-8 * t->hits[exit]) + (double)FLT_MIN;
}
static const char *check_exits(const subject *k, const sss_plan *plan, const tally *t,
                               const sss_exit *exits, int count) {
    int exits_of_plan = plan->exits ? plan->exits : 1;
    if (count < 0 || count > (plan->per_channel ? k->live + (k->lambert > 0) : exits_of_plan))
        return "the number of exits";
    int e;
    for (int i = 0; i < count; ++i) {
        sss_vec3 n = exits[i].normal;
        double length =
            sqrt((double)n.x * (double)n.x + (double)n.y * (double)n.y + (double)n.z * (double)n.z);
        if (!is_finite3(exits[i].position) || !(fabs(length - 1.0) < 1e-6))
            return "an exit's place or normal";
        if (!is_within(exits[i].mass, 0.0, (double)FLT_MAX))
            return "a mass is negative or not finite";
        if (exits[i].hit < -1 || (exits[i].hit < 0 && !k->lambert))
            return "the number of an exit's hit";
        double most;
        for (int c = 0; c < 3; ++c) {
            if (!is_within(exits[i].weight[c], 0.0, (double)FLT_MAX))
                return "a weight is negative or not finite";
            for (e = 0, most = 0.0; e < exits_of_plan; ++e)
                most = fmax(most, greatest_weight(k, c, plan, t, e));
            if (!((double)exits[i].weight[c] <= most)) return "a weight above the bound";
        }
    }
    return NULL;
}

// What an exit is worth to others, among them an entry on the exit.
static const char *check_share(bytes *b, const subject *k, const sss_exit *exit, sss_vec3 entry) {
    sss_entry group[3];

    for (int i = 0; i < 3; ++i) group[i].medium = &k->medium;
    group[0].position = entry;
    group[1].position = exit->position;
    group[2].position = any_vector(b);
    if (!is_finite3(group[2].position)) group[2].position = entry;
    float weight[3][3];
    sss_share(exit, group, 3, 0, 1e-3f, weight);
    for (int i = 0; i < 3; ++i) {
        for (int c = 0; c < 3; ++c) {
            double most = (double)k->medium.albedo[c] * 3.0 * (double)exit->mass * (1.0 + 1e-5);

            if (!is_within(weight[i][c], 0.0, (double)FLT_MAX))
                return "a shared weight is negative or not finite";
            if (i > 0 && !((double)weight[i][c] <= most + (double)FLT_MIN))
                return "a shared weight above the bound";
        }
    }
    return NULL;
}

static const char *run_probes(bytes *b, sss_resampler *s, const subject *k, const sss_plan *plan,
                              sss_vec3 entry) {
    int limit = plan->candidates ? plan->candidates : 8,
        exits_of_plan = plan->exits ? plan->exits : 1;
    int walks = plan->techniques == SSS_WALK;
    uint32_t crowd = draw(b, 1);
    tally t = {{0.0}, {0.0}, {0.0}, {0}, 0};
    if (crowd == 0u) sss_add_hit(s, entry, entry, 1.0f); // of no probe
    int probes;
    sss_probe probe;
    const char *wrong;
    for (probes = 0; sss_next_probe(s, &probe); ++probes) {
        sss_vec3 d = probe.direction;
        double length =
            sqrt((double)d.x * (double)d.x + (double)d.y * (double)d.y + (double)d.z * (double)d.z);
        int hits = crowd == 1u ? 20 : (int)(draw(b, 1) % 3u);
        if (probes >= (walks ? 1000 * limit : limit)) return "a loop without end";
        if (!is_finite3(probe.origin) || !(fabs(length - 1.0) < 1e-6))
            return "a probe's origin or direction";
        if (!is_within(probe.length, (double)FLT_MIN, (double)FLT_MAX)) return "a probe's length";
        for (int i = 0; i < hits; ++i) // s->next: some of the plan's probes may be none
            if ((wrong = add_hit(b, s, &probe, entry, (s->next - 1) % exits_of_plan, &t)) != NULL)
                return wrong;
    }
    if (probes && !k->live) return "probes without a live channel";
    sss_exit exits[SSS_MAX_EXITS];
    int count = sss_finish(s, exits);
    wrong = check_exits(k, plan, &t, exits, count);
    if (wrong) return wrong;
    if (count && !t.accepted && !k->lambert) return "an exit out of nothing";
    for (int i = 0; i < count; ++i)
        if ((wrong = check_share(b, k, &exits[i], entry)) != NULL) return wrong;
    sss_exit again[SSS_MAX_EXITS];
    if (sss_finish(s, again) != count || sss_next_probe(s, &probe)) return "the end is not the end";
    return count && memcmp(again, exits, (size_t)count * sizeof *exits)
               ? "finished twice, with two results"
               : NULL;
}

static const char *run_lookup(bytes *b, const subject *k, const sss_plan *advised) {
    uint32_t kind = draw(b, 1);
    sss_plan given = any_plan(b);
    const sss_plan standard = {0, 0, 0u, 0, 0, 0}, *plan = kind % 16u == 0u   ? NULL
                                                           : kind % 16u == 1u ? advised
                                                                              : &given;
    sss_vec3 x = kind & 32u ? any_vector(b) : sssi_vec3(unit(b), unit(b), -3.0f * unit(b));
    sss_vec3 n = kind & 64u ? any_vector(b) : sssi_vec3(unit(b) - 0.5f, unit(b) - 0.5f, 1.0f);
    const sss_plan *used = plan ? plan : &standard;
    subject seen = as_seen(k, used);
    sss_resampler s;
    sss_result result = sss_begin(&s, &k->medium, plan, x, n, draw(b, 4));
    if (!is_named(result)) return "sss_begin's result has no name";
    if ((result == SSS_OK) != (is_plan(used) && is_place(x) && is_normal(n)))
        return "accepted or refused wrongly";
    if (result == SSS_OK) return run_probes(b, &s, &seen, used, x);
    if (result == SSS_BAD_PLAN       ? is_plan(used)
        : result == SSS_BAD_POSITION ? is_place(x)
                                     : is_normal(n))
        return "refused by the wrong name";
    if (result < SSS_BAD_NORMAL) return "a result that sss_begin has not";
    sss_probe probe;
    if (sss_next_probe(&s, &probe)) return "a probe of a refused lookup";
    sss_add_hit(&s, sssi_vec3(0.0f, 0.0f, 0.0f), sssi_vec3(0.0f, 0.0f, 1.0f), 1.0f);
    sss_exit exit;
    return sss_finish(&s, &exit) || sss_intensity(&s, x, n) != 0.0f ? "light of a refused lookup"
                                                                    : NULL;
}

// A medium and so many lookups: NULL, or what is wrong. Thread-safe.
static const char *fuzz_one(const uint8_t *data, size_t size, int lookups) {
    bytes b;
    b.at = data;
    b.left = size;
    b.state = 0;
    b.state = size >= 4 ? draw(&b, 4) : 0;
    subject k;
    const char *wrong = make_medium(&b, &k);
    if (!wrong) wrong = check_numbers(&b, &k.medium);
    sss_plan advised;
    if (!wrong) wrong = check_need(&b, &k, &advised);
    while (!wrong && lookups-- > 0) wrong = run_lookup(&b, &k, &advised);
    return wrong;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *wrong = fuzz_one(data, size, FUZZ_LOOKUPS);
    if (!wrong) return 0;
    fprintf(stderr, "%s\n", wrong);
    abort();
}
