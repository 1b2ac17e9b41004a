/* The promise of sss_plan.per_channel: each live channel picks its own exit among the same hits,
   channels that pick the same hit share one exit, and every channel keeps the contract's mean.

   What the reservoirs must hold is computed here in double precision from the hits and
   sss_intensity: W_c, the sum of light p_c / Lambda. The masses of a lookup's exits, times the
   light there and the number of live channels, must be sums of W_c over a partition of the
   channels.

   Comparisons: 38 z-scores at |z| < 5.0: the chance that a correct header fails in one of them is
   38 * 5.7e-7 = 2.2e-5. The variances that are compared differ by a factor of
   1.6 at least, and each is known to some percent. make test-long: ten times as many lookups.
   SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT   5.0
#define BLOCKS    64
#define MOST_HITS (64 * ST_MAX_HITS)

static long lookups = 48000; /* of a case */

/* ---- Media ---- */
enum { BURLEY, DIPOLE, BETTER };
typedef struct colours {
    sss_medium medium;
    st_profile profile[3];
    double lambert[3]; /* albedo of channels that scatter like Lambert */
} colours;

static void make_colours(int type, const float albedo[3], const float length[3], colours *k) {
    float dmfp[3];

    for (int c = 0; c < 3; ++c) {
        double a = (double)albedo[c];

        dmfp[c] = type == BURLEY ? (float)st_burley_s(a) * length[c] : 0.8f * length[c];
        k->profile[c] = st_nothing();
        k->lambert[c] = length[c] > 0.0f ? 0.0 : a;
        if (albedo[c] == 0.0f || length[c] == 0.0f) continue;
        k->profile[c] = type == BURLEY ? st_burley(a, (double)dmfp[c])
                                       : st_dipole_from_albedo(a, (double)dmfp[c], (double)1.3f,
                                                               type == BETTER);
    }
    sss_result result;
    if (type == BURLEY) result = sss_burley(&k->medium, albedo, dmfp);
    else if (type == DIPOLE) result = sss_dipole_from_albedo(&k->medium, albedo, dmfp, 1.3f);
    else result = sss_better_dipole_from_albedo(&k->medium, albedo, dmfp, 1.3f);
    assert_int_equal(result, SSS_OK);
}

static int live_of(const colours *k) {
    int live = 0;

    for (int c = 0; c < 3; ++c) live += k->profile[c].albedo > 0.0;
    return live;
}

/* ---- Hints ---- */
static float hint_spot(st_vec y, uint32_t seed, int index) {
    return (float)((st_light_spot(y) + 0.05) * (0.5 + st_noise(seed, index)));
}
static float hint_shadow(st_vec y, uint32_t seed, int index) {
    (void)seed;
    (void)index;
    return (float)(64.0 * st_light_shadow(y));
}

static sss_plan plan_of(int candidates, unsigned techniques, int independent) {
    sss_plan p = {0, 0, 0u, 0, 1, 0};

    p.candidates = candidates;
    p.techniques = techniques;
    p.independent = independent;
    return p;
}

