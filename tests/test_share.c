/* The promise of sss_share: an exit serves a group of lookups. The mean of what each entry gets
   from all exits of all members is the integral of its own Rd E over the surface, every single
   weight is the one that equation [8] states, and what is not shared stays with its own lookup.

   The formula is checked exit by exit in double precision, and the means by z-score. A case is a
   surface, a group of 1, 2, 7 or 64 entries, media, hints and a plan. Its passes are independent;
   the entries of one pass are not, so each z-score is one entry's and one channel's alone.

   Comparisons: at most 180 z-scores at |z| < 5.2: the chance that a correct header fails somewhere
   in this file is 180 * 2.0e-7 = 3.6e-5. make test-long: ten times as many lookups.
   SPDX-License-Identifier: MIT */
#include "sss_test.h"

#define Z_LIMIT 5.2
#define MOST    64    /* entries of a group */
#define WATCHED 3     /* entries whose mean is compared */
#define LOOKUPS 30000 /* of a case; ten times as many with --long */
#define BLOCKS  64

static long lookups = LOOKUPS;

/* ---- Groups. Entry i sees the surface from where it stands: `place` takes its own coordinates, in
   which it is the origin and its normal +z, to those of the group's surface. ---- */
enum { GREY, COLOURED, PARTLY_LAMBERT, OWN_BURLEY, OWN_MIXED, MEDIA };
enum { NO_HINT, OWN_UNITS, SHADOWED };

typedef struct group {
    st_fixture surface;
    int count, media, hint;
    float spacing;
    st_frame place[MOST];
    double size[MOST]; /* of the surface as the entry sees it */
    sss_entry entry[MOST];
    sss_vec3 normal[MOST];
    sss_medium medium[MOST];
    st_profile profile[MOST][3];
    double lambert[MOST][3]; /* albedo of the channels that scatter like Lambert */
} group;

static st_frame turned(st_vec axis, double angle, st_vec centre, st_vec move) {
    st_frame f = st_motion(axis, angle, st_vec3(0.0, 0.0, 0.0));
    st_vec rest = st_sum(centre, st_turn(&f, centre), -1.0);

    f.move = st_sum(rest, move, 1.0);
    return f;
}

/* The side face of an edge: its normal is the group's +x, and the edge lies up. */
static st_frame on_the_side(double a, double y, double z) {
    st_frame f;

    f.row[0] = st_vec3(0.0, 0.0, 1.0);
    f.row[1] = st_vec3(0.0, -1.0, 0.0);
    f.row[2] = st_vec3(1.0, 0.0, 0.0);
    f.move = st_vec3(a, y, z);
    return f;
}

/* Entry i stands at (u, v), measured along the surface from the origin. */
static void place_entry(group *g, int i, double u, double v) {
    st_vec x = st_vec3(1.0, 0.0, 0.0), y = st_vec3(0.0, 1.0, 0.0), none = st_vec3(0.0, 0.0, 0.0);
    st_vec centre = st_vec3(0.0, 0.0, -g->surface.size);
    double R = g->surface.size;

    g->size[i] = R;
    g->place[i] = turned(x, 0.0, none, st_vec3(u, v, 0.0));
    switch (g->surface.kind) {
    case ST_SPHERE:
        if (u == 0.0 && v == 0.0) break;
        g->place[i] = turned(st_vec3(-v, u, 0.0), hypot(u, v) / R, centre, none);
        break;
    case ST_CYLINDER: g->place[i] = turned(y, u / R, centre, st_vec3(0.0, v, 0.0)); break;
    case ST_SLAB:
        if (i % 2 == 1) g->place[i] = turned(x, ST_PI, none, st_vec3(u, v, -R));
        break;
    case ST_EDGE:
        g->size[i] = fabs(R - u);
        if (u > R) g->place[i] = on_the_side(R, v, R - u);
        break;
    default: break;
    }
}

static void place_entries(group *g, double step) {
    int side = g->count > 8 ? 8 : g->count;

    for (int i = 0; i < g->count; ++i) {
        double u = step * (i % side - 0.5 * (side - 1) + 0.3 * st_signed(900u + (uint64_t)i));
        double v = step * (i / side - 0.5 * ((g->count - 1) / side));

        place_entry(g, i, u, v + 0.3 * step * st_signed(700u + (uint64_t)i));
        g->entry[i].position =
            st_float(st_world(&g->surface.frame, st_world(&g->place[i], st_vec3(0.0, 0.0, 0.0))));
        g->normal[i] =
            st_float(st_turn(&g->surface.frame, st_turn(&g->place[i], st_vec3(0.0, 0.0, 1.0))));
    }
}

/* ---- Media: Burley's `length` is d, the dipoles' a third of the decay ---- */
enum { BURLEY, DIPOLE, BETTER };

