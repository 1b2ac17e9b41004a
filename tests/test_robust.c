// test_robust.c - whatever goes in, errors have names and no NaN or infinity comes out.
// SPDX-License-Identifier: MIT
#include "sss_test.h"

static const float wrong_floats[] = {NAN, INFINITY, -INFINITY, -1.0f, 2.0f, 1e-13f, 1e13f};
#define WRONG (int)(sizeof wrong_floats / sizeof *wrong_floats)

static int is_finite(float x) { return x - x == 0.0f; }
static int is_finite3(sss_vec3 v) { return is_finite(v.x) && is_finite(v.y) && is_finite(v.z); }
static const sss_vec3 origin = {0.0f, 0.0f, 0.0f}, up = {0.0f, 0.0f, 1.0f};

static sss_vec3 vector(float x, float y, float z) {
    sss_vec3 v = {x, y, z};
    return v;
}

// ---- Constructors

enum { BURLEY, BURLEY_MFP, DIPOLE, BETTER, DIPOLE_FROM, BETTER_FROM, CONSTRUCTORS };

static sss_result make(int which, sss_medium *m, const float *a, const float *b, float eta) {
    switch (which) {
    case BURLEY: return sss_burley(m, a, b);
    case BURLEY_MFP: return sss_burley_mfp(m, a, b);
    case DIPOLE: return sss_dipole(m, a, b, eta);
    case BETTER: return sss_better_dipole(m, a, b, eta);
    case DIPOLE_FROM: return sss_dipole_from_albedo(m, a, b, eta);
    default: return sss_better_dipole_from_albedo(m, a, b, eta);
    }
}

static sss_medium skin(int which) {
    static const float albedo[3] = {0.8f, 0.5f, 0.3f}, length[3] = {1.0f, 0.4f, 0.1f};
    sss_medium m;
    assert_int_equal(make(which, &m, albedo, length, 1.33f), SSS_OK);
    return m;
}

// A black medium gives no light by any function and any lookup.
static void expect_black(const char *name, const sss_medium *m) {
    for (int c = 0; c < 3; ++c) {
        check_equal(name, sss_profile(m, c, 0.5f) == 0.0f && sss_within(m, c, 0.5f) == 0.0f, 1);
        check_equal(name, m->albedo[c] == 0.0f, 1);
    }
    sss_resampler s;
    check_equal(name, sss_begin(&s, m, NULL, origin, up, 1u), SSS_OK);
    sss_probe probe;
    check_equal(name, sss_next_probe(&s, &probe), 0);
    sss_add_hit(&s, origin, up, 1.0f);
    sss_exit exits[SSS_MAX_EXITS];
    check_equal(name, sss_finish(&s, exits), 0);
    check_equal(name, sss_intensity(&s, origin, up) == 0.0f, 1);
}

static void expect_made(const char *name, int which, const float *a, const float *b, float eta,
                        sss_result expected) {
    sss_medium m;
    memset(&m, 0xff, sizeof m); // NaN all over: the constructor must not leave any of it
    check_equal(name, (long)make(which, &m, a, b, eta), (long)expected);
    if (expected != SSS_OK) expect_black(name, &m);
}

// Each field in turn takes each wrong value. 2 is a length, and 1e-13 an albedo.
static void wrong_field(int which, int field, float wrong) {
    float a[3] = {0.8f, 0.5f, 0.3f}, b[3] = {1.0f, 0.4f, 0.1f}, eta = 1.33f;
    int by_albedo = which != DIPOLE && which != BETTER;
    sss_result expected = field < 3 && by_albedo ? SSS_BAD_ALBEDO
                          : field < 6            ? SSS_BAD_LENGTH
                                                 : SSS_BAD_ETA;
    if (field < 3) a[field] = wrong;
    else if (field < 6) b[field - 3] = wrong;
    else eta = wrong;
    if (expected == SSS_BAD_ALBEDO ? wrong == 1e-13f : wrong == 2.0f) expected = SSS_OK;
    if (field == 6 && (which == BURLEY || which == BURLEY_MFP))
        expected = SSS_OK; // they take no eta
    char name[80];
    snprintf(name, sizeof name, "constructor %d, field %d = %g", which, field, (double)wrong);
    expect_made(name, which, a, b, eta, expected);
}

