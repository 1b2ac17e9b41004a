/* The promise of sss_begin_sample: samples 0, 1, 2, ... of one seed are strata of one another. Each
   sample alone has the contract's mean, sample 0 is sss_begin to the bit, and the mean of 64
   samples has less variance than that of 64 seeds.

   Unbiased: the mean over seeds of the mean over 16 samples, by z-score; 36 comparisons at
   |z| < 5.0, false alarms 36 * 5.7e-7 = 2.1e-5. The variance of a pixel's mean is measured in
   64 blocks of pixels, which also gives its standard error; the ratio of two such variances is
   asked to be below 1 by 5 standard errors. make test-long: ten times as many pixels.
   SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT 5.0
#define BLOCKS  64

static long factor = 1;

static float hint_spot(st_vec y, uint32_t seed, int index) {
    (void)seed;
    (void)index;
    return (float)(st_light_spot(y) + 0.05);
}

/* As st_lookup, of one sample. */
static int lookup(const st_fixture *f, const sss_medium *m, const sss_plan *plan, uint32_t seed,
                  uint32_t sample, st_hint *hint, sss_exit *exits) {
    sss_vec3 x, n;
    int index = 0;

    st_entry(f, &x, &n);
    sss_resampler s;
    if (sss_begin_sample(&s, m, plan, x, n, seed, sample) != SSS_OK) return -1;
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        int count = st_trace(f, &probe, hits);

        /* A walk ends at the nearest hit; the others do no harm. */
        for (int i = 0; i < count; ++i, ++index) {
            float light = hint ? hint(st_local(&f->frame, hits[i].position), seed, index) : 1.0f;

            sss_add_hit(&s, hits[i].position, hits[i].normal, light);
        }
    }
    return sss_finish(&s, exits);
}

/* ---- Media and plans ---- */
static const float albedo[3] = {0.9f, 0.6f, 0.3f};

static void make_medium(int coloured, sss_medium *m, st_profile profile[3]) {
    static const float lengths[2][3] = {{1.0f, 1.0f, 1.0f}, {1.0f, 0.2f, 0.04f}};
    float dmfp[3];

    for (int c = 0; c < 3; ++c) {
        dmfp[c] = (float)st_burley_s((double)albedo[c]) * lengths[coloured][c];
        profile[c] = st_burley((double)albedo[c], (double)dmfp[c]);
    }
    assert_int_equal(sss_burley(m, albedo, dmfp), SSS_OK);
}

typedef struct sample_case {
    const char *name;
    sss_plan plan;
    int coloured;
    st_kind kind;
    st_hint *hint;
} sample_case;

#define PLAN(m, n, bits, alone, colours)                                                           \
    { m, n, bits, alone, colours, 0 }
static const sample_case cases[] = {
    {"default", PLAN(0, 0, 0u, 0, 0), 0, ST_PLANE, NULL},
    {"default, coloured sphere, hints", PLAN(0, 0, 0u, 0, 0), 1, ST_SPHERE, hint_spot},
    {"one candidate", PLAN(1, 1, 0u, 0, 0), 0, ST_SPHERE, NULL},
    {"two candidates, an exit a channel", PLAN(2, 1, 0u, 0, 1), 1, ST_PLANE, hint_spot},
    {"an exit a channel", PLAN(8, 1, 0u, 0, 1), 1, ST_SLAB, hint_spot},
    {"four exits", PLAN(13, 4, 0u, 0, 0), 1, ST_EDGE, hint_spot},
    {"chords", PLAN(3, 1, SSS_CHORD, 0, 0), 0, ST_CYLINDER, NULL},
    {"disks and chords", PLAN(8, 1, 11u, 0, 0), 0, ST_EDGE, hint_spot},
    {"all techniques", PLAN(16, 2, 15u, 0, 0), 1, ST_STACK, NULL},
    {"independent", PLAN(8, 1, 0u, 1, 0), 0, ST_SPHERE, hint_spot},
    {"a walk", PLAN(1, 1, SSS_WALK, 0, 0), 0, ST_SPHERE, NULL},
    {"two walks, an exit a channel", PLAN(2, 1, SSS_WALK, 0, 1), 1, ST_SPHERE, hint_spot},
};
enum { CASES = sizeof cases / sizeof *cases };