/* ---- Grey ---- */
static void grey_media_have_one_exit(void **state) {
    static const float albedos[2][3] = {{0.7f, 0.7f, 0.7f}, {0.9f, 0.5f, 0.2f}};
    static const float one[3] = {1.0f, 1.0f, 1.0f}, two[3] = {1.0f, 0.0f, 1.0f};
    static const int candidates[] = {1, 3, 8, 64};
    static const unsigned techniques[] = {0u, SSS_CHORD, 15u};
    static const st_kind kinds[] = {ST_PLANE, ST_SPHERE, ST_EDGE, ST_STACK};
    long compared = 0;

    (void)state;
    for (int k = 0; k < 2 * 4 * 3 * 4 * 2 * 3; ++k) {
        sss_plan plan = plan_of(candidates[k / 2 % 4], techniques[k / 8 % 3], k / 96 % 2);
        sss_plan plain = plan;
        st_fixture f = st_standard(kinds[k / 24 % 4], st_stay());
        int type = k / 192;

        plain.per_channel = 0;
        colours m;
        make_colours(type, albedos[type == BURLEY && k % 2], k % 3 ? one : two, &m);
        for (uint32_t seed = 0; seed < 20u; ++seed) {
            sss_exit exits[SSS_MAX_EXITS] = {0};
            st_hint *hint = seed % 2u ? hint_spot : NULL;
            int found = st_lookup(&f, &m.medium, &plan, seed, hint, exits);
            int first = k % 3 == 0, expected; /* a Lambert channel has an exit of its own */

            check_at_most("exits", found, first + 1);
            if (first && found) check_equal("the entry", exits[0].hit, -1);
            if (first) continue;
            sss_exit other[SSS_MAX_EXITS];
            expected = st_lookup(&f, &m.medium, &plain, seed, hint, other);
            check_equal("exits with and without per_channel", found, expected);
            if (!found) continue;
            check_equal("hit", exits[0].hit, other[0].hit);
            check_relative("mass", (double)exits[0].mass, (double)other[0].mass, 2e-6);
            ++compared;
        }
    }
    print_message("%ld grey lookups\n", compared);
    check_at_least("lookups", (double)compared, 4000.0);
}

/* ---- Masses: the sum of W_c over the channels that share the exit ---- */
typedef struct reservoirs {
    double weight[3]; /* W_c */
    double light[MOST_HITS];
    int hits;
} reservoirs;

static int lookup(const st_fixture *f, const colours *k, const sss_plan *plan, uint32_t seed,
                  st_hint *hint, reservoirs *r, sss_exit *exits) {
    memset(r, 0, sizeof *r);
    sss_vec3 x, n;
    st_entry(f, &x, &n);
    sss_resampler s;
    assert_int_equal(sss_begin(&s, &k->medium, plan, x, n, seed), SSS_OK);
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        int count = st_trace(f, &probe, hits);

        for (int i = 0; i < count; ++i) {
            st_vec local = st_local(&f->frame, hits[i].position);
            float light = hint ? hint(local, seed, r->hits) : 1.0f;
            double mu = (double)sss_intensity(&s, hits[i].position, hits[i].normal);
            double distance = st_length(st_sum(st_double(hits[i].position), st_double(x), -1.0));

            for (int c = 0; c < 3; ++c) {
                if (k->profile[c].albedo == 0.0) continue;
                r->weight[c] += (double)light * st_rd(&k->profile[c], distance) /
                                k->profile[c].albedo / (mu * plan->candidates);
            }
            r->light[r->hits++] = (double)light;
            sss_add_hit(&s, hits[i].position, hits[i].normal, light);
        }
    }
    return sss_finish(&s, exits);
}

/* 1 if there is a way to give each channel one of the exits such that every exit's mass is the sum
   of its channels' W_c, and every exit has a channel. */
static int is_partition(const colours *k, const reservoirs *r, const sss_exit *exits, int found) {
    double live = live_of(k);
    int ways = found * found * found;

    for (int way = 0; way < ways; ++way) {
        int of[3], right = 1;
        double sum[SSS_MAX_EXITS] = {0.0};

        of[0] = way % found;
        of[1] = way / found % found;
        of[2] = way / found / found;
        for (int c = 0; c < 3; ++c) sum[of[c]] += r->weight[c];
        for (int e = 0; e < found; ++e) {
            double held = (double)exits[e].mass * r->light[exits[e].hit] * live;

            /* Some twenty roundings and the errors of profile and intensity. */
            right &= sum[e] > 0.0 && fabs(held / sum[e] - 1.0) <= 2e-5;
        }
        if (right) return 1;
    }
    return 0;
}