static void test_constructors(void **state) {
    (void)state;
    for (int which = 0; which < CONSTRUCTORS; ++which)
        for (int field = 0; field < 7; ++field)
            for (int i = 0; i < WRONG; ++i) wrong_field(which, field, wrong_floats[i]);
}

// The ends of each range are in it.
static void test_ranges(void **state) {
    static const float ends[] = {0.0f, 1e-12f, 1e12f};
    (void)state;
    for (int which = 0; which < CONSTRUCTORS; ++which) {
        for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) {
                float a[3] = {0.5f, 0.0f, 1.0f}, b[3];
                b[0] = b[1] = b[2] = ends[i];
                if (which == DIPOLE || which == BETTER) a[0] = a[1] = a[2] = ends[k];
                expect_made("the ends of the ranges", which, a, b, k == 0 ? 0.2f : 5.0f, SSS_OK);
            }
        }
    }
}

static void test_names(void **state) {
    (void)state;
    for (int i = SSS_OK; i <= SSS_BAD_PLAN + 1; ++i) {
        const char *text = sss_result_string((sss_result)i);
        assert_true(text && strlen(text) > 1 && !strchr(text, '\n') &&
                    text[strlen(text) - 1] != '.');
        for (int k = SSS_OK; k < i; ++k)
            assert_string_not_equal(text, sss_result_string((sss_result)k));
    }
    assert_string_equal(sss_result_string((sss_result)77),
                        sss_result_string((sss_result)(SSS_BAD_PLAN + 1)));
}

// ---- Lookups that are refused

static void expect_refused(const char *name, const sss_plan *plan, sss_vec3 position,
                           sss_vec3 normal, sss_result expected) {
    static const float albedo[3] = {0.8f, 0.5f, 0.3f},
                       length[3] = {1.0f, 0.0f, 0.1f}; // Lambert among live channels
    sss_medium m;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    sss_resampler s;
    memset(&s, 0xff, sizeof s);
    check_equal(name, (long)sss_begin(&s, &m, plan, position, normal, 1u), (long)expected);
    sss_probe probe;
    check_equal(name, sss_next_probe(&s, &probe), 0);
    sss_add_hit(&s, origin, up, 1.0f);
    sss_exit exits[SSS_MAX_EXITS];
    check_equal(name, sss_finish(&s, exits), 0);
    check_equal(name, sss_intensity(&s, vector(0.1f, 0.2f, 0.0f), up) == 0.0f, 1);
}

static sss_plan plan_of(int candidates, int exits, unsigned techniques, int independent) {
    sss_plan plan = {0, 0, 0u, 0, 0, 0};
    plan.candidates = candidates;
    plan.exits = exits;
    plan.techniques = techniques;
    plan.independent = independent;
    return plan;
}

static void test_bad_plans(void **state) {
    static const unsigned techniques[] = {
        SSS_WALK | SSS_DISK, SSS_LAMBERT | SSS_CHORD, SSS_WALK | SSS_LAMBERT, 64u, 0x80000000u,
        0xffffffffu};
    static const int counts[] = {-1, INT32_MIN, INT32_MAX, 0};
    (void)state;
    for (int i = 0; i < 6; ++i) {
        sss_plan plan = plan_of(8, 1, techniques[i], 0);
        expect_refused("unknown technique, or one that stands alone beside others", &plan, origin,
                       up, SSS_BAD_PLAN);
    }
    for (int i = 0; i < 4; ++i) {
        sss_plan plan = plan_of(counts[i] ? counts[i] : SSS_MAX_CANDIDATES + 1, 1, 0u, 0);
        expect_refused("candidates", &plan, origin, up, SSS_BAD_PLAN);
        plan = plan_of(8, counts[i] ? counts[i] : SSS_MAX_EXITS + 1, 0u, 0);
        expect_refused("exits", &plan, origin, up, SSS_BAD_PLAN);
    }
    for (int i = 2; i <= SSS_MAX_EXITS; ++i) {
        sss_plan plan = plan_of(8, i, 0u, 0);
        plan.per_channel = 1;
        expect_refused("several exits beside one for each channel", &plan, origin, up,
                       SSS_BAD_PLAN);
    }
}

