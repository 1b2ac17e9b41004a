/* The promise: for any irradiance E, the mean over seeds of the sum over exits of weight[c] *
   E(exit) is the integral of Rd_c E over the surface, for every plan that is called exact.

   Ten factors (techniques, candidates, exits, stratified or not, hints, channels, profile, surface,
   place, light) are covered by a design in which every pair of levels meets in some case. Each case
   takes the number of lookups that brings the standard error of each channel to 0.14 % of the
   truth, by the variance of a pilot run with other seeds.

   Comparisons: 171. At |z| < 5.0 the chance that a correct header fails somewhere in this file is
   171 * 5.7e-7 = 1e-4. A bias of 1 % gives z = 7.1 and is seen with probability 0.98, one of 0.7 %
   every other time. In make test, which takes an eighth of the lookups, errors are 2.8 times
   that. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT      5.0
#define TARGET_ERROR 0.0014
#define PILOT        8192
#define BLOCK        4096
#define MOST         12000000.0
#define MAX_CASES    160

enum {
    TECHNIQUES,
    CANDIDATES,
    EXITS,
    INDEPENDENT,
    HINT,
    CHANNELS,
    PROFILE,
    SURFACE,
    PLACE,
    LIGHT,
    FACTORS
};
enum { GREY, SATURATED, BLACK_AND_LAMBERT, LAMBERT_AND_TWO };
enum { BURLEY, DIPOLE, BETTER };
static const int levels[FACTORS] = {8, 7, 3, 2, 5, 4, 3, ST_KINDS, 2, 3};
static const unsigned technique_sets[] = {0u,
                                          SSS_CHORD,
                                          SSS_DISK | SSS_CHORD,
                                          SSS_DISK | SSS_DISK_TANGENTS | SSS_CHORD,
                                          SSS_SPHERE | SSS_CHORD,
                                          SSS_DISK | SSS_SPHERE | SSS_CHORD,
                                          SSS_DISK | SSS_DISK_TANGENTS | SSS_SPHERE | SSS_CHORD,
                                          SSS_DISK | SSS_DISK_TANGENTS};
static const int candidate_counts[] = {1, 2, 3, 7, 8, 13, 64};
static const int exit_counts[] = {1, 2, 4};
static st_light *const lights[] = {st_light_one, st_light_spot, st_light_shadow};

/* ---- Hints: one function for each pair of hint and light, as hints are plain functions ---- */
static float hint_correlated(double light, uint32_t seed, int index) {
    return (float)((light + 0.05) * (0.5 + st_noise(seed, index)));
}
static float hint_random(double light, uint32_t seed, int index) {
    (void)light;
    return (float)exp2(2.0 * st_noise(seed, index) - 1.0);
}
/* A unit of its own for each lookup, 2^-20 to 2^20, and 2^-20 of it in the shadow. */
static float hint_wide(double light, uint32_t seed, int index) {
    double unit = exp2(40.0 * st_random((uint64_t)seed + 12345u) - 20.0);
    return (float)(fmax(light, 9.5e-7) * unit * (0.5 + st_noise(seed, index)));
}
static float hint_exact(double light, uint32_t seed, int index) { /* 0 just where E is */
    (void)seed;
    (void)index;
    return (float)light;
}
#define HINTS(name)                                                                                \
    static float name##_one(st_vec y, uint32_t seed, int i) {                                      \
        return name(st_light_one(y), seed, i);                                                     \
    }                                                                                              \
    static float name##_spot(st_vec y, uint32_t seed, int i) {                                     \
        return name(st_light_spot(y), seed, i);                                                    \
    }                                                                                              \
    static float name##_shadow(st_vec y, uint32_t seed, int i) {                                   \
        return name(st_light_shadow(y), seed, i);                                                  \
    }
