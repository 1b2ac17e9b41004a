/* Meshes as demos/common/triangle_mesh.h makes them fit for probes, and their hits as
   demos/common/mesh_tracer.h finds them with Embree: no crossing counted twice at an edge or a
   vertex, none lost on thin parts, the same hits wherever the scene is; lookups and whole pictures
   of a tessellated ball and slab against the analytic ones, in mean and in noise.

   Comparisons: 17 z-scores at |z| < 5.2: the chance that a correct program fails somewhere in this
   file is 17 * 2.0e-7 = 3.4e-6. What the tessellation itself may change is bounded where it is
   used. SPDX-License-Identifier: MIT */
#include "sss_test.h"

#include "demos/common/mesh_tracer.h"
#include "demos/common/scenes.h"

#define Z_LIMIT 5.2
#define LOOKUPS 200000
#define BLOCK   2000
#define BALL    (MESH_RADIUS / 1.7320508075688772) /* radius of a ball scaled by mesh_make() */

typedef struct soup {
    size_t vertices, triangles;
    float *xyz;
    uint32_t *corner;
} soup;

static soup soup_new(size_t vertices, size_t triangles) {
    soup s = {0, 0, calloc(3 * vertices, sizeof(float)), calloc(3 * triangles, sizeof(uint32_t))};
    assert_true(s.xyz && s.corner);
    return s;
}
static uint32_t soup_vertex(soup *s, double x, double y, double z) {
    float *at = s->xyz + 3 * s->vertices;
    at[0] = (float)x;
    at[1] = (float)y;
    at[2] = (float)z;
    return (uint32_t)s->vertices++;
}
static void soup_triangle(soup *s, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *corner = s->corner + 3 * s->triangles++;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}
static void soup_free(soup *s) {
    free(s->xyz);
    free(s->corner);
}

/* The volume that three corners span from a fourth. */
static double volume(const soup *s, uint32_t a, uint32_t b, uint32_t c, st_vec from) {
    st_vec e[3];
    const uint32_t v[3] = {a, b, c};
    for (int i = 0; i < 3; ++i) {
        const float *p = s->xyz + 3 * (size_t)v[i];
        e[i] = st_sum(st_vec3((double)p[0], (double)p[1], (double)p[2]), from, -1.0);
    }
    return e[0].x * (e[1].y * e[2].z - e[1].z * e[2].y) +
           e[0].y * (e[1].z * e[2].x - e[1].x * e[2].z) +
           e[0].z * (e[1].x * e[2].y - e[1].y * e[2].x);
}
/* A quad as two triangles that bulge away from the origin: with the other diagonal a ball would
 * have valleys. */
static void soup_quad(soup *s, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const float *p = s->xyz + 3 * (size_t)d;
    double below = volume(s, a, b, c, st_vec3((double)p[0], (double)p[1], (double)p[2]));
    int bulges = below * volume(s, a, b, c, st_vec3(0.0, 0.0, 0.0)) >= 0.0;
    soup_triangle(s, a, b, bulges ? c : d);
    soup_triangle(s, bulges ? a : b, c, d);
}
/* A grid of n by n quads from `at` along u and v, with vertices of its own, after a map. */
typedef st_vec soup_map(st_vec p, const void *context);
static void soup_grid(soup *s, int n, st_vec at, st_vec u, st_vec v, soup_map *map,
                      const void *context) {
    uint32_t first = (uint32_t)s->vertices;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
            st_vec p = map(st_sum(st_sum(at, u, (double)i / n), v, (double)j / n), context);
            soup_vertex(s, p.x, p.y, p.z);
        }
    for (uint32_t i = 0; i < (uint32_t)n; ++i)
        for (uint32_t j = 0; j < (uint32_t)n; ++j) {
            uint32_t a = first + i * (uint32_t)(n + 1) + j, b = a + (uint32_t)n + 1;
            soup_quad(s, a, b, b + 1, a + 1);
        }
}
/* The surface of the cube |x|, |y|, |z| <= 1 as six grids, after a map: closed once vertices at one
 * place are one. */
static soup soup_cube(int n, soup_map *map, const void *context) {
    soup s = soup_new(6 * (size_t)((n + 1) * (n + 1)), 12 * (size_t)(n * n));
    for (int side = -1; side <= 1; side += 2) {
        double k = side;
        soup_grid(&s, n, st_vec3(k, -1.0, -1.0), st_vec3(0.0, 2.0, 0.0), st_vec3(0.0, 0.0, 2.0),
                  map, context);
        soup_grid(&s, n, st_vec3(-1.0, k, -1.0), st_vec3(0.0, 0.0, 2.0), st_vec3(2.0, 0.0, 0.0),
                  map, context);
        soup_grid(&s, n, st_vec3(-1.0, -1.0, k), st_vec3(2.0, 0.0, 0.0), st_vec3(0.0, 2.0, 0.0),
                  map, context);
    }
    return s;
}
/* Even in angle along the axes. */
static st_vec to_ball(st_vec p, const void *context) {
    (void)context;
    return st_unit(
        st_vec3(tan(0.25 * ST_PI * p.x), tan(0.25 * ST_PI * p.y), tan(0.25 * ST_PI * p.z)));
}
/* Times a size, to multiples of 1/512: such numbers stay exact when they are moved by up to 1e4. */
static st_vec to_lattice(st_vec p, const void *context) {
    const double *size = context;
    return st_vec3(rint(512.0 * size[0] * p.x) / 512.0, rint(512.0 * size[1] * p.y) / 512.0,
                   rint(512.0 * size[2] * p.z) / 512.0);
}
static st_vec to_lattice_ball(st_vec p, const void *context) {
    return to_lattice(to_ball(p, NULL), context);
}