static void test_bad_points(void **state) {
    static const float wrong[] = {NAN, INFINITY, -INFINITY, 1.0001e30f, -3.4e38f};
    sss_medium m = skin(BURLEY);
    sss_resampler s;
    (void)state;
    assert_int_equal(
        sss_begin(&s, &m, NULL, vector(1e30f, -1e30f, 1e30f), vector(1e38f, 0.0f, 1.0f), 1u),
        SSS_OK);
    for (int i = 0; i < 5; ++i) {
        for (int k = 0; k < 3; ++k) {
            sss_vec3 v = vector(k == 0 ? wrong[i] : 1.0f, k == 1 ? wrong[i] : 1.0f,
                                k == 2 ? wrong[i] : 1.0f);
            expect_refused("position", NULL, v, up, SSS_BAD_POSITION);
            if (i < 3) expect_refused("normal", NULL, origin, v, SSS_BAD_NORMAL);
        }
    }
    expect_refused("zero normal", NULL, origin, origin, SSS_BAD_NORMAL);
    expect_refused("zero normal", NULL, origin, vector(-0.0f, 0.0f, -0.0f), SSS_BAD_NORMAL);
}

// ---- Hits

// Hits on the plane z = 0 of every probe, and before and after each of them the bad one, if any. An
// exit says which call it was: that is compared here and forgotten, so that lookups with other
// calls can be compared.
typedef struct bad_hit {
    sss_vec3 position, normal;
    float light;
} bad_hit;

static int look_up(const sss_medium *m, const sss_plan *plan, uint32_t seed, const bad_hit *bad,
                   float light, sss_exit *exits) {
    st_fixture plane = st_standard(ST_PLANE, st_stay());
    sss_resampler s;
    int calls = 0;
    assert_int_equal(sss_begin(&s, m, plan, origin, up, seed), SSS_OK);
    st_hit hits[ST_MAX_HITS];
    sss_probe probe;
    sss_vec3 called[100];
    int n;
    while (sss_next_probe(&s, &probe)) {
        n = st_trace(&plane, &probe, hits);
        for (int i = 0; i <= n; ++i) {
            if (bad) sss_add_hit(&s, bad->position, bad->normal, bad->light);
            if (bad) called[calls++] = bad->position;
            if (i == n) continue;
            sss_add_hit(&s, hits[i].position, hits[i].normal, light);
            called[calls++] = hits[i].position;
        }
    }
    memset(exits, 0, SSS_MAX_EXITS * sizeof *exits);
    n = sss_finish(&s, exits);
    for (int i = 0; i < n; ++i) {
        assert_in_range(exits[i].hit + 1, 0, calls);
        assert_memory_equal(&exits[i].position, exits[i].hit < 0 ? &origin : &called[exits[i].hit],
                            sizeof origin);
        exits[i].hit = 0;
    }
    return n;
}

static void expect_ignored(const sss_medium *m, bad_hit bad) {
    for (uint32_t seed = 0; seed < 40u; ++seed) {
        sss_plan plan = plan_of((int)(seed % 9u), (int)(seed % (SSS_MAX_EXITS + 1u)), seed % 16u,
                                (int)(seed / 20u));
        sss_exit with[SSS_MAX_EXITS], without[SSS_MAX_EXITS];
        int n = look_up(m, &plan, seed, NULL, 0.7f, without);
        assert_int_equal(look_up(m, &plan, seed, &bad, 0.7f, with), n);
        assert_memory_equal(with, without, sizeof with);
    }
}