static void masses_are_sums_over_channels(void **state) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f};
    static const float lengths[3][3] = {
        {1.0f, 0.2f, 0.04f}, {0.5f, 0.5f, 1.0f}, {1.0f, 0.9f, 0.8f}};
    static st_hint *const hints[3] = {NULL, hint_spot, hint_shadow};
    static reservoirs r;
    long exits_of[4] = {0, 0, 0, 0};

    (void)state;
    for (int k = 0; k < 3 * 3 * 3 * 3; ++k) {
        st_fixture f = st_standard((st_kind)(k % 3), st_stay());
        sss_plan plan = plan_of(k % 4 == 0 ? 3 : 8, 0u, k % 2);

        /* A face at the depth of the sphere technique's point: hits there are left out. */
        if (f.kind == ST_SLAB) f.size = 0.83;
        colours m;
        make_colours(k / 27, albedo, lengths[k / 9 % 3], &m);
        for (uint32_t seed = 0; seed < 60u; ++seed) {
            sss_exit exits[SSS_MAX_EXITS];
            int found = lookup(&f, &m, &plan, seed, hints[k / 3 % 3], &r, exits);

            check_at_most("exits", found, 3);
            ++exits_of[found];
            if (!found) continue;
            for (int e = 0; e < found; ++e) {
                check_at_least("hit", exits[e].hit, 0.0);
                check_at_most("hit", exits[e].hit, r.hits - 1);
                for (int i = 0; i < e; ++i) assert_true(exits[i].hit != exits[e].hit);
            }
            if (!is_partition(&m, &r, exits, found))
                fail_msg(
                    "case %d, seed %u: no sum of %.7g %.7g %.7g over channels gives the masses "
                    "of %d exits, the first %.7g",
                    k, seed, r.weight[0], r.weight[1], r.weight[2], found,
                    (double)exits[0].mass * r.light[exits[0].hit] * live_of(&m));
        }
    }
    print_message("    %ld lookups without exit, %ld with one, %ld with two, %ld with three\n",
                  exits_of[0], exits_of[1], exits_of[2], exits_of[3]);
    for (int e = 1; e < 4; ++e) check_at_least("lookups", (double)exits_of[e], 100.0);
}

/* ---- Means ---- */
typedef struct mean_case {
    st_kind kind;
    int type, candidates, independent;
    unsigned techniques;
    float length[3], albedo[3];
    st_light *light;
    st_hint *hint;
} mean_case;

/* clang-format off */
static const mean_case means[] = {
    {ST_PLANE, BURLEY, 8, 0, 0u, {1.0f, 0.2f, 0.04f}, {0.9f, 0.6f, 0.3f}, st_light_spot, NULL},
    {ST_PLANE, DIPOLE, 8, 0, 0u, {1.0f, 0.2f, 0.04f}, {0.9f, 0.6f, 0.3f}, st_light_spot, hint_spot},
    {ST_SPHERE, BURLEY, 8, 0, 0u, {1.0f, 0.1f, 0.01f}, {0.9f, 0.6f, 0.3f}, st_light_spot,
     hint_spot},
    {ST_SPHERE, BETTER, 3, 0, 0u, {1.0f, 0.3f, 0.1f}, {0.9f, 0.6f, 0.3f}, st_light_one, NULL},
    {ST_SLAB, BURLEY, 8, 1, 0u, {1.0f, 0.2f, 0.04f}, {0.9f, 0.6f, 0.3f}, st_light_spot, hint_spot},
    {ST_SLAB, DIPOLE, 1, 0, SSS_CHORD, {1.0f, 0.5f, 0.2f}, {0.9f, 0.6f, 0.3f}, st_light_one, NULL},
    {ST_EDGE, BURLEY, 8, 0, 0u, {0.3f, 1.0f, 0.1f}, {0.3f, 0.9f, 0.6f}, st_light_shadow,
     hint_shadow},
    {ST_STACK, BURLEY, 8, 0, 15u, {1.0f, 0.2f, 0.04f}, {0.9f, 0.6f, 0.3f}, st_light_spot,
     hint_spot},
    {ST_CYLINDER, BURLEY, 13, 0, 0u, {1.0f, 0.2f, 0.04f}, {0.9f, 0.6f, 0.3f}, st_light_spot, NULL},
    {ST_PLANE, BURLEY, 8, 0, 0u, {1.0f, 0.0f, 0.1f}, {0.9f, 0.6f, 0.3f}, st_light_spot, hint_spot},
    {ST_SPHERE, DIPOLE, 8, 0, 0u, {0.0f, 0.0f, 0.5f}, {0.9f, 0.6f, 0.3f}, st_light_spot, hint_spot},
    {ST_PLANE, BETTER, 8, 0, 0u, {1.0f, 0.2f, 0.5f}, {0.9f, 0.0f, 0.3f}, st_light_spot, hint_spot},
    {ST_PLANE, BURLEY, 8, 0, 0u, {1.0f, 1.0f, 1.0f}, {0.9f, 0.6f, 0.3f}, st_light_spot, hint_spot},
    {ST_EDGE, DIPOLE, 64, 0, 0u, {0.3f, 1.0f, 0.1f}, {0.3f, 0.9f, 0.6f}, st_light_spot, hint_spot},
};
/* clang-format on */
enum { MEANS = sizeof means / sizeof *means };

