/* The rivals of demos/study/chart.c against closed forms and tables, so that the chart compares
   real implementations: the random walk on a half space against Chandrasekhar's total and against a
   searchlight computed elsewhere, its shared path over three channels, unions of shapes; the point
   cloud and brute force on the sphere; tiles by the lean probe and by the header against brute
   force.

   Comparisons: 120 z-scores at |z| < 5.2 (111 in make test): the chance that a correct program
   fails somewhere in this file is 120 * 2.0e-7 = 2.4e-5. Totals of the walk are known to 1 % or
   better, in make test to 2 %. The point cloud is no random estimate of the integral; its limits
   are stated where they are checked. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#include "demos/study/rivals.h"

#define Z_LIMIT 5.2
#define WALKS   400000
#define BLOCK   4000

/* The half space below y = 0: a box so large that no walk meets its other faces. */
static void half_space(scene *s, const float albedo[3], const float dmfp[3]) {
    memset(s, 0, sizeof *s);
    scenes_shape(s, scene_vec(0.0f, -2000.0f, 0.0f), scene_vec(2000.0f, 2000.0f, 2000.0f), 1.0f,
                 scene_vec(0.0f, 0.0f, 0.0f));
    assert_int_equal(sss_burley(&s->medium, albedo, dmfp), SSS_OK);
}

/* Walks in blocks: weight[c] where r0 <= r < r1, its mean over walks with the error. */
static void walk_rings(const scene *s, const walk_medium *m, camera_entry at, const double *radius,
                       int rings, st_stat (*stat)[3]) {
    int blocks = st_samples(WALKS) / BLOCK;
    st_stat(*part)[32][3] = calloc((size_t)blocks, sizeof *part);
    assert_non_null(part);
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < blocks; ++b) {
        for (int i = 0; i < BLOCK; ++i) {
            tracer_random random = tracer_random_begin(TEST_SEED, 5u, (uint32_t)(b * BLOCK + i));
            walk_exit exit = {0};
            double r = -1.0;
            if (walk_lookup(s, m, at.position, at.normal, at.shape, &random, &exit)) {
                sss_vec3 way = scene_sub(exit.position, at.position);
                r = (double)scene_sqrt(scene_dot(way, way));
            }
            for (int k = 0; k < rings; ++k)
                for (int c = 0; c < 3; ++c)
                    st_add(&part[b][k][c],
                           r >= radius[k] && r < radius[k + 1] ? (double)exit.weight[c] : 0.0);
        }
    }
    memset(stat, 0, (size_t)rings * sizeof *stat);
    for (int b = 0; b < blocks; ++b)
        for (int k = 0; k < rings; ++k)
            for (int c = 0; c < 3; ++c) st_merge(&stat[k][c], &part[b][k][c]);
    free(part);
}

static camera_entry entry_at(sss_vec3 position, sss_vec3 normal, int shape) {
    camera_entry at = {position, normal, shape, 1.0f};
    return at;
}

/* One value of a table: the row that begins with `key`, its field `column`, counted from 0. */
static double table(const char *file, const char *key, int column) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", DATA_DIR, file);
    FILE *f = fopen(path, "r");
    if (!f) fail_msg("cannot read %s", path);
    char line[512];
    while (fgets(line, sizeof line, f)) {
        char *field = line;
        if (strncmp(line, key, strlen(key)) != 0) continue;
        fclose(f);
        for (; column > 0; --column) field = strchr(field, ',') + 1;
        return strtod(field, NULL);
    }
    fclose(f);
    fail_msg("%s has no row %s", path, key);
    return 0.0;
}

static void walk_has_the_exact_total(void **state) {
    static const char *const names[] = {"0.2", "0.5", "0.8", "0.9", "0.95", "0.99"};
    static const double all[] = {0.0, 1e9};
    static scene s;
    (void)state;
    for (int i = 0; i < 6; i += 3) { /* three channels at once: as different as they come */
        walk_medium m = {
            {1.0, 1.0, 1.0},
            {strtod(names[i], NULL), strtod(names[i + 1], NULL), strtod(names[i + 2], NULL)}};
        static const double sigma[3] = {1.0, 0.4, 2.5};
        static const float half[3] = {0.5f, 0.5f, 0.5f}, one[3] = {1.0f, 1.0f, 1.0f};
        memcpy(m.extinction, sigma, sizeof sigma);
        half_space(&s, half, one);
        st_stat total[1][3];
        walk_rings(&s, &m, entry_at(scene_vec(0.0f, 0.0f, 0.0f), scene_vec(0.0f, 1.0f, 0.0f), 0),
                   all, 1, total);
        for (int c = 0; c < 3; ++c) {
            char key[32];
            snprintf(key, sizeof key, "%s,1.0,D", names[i + c]);
            check_z(key, total[0][c].mean, st_error(&total[0][c]),
                    table("exact_totals.csv", key, 3), 0.0, Z_LIMIT);
        }
    }
}