static void make_mesh(mesh_world *w, soup *s) {
    memset(w, 0, sizeof *w);
    const char *wrong = mesh_make(&w->m, s->xyz, s->vertices, s->corner, s->triangles);
    if (wrong) fail_msg("the mesh %s", wrong);
    soup_free(s);
}
static void start_rays(mesh_world *w) {
    const char *wrong = mesh_open(w);
    if (wrong) fail_msg("%s", wrong);
}
static void make(mesh_world *w, soup *s) {
    make_mesh(w, s);
    start_rays(w);
}

static sss_vec3 direction_of(uint64_t i) {
    double z = st_signed(4 * i), turn = 2.0 * ST_PI * st_random(4 * i + 1), rim = sqrt(1.0 - z * z);
    return scene_vec((float)(rim * cos(turn)), (float)(rim * sin(turn)), (float)z);
}
/* A point of the mesh's triangle: 0 somewhere on its first edge, 1 its first vertex, 2 inside. */
static sss_vec3 point_of(const triangle_mesh *m, uint32_t triangle, int where, uint64_t i) {
    const uint32_t *c = m->corner + 3 * (size_t)triangle;
    float u = where == 1 ? 0.0f : (float)st_random(5 * i),
          v = where == 2 ? (1.0f - u) * (float)st_random(5 * i + 1) : 0.0f;
    sss_vec3 p = m->position[c[0]];
    p = scene_along(p, scene_sub(m->position[c[1]], m->position[c[0]]), u);
    return scene_along(p, scene_sub(m->position[c[2]], m->position[c[0]]), v);
}

/* Lines through a convex body from outside, aimed at edges, at vertices and inside of triangles:
   two crossings, or none where they touch it. At edges Embree loses less than 1 of 10000. At
   vertices, where up to eight triangles meet, it loses more, but a probe has to come within a few
   units in the last place of both coordinates. */
static void edges_count_once(void **state) {
    mesh_world w;
    mesh_hits hits = {0, 0, NULL};
    (void)state;
    soup s = soup_cube(24, to_ball, NULL);
    make(&w, &s);
    for (int where = 0; where < 3; ++where) {
        long more = 0, odd = 0, none = 0;
        for (uint64_t i = 0; i < 100000; ++i) {
            sss_vec3 aim = point_of(&w.m, (uint32_t)(st_random(7 * i) * w.m.triangles), where, i);
            sss_vec3 origin = scene_along(aim, direction_of(i), -5.0f),
                     way = scene_normalize(scene_sub(aim, origin));
            hits.count = 0;
            mesh_all_hits(&w, w.m.object[0], origin, way, 10.0f, &hits);
            more += hits.count > 2;
            odd += hits.count == 1;
            none += hits.count == 0;
        }
        print_message("aimed at %s: %ld counted too often, %ld lost, %ld touched\n",
                      where == 0   ? "edges"
                      : where == 1 ? "vertices"
                                   : "triangles",
                      more, odd, none);
        check_equal("crossings too many", more, 0);
        if (where != 1) check_at_most("share of lost crossings", 1e-5 * (double)odd, 1e-4);
        if (where == 2) check_at_most("share of rays that miss", 1e-5 * (double)none, 1e-4);
    }
    free(hits.hit);
    mesh_close(&w);
}

/* A sheet 2^-20 of its width thick, whose two sides float32 can just tell apart, has two sides
   everywhere; and where two faces meet at an edge of next to no angle, both count up to the
   edge. */