static void test_bad_hits(void **state) {
    static const float wrong[] = {NAN, INFINITY, -INFINITY};
    static const float dark[] = {NAN, INFINITY, -INFINITY, -1.0f, -1e-45f, 0.0f, -0.0f};
    static const float albedo[3] = {0.8f, 0.5f, 0.3f}, length[3] = {1.0f, 0.0f, 0.1f};
    const bad_hit good = {{0.1f, 0.2f, 0.0f}, {0.0f, 0.0f, 1.0f}, 1.0f};
    sss_medium media[2];
    (void)state;
    media[0] = skin(BETTER);
    assert_int_equal(sss_burley(&media[1], albedo, length), SSS_OK);
    for (int k = 0; k < 2; ++k) {
        bad_hit bad = good;
        for (int i = 0; i < 3; ++i) {
            bad = good, bad.position.x = wrong[i], expect_ignored(&media[k], bad);
            bad = good, bad.position.z = wrong[i], expect_ignored(&media[k], bad);
            bad = good, bad.normal.y = wrong[i], expect_ignored(&media[k], bad);
            bad = good, bad.normal.z = wrong[i], expect_ignored(&media[k], bad);
        }
        bad = good, bad.normal = origin, expect_ignored(&media[k], bad);
        for (int i = 0; i < 7; ++i) bad = good, bad.light = dark[i], expect_ignored(&media[k], bad);
    }
}

// Positive hints act as clamped to [2^-30, 2^30], denormals and all.
static void test_hints_are_clamped(void **state) {
    static const float given[] = {1e-45f, 1e-38f, 9.2e-10f, 1.1e9f, 1e30f, 3.402823466e38f};
    sss_medium m = skin(BURLEY);
    (void)state;
    for (int i = 0; i < 6; ++i) {
        for (uint32_t seed = 0; seed < 50u; ++seed) {
            sss_exit a[SSS_MAX_EXITS], b[SSS_MAX_EXITS];
            int n = look_up(&m, NULL, seed, NULL, ldexpf(1.0f, given[i] < 1.0f ? -30 : 30), a);
            assert_int_equal(look_up(&m, NULL, seed, NULL, given[i], b), n);
            assert_memory_equal(a, b, sizeof a);
        }
    }
}

static void test_hit_before_any_probe(void **state) {
    sss_medium m = skin(DIPOLE);
    sss_resampler s;
    (void)state;
    assert_int_equal(sss_begin(&s, &m, NULL, origin, up, 1u), SSS_OK);
    sss_add_hit(&s, vector(0.1f, 0.0f, 0.0f), up, 1.0f);
    sss_exit exits[SSS_MAX_EXITS];
    assert_int_equal(sss_finish(&s, exits), 0);
}

static void test_finish_twice(void **state) {
    static const float albedo[3] = {0.8f, 0.5f, 0.3f}, length[3] = {1.0f, 0.0f, 0.1f};
    st_fixture plane = st_standard(ST_PLANE, st_stay());
    sss_medium m;
    (void)state;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    for (uint32_t seed = 0; seed < 100u; ++seed) {
        sss_plan plan = plan_of(7, SSS_MAX_EXITS < 3 ? 1 : 3, 0u, 0);
        sss_resampler s;
        assert_int_equal(sss_begin(&s, &m, &plan, origin, up, seed), SSS_OK);
        sss_probe probe;
        st_hit hits[ST_MAX_HITS];
        while (sss_next_probe(&s, &probe))
            if (st_trace(&plane, &probe, hits))
                sss_add_hit(&s, hits[0].position, hits[0].normal, 1.0f);
        sss_exit a[SSS_MAX_EXITS];
        memset(a, 0, sizeof a);
        sss_exit b[SSS_MAX_EXITS];
        memset(b, 0, sizeof b);
        assert_int_equal(sss_finish(&s, a), sss_finish(&s, b));
        assert_memory_equal(a, b, sizeof a);
        assert_int_equal(sss_next_probe(&s, &probe), 0);
    }
}

// Probe j feeds exit j mod N: hits say in their place which probe found them, and chords all have a
// segment.
static void test_probes_feed_exits_in_turn(void **state) {
    static const float albedo[3] = {0.8f, 0.5f, 0.3f}, length[3] = {1.0f, 0.4f, 0.1f};
    sss_medium m;
    (void)state;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    for (uint32_t seed = 0; seed < 300u; ++seed) {
        int exits = 1 + (int)(seed % SSS_MAX_EXITS), candidates = exits + (int)(seed % 20u),
            probes = 0;
        sss_plan plan = plan_of(candidates, exits, SSS_CHORD, (int)(seed / 150u));
        sss_resampler s;
        assert_int_equal(sss_begin(&s, &m, &plan, origin, up, seed), SSS_OK);
        sss_probe probe;
        for (; sss_next_probe(&s, &probe); ++probes)
            sss_add_hit(&s, vector(0.01f * (float)(probes + 1), 0.0f, 0.0f), up, 1.0f);
        assert_int_equal(probes, candidates);
        sss_exit out[SSS_MAX_EXITS];
        int n = sss_finish(&s, out);
        assert_int_equal(n, exits);
        for (int i = 0; i < n; ++i)
            check_equal("exit of a probe", ((int)(100.0f * out[i].position.x + 0.5f) - 1) % exits,
                        i);
    }
}