HINTS(hint_correlated)
HINTS(hint_random)
HINTS(hint_wide)
HINTS(hint_exact)
#define NAMES(name)                                                                                \
    { name##_one, name##_spot, name##_shadow }
static st_hint *const hints[5][3] = {{NULL, NULL, NULL},
                                     NAMES(hint_correlated),
                                     NAMES(hint_random),
                                     NAMES(hint_wide),
                                     NAMES(hint_exact)};

/* ---- Cases ---- */
typedef struct contract_case {
    int level[FACTORS];
    st_fixture fixture;
    sss_medium medium;
    st_profile profile[3];
    double albedo[3]; /* of the Lambert channels, 0 for others */
    sss_plan plan;
    st_light *light;
    st_hint *hint;
    double truth[3];
    char name[200];
} contract_case;

static void make_channel(contract_case *k, int c, float albedo, float length, float *a,
                         float *dmfp) {
    int type = k->level[PROFILE];
    a[c] = albedo;
    dmfp[c] = type == BURLEY ? (float)st_burley_s((double)albedo) * length : 0.8f * length;
    k->profile[c] = st_nothing();
    k->albedo[c] = length > 0.0f ? 0.0 : (double)albedo;
    if (albedo == 0.0f || length == 0.0f) return;
    if (type == BURLEY) k->profile[c] = st_burley((double)albedo, (double)dmfp[c]);
    else
        k->profile[c] =
            st_dipole_from_albedo((double)albedo, (double)dmfp[c], (double)1.3f, type == BETTER);
}
/* The dipoles of a medium with three live channels come from their coefficients, the others from
   the albedo. */
static void make_coefficients(contract_case *k, const float *length) {
    float sigma_a[3], sigma_s[3];
    int better = k->level[PROFILE] == BETTER;
    for (int c = 0; c < 3; ++c) {
        sigma_a[c] = (c == 1 ? 0.4f : 0.1f) / length[c];
        sigma_s[c] = 3.0f / length[c];
        k->profile[c] = st_dipole((double)sigma_a[c], (double)sigma_s[c], (double)1.3f, better);
    }
    assert_int_equal((better ? sss_better_dipole : sss_dipole)(&k->medium, sigma_a, sigma_s, 1.3f),
                     SSS_OK);
}
static void make_medium(contract_case *k) {
    static const float albedos[4][3] = {
        {0.9f, 0.5f, 0.2f}, {0.9f, 0.6f, 0.3f}, {0.8f, 0.0f, 0.6f}, {0.5f, 0.9f, 0.3f}};
    static const float lengths[4][3] = {
        {1.0f, 1.0f, 1.0f}, {1.0f, 0.1f, 0.01f}, {1.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.1f}};
    const float *length = lengths[k->level[CHANNELS]];
    float a[3], dmfp[3];
    int type = k->level[PROFILE];
    for (int c = 0; c < 3; ++c)
        make_channel(k, c, albedos[k->level[CHANNELS]][c], length[c], a, dmfp);
    sss_result result;
    if (type == BURLEY) result = sss_burley(&k->medium, a, dmfp);
    else
        result = (type == BETTER ? sss_better_dipole_from_albedo
                                 : sss_dipole_from_albedo)(&k->medium, a, dmfp, 1.3f);
    assert_int_equal(result, SSS_OK);
    if (type != BURLEY && k->level[CHANNELS] <= SATURATED) make_coefficients(k, length);
}
/* A plan without chords sees the ball that holds all but 1e-4 of the widest channel's albedo. */
static void cut_profiles(contract_case *k) {
    double widest = 0.0;
    for (int c = 0; c < 3; ++c)
        if (k->profile[c].albedo > 0.0)
            widest = fmax(widest, st_radius_of_tail(&k->profile[c], 1e-4));
    for (int c = 0; c < 3; ++c) k->profile[c].cut = widest;
}
static void make_case(contract_case *k) {
    static const char *const channels[] = {"grey", "saturated", "live, black, Lambert",
                                           "Lambert, live, live"};
    static const char *const profiles[] = {"Burley", "dipole", "better dipole"};
    static const char *const hint_names[] = {"none", "correlated", "random", "wide", "exact"};
    k->fixture = st_standard((st_kind)k->level[SURFACE], k->level[PLACE] ? st_moved() : st_stay());
    make_medium(k);
    k->plan.techniques = technique_sets[k->level[TECHNIQUES]];
    k->plan.candidates = candidate_counts[k->level[CANDIDATES]];
    k->plan.exits = exit_counts[k->level[EXITS]];
    k->plan.independent = k->level[INDEPENDENT];
    k->light = lights[k->level[LIGHT]];
    k->hint = hints[k->level[HINT]][k->level[LIGHT]];
    if (k->plan.techniques == (SSS_DISK | SSS_DISK_TANGENTS)) cut_profiles(k);
    for (int c = 0; c < 3; ++c)
        k->truth[c] = st_truth(&k->fixture, &k->profile[c], k->light) +
                      k->albedo[c] * k->light(st_vec3(0.0, 0.0, 0.0));
    snprintf(k->name, sizeof k->name,
             "techniques %u, M %d, N %d, %s, hint %s, %s, %s, %s %s, light %d", k->plan.techniques,
             k->plan.candidates, k->plan.exits, k->plan.independent ? "independent" : "stratified",
             hint_names[k->level[HINT]], channels[k->level[CHANNELS]], profiles[k->level[PROFILE]],
             st_kind_name(k->fixture.kind), k->level[PLACE] ? "moved" : "at rest", k->level[LIGHT]);
}

/* ---- The design ---- */
static unsigned char covered[FACTORS][FACTORS][8][8];

static int pair_is_new(const int *level, int a, int b) {
    return level[a] >= 0 && level[b] >= 0 && !covered[a][b][level[a]][level[b]];
}
static int new_pairs(const int *level) {
    int count = 0;
    for (int a = 0; a < FACTORS; ++a)
        for (int b = a + 1; b < FACTORS; ++b) count += pair_is_new(level, a, b);
    return count;
}
/* Fills the open factors, in a random order, each with the level that covers most. */
static void fill_levels(int *level, uint64_t seed) {
    int from = (int)(st_random(seed) * FACTORS);
    for (int i = 0; i < FACTORS; ++i) {
        int f = (i + from) % FACTORS, best = -1, best_level = 0;
        int first = (int)(st_random(seed + 77u * (uint64_t)i + 1u) * levels[f]);
        if (level[f] >= 0) continue;
        for (int l = 0; l < levels[f]; ++l) {
            level[f] = (l + first) % levels[f];
            int gain = new_pairs(level);
            if (gain > best) best = gain, best_level = level[f];
        }
        level[f] = best_level;
    }
}
/* Any pair not covered yet. */
static int open_pair(int *level) {
    for (int a = 0; a < FACTORS; ++a)
        for (int b = a + 1; b < FACTORS; ++b)
            for (int i = 0; i < levels[a]; ++i)
                for (int j = 0; j < levels[b]; ++j)
                    if (!covered[a][b][i][j]) {
                        level[a] = i;
                        level[b] = j;
                        return 1;
                    }
    return 0;
}
static void clear_levels(int *level) {
    for (int f = 0; f < FACTORS; ++f) level[f] = -1;
}
/* About how long a case takes, in no unit: the design prefers cheap ones. */
static double cost(const int *level) {
    static const double found[ST_KINDS] = {0.75, 0.6, 1.4, 7.3, 0.6, 0.5};
    static const double hint[] = {1.0, 0.7, 1.4, 0.7, 0.5}, light[] = {0.2, 0.4, 0.8},
                        source[] = {1.5, 3.0, 2.0, 3.0};
    static const double pick[] = {0.1, 1.8, 0.8, 1.2};
    double m = candidate_counts[level[CANDIDATES]], n = exit_counts[level[EXITS]];
    double hits = found[level[SURFACE]] * (level[PROFILE] == BURLEY ? 1.0 : 1.5);
    double variance =
        (source[level[CHANNELS]] + light[level[LIGHT]]) / m +
        hint[level[HINT]] * (pick[level[CHANNELS]] + light[level[LIGHT]]) / fmin(m, n);
    return (1.0 + m * (1.0 + 1.2 * hits)) * variance;
}
static int make_design(contract_case *found) {
    int count = 0;
    memset(covered, 0, sizeof covered);
    int start[FACTORS], level[FACTORS];
    for (clear_levels(start); open_pair(start); clear_levels(start), ++count) {
        double best = -1.0;
        assert_true(count < MAX_CASES);
        for (int attempt = 0; attempt < 300; ++attempt) {
            memcpy(level, start, sizeof level);
            fill_levels(level, TEST_SEED + 1000u * (uint64_t)(300 * count + attempt));
            double value = new_pairs(level) / (cost(level) + 20.0);
            if (value > best) {
                best = value;
                memcpy(found[count].level, level, sizeof level);
            }
        }
        for (int a = 0; a < FACTORS; ++a)
            for (int b = a + 1; b < FACTORS; ++b)
                covered[a][b][found[count].level[a]][found[count].level[b]] = 1;
    }
    return count;
}

/* ---- Running ---- */
static void run_block(const contract_case *k, uint32_t name, uint32_t first, uint32_t count,
                      st_stat *stats) {
    memset(stats, 0, 3 * sizeof *stats);
    sss_exit exits[SSS_MAX_EXITS];
    for (uint32_t i = 0; i < count; ++i) {
        int n =
            st_lookup(&k->fixture, &k->medium, &k->plan, sss_hash(name, first + i), k->hint, exits);
        double sum[3] = {0.0, 0.0, 0.0};
        for (int e = 0; e < n; ++e) {
            double light = k->light(st_local(&k->fixture.frame, exits[e].position));
            for (int c = 0; c < 3; ++c) sum[c] += (double)exits[e].weight[c] * light;
        }
        for (int c = 0; c < 3; ++c) st_add(&stats[c], sum[c]);
    }
}
static void run_lookups(const contract_case *k, uint32_t name, int blocks, st_stat *total) {
    st_stat(*stats)[3] = (st_stat(*)[3])calloc((size_t)blocks, sizeof *stats);
    assert_non_null(stats);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < blocks; ++b) run_block(k, name, (uint32_t)b * BLOCK, BLOCK, stats[b]);
    memset(total, 0, 3 * sizeof *total);
    for (int b = 0; b < blocks; ++b)
        for (int c = 0; c < 3; ++c) st_merge(&total[c], &stats[b][c]);
    free(stats);
}
static void check_case(const contract_case *k, int index) {
    st_stat pilot[3];
    double need = 0.0;
    run_lookups(k, TEST_SEED + 7919u * (uint32_t)index, PILOT / BLOCK, pilot);
    for (int c = 0; c < 3; ++c)
        if (k->truth[c] > 0.0)
            need = fmax(need, st_variance(&pilot[c]) /
                                  pow(st_bluntness() * TARGET_ERROR * k->truth[c], 2.0));
    int blocks = (int)(fmin(need, MOST) / BLOCK) + 1;
    st_stat total[3];
    run_lookups(k, TEST_SEED + 7919u * (uint32_t)index + 1u, blocks, total);
    for (int c = 0; c < 3; ++c) {
        char name[240];
        snprintf(name, sizeof name, "channel %d of: %s", c, k->name);
        if (k->truth[c] == 0.0) check_at_most(name, total[c].mean, 0.0);
        else
            check_z(name, total[c].mean, st_error(&total[c]), k->truth[c], 2e-5 * k->truth[c],
                    Z_LIMIT);
    }
}
static contract_case cases[MAX_CASES];
static int case_count;