static void thin_parts_have_two_sides(void **state) {
    mesh_hits hits = {0, 0, NULL};
    soup s = soup_new(2 * 33 * 33, 4 * 32 * 32), wedge = soup_new(6, 8);
    long wrong = 0;
    (void)state;
    for (int side = 0; side < 2; ++side) {
        uint32_t first = (uint32_t)s.vertices;
        for (int i = 0; i < 33 * 33; ++i)
            soup_vertex(&s, i % 33 - 16.0, side * 0x1p-15, i / 33 - 16.0);
        for (uint32_t i = 0; i < 32 * 33; ++i) {
            if (i % 33 == 32) continue;
            soup_triangle(&s, first + i, first + i + 34, first + i + 1);
            soup_triangle(&s, first + i, first + i + 33, first + i + 34);
        }
    }
    mesh_world w;
    make(&w, &s);
    for (uint64_t i = 0; i < 100000; ++i) {
        sss_vec3 aim =
            scene_vec(0.8f * (float)st_signed(9 * i), 0.0f, 0.8f * (float)st_signed(9 * i + 1));
        sss_vec3 way = direction_of(i);
        if (fabsf(way.y) < 0.05f) continue;
        hits.count = 0;
        mesh_all_hits(&w, w.m.object[0], scene_along(aim, way, -2.0f), way, 4.0f, &hits);
        wrong += hits.count != 2;
    }
    check_equal("lines that do not cross a thin sheet twice", wrong, 0);
    mesh_close(&w);

    for (int i = 0; i < 6; ++i)
        soup_vertex(&wedge, i / 3, i % 3 == 2 ? 0x1p-12 : 0.0, i % 3 == 0 ? 0.0 : 1.0);
    static const uint32_t faces[8][3] = {{0, 1, 4}, {0, 4, 3}, {0, 5, 2}, {0, 3, 5},
                                         {1, 2, 5}, {1, 5, 4}, {0, 2, 1}, {3, 4, 5}};
    for (int i = 0; i < 8; ++i) soup_triangle(&wedge, faces[i][0], faces[i][1], faces[i][2]);
    make(&w, &wedge);
    wrong = 0;
    for (uint64_t i = 0; i < 20000; ++i) { /* right at the edge, from 1e-7 to 1e-3 inside */
        float depth = powf(10.0f, -7.0f + 4.0f * (float)st_random(3 * i)), z = w.m.position[0].z;
        for (uint32_t k = 0; k < w.m.vertices; ++k) z = fminf(z, w.m.position[k].z);
        hits.count = 0;
        mesh_all_hits(&w, w.m.object[0],
                      scene_vec(0.5f * (float)st_signed(3 * i + 1), 2.0f, z + depth),
                      scene_vec(0.0f, -1.0f, 0.0f), 4.0f, &hits);
        wrong += hits.count != 2;
    }
    check_equal("lines that do not cross a thin wedge twice", wrong, 0);
    free(hits.hit);
    mesh_close(&w);
}

/* How many hits each of the same probes has on a body that is moved by `far` along all axes: as the
   program does it, or `raw`, in the moved coordinates themselves, which are on the lattice like the
   probes' origins. */
#define PROBES 40000
static void count_moved(soup (*body)(void), double far, int raw, unsigned char *count) {
    mesh_hits hits = {0, 0, NULL};
    soup s = body();
    for (size_t i = 0; i < 3 * s.vertices; ++i) s.xyz[i] = (float)((double)s.xyz[i] + far);
    mesh_world w;
    make_mesh(&w, &s);
    for (uint32_t i = 0; i < w.m.vertices && raw; ++i) {
        sss_vec3 *p = &w.m.position[i];
        st_vec at = st_vec3((double)p->x / w.m.unit, (double)p->y / w.m.unit - 0.5 * w.m.size[1],
                            (double)p->z / w.m.unit);
        *p = st_float(st_vec3(rint(512.0 * at.x) / 512.0 + far, rint(512.0 * at.y) / 512.0 + far,
                              rint(512.0 * at.z) / 512.0 + far));
    }
    start_rays(&w);
    for (uint64_t i = 0; i < PROBES; ++i) {
        st_vec p = st_vec3(1.5 * st_signed(11 * i), 1.5 * st_signed(11 * i + 1),
                           1.5 * st_signed(11 * i + 2));
        if (raw)
            p = st_vec3(rint(512.0 * p.x) / 512.0 + far, rint(512.0 * p.y) / 512.0 + far,
                        rint(512.0 * p.z) / 512.0 + far);
        hits.count = 0;
        mesh_all_hits(&w, w.m.object[0], st_float(p), direction_of(i), 1.0f, &hits);
        count[i] = (unsigned char)hits.count;
    }
    free(hits.hit);
    mesh_close(&w);
}
static soup lattice_ball(void) {
    static const double size[3] = {1.0, 1.0, 1.0};
    return soup_cube(24, to_lattice_ball, size);
}
static soup lattice_slab(void) { /* 1/128 thick */
    static const double size[3] = {1.0, 0x1p-8, 1.0};
    return soup_cube(16, to_lattice, size);
}
static void moving_keeps_the_hits(void **state) {
    static unsigned char still[PROBES], moved[PROBES];
    soup (*const body[2])(void) = {lattice_ball, lattice_slab};
    (void)state;
    for (int which = 0; which < 4; ++which) {
        long total = 0;
        count_moved(body[which / 2], 0.0, which % 2, still);
        for (int i = 0; i < PROBES; ++i) total += still[i];
        check_at_least("hits of the probes", (double)total, 0.05 * PROBES);
        for (int k = 0; k <= 4; ++k) {
            long differ = 0;
            count_moved(body[which / 2], rint(pow(10.0, k)), which % 2, moved);
            for (int i = 0; i < PROBES; ++i) differ += still[i] != moved[i];
            check_equal("probes with another number of hits", differ, 0);
        }
    }
}