static void make_medium(group *g, int i, int type, const float albedo[3], const float length[3]) {
    float dmfp[3];

    for (int c = 0; c < 3; ++c) {
        double a = (double)albedo[c];

        dmfp[c] = type == BURLEY ? (float)st_burley_s(a) * length[c] : 0.8f * length[c];
        g->profile[i][c] = st_nothing();
        g->lambert[i][c] = length[c] > 0.0f ? 0.0 : a;
        if (albedo[c] == 0.0f || length[c] == 0.0f) continue;
        g->profile[i][c] = type == BURLEY ? st_burley(a, (double)dmfp[c])
                                          : st_dipole_from_albedo(a, (double)dmfp[c], (double)1.3f,
                                                                  type == BETTER);
    }
    sss_result result;
    if (type == BURLEY) result = sss_burley(&g->medium[i], albedo, dmfp);
    else if (type == DIPOLE) result = sss_dipole_from_albedo(&g->medium[i], albedo, dmfp, 1.3f);
    else result = sss_better_dipole_from_albedo(&g->medium[i], albedo, dmfp, 1.3f);
    assert_int_equal(result, SSS_OK);
}

static void make_own_medium(group *g, int i, int mixed) {
    float albedo[3], length[3];

    for (int c = 0; c < 3; ++c) {
        albedo[c] = 0.2f + 0.7f * (float)st_random(17u + (uint64_t)(3 * i + c));
        length[c] = 0.1f + 0.9f * (float)st_random(1017u + (uint64_t)(3 * i + c));
    }
    if (mixed && i % 4 == 1) albedo[i % 3] = 0.0f;
    if (mixed && i % 4 == 2) length[i % 3] = 0.0f;
    if (mixed && i % 16 == 7) albedo[0] = albedo[1] = albedo[2] = 0.0f;
    if (mixed && i % 16 == 11) length[0] = length[1] = length[2] = 0.0f;
    make_medium(g, i, mixed ? i % 3 : BURLEY, albedo, length);
}

static void make_media(group *g, int type) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f}, grey[3] = {1.0f, 1.0f, 1.0f};
    static const float coloured[3] = {1.0f, 0.2f, 0.04f}, lambert[3] = {1.0f, 0.0f, 0.3f};

    for (int i = 0; i < g->count; ++i) {
        if (g->media == GREY) make_medium(g, i, type, albedo, grey);
        if (g->media == COLOURED) make_medium(g, i, type, albedo, coloured);
        if (g->media == PARTLY_LAMBERT) make_medium(g, i, type, albedo, lambert);
        if (g->media >= OWN_BURLEY) make_own_medium(g, i, g->media == OWN_MIXED);
        g->entry[i].medium = g->media >= OWN_BURLEY ? &g->medium[i] : &g->medium[0];
    }
}

/* ---- Light, hints and lookups ---- */

/* Each member's hints are in a unit of its own, and say something else. */
static float hint_of(const group *g, st_light *light, st_vec y, int member, uint32_t seed,
                     int index) {
    double e = light(y), unit = exp2(3.0 * (member % 7) - 9.0);

    if (g->hint == NO_HINT) return 1.0f;
    if (g->hint == SHADOWED) return (float)(e * unit); /* 0 just where no light comes */
    if (member % 3 == 0) return (float)unit;
    return (float)((e + 0.05) * unit * (0.5 + st_noise(seed, index)));
}

static int lookup(const group *g, const sss_plan *plan, st_light *light, int member, uint32_t seed,
                  sss_exit *exits) {
    sss_resampler s;
    int index = 0;

    if (sss_begin(&s, g->entry[member].medium, plan, g->entry[member].position, g->normal[member],
                  seed) != SSS_OK)
        return -1;
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        int count = st_trace(&g->surface, &probe, hits);

        for (int i = 0; i < count; ++i, ++index) {
            st_vec y = st_local(&g->surface.frame, hits[i].position);

            sss_add_hit(&s, hits[i].position, hits[i].normal,
                        hint_of(g, light, y, member, seed, index));
        }
    }
    return sss_finish(&s, exits);
}

static uint32_t seed_of(long pass, int member) {
    return sss_hash(TEST_SEED + (uint32_t)member, (uint32_t)pass);
}

/* The integral of Rd E of one entry and channel. */
typedef struct lit_entry {
    const st_profile *profile;
    const st_frame *place;
    st_light *light;
} lit_entry;

static double lit_from(st_vec local, st_vec normal, const void *context) {
    const lit_entry *e = (const lit_entry *)context;

    (void)normal;
    return st_rd(e->profile, st_length(local)) * e->light(st_world(e->place, local));
}

static double truth_of(const group *g, st_light *light, int i, int c) {
    const st_profile *p = &g->profile[i][c];
    lit_entry e;
    st_fixture seen = g->surface;
    double here = light(st_world(&g->place[i], st_vec3(0.0, 0.0, 0.0)));

    e.profile = p;
    e.place = &g->place[i];
    e.light = light;
    seen.size = g->size[i];
    if (p->albedo == 0.0) return g->lambert[i][c] * here;
    return st_surface(&seen, p->dipole ? 1.0 / (3.0 * p->s) : p->d, lit_from, &e);
}

/* ---- What a single share must be ---- */

/* Rd as the header says it: below 1e-6 of its length Burley's is as at that radius. */
static double profile_of(const st_profile *p, double r) {
    return st_rd(p, p->dipole ? r : fmax(r, 1e-6 * p->d));
}