static st_fixture surface_of(const sample_case *k) {
    st_fixture f = st_standard(k->kind, st_stay());

    if (k->kind == ST_SLAB) f.size = 0.83;
    return f;
}

/* ---- Sample 0 ---- */
static void sample_0_is_the_plain_lookup(void **state) {
    long compared = 0, other = 0;

    (void)state;
    for (int k = 0; k < CASES; ++k) {
        st_fixture f = surface_of(&cases[k]);
        st_profile profile[3];
        sss_medium m;

        make_medium(cases[k].coloured, &m, profile);
        for (uint32_t seed = 0; seed < 200u; ++seed) {
            sss_exit plain[SSS_MAX_EXITS], first[SSS_MAX_EXITS];
            int found = st_lookup(&f, &m, &cases[k].plan, seed, cases[k].hint, plain);

            check_equal(cases[k].name,
                        lookup(&f, &m, &cases[k].plan, seed, 0u, cases[k].hint, first), found);
            for (int e = 0; e < found; ++e) {
                assert_memory_equal(&plain[e].position, &first[e].position, sizeof(sss_vec3));
                assert_memory_equal(&plain[e].normal, &first[e].normal, sizeof(sss_vec3));
                assert_int_equal(plain[e].hit, first[e].hit);
                assert_true(sssi_bits(plain[e].mass) == sssi_bits(first[e].mass));
                for (int c = 0; c < 3; ++c)
                    assert_true(sssi_bits(plain[e].weight[c]) == sssi_bits(first[e].weight[c]));
                ++compared;
            }

            /* The next sample is another one. */
            sss_exit next[SSS_MAX_EXITS];
            if (lookup(&f, &m, &cases[k].plan, seed, 1u, cases[k].hint, next) < 1 || found < 1)
                continue;
            other += memcmp(&next[0].position, &plain[0].position, sizeof(sss_vec3)) != 0;
        }
    }
    print_message("    %ld exits with the same bits; %ld others in sample 1\n", compared, other);
    check_at_least("exits", (double)compared, 1000.0);
    check_at_least("other exits", (double)other, 1000.0);
}

/* ---- Pixels: the mean over `samples` samples of one seed, or of as many seeds. Each block of
   pixels has its own statistics. ---- */
typedef struct blocks {
    st_stat stat[BLOCKS][3];
} blocks;

static void find_pixels(const st_fixture *f, const sss_medium *m, const sample_case *k, long count,
                        uint32_t samples, int strata, blocks *out) {
    memset(out, 0, sizeof *out);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < BLOCKS; ++b) {
        for (long i = b; i < count; i += BLOCKS) {
            double sum[3] = {0.0, 0.0, 0.0};
            uint32_t seed = sss_hash(TEST_SEED + (uint32_t)strata, (uint32_t)i);

            for (uint32_t j = 0; j < samples; ++j) {
                sss_exit exits[SSS_MAX_EXITS];
                int found = strata ? lookup(f, m, &k->plan, seed, j, k->hint, exits)
                                   : lookup(f, m, &k->plan, sss_hash(seed, j), 0u, k->hint, exits);

                for (int e = 0; e < found; ++e) {
                    double light = st_light_spot(st_local(&f->frame, exits[e].position));

                    for (int c = 0; c < 3; ++c) sum[c] += (double)exits[e].weight[c] * light;
                }
            }
            for (int c = 0; c < 3; ++c) st_add(&out->stat[b][c], sum[c] / samples);
        }
    }
}

static st_stat all_of(const blocks *p, int c) {
    st_stat sum = {0.0, 0.0, 0.0};

    for (int b = 0; b < BLOCKS; ++b) st_merge(&sum, &p->stat[b][c]);
    return sum;
}

