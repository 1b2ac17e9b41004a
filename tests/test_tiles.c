/* The demos' tracer: tiles that share their exits have the mean of brute force everywhere in the
   picture, whatever the plan; every pixel belongs to one tile; and walks leave a union of shapes
   where probes cross its boundary. SPDX-License-Identifier: MIT */
#include "sss_test.h"
#include "demos/common/scenes.h"
#include "demos/common/tracer.h"

#define SIDE  32
#define BLOCK 4 /* pixels to a side: means of blocks are nearer to normal than single pixels */
enum { BLOCKS = SIDE / BLOCK * (SIDE / BLOCK), WHOLE = BLOCKS, RUNS = 640 };

/* With 160 pictures or more on each side |t| > 6 has the probability 6e-9. */
#define Z_LIMIT 6.0

static scene load(int which, int profile) {
    scene s;
    scenes_optics optics = scenes_make(&s, which);
    if (profile == 0) assert_int_equal(sss_burley(&s.medium, optics.albedo, optics.dmfp), SSS_OK);
    else
        assert_int_equal(sss_dipole_from_albedo(&s.medium, optics.albedo, optics.dmfp, 1.35f),
                         SSS_OK);
    return s;
}

/* ---- Every pixel of every sample is in one tile */

static void pixels_are_covered_once(void **state) {
    static int seen[67 * 45];
    int moved = 0;
    (void)state;
    for (uint32_t sample = 0; sample < 200; ++sample) {
        tracer_settings settings;
        memset(&settings, 0, sizeof settings);
        settings.method = TRACER_RESAMPLED;
        settings.width = 67;
        settings.height = 45;
        settings.plan.tile = 2 + (int)(sample % 7);
        memset(seen, 0, sizeof seen);
        int columns = tracer_tile_count(settings, sample, 0),
            rows = tracer_tile_count(settings, sample, 1);
        for (int i = 0; i < columns * rows * TRACER_TILE_PIXELS; ++i) {
            int tile = i / TRACER_TILE_PIXELS, x, y;
            if (!tracer_tile_pixel(settings, sample, tile % columns, tile / columns,
                                   i % TRACER_TILE_PIXELS, &x, &y))
                continue;
            ++seen[y * 67 + x];
        }
        for (int i = 0; i < 67 * 45; ++i) check_equal("tiles of a pixel", seen[i], 1);
        moved +=
            tracer_tile_shift(settings, sample, 0) != tracer_tile_shift(settings, sample + 7, 0);
    }
    check_at_least("samples whose tiles begin elsewhere", moved, 100);
}

/* ---- Means */

static void add_picture(const scene *s, tracer_settings settings, st_stat block[BLOCKS + 1][3]) {
    static double sum[BLOCKS + 1][3]; /* one picture at a time */
    memset(sum, 0, sizeof sum);
    int tiled = tracer_tile_side(settings) > 1;
    int columns = tiled ? tracer_tile_count(settings, 0, 0) : SIDE,
        rows = tiled ? tracer_tile_count(settings, 0, 1) : SIDE;
#pragma omp parallel for schedule(dynamic, 4)
    for (int number = 0; number < columns * rows; ++number) {
        sss_vec3 radiance[TRACER_TILE_PIXELS];
        tracer_tile tile;
        int x = number % columns, y = number / columns, pixels = tiled ? TRACER_TILE_PIXELS : 1;
        if (tiled) tracer_tile_sample(s, settings, x, y, 0, &tile, radiance);
        else radiance[0] = tracer_sample(s, settings, x, y, 0).radiance;
        for (int i = 0; i < pixels; ++i) {
            int at_x = x, at_y = y;
            if (tiled && !tracer_tile_pixel(settings, 0, x, y, i, &at_x, &at_y)) continue;
            double *to = sum[at_y / BLOCK * (SIDE / BLOCK) + at_x / BLOCK];
#pragma omp critical
            {
                to[0] += (double)radiance[i].x;
                to[1] += (double)radiance[i].y;
                to[2] += (double)radiance[i].z;
            }
        }
    }
    for (int b = 0; b < BLOCKS; ++b)
        for (int c = 0; c < 3; ++c) sum[WHOLE][c] += sum[b][c];
    for (int b = 0; b <= WHOLE; ++b)
        for (int c = 0; c < 3; ++c) st_add(&block[b][c], sum[b][c]);
}

static void add_pictures(const scene *s, tracer_settings settings, uint32_t stream,
                         st_stat block[BLOCKS + 1][3]) {
    memset(block, 0, (BLOCKS + 1) * sizeof *block);
    for (int k = 0; k < st_samples(RUNS); ++k) {
        settings.seed = sss_hash(sss_hash(TEST_SEED, stream), (uint32_t)k);
        add_picture(s, settings, block);
    }
}

static void compare_means(const char *name, st_stat one[BLOCKS + 1][3],
                          st_stat truth[BLOCKS + 1][3]) {
    for (int b = 0; b <= WHOLE; ++b) {
        for (int c = 0; c < 3; ++c) {
            char inputs[120];
            double error = hypot(st_error(&one[b][c]), st_error(&truth[b][c]));
            snprintf(inputs, sizeof inputs, "%s, block %d, channel %d", name, b, c);
            check_z(inputs, one[b][c].mean, error, truth[b][c].mean, 1e-5 * truth[b][c].mean,
                    Z_LIMIT);
        }
    }
}

/* Silhouettes, shadows, creases and the floor beside the object are all in some block. The first
   plan has lookups that find no exit, the second paths that go on from one of several. */