/* Channel by channel, and exits in a lookup. */
static void estimate(const st_fixture *f, const sss_medium *m, const sss_plan *plan,
                     st_light *light, st_hint *hint, st_stat stat[4]) {
    static st_stat part[BLOCKS][4];

    memset(part, 0, sizeof part);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        for (long i = b; i < lookups; i += BLOCKS) {
            sss_exit exits[SSS_MAX_EXITS];
            double sum[3] = {0.0, 0.0, 0.0};
            int found = st_lookup(f, m, plan, sss_hash(TEST_SEED, (uint32_t)i), hint, exits);

            for (int e = 0; e < found; ++e) {
                double shaded = light(st_local(&f->frame, exits[e].position));

                for (int k = 0; k < 3; ++k) sum[k] += (double)exits[e].weight[k] * shaded;
            }
            for (int k = 0; k < 3; ++k) st_add(&part[b][k], sum[k]);
            st_add(&part[b][3], found);
        }
    }
    memset(stat, 0, 4 * sizeof *stat);
    for (int b = 0; b < BLOCKS; ++b)
        for (int c = 0; c < 4; ++c) st_merge(&stat[c], &part[b][c]);
}

static void every_channel_has_its_integral(void **state) {
    st_stat stat[4];

    (void)state;
    for (int k = 0; k < MEANS; ++k) {
        const mean_case *one = &means[k];
        sss_plan plan = plan_of(one->candidates, one->techniques, one->independent);
        st_fixture f = st_standard(one->kind, k % 2 ? st_moved() : st_stay());
        double here = one->light(st_vec3(0.0, 0.0, 0.0));
        colours m;

        make_colours(one->type, one->albedo, one->length, &m);
        estimate(&f, &m.medium, &plan, one->light, one->hint, stat);
        for (int c = 0; c < 3; ++c) {
            double truth = st_truth(&f, &m.profile[c], one->light) + m.lambert[c] * here;
            char name[80];

            snprintf(name, sizeof name, "case %d, %s, channel %d", k, st_kind_name(f.kind), c);
            if (m.lambert[c] > 0.0)
                check_relative(name, stat[c].mean, truth, 1e-6); /* the same in every lookup */
            else if (truth == 0.0) check_near(name, stat[c].mean, 0.0, 0.0);
            else check_z(name, stat[c].mean, st_error(&stat[c]), truth, 3e-6, Z_LIMIT);
        }
    }
}