/* The sum over the channels of the relative variances: its mean over the blocks, with an error. */
static st_stat variance_of(const blocks *p) {
    st_stat variance = {0.0, 0.0, 0.0};

    for (int b = 0; b < BLOCKS; ++b) {
        double sum = 0.0;

        for (int c = 0; c < 3; ++c)
            sum += st_variance(&p->stat[b][c]) / pow(all_of(p, c).mean, 2.0);
        st_add(&variance, sum);
    }
    return variance;
}

static void means_over_samples_are_unbiased(void **state) {
    static blocks strata, seeds;

    (void)state;
    for (int k = 0; k < CASES; ++k) {
        st_fixture f = surface_of(&cases[k]);
        int walks = cases[k].plan.techniques == SSS_WALK;
        st_profile profile[3];
        sss_medium m;

        make_medium(cases[k].coloured, &m, profile);
        find_pixels(&f, &m, &cases[k], 1536 * factor, 16u, 1, &strata);

        /* A walk has no closed form here: its samples are compared with its seeds. */
        if (walks) find_pixels(&f, &m, &cases[k], 1536 * factor, 16u, 0, &seeds);
        for (int c = 0; c < 3; ++c) {
            st_stat mine = all_of(&strata, c), other = all_of(&seeds, c);
            double truth = walks ? other.mean : st_truth(&f, &profile[c], st_light_spot);
            double error = walks ? hypot(st_error(&mine), st_error(&other)) : st_error(&mine);
            char name[80];

            snprintf(name, sizeof name, "%s, channel %d", cases[k].name, c);
            check_z(name, mine.mean, error, truth, 3e-6, Z_LIMIT);
        }
    }
}

/* ---- The gain ---- */
static void samples_are_calmer_than_seeds(void **state) {
    static const sample_case calm[] = {
        {"plane", PLAN(0, 0, 0u, 0, 0), 0, ST_PLANE, hint_spot},
        {"sphere", PLAN(0, 0, 0u, 0, 0), 0, ST_SPHERE, hint_spot},
        {"edge", PLAN(0, 0, 0u, 0, 0), 0, ST_EDGE, hint_spot},
        {"sphere, an exit a channel", PLAN(0, 0, 0u, 0, 1), 1, ST_SPHERE, hint_spot},
        {"slab, two candidates", PLAN(2, 0, 0u, 0, 1), 1, ST_SLAB, hint_spot},
        {"sphere, a walk", PLAN(1, 0, SSS_WALK, 0, 0), 0, ST_SPHERE, NULL},
    };
    static blocks strata, seeds;

    (void)state;
    for (int k = 0; k < (int)(sizeof calm / sizeof *calm); ++k) {
        st_fixture f = surface_of(&calm[k]);
        st_profile profile[3];
        sss_medium m;

        make_medium(calm[k].coloured, &m, profile);
        find_pixels(&f, &m, &calm[k], 1536 * factor, 64u, 1, &strata);
        find_pixels(&f, &m, &calm[k], 1536 * factor, 64u, 0, &seeds);
        st_stat mine = variance_of(&strata);
        st_stat theirs = variance_of(&seeds);
        double ratio = mine.mean / theirs.mean;
        double spread = ratio * hypot(st_error(&mine) / mine.mean, st_error(&theirs) / theirs.mean);
        print_message("    %s: 64 samples have %.2f +- %.2f of the variance of 64 seeds; the error "
                      "is %.0f %% less\n",
                      calm[k].name, ratio, spread, 100.0 * (1.0 - sqrt(ratio)));
        check_at_most(calm[k].name, ratio, 1.0 - 5.0 * spread);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sample_0_is_the_plain_lookup),
        cmocka_unit_test(means_over_samples_are_unbiased),
        cmocka_unit_test(samples_are_calmer_than_seeds),
    };
    if (st_is_long()) factor = 10;
    return cmocka_run_group_tests_name("samples", tests, NULL, st_report);
}