/* g_j of equation [8]: the mean of the live channels' unit profiles. */
static double target_of(const group *g, int i, double r) {
    double sum = 0.0;
    int live = 0;

    for (int c = 0; c < 3; ++c) {
        if (g->profile[i][c].albedo == 0.0) continue;
        sum += profile_of(&g->profile[i][c], r) / g->profile[i][c].albedo;
        ++live;
    }
    return live ? sum / live : 0.0;
}
static int live_of(const group *g, int i) {
    int live = 0;

    for (int c = 0; c < 3; ++c) live += g->profile[i][c].albedo > 0.0;
    return live;
}
static double distance(const group *g, int i, const sss_exit *exit) {
    return st_length(st_sum(st_double(exit->position), st_double(g->entry[i].position), -1.0));
}

/* Shared, or not: the length that counts is Burley's d or the dipoles' z_r. */
static int is_wide(const group *g, int i, int c) {
    const st_profile *p = &g->profile[i][c];

    return p->albedo > 0.0 && 2.0 * (p->dipole ? p->zr : p->d) >= (double)g->spacing;
}

/* How far the header may be off: its profiles' stated errors, twice, and the rounding of a few
   operations. 70 e-foldings away its profiles end. */
static double tolerance_of(const group *g, const sss_exit *exit, double *folds) {
    *folds = 0.0;
    for (int i = 0; i < g->count; ++i) {
        double r = distance(g, i, exit);

        for (int c = 0; c < 3; ++c) {
            const st_profile *p = &g->profile[i][c];

            if (p->albedo == 0.0) continue;
            *folds = fmax(*folds, p->dipole ? p->s * r : r / (3.0 * p->d));
        }
    }
    return 2.0 * (1.4e-6 + 2.1e-7 * *folds) + 1e-6;
}

typedef struct violations {
    long checked, wrong, above, strangers;
    double worst;
} violations;

/* Every weight of one exit by the formula, and the bound. */
static void check_share(const group *g, const sss_exit *exit, int own, float (*weight)[3],
                        violations *v) {
    double sum = 0.0, folds, tolerance = tolerance_of(g, exit, &folds);

    for (int i = 0; i < g->count; ++i) sum += target_of(g, i, distance(g, i, exit));
    for (int i = 0; i < g->count; ++i) {
        double r = distance(g, i, exit);

        for (int c = 0; c < 3; ++c) {
            const st_profile *p = &g->profile[i][c];
            double w = (double)weight[i][c];

            if (!(exit->mass > 0.0f && is_wide(g, i, c))) {
                double kept = i == own ? (double)exit->weight[c] : 0.0;

                v->strangers += !(w == kept);
                continue;
            }
            v->above += !(w <= p->albedo * live_of(g, i) * (double)exit->mass * 1.000001);
            if (folds > 65.0) continue;
            double expected = profile_of(p, r) / sum * (double)exit->mass;
            double error = fabs(w - expected) / fmax(expected, 1e-30);
            v->checked += 1;
            v->wrong += !(error <= tolerance);
            v->worst = fmax(v->worst, error / tolerance);
        }
    }
}

/* ---- Cases ---- */
typedef struct share_case {
    const char *name;
    st_kind kind;
    double size, step;
    int count, media, type, hint;
    sss_plan plan;
    float spacing;
    st_light *light;
} share_case;

#define PLAN(m, n, bits, colours)                                                                  \
    { m, n, bits, 0, colours, 0 }