/* Rings of the searchlight: sums of eight bins, each with its own noise. */
static void walk_has_the_searchlight(void **state) {
    static const float half[3] = {0.5f, 0.5f, 0.5f}, one[3] = {1.0f, 1.0f, 1.0f};
    static const walk_medium m = {{1.0, 1.0, 1.0}, {0.5, 0.8, 0.95}};
    static const char *const names[] = {"0.5,1,D", "0.8,1,D", "0.95,1,D"};
    static const double radius[] = {0.01, 0.0316227766, 0.1, 0.316227766, 1.0, 3.16227766, 10.0};
    static scene s;
    (void)state;
    half_space(&s, half, one);
    st_stat ring[6][3];
    walk_rings(&s, &m, entry_at(scene_vec(0.0f, 0.0f, 0.0f), scene_vec(0.0f, 1.0f, 0.0f), 0),
               radius, 6, ring);
    for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < 6; ++k) {
            double energy = 0.0, variance = 0.0;
            FILE *f = fopen(DATA_DIR "/mc_searchlight.csv", "r");
            assert_non_null(f);
            char line[512];
            while (fgets(line, sizeof line, f)) {
                if (strncmp(line, names[c], strlen(names[c])) != 0) continue;
                double v[5];
                if (sscanf(line + strlen(names[c]), ",%lf,%lf,%lf,%lf", &v[0], &v[1], &v[2],
                           &v[3]) != 4)
                    continue;
                if (v[0] < radius[k] * 0.999 || v[1] > radius[k + 1] * 1.001) continue;
                energy += v[2];
                variance += v[3] * v[3];
            }
            fclose(f);
            char key[64];
            snprintf(key, sizeof key, "%s, r %g..%g", names[c], radius[k], radius[k + 1]);
            check_z(key, ring[k][c].mean, sqrt(st_variance(&ring[k][c]) / ring[k][c].n + variance),
                    energy, 0.0, Z_LIMIT);
        }
    }
}

/* Inverting the albedo gives the exact total again. */
static void walk_inverts_the_albedo(void **state) {
    static const char *const names[] = {"0.1", "0.5", "0.8", "0.95", "0.99", "0.999"};
    (void)state;
    for (int i = 0; i < 6; ++i) {
        char key[32];
        snprintf(key, sizeof key, "%s,1.0,D", names[i]);
        float total = (float)table("exact_totals.csv", key, 3), albedo[3] = {total, total, total},
              dmfp[3] = {1, 2, 4};
        walk_medium m = walk_from_albedo(albedo, dmfp);
        check_relative(key, 1.0 - m.albedo[0], 1.0 - strtod(names[i], NULL), 1e-4);
        check_relative(key, m.extinction[0] / m.extinction[2], 4.0, 1e-9);
    }
}