/* ---- How many exits, and how calm ---- */
static void colours_are_calm_for_two_exits(void **state) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, length[3] = {1.0f, 0.2f, 0.04f};
    static const st_kind kinds[] = {ST_PLANE, ST_SPHERE, ST_SLAB, ST_EDGE, ST_CYLINDER};
    double mean = 0.0;

    (void)state;
    for (int k = 0; k < 5; ++k) {
        sss_plan plan = plan_of(8, 0u, 0), plain = plan;
        st_fixture f = st_standard(kinds[k], st_stay());

        plain.per_channel = 0;
        colours m;
        make_colours(BURLEY, albedo, length, &m);
        st_stat own[4];
        estimate(&f, &m.medium, &plan, st_light_one, NULL, own);
        st_stat one[4];
        estimate(&f, &m.medium, &plain, st_light_one, NULL, one);
        print_message("    %s: %.3f exits; relative variance", st_kind_name(f.kind), own[3].mean);
        for (int c = 0; c < 3; ++c) {
            double mine = st_variance(&own[c]) / (own[c].mean * own[c].mean);
            double theirs = st_variance(&one[c]) / (one[c].mean * one[c].mean);

            print_message(" %.2f against %.2f%s", mine, theirs, c < 2 ? "," : "\n");
            check_at_most("variance of a channel", mine, theirs);
        }
        check_at_most("exits without per_channel", one[3].mean, 1.0);
        mean += own[3].mean / 5.0;
    }
    print_message("%.3f exits in the mean of these\n", mean);
    check_at_most("exits in the mean, said to be 2.0 to 2.1", mean, 2.15);
}

/* ---- Lambert channels beside live ones: an exit of their own, with the whole albedo ---- */
static void lambert_channels_have_their_own_exit(void **state) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f};
    static const float lengths[3][3] = {{1.0f, 0.0f, 0.1f}, {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.0f}};
    st_fixture f = st_standard(ST_PLANE, st_stay());

    (void)state;
    for (int k = 0; k < 3; ++k) {
        sss_plan plan = plan_of(8, 0u, 0);
        colours m;

        make_colours(BURLEY, albedo, lengths[k], &m);
        for (uint32_t seed = 0; seed < 500u; ++seed) {
            sss_exit exits[SSS_MAX_EXITS];
            int found = st_lookup(&f, &m.medium, &plan, seed, hint_spot, exits);

            check_at_least("exits", found, 1.0);
            check_at_most("exits", found, 1.0 + live_of(&m));
            check_equal("the entry comes once", exits[0].hit, -1);
            for (int e = 0; e < found; ++e) {
                if (e) check_at_least("hit", exits[e].hit, 0.0);
                for (int c = 0; c < 3; ++c) {
                    double here = e == 0 ? m.lambert[c] : 0.0;

                    if (lengths[k][c] > 0.0f && e > 0) continue;
                    check_near("weight", (double)exits[e].weight[c], here, 0.0);
                }
            }
        }
    }
}

/* ---- What is refused ---- */
static void several_exits_are_refused(void **state) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, length[3] = {1.0f, 0.2f, 0.04f};
    st_fixture f = st_standard(ST_PLANE, st_stay());
    colours m;

    (void)state;
    make_colours(BURLEY, albedo, length, &m);
    sss_vec3 x, n;
    st_entry(&f, &x, &n);
    for (int exits = -1; exits <= SSS_MAX_EXITS + 1; ++exits) {
        sss_plan plan = plan_of(0, 0u, 0);
        int fine = exits == 0 || exits == 1;

        plan.exits = exits;
        plan.per_channel = exits % 2 ? -3 : 1; /* any number but 0 */
        sss_resampler s;
        check_equal("result", sss_begin(&s, &m.medium, &plan, x, n, 1u),
                    fine ? SSS_OK : SSS_BAD_PLAN);
        sss_probe probe;
        check_equal("probes", sss_next_probe(&s, &probe), fine);
        sss_exit out[SSS_MAX_EXITS];
        if (!fine) check_equal("exits", sss_finish(&s, out), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grey_media_have_one_exit),
        cmocka_unit_test(masses_are_sums_over_channels),
        cmocka_unit_test(every_channel_has_its_integral),
        cmocka_unit_test(colours_are_calm_for_two_exits),
        cmocka_unit_test(lambert_channels_have_their_own_exit),
        cmocka_unit_test(several_exits_are_refused),
    };
    if (st_is_long()) lookups *= 10;
    return cmocka_run_group_tests_name("colours", tests, NULL, st_report);
}