/* A slab that lies on the floor: probes through both count the slab alone; paths and light meet
 * both. */
static void probes_meet_the_object_alone(void **state) {
    static const double size[3] = {1.0, 0.1, 1.0};
    mesh_world w;
    mesh_hits hits = {0, 0, NULL};
    (void)state;
    soup s = soup_cube(4, to_lattice, size);
    make(&w, &s);
    const sss_vec3 down = scene_vec(0.0f, -1.0f, 0.0f), above = scene_vec(0.1f, 3.0f, 0.2f);
    mesh_all_hits(&w, w.m.object[0], above, down, 10.0f, &hits);
    check_equal("hits through slab and floor", hits.count, 2);
    for (int i = 0; i < hits.count; ++i)
        check_equal("geometry", (long)hits.hit[i].geometry, MESH_OBJECT);
    check_at_least("nearest first", (double)(hits.hit[1].t - hits.hit[0].t), 0.1);
    check_near("its top faces up", (double)hits.hit[0].normal.y, 1.0, 1e-6);
    check_near("its bottom faces down", (double)hits.hit[1].normal.y, -1.0, 1e-6);
    mesh_hit top = mesh_nearest(&w, above, down, NULL);
    check_equal("a path meets the slab", (long)top.geometry, MESH_OBJECT);
    mesh_hit floor = mesh_nearest(&w, scene_vec(3.0f, 3.0f, 0.0f), down, NULL);
    check_equal("and beside it the floor", (long)floor.geometry, MESH_FLOOR);
    check_equal("which the slab shades",
                mesh_occluded(&w, &floor, scene_normalize(scene_vec(-3.0f, 0.05f, 0.0f)), 9.0f), 1);
    check_equal("but not from above", mesh_occluded(&w, &floor, scene_vec(0.0f, 1.0f, 0.0f), 9.0f),
                0);
    free(hits.hit);
    mesh_close(&w);
}

/* Two balls, one inside of the other, are two objects; a ball torn into six patches that share no
 * vertex is one. */
static void objects_are_pieces(void **state) {
    mesh_world w;
    mesh_hits hits = {0, 0, NULL};
    long wrong = 0;
    (void)state;
    for (int torn = 0; torn < 2; ++torn) {
        soup s = soup_cube(8, to_ball, NULL), both = soup_new(2 * s.vertices, 2 * s.triangles);
        for (size_t i = 0; i < s.triangles * (torn ? 1 : 2); ++i) {
            double size = i < s.triangles ? 1.0 : 0.5;
            if (i % s.triangles == 0)
                for (size_t k = 0; k < s.vertices; ++k) {
                    const float *p = s.xyz + 3 * k;
                    if (torn)
                        size =
                            1.0 +
                            1e-5 * (double)(k / (s.vertices / 6)); /* each patch a little larger */
                    soup_vertex(&both, size * (double)p[0], size * (double)p[1],
                                size * (double)p[2]);
                }
            uint32_t v[3];
            for (size_t k = 0; k < 3; ++k)
                v[k] = s.corner[3 * (i % s.triangles) + k] +
                       (uint32_t)(i < s.triangles ? 0 : s.vertices);
            soup_triangle(&both, v[0], v[1], v[2]);
        }
        soup_free(&s);
        make(&w, &both);
        uint32_t first = w.m.object[0], last = w.m.object[w.m.triangles - 1];
        check_equal("first and last triangle in one object", first == last, torn);
        check_equal("an open object", first == 0, torn);
        for (uint64_t i = 0; i < 1000; ++i) { /* through the middle of both, away from seams */
            sss_vec3 way = direction_of(i), from = scene_vec(0.0f, (float)BALL, 0.0f);
            float longest = fmaxf(fabsf(way.x), fmaxf(fabsf(way.y), fabsf(way.z)));
            float next = fabsf(way.x) + fabsf(way.y) + fabsf(way.z) - longest;
            if (longest - next < 0.01f) continue;
            from = scene_along(from, way, -2.0f);
            hits.count = 0;
            mesh_all_hits(&w, first, from, way, 4.0f, &hits);
            wrong += hits.count != 2 || hits.hit[0].t > 1.5f;
            hits.count = 0;
            mesh_all_hits(&w, last, from, way, 4.0f, &hits);
            wrong += hits.count != 2 || (hits.hit[0].t > 1.5f) == torn;
        }
        mesh_close(&w);
    }
    check_equal("lines with the hits of another object", wrong, 0);
    free(hits.hit);
}