// ---- Channels without a profile

static void test_black_lookup(void **state) {
    static const float zero[3] = {0.0f, 0.0f, 0.0f}, one[3] = {1.0f, 1.0f, 1.0f};
    sss_medium m;
    (void)state;
    for (int which = 0; which < CONSTRUCTORS; ++which) {
        int coefficients = which == DIPOLE || which == BETTER;
        assert_int_equal(
            make(which, &m, coefficients ? one : zero, coefficients ? zero : one, 1.4f), SSS_OK);
        expect_black("black", &m);
    }
    assert_int_equal(sss_dipole(&m, zero, zero, 1.4f), SSS_OK);
    expect_black("empty", &m);
}

static void test_lambert_lookup(void **state) {
    static const float albedo[3] = {0.8f, 0.0f, 0.3f}, zero[3] = {0.0f, 0.0f, 0.0f};
    const sss_vec3 x = {1.0f, 2.0f, 3.0f}, n = {0.0f, 0.0f, -7.0f};
    sss_medium m;
    (void)state;
    assert_int_equal(sss_burley(&m, albedo, zero), SSS_OK);
    for (uint32_t seed = 0; seed < 100u; ++seed) {
        sss_resampler s;
        sss_plan plan = plan_of(8, (int)(seed % (SSS_MAX_EXITS + 1u)), 0u, 0);
        assert_int_equal(sss_begin(&s, &m, &plan, x, n, seed), SSS_OK);
        sss_probe probe;
        assert_int_equal(sss_next_probe(&s, &probe), 0);
        sss_exit exits[SSS_MAX_EXITS];
        assert_int_equal(sss_finish(&s, exits), 1);
        assert_memory_equal(&exits[0].position, &x, sizeof x);
        assert_true(exits[0].normal.x == 0.0f && exits[0].normal.y == 0.0f &&
                    exits[0].normal.z == -1.0f);
        for (int c = 0; c < 3; ++c) assert_true(exits[0].weight[c] == albedo[c]);
    }
}

// A Lambert and a black channel beside a live one: the entry bears light in the first alone, the
// surface in the last.
static void test_mixed_lookup(void **state) {
    static const float albedo[3] = {0.8f, 0.0f, 0.3f}, length[3] = {0.0f, 1.0f, 0.5f};
    sss_medium m;
    double sum = 0.0;
    int entries = 0;
    (void)state;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    int n;
    for (uint32_t seed = 0; seed < 4000u; ++seed) {
        sss_exit exits[SSS_MAX_EXITS];
        n = look_up(&m, NULL, seed, NULL, 1.0f, exits);
        for (int i = 0; i < n; ++i) {
            int entry = exits[i].weight[0] > 0.0f;
            assert_true(exits[i].weight[1] == 0.0f && entry == !(exits[i].weight[2] > 0.0f));
            if (entry) assert_memory_equal(&exits[i].position, &origin, sizeof origin);
            entries += entry;
            sum += (double)exits[i].weight[0];
        }
    }
    // Of a weight that is 0 or about twice the albedo the mean over 4000 has 1.6 % of noise: five
    // of them
    assert_in_range(entries, 1000, 3000);
    check_near("mean weight of Lambert's channel", sum / 4000.0, 0.8, 0.8 * 0.08);
}

// ---- Far, near and faint

static int exits_are_sound(const sss_exit *exits, int n) {
    for (int i = 0; i < n; ++i) {
        if (!is_finite3(exits[i].position) || !is_finite3(exits[i].normal)) return 0;
        for (int c = 0; c < 3; ++c)
            if (!(exits[i].weight[c] >= 0.0f && is_finite(exits[i].weight[c]))) return 0;
    }
    return 1;
}