static const unsigned disk_chord = SSS_DISK | SSS_CHORD;
static const share_case cases[] = {
    {"one entry on a plane", ST_PLANE, 0.0, 0.3, 1, GREY, BURLEY, NO_HINT, PLAN(8, 1, 0u, 0), 0.0f,
     st_light_spot},
    {"two sides of a thin slab", ST_SLAB, 0.1, 0.2, 2, GREY, BURLEY, OWN_UNITS, PLAN(8, 1, 0u, 0),
     0.0f, st_light_spot},
    {"two sides of a thin slab, dipole", ST_SLAB, 0.1, 0.1, 7, COLOURED, DIPOLE, OWN_UNITS,
     PLAN(8, 1, 0u, 1), 0.0f, st_light_shadow},
    {"both faces of an edge", ST_EDGE, 0.1, 0.25, 7, GREY, BURLEY, SHADOWED, PLAN(8, 1, 0u, 0),
     0.0f, st_light_shadow},
    {"edge, colours", ST_EDGE, 0.05, 0.15, 64, COLOURED, BURLEY, OWN_UNITS, PLAN(8, 1, 0u, 1), 0.0f,
     st_light_spot},
    {"sphere, a candidate each", ST_SPHERE, 1.0, 0.15, 64, GREY, BURLEY, NO_HINT,
     PLAN(1, 1, SSS_CHORD, 0), 0.0f, st_light_one},
    {"sphere, better dipole", ST_SPHERE, 0.5, 0.1, 64, COLOURED, BETTER, OWN_UNITS,
     PLAN(8, 2, 0u, 0), 0.0f, st_light_spot},
    {"hair", ST_CYLINDER, 0.1, 0.08, 64, GREY, BURLEY, OWN_UNITS, PLAN(8, 1, 0u, 0), 0.0f,
     st_light_spot},
    {"hair, colours", ST_CYLINDER, 0.1, 0.08, 7, COLOURED, BURLEY, SHADOWED, PLAN(7, 1, 0u, 1),
     0.0f, st_light_shadow},
    {"plane, live, Lambert and live", ST_PLANE, 0.0, 0.2, 7, PARTLY_LAMBERT, BURLEY, OWN_UNITS,
     PLAN(8, 1, 0u, 0), 0.0f, st_light_spot},
    {"plane, Lambert, colours", ST_PLANE, 0.0, 0.2, 64, PARTLY_LAMBERT, DIPOLE, OWN_UNITS,
     PLAN(8, 1, 0u, 1), 0.0f, st_light_spot},
    {"a medium each, two", ST_PLANE, 0.0, 0.3, 2, OWN_BURLEY, BURLEY, OWN_UNITS, PLAN(8, 1, 0u, 0),
     0.0f, st_light_spot},
    {"a medium each, sphere", ST_SPHERE, 1.0, 0.12, 64, OWN_BURLEY, BURLEY, OWN_UNITS,
     PLAN(8, 1, 0u, 1), 0.0f, st_light_spot},
    {"all profiles, black and Lambert channels", ST_PLANE, 0.0, 0.15, 64, OWN_MIXED, BURLEY,
     OWN_UNITS, PLAN(8, 1, 0u, 0), 0.0f, st_light_spot},
    {"the same on an edge, colours", ST_EDGE, 0.1, 0.12, 64, OWN_MIXED, BURLEY, NO_HINT,
     PLAN(8, 1, 0u, 1), 0.0f, st_light_spot},
    {"two channels below the spacing", ST_PLANE, 0.0, 0.3, 64, COLOURED, BURLEY, OWN_UNITS,
     PLAN(8, 1, 0u, 1), 0.6f, st_light_spot},
    {"two channels below the spacing, one exit", ST_SPHERE, 1.0, 0.12, 7, COLOURED, DIPOLE,
     OWN_UNITS, PLAN(8, 1, 0u, 0), 0.24f, st_light_spot},
    {"spacing among media of their own", ST_PLANE, 0.0, 0.3, 64, OWN_BURLEY, BURLEY, OWN_UNITS,
     PLAN(8, 1, 0u, 1), 1.0f, st_light_spot},
    {"spacing among mixed media", ST_SLAB, 0.2, 0.3, 7, OWN_MIXED, BURLEY, OWN_UNITS,
     PLAN(8, 2, 0u, 0), 0.6f, st_light_spot},
    {"members that miss", ST_CYLINDER, 0.1, 0.1, 7, GREY, BURLEY, OWN_UNITS,
     PLAN(1, 1, disk_chord, 0), 0.0f, st_light_spot},
};
enum { CASES = sizeof cases / sizeof *cases };

static void make_group(const share_case *k, st_frame frame, group *g) {
    memset(g, 0, sizeof *g);
    g->surface.kind = k->kind;
    g->surface.size = k->size;
    g->surface.frame = frame;
    g->count = k->count;
    g->media = k->media;
    g->hint = k->hint;
    g->spacing = k->spacing;
    place_entries(g, k->step);
    make_media(g, k->type);
}

static int watched(const group *g, int w) {
    return g->count <= WATCHED ? w : w * (g->count - 1) / (WATCHED - 1);
}

/* What one pass gives to the entries that are watched. */
typedef struct pass_sums {
    st_stat stat[WATCHED][3];
    violations seen;
    long missed;
} pass_sums;

static void run_pass(const share_case *k, const group *g, long pass, pass_sums *sums) {
    double sum[WATCHED][3];
    int shown = g->count < WATCHED ? g->count : WATCHED;

    memset(sum, 0, sizeof sum);
    float weight[MOST][3];
    for (int i = 0; i < g->count; ++i) {
        sss_exit exits[SSS_MAX_EXITS];
        int found = lookup(g, &k->plan, k->light, i, seed_of(pass, i), exits);

        sums->missed += found == 0 && live_of(g, i) > 0;
        for (int e = 0; e < found; ++e) {
            double light = k->light(st_local(&g->surface.frame, exits[e].position));

            sss_share(&exits[e], g->entry, g->count, i, g->spacing, weight);
            if (pass < 8) check_share(g, &exits[e], i, weight, &sums->seen);
            for (int w = 0; w < shown; ++w)
                for (int c = 0; c < 3; ++c) sum[w][c] += (double)weight[watched(g, w)][c] * light;
        }
    }
    for (int w = 0; w < shown; ++w)
        for (int c = 0; c < 3; ++c) st_add(&sums->stat[w][c], sum[w][c]);
}

static void compare_means(const share_case *k, const group *g, const pass_sums *all) {
    int shown = g->count < WATCHED ? g->count : WATCHED;
    double truth[WATCHED][3];

#pragma omp parallel for schedule(dynamic)
    for (int w = 0; w < shown * 3; ++w)
        truth[w / 3][w % 3] = truth_of(g, k->light, watched(g, w / 3), w % 3);
    for (int w = 0; w < shown; ++w) {
        for (int c = 0; c < 3; ++c) {
            char name[160];
            const st_stat *s = &all->stat[w][c];

            snprintf(name, sizeof name, "%s, entry %d, channel %d", k->name, watched(g, w), c);
            if (truth[w][c] == 0.0) check_near(name, s->mean, 0.0, 0.0);
            else check_z(name, s->mean, st_error(s), truth[w][c], 3e-6, Z_LIMIT);
        }
    }
}