/* Rays that leave a body from anywhere on it, outwards of a convex one, are never stopped by it. */
static void rays_leave(void **state) {
    mesh_world w;
    mesh_hits hits = {0, 0, NULL};
    long stopped = 0;
    (void)state;
    soup s = soup_cube(64, to_ball, NULL);
    make(&w, &s);
    for (uint64_t i = 0; i < 200000; ++i) {
        sss_vec3 way = direction_of(i), aim = scene_scale(direction_of(i + 1000000), 0.3f);
        aim.y += (float)BALL;
        hits.count = 0;
        mesh_all_hits(&w, w.m.object[0], aim, way, 10.0f, &hits);
        if (hits.count != 1) continue;
        way = direction_of(i + 2000000);
        if (scene_dot(way, hits.hit[0].normal) < 0.0f) way = scene_scale(way, -1.0f);
        mesh_hit next = mesh_nearest(&w, hits.hit[0].position, way, &hits.hit[0]);
        stopped += next.geometry == MESH_OBJECT;
    }
    check_equal("rays stopped by what they leave", stopped, 0);
    free(hits.hit);
    mesh_close(&w);
}

/* Corners at one place become one vertex: a closed surface of Euler's characteristic 2 comes out of
   loose triangles, of whatever winding, with all normals outward; what is broken is left out. */
static void loose_triangles_join(void **state) {
    soup s = soup_cube(16, to_ball, NULL), loose = soup_new(3 * s.triangles + 6, s.triangles + 6);
    (void)state;
    for (size_t i = 0; i < s.triangles; ++i) {
        uint32_t v[3];
        for (size_t k = 0; k < 3; ++k) {
            const float *p = s.xyz + 3 * (size_t)s.corner[3 * i + k];
            v[k] = soup_vertex(&loose, (double)p[0], (double)p[1], (double)p[2]);
        }
        if (st_random(i) < 0.5) soup_triangle(&loose, v[0], v[1], v[2]);
        else soup_triangle(&loose, v[0], v[2], v[1]);
    }
    uint32_t nan = soup_vertex(&loose, (double)NAN, 0.0, 0.0),
             inf = soup_vertex(&loose, 0.0, HUGE_VAL, 0.0);
    soup_triangle(&loose, 0, 1, nan);
    soup_triangle(&loose, 0, inf, 1);
    soup_triangle(&loose, 0, 1, 0);           /* no area */
    soup_triangle(&loose, 0, 1, 0xffffffffu); /* no such vertex */
    soup_triangle(&loose, loose.corner[1], loose.corner[0],
                  loose.corner[2]);                        /* there already, turned over */
    soup_triangle(&loose, 0, 1, (uint32_t)loose.vertices); /* no such vertex */
    triangle_mesh m;
    assert_null(mesh_make(&m, loose.xyz, loose.vertices, loose.corner, loose.triangles));
    check_equal("triangles left out", (long)m.left_out, 6);
    check_equal("triangles", (long)m.triangles, (long)s.triangles);
    check_equal("Euler's characteristic", (long)m.vertices - (long)m.triangles / 2, 2);
    const sss_vec3 middle = scene_vec(0.0f, (float)BALL, 0.0f);
    double least = 1.0, smooth = 1.0;
    for (uint32_t i = 0; i < 3 * m.triangles; ++i) {
        sss_vec3 out = scene_normalize(scene_sub(m.position[m.corner[i]], middle));
        least = fmin(least, (double)scene_dot(out, mesh_normal(&m, i / 3)));
        smooth = fmin(smooth, (double)scene_dot(out, m.shading[i]));
    }
    check_at_least("normals are outward: cosine", least, 0.99);
    check_at_least("shading normals are the ball's: cosine", smooth, 0.9998);
    mesh_free(&m);
    check_equal("nothing to see", mesh_make(&m, loose.xyz, loose.vertices, loose.corner, 0) != NULL,
                1);
    check_equal("only broken ones",
                mesh_make(&m, loose.xyz, loose.vertices, loose.corner + 3 * s.triangles, 4) != NULL,
                1);
    soup_free(&loose);
    soup_free(&s);
}

/* A cube keeps its edges. */
static void creases_stay(void **state) {
    static const double size[3] = {1.0, 1.0, 1.0};
    triangle_mesh m;
    soup s = soup_cube(2, to_lattice, size);
    (void)state;
    assert_null(mesh_make(&m, s.xyz, s.vertices, s.corner, s.triangles));
    for (uint32_t i = 0; i < 3 * m.triangles; ++i)
        check_near("a cube's shading normal",
                   (double)scene_dot(m.shading[i], mesh_normal(&m, i / 3)), 1.0, 1e-6);
    mesh_free(&m);
    soup_free(&s);
}

/* ---- Against the analytic scenes */

typedef struct entry {
    sss_vec3 position, normal;
    const sss_medium *medium;
    const mesh_world *w; /* or */
    const scene *s;
    st_light *light; /* at the place about the entry */
} entry;