static int set_up(void **state) {
    (void)state;
    case_count = make_design(cases);
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < case_count; ++i) make_case(&cases[i]);
    print_message("%d cases\n", case_count);
    return 0;
}

static void fixtures_agree_with_closed_forms(void **state) {
    static const double theory[ST_KINDS] = {1.0,
                                            0.58110333991640281,
                                            1.6293683432232025,
                                            6.4456806163299854,
                                            1.0575796767025040,
                                            0.57549825590427322};
    st_profile p = st_burley(1.0, st_burley_s(1.0));
    (void)state;
    for (int i = 0; i < ST_KINDS; ++i) {
        st_fixture f = st_standard((st_kind)i, st_stay());
        check_relative(st_kind_name(f.kind), st_closed_form(&f), theory[i], 2e-7);
        check_relative(st_kind_name(f.kind), st_truth(&f, &p, st_light_one), theory[i], 1e-5);
    }
}
static void mean_of_exits_is_the_integral(void **state) {
    (void)state;
    for (int i = 0; i < case_count; ++i) check_case(&cases[i], i);
}

/* ---- What an exit is ---- */

typedef struct hit_list {
    int count;
    sss_vec3 position[64 * ST_MAX_HITS];
    sss_vec3 normal[64 * ST_MAX_HITS];
} hit_list;
static int traced_lookup(const contract_case *k, uint32_t seed, hit_list *list, sss_exit *exits) {
    sss_vec3 x, n;
    int probes = 0;
    st_entry(&k->fixture, &x, &n);
    list->count = 0;
    sss_resampler s;
    assert_int_equal(sss_begin(&s, &k->medium, &k->plan, x, n, seed), SSS_OK);
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    for (; sss_next_probe(&s, &probe); ++probes) {
        int count = st_trace(&k->fixture, &probe, hits);
        for (int i = 0; i < count; ++i) {
            sss_add_hit(&s, hits[i].position, hits[i].normal, 1.0f);
            list->position[list->count] = hits[i].position;
            list->normal[list->count++] = hits[i].normal;
        }
    }
    assert_true(probes <= k->plan.candidates);
    return sss_finish(&s, exits);
}
/* An exit that lies at the entry is the Lambert channels': all other weights are 0 there. */
static void check_exit(const contract_case *k, const hit_list *list, const sss_exit *exit) {
    sss_vec3 x, n;
    double length = st_length(st_double(exit->normal));
    st_entry(&k->fixture, &x, &n);
    check_near(k->name, length, 1.0, 1e-6);
    int lambert = st_same_bits(exit->position, x) && k->level[CHANNELS] >= BLACK_AND_LAMBERT;
    for (int c = 0; c < 3; ++c)
        if ((k->albedo[c] > 0.0) != lambert || k->truth[c] == 0.0)
            check_equal(k->name, exit->weight[c] != 0.0f, 0);
    if (lambert) return;
    for (int i = 0; i < list->count; ++i)
        if (st_same_bits(list->position[i], exit->position)) {
            check_near(k->name, st_dot(st_double(list->normal[i]), st_double(exit->normal)), 1.0,
                       1e-6);
            return;
        }
    fail_msg("%s: the exit is none of the hits", k->name);
}
static void exits_are_distinct_hits(void **state) {
    static hit_list list;
    sss_exit exits[SSS_MAX_EXITS];
    (void)state;
    for (int i = 0; i < case_count; ++i) {
        const contract_case *k = &cases[i];
        for (uint32_t seed = 0; seed < 500; ++seed) {
            int n = traced_lookup(k, sss_hash(TEST_SEED + (uint32_t)i, seed), &list, exits);
            if (n < 0 || n > k->plan.exits) fail_msg("%s: %d exits", k->name, n);
            for (int e = 0; e < n; ++e) {
                check_exit(k, &list, &exits[e]);
                for (int d = 0; d < e; ++d)
                    check_equal(k->name, st_same_bits(exits[d].position, exits[e].position), 0);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fixtures_agree_with_closed_forms),
        cmocka_unit_test(exits_are_distinct_hits),
        cmocka_unit_test(mean_of_exits_is_the_integral),
    };
    return cmocka_run_group_tests_name("contract", tests, set_up, st_report);
}