// One hit on every probe, at a distance r from the entry. Returns whether all exits are finite.
static int hit_at(const sss_medium *m, const sss_plan *plan, float r, float light, uint32_t seed,
                  float *weight) {
    sss_resampler s;
    sss_vec3 at = vector(0.8f * r, -0.6f * r, 0.0f), n = vector(0.3f, 0.1f, 1.0f);
    assert_int_equal(sss_begin(&s, m, plan, origin, up, seed), SSS_OK);
    sss_probe probe;
    while (sss_next_probe(&s, &probe)) sss_add_hit(&s, at, n, light);
    sss_exit exits[SSS_MAX_EXITS];
    int count = sss_finish(&s, exits);
    *weight = count ? exits[0].weight[0] : 0.0f;
    return exits_are_sound(exits, count) && is_finite(sss_intensity(&s, at, n)) &&
           sss_intensity(&s, at, n) >= 0.0f;
}

static void sweep_distance(int flush) {
    static const float lights[] = {1.0f, 1e-30f, 1e30f};
    int broken = 0;
    char first[120] = "";
    for (int which = 0; which < CONSTRUCTORS; ++which) {
        sss_medium m = skin(which);
        st_flush_denormals(flush);
        for (unsigned techniques = 0; techniques < 16u; ++techniques) {
            for (int k = 0; k < 800 * 3; ++k) {
                float r = (float)pow(10.0, k / 3 < 300 ? k / 3 / 100.0 - 1.0
                                                       : (k / 3 - 300) / 14.0 + 2.0),
                      weight;
                sss_plan plan = plan_of(8, 1, techniques, 0);
                if (hit_at(&m, &plan, r, lights[k % 3], techniques + 1u, &weight)) continue;
                if (!broken++)
                    snprintf(first, sizeof first,
                             "constructor %d, techniques %u, r %g, light %g: weight %g", which,
                             techniques, (double)r, (double)lights[k % 3], (double)weight);
            }
        }
        st_flush_denormals(0);
    }
    if (broken) fail_msg("%d lookups are not finite, first %s", broken, first);
}

static void test_far_hits(void **state) {
    (void)state;
    sweep_distance(0);
}

static void test_far_hits_flushed(void **state) {
    (void)state;
    if (!ST_CAN_FLUSH) skip();
    sweep_distance(1);
}

// At the entry exactly and next to it: finite, and within the bound of a chord's hit: 8 hits of a
// probe in 8.
static void test_hit_at_the_entry(void **state) {
    static const float near_by[] = {0.0f, 1e-45f, 1e-38f, 1e-20f, 1e-10f, 1e-7f, 1e-6f};
    sss_plan plan = plan_of(8, 1, SSS_CHORD, 0);
    (void)state;
    for (int which = 0; which < CONSTRUCTORS; ++which) {
        sss_medium m = skin(which);
        for (int i = 0; i < 7; ++i) {
            float weight, sup = m.dipole ? 3.3f : 1.0f;
            int sound = hit_at(&m, &plan, near_by[i], 1.0f, 3u, &weight);
            assert_true(sound && weight > 0.0f);
            check_at_most("weight at the entry", (double)weight,
                          (double)(m.albedo[0] * 3.0f * 2.0f * sup) * (1.0 + 1e-5));
        }
    }
}

// Where all lines of the sphere meet their density is infinite: nothing is found there, and beside
// it all is finite, for the narrow channel of a wide medium too.
static void test_hit_at_the_sphere(void **state) {
    static const float albedo[3] = {0.8f, 0.8f, 0.8f}, length[3] = {1.0f, 1e-9f, 1e-5f};
    sss_plan plan = plan_of(8, 1, SSS_SPHERE, 0);
    sss_medium m;
    (void)state;
    assert_int_equal(sss_burley(&m, albedo, length), SSS_OK);
    for (int c = 0; c < 3; ++c)
        for (int step = -3; step <= 3; ++step) {
            sss_resampler s;
            sss_vec3 x = vector(0.0f, 0.0f, -sssi_float(sssi_bits(m.length[c]) + (uint32_t)step));
            assert_int_equal(sss_begin(&s, &m, &plan, origin, up, 1u), SSS_OK);
            sss_probe probe;
            while (sss_next_probe(&s, &probe)) sss_add_hit(&s, x, up, 1.0f);
            if (!is_finite(sss_intensity(&s, x, up)))
                fail_msg("channel %d, %d roundings beside the sphere's origin: intensity %g", c,
                         step, (double)sss_intensity(&s, x, up));
            sss_exit exits[SSS_MAX_EXITS];
            assert_true(exits_are_sound(exits, sss_finish(&s, exits)));
        }
}