static void every_entry_has_its_integral(void **state) {
    static group g;
    static pass_sums part[BLOCKS];
    violations all = {0, 0, 0, 0, 0.0};
    long missed = 0;

    (void)state;
    for (int k = 0; k < CASES; ++k) {
        long passes = lookups / cases[k].count / BLOCKS;

        if (passes > lookups / 400) passes = lookups / 400; /* small groups */
        make_group(&cases[k], k % 2 ? st_moved() : st_stay(), &g);
        memset(part, 0, sizeof part);
#pragma omp parallel for schedule(dynamic)
        for (int b = 0; b < BLOCKS; ++b) {
            for (long pass = 0; pass < passes; ++pass)
                run_pass(&cases[k], &g, b + BLOCKS * pass, &part[b]);
        }
        for (int b = 1; b < BLOCKS; ++b) {
            for (int w = 0; w < WATCHED; ++w)
                for (int c = 0; c < 3; ++c) st_merge(&part[0].stat[w][c], &part[b].stat[w][c]);
        }
        for (int b = 0; b < BLOCKS; ++b) {
            const violations *v = &part[b].seen;

            all.checked += v->checked;
            all.worst = fmax(all.worst, v->worst);
            missed += part[b].missed;
            check_equal(cases[k].name, v->wrong, 0);
            check_equal("weights above the bound", v->above, 0);
            check_equal("weights that should stay with their own lookup", v->strangers, 0);
        }
        compare_means(&cases[k], &g, &part[0]);
    }
    print_message("%ld weights by the formula, worst error %.2f of the tolerance; %ld lookups "
                  "missed\n",
                  all.checked, all.worst, missed);
    check_at_least("weights compared", (double)all.checked, 10000.0);
    check_at_least("lookups that missed", (double)missed, 1000.0);
}

/* ---- Mass: the sum of light g / Lambda over the hits, over the light of the one that is held.
   Lambda comes from sss_intensity, g from double precision. ---- */
static double mass_of(const group *g, const share_case *k, int member, uint32_t seed) {
    double sum = 0.0;
    sss_resampler s;
    int index = 0;

    sss_begin(&s, g->entry[member].medium, &k->plan, g->entry[member].position, g->normal[member],
              seed);
    double light[16 * ST_MAX_HITS];
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        int count = st_trace(&g->surface, &probe, hits);

        for (int i = 0; i < count; ++i, ++index) {
            st_vec local = st_local(&g->surface.frame, hits[i].position);
            sss_vec3 y = hits[i].position;
            float hint = hint_of(g, k->light, local, member, seed, index);
            st_vec way = st_sum(st_double(y), st_double(g->entry[member].position), -1.0);
            double mu = (double)sss_intensity(&s, y, hits[i].normal) * k->plan.candidates;

            light[index] = (double)hint;
            sum += light[index] * target_of(g, member, st_length(way)) / mu;
            sss_add_hit(&s, y, hits[i].normal, hint);
        }
    }
    sss_exit exit;
    check_equal("exits", sss_finish(&s, &exit), sum > 0.0);
    if (!(sum > 0.0)) return -1.0;
    check_at_least("number of the hit", exit.hit, 0.0);
    check_at_most("number of the hit", exit.hit, index - 1);
    double error = fabs((double)exit.mass * light[exit.hit] / sum - 1.0);

    /* Ten times what the profile of theory and that of the intensity may be off together. */
    check_at_most(k->name, error, 2e-5);
    return error;
}

static void mass_is_what_the_reservoir_holds(void **state) {
    static group g;
    double worst = 0.0;
    long checked = 0;

    (void)state;
    for (int k = 0; k < CASES; ++k) {
        const share_case *one = &cases[k];

        /* Other tests look at several reservoirs; Lambert channels add to the mass. */
        if (one->plan.per_channel || one->plan.exits > 1) continue;
        if (one->media == PARTLY_LAMBERT || one->media == OWN_MIXED) continue;
        make_group(one, st_stay(), &g);
        for (int i = 0; i < 200; ++i) {
            double error = mass_of(&g, one, i % g.count, seed_of(i, 77));

            worst = fmax(worst, error);
            checked += error >= 0.0;
        }
    }
    print_message("%ld masses, worst relative error %.2g\n", checked, worst);
    check_at_least("masses", (double)checked, 1000.0);
}

/* ---- Bits ---- */
static int same_bits(float a, float b) { return sssi_bits(a) == sssi_bits(b); }