/* A body cut into overlapping parts is the same body. */
static void walk_goes_through_seams(void **state) {
    static const float albedo[3] = {0.8f, 0.6f, 0.3f}, dmfp[3] = {1.0f, 0.5f, 0.3f};
    static const double radius[] = {0.0, 0.3, 1e9};
    static scene whole, parts;
    walk_medium m = walk_from_albedo(albedo, dmfp);
    sss_vec3 none = scene_vec(0.0f, 0.0f, 0.0f);
    (void)state;
    memset(&whole, 0, sizeof whole);
    memset(&parts, 0, sizeof parts);
    scenes_shape(&whole, none, scene_vec(1.0f, 0.5f, 0.5f), 0.01f, none);
    scenes_shape(&parts, scene_vec(0.6f, 0.0f, 0.0f), scene_vec(0.4f, 0.5f, 0.5f), 0.01f, none);
    scenes_shape(&parts, scene_vec(0.05f, 0.0f, 0.0f), scene_vec(0.25f, 0.5f, 0.5f), 0.01f, none);
    scenes_shape(&parts, scene_vec(-0.55f, 0.0f, 0.0f), scene_vec(0.45f, 0.5f, 0.5f), 0.01f, none);
    scenes_shape(&parts, none, scene_vec(0.1f, 0.4f, 0.4f), 0.01f, none); /* buried */
    camera_entry at = entry_at(scene_vec(0.4f, 0.5f, 0.1f), scene_vec(0.0f, 1.0f, 0.0f), 0);
    st_stat a[2][3];
    walk_rings(&whole, &m, at, radius, 2, a);
    for (int i = 0; i < 2; ++i)
        m.extinction[i] *= 1.0 + 1e-12; /* other walks by their rounding alone */
    st_stat b[2][3];
    walk_rings(&parts, &m, at, radius, 2, b);
    for (int k = 0; k < 2; ++k)
        for (int c = 0; c < 3; ++c)
            check_z("cut body", b[k][c].mean, hypot(st_error(&a[k][c]), st_error(&b[k][c])),
                    a[k][c].mean, 0.0, Z_LIMIT);
}

/* A sphere in light that is 1 everywhere: the albedo within twice its radius. Brute force to its
   noise; the cloud, with 16384 points, to 1 % in the mean, and from place to place to 0.045 over
   the diffuse mean free path in radii: 1.5 spacings of its points over it. */
static void sphere_has_its_closed_form(void **state) {
    static const float albedo[3] = {0.8f, 0.5f, 0.3f}, size[3] = {0.3f, 1.0f, 4.0f};
    static rivals_world w;
    (void)state;
    for (int k = 0; k < 6; k += st_is_long() ? 1 : 2) {
        float dmfp[3] = {size[k % 3], size[k % 3] * 0.8f, size[k % 3] * 0.6f};
        memset(&w, 0, sizeof w);
        scenes_make(&w.s, SCENES_SPHERE);
        if (k < 3) assert_int_equal(sss_burley(&w.s.medium, albedo, dmfp), SSS_OK);
        else assert_int_equal(sss_dipole_from_albedo(&w.s.medium, albedo, dmfp, 1.4f), SSS_OK);
        assert_int_equal(cloud_scatter(&w.cloud, &w.s, 16384, TEST_SEED), 1);
        check_relative("area of the sphere", (double)w.cloud.area * w.cloud.points, 4.0 * ST_PI,
                       0.01);
        check_relative("number of points", w.cloud.points, 16384.0, 0.1);
        for (int i = 0; i < w.cloud.points; ++i)
            w.cloud.point[i].light = scene_vec(1.0f, 1.0f, 1.0f);
        assert_int_equal(cloud_gather(&w.cloud, &w.s.medium), 1);
        for (int c = 0; c < 3; ++c) {
            st_stat cloud = {0.0, 0.0, 0.0}, brute = {0.0, 0.0, 0.0};
            double truth = (double)sss_within(&w.s.medium, c, 2.0f);
            for (uint32_t i = 0; i < 4000; ++i) {
                tracer_random random = tracer_random_begin(TEST_SEED, 9u, i);
                sss_vec3 n = walk_isotropic(&random), x = scene_add(w.s.shape[0].center, n);
                sss_vec3 sum = cloud_lookup(&w.cloud, &w.s.medium, x, 0.05f),
                         area = scene_vec(0.0f, 0.0f, 0.0f);
                tracer_points points;
                tracer_area_points(&w.s, x, &random, &points);
                for (int p = 0; p < points.count; ++p)
                    area = scene_add(area, points.point[p].weight);
                st_add(&cloud, (double)(c == 0 ? sum.x : c == 1 ? sum.y : sum.z));
                st_add(&brute, (double)(c == 0 ? area.x : c == 1 ? area.y : area.z));
            }
            check_z("brute force on the sphere", brute.mean, st_error(&brute), truth, 1e-5,
                    Z_LIMIT);
            check_relative("cloud on the sphere", cloud.mean, truth, 0.01);
            check_at_most("spread of the cloud", sqrt(st_variance(&cloud)) / truth,
                          0.045 / (double)size[k % 3]);
        }
        cloud_free(&w.cloud);
    }
}