/* One lookup of the default plan: the weights times the light there. */
static void one_lookup(const entry *e, uint32_t seed, mesh_hits *hits, double out[3]) {
    out[0] = out[1] = out[2] = 0.0;
    sss_resampler s;
    sss_begin(&s, e->medium, NULL, e->position, e->normal, seed);
    sss_probe probe;
    while (sss_next_probe(&s, &probe)) {
        if (e->w) {
            hits->count = 0;
            mesh_all_hits(e->w, e->w->m.object[0], probe.origin, probe.direction, probe.length,
                          hits);
            for (int i = 0; i < hits->count; ++i)
                sss_add_hit(&s, hits->hit[i].position, hits->hit[i].normal, 1.0f);
        } else {
            scene_hits all;
            scene_segment_hits(e->s, probe.origin, probe.direction, probe.length, &all);
            for (int i = 0; i < all.count; ++i) {
                sss_vec3 at = scene_along(probe.origin, probe.direction, all.hit[i].t);
                sss_add_hit(&s, at, scene_normal(&e->s->shape[all.hit[i].shape], at), 1.0f);
            }
        }
    }
    sss_exit exit;
    if (!sss_finish(&s, &exit)) return;
    double light = e->light(st_sum(st_double(exit.position), st_double(e->position), -1.0));
    for (int c = 0; c < 3; ++c) out[c] = (double)exit.weight[c] * light;
}

/* Mean and relative variance of a lookup with the errors of both. */
typedef struct moments {
    double mean[3], mean_error[3], noise[3], noise_error[3];
} moments;

static moments lookups(const entry *e, uint32_t stream) {
    static double value[LOOKUPS][3];
    const int count = st_samples(LOOKUPS);
#pragma omp parallel
    {
        mesh_hits hits = {0, 0, NULL};
#pragma omp for schedule(dynamic, BLOCK)
        for (int i = 0; i < count; ++i)
            one_lookup(e, sss_hash(sss_hash(TEST_SEED, stream), (uint32_t)i), &hits, value[i]);
        free(hits.hit);
    }
    moments m;
    for (int c = 0; c < 3; ++c) {
        st_stat first = {0.0, 0.0, 0.0}, second = {0.0, 0.0, 0.0};
        for (int i = 0; i < count; ++i) st_add(&first, value[i][c]);
        for (int i = 0; i < count; ++i) st_add(&second, pow(value[i][c] / first.mean - 1.0, 2.0));
        m.mean[c] = first.mean;
        m.mean_error[c] = st_error(&first);
        m.noise[c] = second.mean;
        m.noise_error[c] =
            hypot(st_error(&second), 2.0 * second.mean * st_error(&first) / first.mean);
    }
    return m;
}

/* may_differ: of the means. A weight is one density over another, and so are the chances of hits;
   each differs by no more than the mean does, relatively, so second moments, over the squared mean,
   do by no more than 8 times that. */
static void same_moments(const char *name, const moments *a, const moments *b,
                         const double may_differ[3]) {
    for (int c = 0; c < 3; ++c) {
        char text[80];
        snprintf(text, sizeof text, "%s, channel %d: mean", name, c);
        check_z(text, a->mean[c], hypot(a->mean_error[c], b->mean_error[c]), b->mean[c],
                may_differ[c], Z_LIMIT);
        snprintf(text, sizeof text, "%s, channel %d: relative variance", name, c);
        check_z(text, a->noise[c], hypot(a->noise_error[c], b->noise_error[c]), b->noise[c],
                8.0 * (1.0 + b->noise[c]) * may_differ[c] / b->mean[c], Z_LIMIT);
    }
}

static double ball_light(st_vec v) { return 1.0 + 0.5 * v.y / BALL; }
static double ball_light_local(st_vec v) {
    return 1.0 + 0.5 * v.z / BALL;
} /* the fixture's normal is z */

/* How much the integral of Rd E over a tessellated ball may differ from that over the ball itself,
   over the albedo; the entry is a vertex. Let the triangles' planes be at least R (1 - s) from the
   centre. Sent to the ball along its radius, a point p = (1 - d) q, 0 <= d <= s, changes its area
   element by a factor between (1 - s)^2 and 1 / (1 - s), and its squared distance from the entry by
   the factor 1 - d + d^2 R^2 / |q|^2. On a triangle with the entry as its corner d is at most |p|
   sqrt(2 s) / R (the power of the entry in the triangle's circle), elsewhere |q| is at least the
   shortest edge h. So distances change by the factor 1 +- e, 2 e <= s + max(2 s, (s R / h)^2). For
   every falling profile the integral of r |Rd'| over the ball is at most twice the albedo. Last, E
   changes by at most s / 2. */