// Disk probes about one axis see a face along it with next to no density: the sum of such weights
// must stay finite.
static void test_sum_of_weights_overflows(void **state) {
    sss_medium m = skin(BURLEY);
    sss_plan plan = plan_of(8, 1, SSS_DISK, 0);
    sss_resampler s;
    sss_probe probe;
    sss_exit exits[SSS_MAX_EXITS];
    (void)state;
    for (float steep = 1e-30f; steep > 1e-44f; steep *= 0.5f) {
        assert_int_equal(sss_begin(&s, &m, &plan, origin, up, 5u), SSS_OK);
        while (sss_next_probe(&s, &probe))
            for (int i = 0; i < 20; ++i)
                sss_add_hit(&s, vector(0.1f, 0.0f, 0.0f), vector(1.0f, 0.0f, steep), 1.0f);
        int n = sss_finish(&s, exits);
        if (!exits_are_sound(exits, n))
            fail_msg("normals (1, 0, %g): weight %g", (double)steep, (double)exits[0].weight[0]);
    }
}

// ---- Plans for needs: whatever is asked, one of the four models, in counts that sss_begin takes

static int is_one_model(const sss_medium *m, const sss_need *need) {
    sss_plan plan = sss_plan_for(m, need);
    int one_disk = plan.techniques == SSS_DISK && plan.candidates == 1;
    sss_resampler s;

    return (one_disk || plan.techniques == 0u || plan.techniques == SSS_WALK ||
            plan.techniques == SSS_LAMBERT) &&
           plan.tile >= 0 && sss_begin(&s, m, &plan, origin, up, 1u) == SSS_OK;
}

static void test_plans(void **state) {
    static const float some[] = {0.0f, -0.0f, 1e-45f,  1e-20f, 1e-3f, 1.0f,     30.0f,
                                 1e4f, 1e20f, 3.4e38f, -1.0f,  NAN,   INFINITY, -INFINITY};
    enum { SOME = (int)(sizeof some / sizeof *some) };
    (void)state;
    for (int which = 0; which < CONSTRUCTORS; ++which) {
        sss_medium m = skin(which);
        for (int i = 0; i < 2 * SOME * SOME * SOME * SOME; ++i) {
            sss_need need;

            need.hinted = i % 2;
            need.footprint = some[i / 2 % SOME];
            need.curvature_radius = some[i / (2 * SOME) % SOME];
            need.shading_cost = some[i / (2 * SOME * SOME) % SOME];
            need.tolerance = some[i / (2 * SOME * SOME * SOME)];
            if (!is_one_model(&m, &need))
                fail_msg("constructor %d, needs %g %g %g %g %d", which, (double)need.footprint,
                         (double)need.curvature_radius, (double)need.shading_cost,
                         (double)need.tolerance, need.hinted);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constructors),
        cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_bad_plans),
        cmocka_unit_test(test_bad_points),
        cmocka_unit_test(test_bad_hits),
        cmocka_unit_test(test_hints_are_clamped),
        cmocka_unit_test(test_hit_before_any_probe),
        cmocka_unit_test(test_finish_twice),
        cmocka_unit_test(test_probes_feed_exits_in_turn),
        cmocka_unit_test(test_black_lookup),
        cmocka_unit_test(test_lambert_lookup),
        cmocka_unit_test(test_mixed_lookup),
        cmocka_unit_test(test_far_hits),
        cmocka_unit_test(test_far_hits_flushed),
        cmocka_unit_test(test_hit_at_the_entry),
        cmocka_unit_test(test_hit_at_the_sphere),
        cmocka_unit_test(test_sum_of_weights_overflows),
        cmocka_unit_test(test_plans),
    };
    return cmocka_run_group_tests_name("robustness", tests, NULL, NULL);
}