/* The whole surface of a rounded box: its faces, edges and corners. */
static double box_area(const scene_shape *s) {
    double r = (double)s->rounding, x = (double)s->extent.x - r, y = (double)s->extent.y - r;
    double z = (double)s->extent.z - r;
    return 8.0 * (x * y + y * z + z * x) + 4.0 * ST_PI * r * (x + y + z + r);
}

/* Points keep their distance, fill the surface and lie on it. */
static void cloud_is_blue(void **state) {
    static rivals_world w;
    (void)state;
    for (int k = SCENES_SLAB; k < SCENES; ++k) {
        double least = 1e9;
        memset(&w, 0, sizeof w);
        scenes_make(&w.s, k);
        assert_int_equal(cloud_scatter(&w.cloud, &w.s, 2000, TEST_SEED), 1);
        for (int i = 0; i < w.cloud.points; ++i) {
            const cloud_point *p = &w.cloud.point[i];
            check_near("level of a point", (double)scene_level(&w.s.shape[p->shape], p->position),
                       0.0, 1e-3);
            assert_int_equal(scene_inside_another(&w.s, p->position, p->shape), 0);
            for (int j = 0; j < i; ++j) {
                const cloud_point *q = &w.cloud.point[j];
                sss_vec3 gap = scene_sub(p->position, q->position);
                if (scene_dot(scene_normal(&w.s.shape[p->shape], p->position),
                              scene_normal(&w.s.shape[q->shape], q->position)) > 0.0f)
                    least = fmin(least, (double)scene_dot(gap, gap));
            }
        }
        if (w.s.shape_count == 1)
            check_relative("area", (double)w.cloud.area * w.cloud.points, box_area(&w.s.shape[0]),
                           0.03);
        check_at_least(scenes_known[k].name, sqrt(least / (double)w.cloud.area), 0.74);
        cloud_free(&w.cloud);
    }
}

/* Ways to sample a tile: the lean probe, and plans of the header with and without strata, hints,
   colours and sharing. */
typedef struct tile_way {
    const char *name;
    int lean, hint, strata;
    sss_plan plan;
} tile_way;
static const tile_way tile_ways[] = {
    {"lean", 1, HINT_NONE, 1, {0, 0, 0u, 0, 0, 0}},
    {"memo", 0, HINT_NONE, 1, {8, 1, SSS_DISK | SSS_SPHERE, 1, 0, 0}},
    {"resampled", 0, HINT_COSINE, 1, {8, 1, 0u, 0, 0, 0}},
    {"no strata", 0, HINT_LAMP, 0, {8, 1, 0u, 0, 0, 0}},
    {"four exits", 0, HINT_EXACT, 1, {8, 4, 0u, 0, 0, 0}},
    {"colours", 0, HINT_COSINE, 1, {4, 1, 0u, 0, 1, 0}},
    {"shared", 0, HINT_WRONG, 1, {4, 1, 0u, 0, 1, 8}},
    {"one probe shared", 0, HINT_NONE, 1, {1, 1, 0u, 0, 0, 8}},
};
#define TILE_WAYS ((int)(sizeof tile_ways / sizeof *tile_ways))

/* Later pixels weigh more in a tile's mean, so that light of the wrong pixel shows. */
static double pixel_weight(const rivals_tile *tile, int i) {
    return 2.0 * (i + 1) / (tile->count * (tile->count + 1.0));
}

/* The mean light over a tile's pixels in each channel, from one run of 16 samples a pixel. */
static void tile_run(const rivals_world *w, const rivals_tile *tile, const tile_way *m,
                     uint32_t seed, double light[3]) {
    rivals_way way = {.hint = m->hint, .strata = m->strata};
    rivals_work work = {0, 0};
    light[0] = light[1] = light[2] = 0.0;
    for (int i = 0; i < tile->count; ++i) way.plan[i] = m->plan;
    rivals_values value;
    for (uint32_t n = 0; n < 16; ++n) {
        if (m->lean) rivals_lean_tile(w, tile, seed, n, value, &work);
        else rivals_header_tile(w, tile, &way, seed, n, value, &work);
        for (int k = 0; k < 3 * tile->count; ++k)
            light[k % 3] += pixel_weight(tile, k / 3) * value[k / 3][k % 3] / 16.0;
    }
}