/* The medium of an entry, 2^k larger. Lengths are made again by the same constructors. */
static void scaled_medium(int type, int k, sss_medium *m) {
    static const float albedo[3] = {0.9f, 0.6f, 0.3f};
    float dmfp[3] = {ldexpf(3.7f, k), ldexpf(0.9f, k), ldexpf(0.21f, k)};
    float absorption[3] = {ldexpf(0.3f, -k), ldexpf(0.9f, -k), ldexpf(0.01f, -k)};
    float scattering[3] = {ldexpf(2.0f, -k), ldexpf(5.0f, -k), ldexpf(9.0f, -k)};

    if (type == 0) assert_int_equal(sss_burley(m, albedo, dmfp), SSS_OK);
    if (type == 1) assert_int_equal(sss_dipole(m, absorption, scattering, 1.3f), SSS_OK);
    if (type == 2) assert_int_equal(sss_better_dipole(m, absorption, scattering, 1.3f), SSS_OK);
    if (type == 3) assert_int_equal(sss_burley_mfp(m, albedo, dmfp), SSS_OK);
}

/* A lookup on a plane, everything 2^k larger: its exits and what an entry alone gets of them. */
static int scaled_lookup(int type, int k, int plan_number, uint32_t seed, sss_medium *m,
                         sss_entry *entry, sss_exit *exits) {
    static const sss_plan plans[] = {PLAN(0, 0, 0u, 0), PLAN(8, 0, 0u, 1), PLAN(13, 4, 0u, 0),
                                     PLAN(3, 1, SSS_CHORD, 0)};
    st_fixture plane = st_standard(ST_SLAB, st_stay());
    int index = 0;

    scaled_medium(type, k, m);
    sss_vec3 x, n;
    st_entry(&plane, &x, &n);
    x.x = 0.75f;
    entry->position = st_scaled(x, k);
    entry->medium = m;
    sss_resampler s;
    assert_int_equal(sss_begin(&s, m, &plans[plan_number], entry->position, n, seed), SSS_OK);
    sss_probe probe;
    st_hit hits[ST_MAX_HITS];
    while (sss_next_probe(&s, &probe)) {
        probe.origin = st_scaled(probe.origin, -k);
        probe.length = ldexpf(probe.length, -k);
        int count = st_trace(&plane, &probe, hits);
        for (int i = 0; i < count; ++i, ++index)
            sss_add_hit(&s, st_scaled(hits[i].position, k), hits[i].normal,
                        (float)(0.5 + st_noise(seed, index)));
    }
    return sss_finish(&s, exits);
}

/* Densities travel in scene units: an exit so far away that Rd is no normal float there is lost. */
static int is_faint(const sss_medium *m, int c, const sss_entry *entry, const sss_exit *exit) {
    double r = st_length(st_sum(st_double(exit->position), st_double(entry->position), -1.0));

    return !(sss_profile(m, c, (float)r) >= 4.0f * FLT_MIN);
}

static void one_entry_alone_gets_its_own_weight(void **state) {
    static const int scales[] = {0, -33, -20, 3, 21, 33};
    long compared = 0, faint = 0;

    (void)state;
    for (int type = 0; type < 4; ++type) {
        for (int plan = 0; plan < 4; ++plan) {
            for (uint32_t seed = 0; seed < 300u; ++seed) {
                sss_exit first[SSS_MAX_EXITS], exits[SSS_MAX_EXITS];
                sss_medium m;
                sss_entry entry;
                int found = scaled_lookup(type, 0, plan, seed, &m, &entry, first);

                for (int k = 0; k < 6; ++k) {
                    check_equal("exits at another scale",
                                scaled_lookup(type, scales[k], plan, seed, &m, &entry, exits),
                                found);
                    for (int e = 0; e < found; ++e) {
                        float weight[1][3];
                        float density = sss_share_density(&m, entry.position, &exits[e]);

                        sss_share(&exits[e], &entry, 1, 0, 0.0f, weight);
                        float half[3];
                        sss_share_weight(&m, entry.position, &exits[e], density, half);
                        assert_true(same_bits(exits[e].mass, first[e].mass));
                        assert_int_equal(exits[e].hit, first[e].hit);
                        for (int c = 0; c < 3; ++c) {
                            assert_true(same_bits(first[e].weight[c], exits[e].weight[c]));
                            assert_true(same_bits(half[c], weight[0][c]));
                            if (is_faint(&m, c, &entry, &exits[e])) {
                                check_at_most("a faint weight", (double)weight[0][c],
                                              3.0 * (double)exits[e].mass);
                                ++faint;
                                continue;
                            }
                            assert_true(same_bits(weight[0][c], exits[e].weight[c]));
                            ++compared;
                        }
                    }
                }
            }
        }
    }
    print_message("    %ld weights of entries alone, the same bits at 6 scales; %ld too faint\n",
                  compared, faint);
    check_at_most("faint weights", (double)faint, 1e-2 * (double)compared);
    check_at_least("weights", (double)compared, 50000.0);
}