static double ball_deviation(const triangle_mesh *m) {
    const sss_vec3 middle = scene_vec(0.0f, (float)BALL, 0.0f);
    double depth = 0.0, edge = HUGE_VAL;
    for (uint32_t i = 0; i < m->triangles; ++i) {
        const uint32_t *c = m->corner + 3 * (size_t)i;
        mesh_vector n = mesh_span(m, i), a = mesh_between(middle, m->position[c[0]]);
        mesh_vector side = mesh_between(m->position[c[0]], m->position[c[1]]);
        depth = fmax(depth, 1.0 - mesh_dot(n, a) / sqrt(mesh_dot(n, n)) / BALL);
        edge = fmin(edge, sqrt(mesh_dot(side, side)));
    }
    double e = depth + fmax(2.0 * depth, pow(depth * BALL / edge, 2.0));
    return 1.01 * (2.0 * depth + e + 0.5 * depth); /* 1.01: terms of second order */
}

static void ball_agrees(void **state) {
    static const float albedo[3] = {0.8f, 0.5f, 0.93f}, dmfp[3] = {0.5f, 1.0f, 0.2f};
    static scene s;
    mesh_world w;
    soup body = soup_cube(96, to_ball, NULL);
    (void)state;
    make(&w, &body);
    sss_medium medium;
    assert_int_equal(sss_burley(&medium, albedo, dmfp), SSS_OK);
    scenes_ellipsoid(&s, scene_vec(0.0f, (float)BALL, 0.0f),
                     scene_vec((float)BALL, (float)BALL, (float)BALL), scene_vec(0.0f, 0.0f, 0.0f));
    entry e = {scene_vec(0.0f, (float)(2.0 * BALL), 0.0f),
               scene_vec(0.0f, 1.0f, 0.0f),
               &medium,
               &w,
               NULL,
               ball_light};
    moments of_mesh = lookups(&e, 1);
    e.w = NULL;
    e.s = &s;
    moments analytic = lookups(&e, 2);
    double deviation = ball_deviation(&w.m);
    print_message("    the tessellated ball may be %.2g off\n", deviation);
    check_at_most("deviation of the tessellation", deviation, 1e-3);
    double may_differ[3];
    for (int c = 0; c < 3; ++c) {
        st_fixture f = {ST_SPHERE, BALL, st_stay()};
        st_profile p = st_burley((double)albedo[c], (double)dmfp[c]);
        may_differ[c] = deviation * (double)albedo[c];
        check_z("ball against its integral", of_mesh.mean[c], of_mesh.mean_error[c],
                st_truth(&f, &p, ball_light_local), may_differ[c], Z_LIMIT);
    }
    same_moments("ball", &of_mesh, &analytic, may_differ);
    mesh_close(&w);
}

/* The rounded boxes of scene.h: of the grid's half width 3/4 is flat, the rest an arc of 45
 * degrees. */
static double spread(double c, double core, double r) {
    double a = fabs(c),
           x = a <= 0.75 ? core * a / 0.75 : core + r * (a < 1.0 ? tan(ST_PI * (a - 0.75)) : 1.0);
    return c < 0.0 ? -x : x;
}
static st_vec to_rounded_box(st_vec p, const void *context) {
    const scene_shape *b = context;
    double r = (double)b->rounding, x = (double)b->extent.x - r, y = (double)b->extent.y - r,
           z = (double)b->extent.z - r;
    st_vec q = st_vec3(spread(p.x, x, r), spread(p.y, y, r), spread(p.z, z, r)),
           at = st_double(b->center);
    st_vec k = st_vec3(fmax(-x, fmin(x, q.x)), fmax(-y, fmin(y, q.y)), fmax(-z, fmin(z, q.z)));
    k = st_sum(k, st_unit(st_sum(q, k, -1.0)), r);
    at = st_sum(at, st_double(b->axis[0]), k.x);
    return st_sum(st_sum(at, st_double(b->axis[1]), k.y), st_double(b->axis[2]), k.z);
}

/* Back to the size and the place that it had, as a body that is symmetric about `middle`. */
static void bring_back(triangle_mesh *m, sss_vec3 middle) {
    for (uint32_t i = 0; i < m->vertices; ++i) {
        st_vec p =
            st_sum(st_vec3(0.0, -0.5 * m->size[1], 0.0), st_double(m->position[i]), 1.0 / m->unit);
        m->position[i] = st_float(st_sum(p, st_double(middle), 1.0));
    }
}

static double slab_light(st_vec v) { return 1.0 + 0.5 * v.x; }

/* The slab of the demos. Its flat sides are exact; its rim, further than `far` from the entry, is
   inscribed in arcs by 1 - cos(half a step) of their radius: see ball_deviation(). */