/* The same by points all over the surface. */
static void tile_brute_force(const rivals_world *w, const rivals_tile *tile, uint32_t n,
                             double light[3]) {
    light[0] = light[1] = light[2] = 0.0;
    for (int i = 0; i < tile->count; ++i) {
        tracer_random random = tracer_random_begin(TEST_SEED, (uint32_t)i, n);
        rivals_work work = {0, 0};
        tracer_points points;
        tracer_area_points(&w->s, tile->at[i].position, &random, &points);
        for (int p = 0; p < points.count; ++p) {
            tracer_point y = points.point[p];
            sss_vec3 e = rivals_shade_exit(&w->s, y.position, y.normal, y.shape, 0, &random, &work);
            light[0] += pixel_weight(tile, i) * (double)(y.weight.x * e.x);
            light[1] += pixel_weight(tile, i) * (double)(y.weight.y * e.y);
            light[2] += pixel_weight(tile, i) * (double)(y.weight.z * e.z);
        }
    }
}

/* All have the mean of brute force: the mean over the pixels of a tile, 3 scenes, 8 ways, 3
   channels. r_max leaves 1e-4 of the widest channel to those without chords. */
static void tiles_have_the_mean_of_brute_force(void **state) {
    static const int scenes[] = {SCENES_SPHERE, SCENES_CORNER, SCENES_BEAR};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        static rivals_world w;
        static rivals_tile tile;
        st_stat brute[3] = {{0.0, 0.0, 0.0}};
        memset(&w, 0, sizeof w);
        scenes_optics optics = scenes_make(&w.s, scenes[k]);
        if (k == 2)
            optics.dmfp[1] *= 0.02f; /* narrower than a pixel: it stays with its own lookup */
        assert_int_equal(sss_burley(&w.s.medium, optics.albedo, optics.dmfp), SSS_OK);
        rivals_place(&w.s, 1u, &tile);
        assert_true(tile.count >= RIVALS_PIXELS / 2);
        double light[3];
        for (uint32_t n = 0; n < (uint32_t)st_samples(4000); ++n) {
            tile_brute_force(&w, &tile, n, light);
            for (int c = 0; c < 3; ++c) st_add(&brute[c], light[c]);
        }
        for (int m = 0; m < TILE_WAYS; ++m) {
            st_stat own[3] = {{0.0, 0.0, 0.0}};
            for (uint32_t n = 0; n < (uint32_t)st_samples(100); ++n) {
                tile_run(&w, &tile, &tile_ways[m], sss_hash(TEST_SEED, n), light);
                for (int c = 0; c < 3; ++c) st_add(&own[c], light[c]);
            }
            for (int c = 0; c < 3; ++c) {
                check_z(tile_ways[m].name, own[c].mean,
                        hypot(st_error(&own[c]), st_error(&brute[c])), brute[c].mean, 2e-4,
                        Z_LIMIT);
                check_at_most("its error", st_error(&own[c]) / own[c].mean, 0.03 * st_bluntness());
            }
        }
    }
}

/* Four rays inwards: the radius on a sphere, half the thickness of the pane away from its edges. */
static void radius_is_found(void **state) {
    static scene s;
    (void)state;
    scenes_make(&s, SCENES_SPHERE);
    camera_entry at;
    assert_int_equal(camera_sees(&s, 0.5f, 0.5f, &at), 1);
    check_relative("radius of the sphere", (double)rivals_radius(&s, &at), 1.0, 1e-4);
    scenes_make(&s, SCENES_SLAB);
    assert_int_equal(camera_sees(&s, 0.5f, 0.5f, &at), 1);
    check_relative("half the pane", (double)rivals_radius(&s, &at), 0.075, 1e-4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walk_has_the_exact_total),
        cmocka_unit_test(walk_has_the_searchlight),
        cmocka_unit_test(walk_inverts_the_albedo),
        cmocka_unit_test(walk_goes_through_seams),
        cmocka_unit_test(sphere_has_its_closed_form),
        cmocka_unit_test(cloud_is_blue),
        cmocka_unit_test(tiles_have_the_mean_of_brute_force),
        cmocka_unit_test(radius_is_found),
    };
    return cmocka_run_group_tests_name("rivals", tests, NULL, st_report);
}