/* The whole by its two halves, and in another order of the entries. */
static void halves_give_the_bits_of_the_whole(void **state) {
    static group g;
    static sss_entry backwards[MOST];
    long compared = 0;

    (void)state;
    for (int k = 0; k < CASES; ++k) {
        make_group(&cases[k], st_moved(), &g);
        for (int i = 0; i < g.count; ++i) {
            sss_exit exits[SSS_MAX_EXITS];
            int found = lookup(&g, &cases[k].plan, cases[k].light, i, seed_of(k, i), exits);

            for (int e = 0; e < found; ++e) {
                float whole[MOST][3], sum = 0.0f;

                sss_share(&exits[e], g.entry, g.count, i, g.spacing, whole);
                for (int j = 0; j < g.count; ++j) {
                    backwards[g.count - 1 - j] = g.entry[j];
                    sum += sss_share_density(g.entry[j].medium, g.entry[j].position, &exits[e]);
                }
                float other[MOST][3];
                sss_share(&exits[e], backwards, g.count, g.count - 1 - i, g.spacing, other);
                for (int j = 0; j < g.count; ++j) {
                    float half[3];

                    sss_share_weight(g.entry[j].medium, g.entry[j].position, &exits[e], sum, half);
                    for (int c = 0; c < 3; ++c) {
                        float back = other[g.count - 1 - j][c];

                        int kept = !(exits[e].mass > 0.0f) ||
                                   !sss_is_shared(g.entry[j].medium, c, g.spacing);
                        if (kept) half[c] = j == i ? exits[e].weight[c] : 0.0f;
                        if (!same_bits(half[c], whole[j][c]))
                            fail_msg("%s: exit of %d, entry %d: %.9g by halves, %.9g as a whole",
                                     cases[k].name, i, j, (double)half[c], (double)whole[j][c]);

                        /* Each of the sums may be off by half an ulp for each entry. */
                        check_relative(cases[k].name, (double)back, (double)whole[j][c],
                                       6e-8 * (2.0 * g.count + 4.0));
                        ++compared;
                    }
                }
            }
        }
    }
    print_message("    %ld weights by halves and backwards\n", compared);
}

/* ---- The spacing: by entry and channel, whoever found the exit ---- */
static void narrow_channels_keep_to_themselves(void **state) {
    static const float albedo[3] = {0.8f, 0.7f, 0.6f}, wide[3] = {2.0f, 2.0f, 2.0f},
                       narrow[3] = {2.0f, 0.1f, 2.0f}, origin[3] = {0.0f, 0.5f, 0.0f};
    static group g;

    (void)state;
    memset(&g, 0, sizeof g);
    g.count = 2;
    make_medium(&g, 0, BURLEY, albedo, wide);
    make_medium(&g, 1, BURLEY, albedo, narrow);
    for (int c = 0; c < 2; ++c) {
        g.entry[c].position.x = origin[c];
        g.entry[c].medium = &g.medium[c];
    }
    sss_exit exit;
    memset(&exit, 0, sizeof exit);
    exit.position.y = 0.1f;
    exit.mass = 1.25f;
    for (int c = 0; c < 3; ++c) exit.weight[c] = 0.5f + (float)c;
    float weight[2][3];
    for (int own = 0; own < 2; ++own) {
        sss_share(&exit, g.entry, 2, own, 0.5f, weight);
        for (int c = 0; c < 3; ++c) check_at_least("a wide entry", (double)weight[0][c], 1e-3);
        check_near("a narrow channel", (double)weight[1][1], own ? (double)exit.weight[1] : 0.0,
                   0.0);
        check_at_least("a wide channel beside it", (double)weight[1][0], 1e-3);
        if (own == 0) continue;
        assert_true(weight[1][0] != exit.weight[0]);
    }
    assert_int_equal(sss_is_shared(&g.medium[1], 1, 0.5f), 0);
    assert_int_equal(sss_is_shared(&g.medium[1], 0, 0.5f), 1);
    assert_int_equal(sss_is_shared(&g.medium[1], 1, 0.0f), 1);
    assert_int_equal(sss_is_shared(&g.medium[1], 1, 2.0f * g.medium[1].length[1]), 1);
    assert_int_equal(sss_is_shared(&g.medium[1], 1, 2.00001f * g.medium[1].length[1]), 0);
}

/* ---- Exits that serve their own entry alone ---- */
static void walks_and_lambert_serve_themselves(void **state) {
    static const float albedo[3] = {0.8f, 0.5f, 0.0f}, mfp[3] = {1.0f, 0.5f, 1.0f};
    static const float lambert[3] = {1.0f, 0.0f, 1.0f};
    static const unsigned techniques[3] = {SSS_WALK, SSS_LAMBERT, 0u};
    st_fixture ball = st_standard(ST_SPHERE, st_stay());
    sss_medium media[2];
    long walks = 0, entries = 0;

    (void)state;
    assert_int_equal(sss_burley_mfp(&media[0], albedo, mfp), SSS_OK);
    assert_int_equal(sss_burley(&media[1], albedo, lambert), SSS_OK);
    for (int t = 0; t < 3; ++t) {
        for (int m = 0; m < 2; ++m) {
            for (uint32_t seed = 0; seed < 400u; ++seed) {
                sss_plan plan = PLAN(2, 0, techniques[t], (int)seed % 2);
                sss_exit exits[SSS_MAX_EXITS];
                sss_entry crowd[3];
                int found = st_lookup(&ball, &media[m], &plan, seed, NULL, exits);

                for (int i = 0; i < 3; ++i) {
                    sss_vec3 n;

                    st_entry(&ball, &crowd[i].position, &n);
                    crowd[i].position.x += 0.01f * (float)(i - 1);
                    crowd[i].medium = &media[m];
                }
                float weight[3][3];
                for (int e = 0; e < found; ++e) {
                    int own = (int)(seed % 3u);
                    int alone = techniques[t] == SSS_WALK || exits[e].hit == -1;

                    walks += techniques[t] == SSS_WALK && exits[e].hit >= 0;
                    entries += exits[e].hit == -1;
                    if (!alone) continue;
                    check_near("mass", (double)exits[e].mass, 0.0, 0.0);
                    sss_share(&exits[e], crowd, 3, own, 0.0f, weight);
                    for (int i = 0; i < 3; ++i) {
                        for (int c = 0; c < 3; ++c)
                            assert_true(
                                same_bits(weight[i][c], i == own ? exits[e].weight[c] : 0.0f));
                    }
                }
            }
        }
    }
    check_at_least("exits of walks", (double)walks, 500.0);
    check_at_least("exits at the entry", (double)entries, 500.0);
}