static void shared_pictures_have_the_mean_of_brute_force(void **state) {
    static st_stat truth[BLOCKS + 1][3], shared[BLOCKS + 1][3];
    static const struct {
        int tile, exits, per_channel, candidates, hints, lambert;
    } plans[] = {{8, 1, 0, 1, 1, 0}, {5, 3, 0, 4, 0, 0}, {8, 1, 1, 2, 1, 0}, {8, 1, 1, 2, 0, 1}};
    (void)state;
    for (unsigned k = 0; k < sizeof plans / sizeof *plans; ++k) {
        static const int scenes[] = {SCENES_NEEDLES, SCENES_CORNER, SCENES_SLAB, SCENES_BEAR};
        tracer_settings settings;
        memset(&settings, 0, sizeof settings);
        settings.width = settings.height = SIDE;
        scene s = load(scenes[k], (int)k == 2);
        if (plans[k].lambert) {
            static const float albedo[3] = {0.6f, 0.7f, 0.4f}, dmfp[3] = {0.7f, 0.0f, 0.2f};
            assert_int_equal(sss_burley(&s.medium, albedo, dmfp), SSS_OK);
        }
        settings.method = plans[k].lambert ? TRACER_RESAMPLED
                                           : TRACER_REFERENCE; /* brute force knows no Lambert */
        settings.plan.candidates = 8;
        settings.plan.exits = 2;
        add_pictures(&s, settings, 2 * k, truth);
        settings.method = TRACER_RESAMPLED;
        settings.light_aware = plans[k].hints;
        settings.plan.tile = plans[k].tile;
        settings.plan.exits = plans[k].exits;
        settings.plan.per_channel = plans[k].per_channel;
        settings.plan.candidates = plans[k].candidates;
        add_pictures(&s, settings, 2 * k + 1, shared);
        char name[80];
        snprintf(name, sizeof name, "%s, tiles of %d", scenes_known[scenes[k]].name, plans[k].tile);
        compare_means(name, shared, truth);
    }
}

/* What is narrower than a pixel is not shared: the picture is that of lookups of their own, but for
   the order in which it is added up. None of its terms is above 30, and some twenty are added. */
static void narrow_media_stay_with_their_lookups(void **state) {
    static const float albedo[3] = {0.6f, 0.7f, 0.4f},
                       dmfp[2][3] = {{3e-3f, 2e-3f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    (void)state;
    for (int k = 0; k < 2; ++k) {
        scene s = load(SCENES_BEAR, 0);
        tracer_settings settings;
        memset(&settings, 0, sizeof settings);
        settings.method = TRACER_RESAMPLED;
        settings.width = settings.height = SIDE;
        settings.plan.tile = 8;
        assert_int_equal(sss_burley(&s.medium, albedo, dmfp[k]), SSS_OK);
        for (int number = 0; number < 36; ++number) {
            static tracer_tile tile;
            sss_vec3 radiance[TRACER_TILE_PIXELS];
            tracer_tile_sample(&s, settings, number % 6, number / 6, 3, &tile, radiance);
            int x, y;
            for (int i = 0; i < TRACER_TILE_PIXELS; ++i) {
                if (!tracer_tile_pixel(settings, 3, number % 6, number / 6, i, &x, &y)) continue;
                sss_vec3 own = tracer_sample(&s, settings, x, y, 3).radiance;
                check_near("red", (double)radiance[i].x, (double)own.x, 30.0 * 20.0 * 0x1p-24);
                check_near("green", (double)radiance[i].y, (double)own.y, 30.0 * 20.0 * 0x1p-24);
                check_near("blue", (double)radiance[i].z, (double)own.z, 30.0 * 20.0 * 0x1p-24);
            }
        }
    }
}

/* ---- Walks */

/* From inside, the way out is the first crossing that a probe of that segment has. */
static void walks_leave_where_probes_cross(void **state) {
    static scene_hits all, one;
    long inside = 0, left = 0;
    (void)state;
    for (int which = 0; which < SCENES; ++which) {
        scene s = load(which, 0);
        for (uint64_t i = 0; i < 40000; ++i) {
            sss_vec3 d = {(float)st_signed(8 * i + 3), (float)st_signed(8 * i + 4),
                          (float)st_signed(8 * i + 5)};
            float length = 2.0f * (float)st_random(8 * i + 6);
            sss_vec3 o = scene_vec(1.2f * (float)st_signed(8 * i),
                                   1.0f + (float)st_signed(8 * i + 1), (float)st_signed(8 * i + 2));
            d = scene_normalize(d);
            if (!scene_inside_another(&s, o, -1)) continue;
            ++inside;
            scene_segment_hits(&s, o, d, length, &all);
            scene_way_out(&s, o, d, length, &one);
            check_equal("leaves", one.count, all.count > 0);
            if (!one.count) continue;
            ++left;
            if (one.hit[0].t != all.hit[0].t || one.hit[0].shape != all.hit[0].shape)
                fail_msg("%s: leaves at %.9g on %d, crosses at %.9g on %d",
                         scenes_known[which].name, (double)one.hit[0].t, one.hit[0].shape,
                         (double)all.hit[0].t, all.hit[0].shape);
        }
    }
    check_at_least("points inside", (double)inside, 5000.0);
    check_at_least("that leave", (double)left, 2000.0);
    print_message("%ld walks' segments, %ld leave\n", inside, left);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_are_covered_once),
        cmocka_unit_test(shared_pictures_have_the_mean_of_brute_force),
        cmocka_unit_test(narrow_media_stay_with_their_lookups),
        cmocka_unit_test(walks_leave_where_probes_cross),
    };
    return cmocka_run_group_tests_name("tiles", tests, NULL, st_report);
}