static void slab_agrees(void **state) {
    static scene s;
    (void)state;
    scenes_optics optics = scenes_make(&s, SCENES_SLAB);
    sss_medium medium;
    assert_int_equal(sss_burley(&medium, optics.albedo, optics.dmfp), SSS_OK);
    const scene_shape *b = &s.shape[0];
    const int n = 64;
    soup body = soup_cube(n, to_rounded_box, b);
    mesh_world w;
    make_mesh(&w, &body);
    bring_back(&w.m, b->center);
    start_rays(&w);
    entry e = {
        scene_along(b->center, b->axis[2], b->extent.z), b->axis[2], &medium, &w, NULL, slab_light};
    moments of_mesh = lookups(&e, 3);
    e.w = NULL;
    e.s = &s;
    moments analytic = lookups(&e, 4);
    double r = (double)b->rounding, x = (double)b->extent.x - r, y = (double)b->extent.y - r,
           may_differ[3];
    double depth = 1.0 - cos(ST_PI / n), far = fmin(x, y), rim = 4.0 * ST_PI * r * (x + y + r);
    for (int c = 0; c < 3; ++c)
        may_differ[c] = 10.0 * depth * rim * (double)sss_profile(&medium, c, (float)far);
    same_moments("slab", &of_mesh, &analytic, may_differ);
    mesh_close(&w);
}

/* ---- Pictures: the ball of the demos by Embree and by formulas */

#define SIDE  40
#define SEEDS 48

/* The radiance of every pixel that shows the object, seed by seed, one sample each. */
static int picture(const scene *s, const mesh_world *w, uint32_t stream, st_stat *pixel,
                   st_stat *whole) {
    static float value[SEEDS][SIDE * SIDE];
    static unsigned char shows[SIDE * SIDE];
    int count = 0;
    tracer_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.method = TRACER_RESAMPLED;
    settings.width = settings.height = SIDE;
    for (int i = 0; i < SIDE * SIDE; ++i)
        count += shows[i] = (unsigned char)tracer_sees_object(s, SIDE, SIDE, i % SIDE, i / SIDE);
#pragma omp parallel
    {
        mesh_hits hits = {0, 0, NULL};
#pragma omp for schedule(dynamic)
        for (int k = 0; k < SEEDS; ++k) {
            tracer_settings own = settings;
            own.seed = sss_hash(sss_hash(TEST_SEED, stream), (uint32_t)k);
            for (int i = 0; i < SIDE * SIDE; ++i) {
                if (!shows[i]) continue;
                tracer_result one = w ? mesh_sample(w, own, i % SIDE, i / SIDE, 0, &hits)
                                      : tracer_sample(s, own, i % SIDE, i / SIDE, 0);
                value[k][i] = scene_mean(one.radiance);
            }
        }
        free(hits.hit);
    }
    memset(whole, 0, sizeof *whole);
    memset(pixel, 0, SIDE * SIDE * sizeof *pixel);
    for (int k = 0; k < SEEDS; ++k) {
        double sum = 0.0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            if (!shows[i]) continue;
            st_add(&pixel[i], (double)value[k][i]);
            sum += (double)value[k][i];
        }
        st_add(whole, sum / count);
    }
    return count;
}

static void pictures_agree(void **state) {
    static st_stat pixel[2][SIDE * SIDE];
    static scene s;
    st_stat difference = {0.0, 0.0, 0.0};
    double variance = 0.0;
    (void)state;
    scenes_optics optics = scenes_make(&s, SCENES_SPHERE);
    assert_int_equal(sss_burley(&s.medium, optics.albedo, optics.dmfp), SSS_OK);
    soup body = soup_cube(96, to_ball, NULL);
    mesh_world w;
    make_mesh(&w, &body);
    double deviation = ball_deviation(&w.m);
    bring_back(&w.m, s.shape[0].center);
    start_rays(&w);
    w.s = s;
    w.s.shape_count = 0;
    st_stat whole[2];
    picture(&s, &w, 5, pixel[0], &whole[0]);
    int count = picture(&s, NULL, 6, pixel[1], &whole[1]);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        if (pixel[0][i].n == 0.0) continue;
        st_add(&difference, st_variance(&pixel[0][i]) - st_variance(&pixel[1][i]));
        variance += st_variance(&pixel[1][i]) / count;
    }
    check_z("picture of the ball: mean", whole[0].mean,
            hypot(st_error(&whole[0]), st_error(&whole[1])), whole[1].mean,
            deviation * whole[1].mean, Z_LIMIT);
    check_z("picture of the ball: variance of a sample", variance + difference.mean,
            st_error(&difference), variance, 8.0 * deviation * variance, Z_LIMIT);
    mesh_close(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_count_once),      cmocka_unit_test(thin_parts_have_two_sides),
        cmocka_unit_test(moving_keeps_the_hits), cmocka_unit_test(probes_meet_the_object_alone),
        cmocka_unit_test(objects_are_pieces),    cmocka_unit_test(rays_leave),
        cmocka_unit_test(loose_triangles_join),  cmocka_unit_test(creases_stay),
        cmocka_unit_test(ball_agrees),           cmocka_unit_test(slab_agrees),
        cmocka_unit_test(pictures_agree),
    };
    return cmocka_run_group_tests_name("mesh", tests, NULL, st_report);
}