/* ---- Hostile arguments: no NaN comes out, nothing is written beyond the group ---- */
static void check_hostile(const sss_exit *exit, const sss_entry *crowd, int count, int own,
                          float spacing) {
    float weight[10][3], sum = 0.0f;

    for (int i = 0; i < 10; ++i)
        for (int c = 0; c < 3; ++c) weight[i][c] = -7.0f;
    sss_share(exit, crowd, count, own, spacing, weight);
    for (int i = 0; i < 10; ++i) {
        for (int c = 0; c < 3; ++c) {
            float w = weight[i][c];

            if (i >= count) assert_true(w == -7.0f);
            else if (!(w >= 0.0f && w <= FLT_MAX)) fail_msg("weight %g of entry %d", (double)w, i);
        }
    }
    for (int i = 0; i < count; ++i)
        sum += sss_share_density(crowd[i].medium, crowd[i].position, exit);
    for (int i = 0; i < count; ++i) {
        sss_share_weight(crowd[i].medium, crowd[i].position, exit, sum, weight[0]);
        for (int c = 0; c < 3; ++c) {
            if (!(weight[0][c] >= 0.0f && weight[0][c] <= FLT_MAX))
                fail_msg("weight %g of entry %d by halves", (double)weight[0][c], i);
        }
    }
}

static void hostile_arguments_make_no_nan(void **state) {
    static const float bad[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1e20f, 1e-40f, 0.0f};
    static const float albedo[3] = {0.8f, 0.5f, 0.3f}, one[3] = {1.0f, 0.2f, 0.0f};
    static const float spacings[] = {0.0f, NAN, INFINITY, -1.0f, 0.1f};
    static const float masses[] = {1.0f, 0.0f, NAN, -1.0f, 1e-40f, 1e20f};
    static const int counts[] = {0, 1, 2, 9}, owns[] = {0, -1, 9, 1000000, -2147483647 - 1};
    sss_medium media[4];
    long calls = 0;

    (void)state;
    sss_burley(&media[0], albedo, one);
    sss_dipole_from_albedo(&media[1], albedo, one, 1.3f);
    sss_better_dipole_from_albedo(&media[2], albedo, one, 1.3f);
    assert_int_equal(sss_burley(&media[3], one, bad), SSS_BAD_LENGTH); /* black */
    for (int b = 0; b < 8; ++b) {
        for (int k = 0; k < 4 * 5 * 5 * 6 * 4; ++k) {
            sss_exit exit;
            int count = counts[k % 4], own = owns[k / 4 % 5];

            memset(&exit, 0, sizeof exit);
            exit.weight[0] = exit.weight[1] = exit.weight[2] = 0.5f;
            exit.mass = masses[k / 100 % 6];
            if (k % 3 == 0) exit.position.x = bad[b];
            sss_entry crowd[9];
            for (int i = 0; i < 9; ++i) {
                int m = k / 600 == 3 ? i % 4 : k / 600;
                crowd[i].medium = &media[m];
                crowd[i].position.x = 0.1f * (float)i;
                crowd[i].position.y = k % 3 == 1 ? bad[b] : 0.0f;
                crowd[i].position.z = i == 1 && k % 3 == 2 ? bad[b] : 0.0f;
            }
            check_hostile(&exit, crowd, count, own, spacings[k / 20 % 5]);
            ++calls;
        }
    }
    check_hostile(&(sss_exit){{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, {1.0f, 1.0f, 1.0f}, 0, 1.0f},
                  NULL, 0, 0, 0.0f);
    print_message("    %ld hostile calls\n", calls);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_entry_has_its_integral),
        cmocka_unit_test(mass_is_what_the_reservoir_holds),
        cmocka_unit_test(one_entry_alone_gets_its_own_weight),
        cmocka_unit_test(halves_give_the_bits_of_the_whole),
        cmocka_unit_test(narrow_channels_keep_to_themselves),
        cmocka_unit_test(walks_and_lambert_serve_themselves),
        cmocka_unit_test(hostile_arguments_make_no_nan),
    };
    if (st_is_long()) lookups = 10 * LOOKUPS;
    return cmocka_run_group_tests_name("share", tests, NULL, st_report);
}
