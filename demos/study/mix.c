// mix.c - the experiment that chose the default plan: the variance of one lookup for many mixes of
// techniques, over scenes, sizes of dmfp, grey and saturated media, with and without a hint of the
// light. SPDX-License-Identifier: MIT
#include <stdio.h>
#include <stdlib.h>

#include "demos/common/entries.h"
#include "demos/common/scenes.h"
#include "demos/common/tracer.h"

#define MIX_SCENES SCENES_RABBIT // those before it: it is for the picture of the README
#define MIX_MEDIA  6             // three sizes of dmfp, grey and saturated

typedef struct mix_plan {
    const char *name;
    int candidates, independent, hinted;
    float share[SSSI_TECHNIQUES]; // disk normal, tangent, bitangent, sphere, chord
} mix_plan;

// The first two are what the others are measured against.
enum { MIX_KING, MIX_FLOOR, MIX_DEFAULT, MIX_MEMO, MIX_HINTED = 11 };
static const mix_plan mix_plans[] = {
    [MIX_KING] = {"King, 1 candidate", 1, 1, 0, {0.5f, 0.25f, 0.25f, 0.0f, 0.0f}},
    [MIX_FLOOR] = {"floor: 256 candidates", 256, 0, 0, {0.375f, 0.0f, 0.0f, 0.375f, 0.25f}},
    [MIX_DEFAULT] =
        {"default (disk 3 sphere 3 chord 2)", 8, 0, 0, {0.375f, 0.0f, 0.0f, 0.375f, 0.25f}},
    [MIX_MEMO] = {"  the same, 16 independent", 16, 1, 0, {0.375f, 0.0f, 0.0f, 0.375f, 0.25f}},
    {"  the same, 8 independent", 8, 1, 0, {0.375f, 0.0f, 0.0f, 0.375f, 0.25f}},
    {"disk 4 chord 4", 8, 0, 0, {0.5f, 0.0f, 0.0f, 0.0f, 0.5f}},
    {"disk 4 tangents 2+2", 8, 0, 0, {0.5f, 0.25f, 0.25f, 0.0f, 0.0f}},
    {"disk 4 tangents 1+1 chord 2", 8, 0, 0, {0.5f, 0.125f, 0.125f, 0.0f, 0.25f}},
    {"disk 4 sphere 2 chord 2", 8, 0, 0, {0.5f, 0.0f, 0.0f, 0.25f, 0.25f}},
    {"disk 2 sphere 4 chord 2", 8, 0, 0, {0.25f, 0.0f, 0.0f, 0.5f, 0.25f}},
    {"disk 2 sphere 5 chord 1", 8, 0, 0, {0.25f, 0.0f, 0.0f, 0.625f, 0.125f}},
    [MIX_HINTED] = {"default, light hint", 8, 0, 1, {0.375f, 0.0f, 0.0f, 0.375f, 0.25f}},
    {"disk 4 chord 4, hinted", 8, 0, 1, {0.5f, 0.0f, 0.0f, 0.0f, 0.5f}},
    {"disk 4 tangents 2+2, hinted", 8, 0, 1, {0.5f, 0.25f, 0.25f, 0.0f, 0.0f}},
    {"disk 2 sphere 5 chord 1, hinted", 8, 0, 1, {0.25f, 0.0f, 0.0f, 0.625f, 0.125f}},
};
#define MIX_PLANS ((int)(sizeof mix_plans / sizeof mix_plans[0]))

// Relative variances summed over the entries of a scene, and their logarithms over the floor and
// King.
typedef struct mix_sums {
    double variance[MIX_SCENES][MIX_PLANS], log_floor[MIX_PLANS], log_king[MIX_PLANS];
    int entries;
} mix_sums;

// n.l of the lamp's centre and a little from everywhere; the hint leaves out the shadow.
static float mix_light(const scene *s, sss_vec3 position, sss_vec3 normal, int shape, int hint) {
    sss_vec3 path = scene_sub(s->light.center, position), l = scene_normalize(path);
    float cosine = scene_dot(l, normal), little = 0.05f;
    if (cosine <= 0.0f) return little;
    if (!hint && position.y < 0.0f) return little;
    if (!hint && scene_occluded(s, position, l, scene_sqrt(scene_dot(path, path)), shape))
        return little;
    return cosine + little;
}

// One lookup: the estimate of the integral of Rd E over the surface, by channel.
static void mix_lookup(const scene *s, const mix_plan *plan, camera_entry at, uint32_t seed,
                       double value[3]) {
    sss_resampler r;
    sss_probe probe;
    sss_exit exit;
    scene_hits hits;
    unsigned char found[SCENE_MAX_FOUND];
    int calls = 0;
    sss_plan p = {0, 1, 0, 0, 0, 0};
    p.candidates = plan->candidates;
    p.independent = plan->independent;
    sss_begin(&r, &s->medium, &p, at.position, at.normal, seed);

    // Shares that no plan can ask for: this experiment sets what is private.
    memcpy(r.share, plan->share, sizeof r.share);
    sssi_set_counts(&r);
    while (sss_next_probe(&r, &probe)) {
        scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; i++) {
            sss_vec3 x = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 n = scene_normal(&s->shape[hits.hit[i].shape], x);
            found[calls++] = (unsigned char)hits.hit[i].shape;
            sss_add_hit(&r, x, n, plan->hinted ? mix_light(s, x, n, 0, 1) : 1.0f);
        }
    }
    value[0] = value[1] = value[2] = 0.0;
    if (!sss_finish(&r, &exit)) return;
    float light = mix_light(s, exit.position, exit.normal, found[exit.hit], 0);
    for (int c = 0; c < 3; c++) value[c] = (double)(exit.weight[c] * light);
}

// Variance over squared mean, the channels summed.
static double mix_variance(const scene *s, const mix_plan *plan, camera_entry at, uint32_t key,
                           int lookups) {
    double sum[3] = {0.0, 0.0, 0.0}, squares[3] = {0.0, 0.0, 0.0}, variance = 0.0, square = 0.0;
    for (int i = 0; i < lookups; i++) {
        double value[3];
        mix_lookup(s, plan, at, sss_hash(key, (uint32_t)i), value);
        for (int c = 0; c < 3; c++) {
            sum[c] += value[c];
            squares[c] += value[c] * value[c];
        }
    }
    for (int c = 0; c < 3; c++) {
        double mean = sum[c] / lookups;
        variance += (squares[c] - sum[c] * mean) / (lookups - 1);
        square += mean * mean;
    }
    return variance / square;
}

// Medium k of a scene: its green dmfp times 1/4, 1 or 4, the same in all channels or spread over a
// factor of 20.
static void mix_medium(scene *s, const scenes_optics *optics, int k, const char *profile) {
    static const float size[3] = {0.25f, 1.0f, 4.0f},
                       spread[2][3] = {{1.0f, 1.0f, 1.0f}, {2.0f, 0.4f, 0.1f}};
    static const float albedo[2][3] = {{0.8f, 0.8f, 0.8f}, {0.9f, 0.5f, 0.3f}};
    float dmfp[3];
    for (int c = 0; c < 3; c++) dmfp[c] = size[k % 3] * spread[k / 3][c] * optics->dmfp[1];
    if (strcmp(profile, "dipole") == 0)
        sss_dipole_from_albedo(&s->medium, albedo[k / 3], dmfp, 1.4f);
    else if (strcmp(profile, "better-dipole") == 0)
        sss_better_dipole_from_albedo(&s->medium, albedo[k / 3], dmfp, 1.4f);
    else sss_burley(&s->medium, albedo[k / 3], dmfp);
}

static void mix_measure(mix_sums *sums, const scene *s, int scene_index, camera_entry at,
                        uint32_t key, int lookups) {
    double v[MIX_PLANS];
    for (int p = 0; p < MIX_PLANS; p++) {
        int n = mix_plans[p].candidates > 100 ? lookups / 4 : lookups;
        v[p] = mix_variance(s, &mix_plans[p], at, sss_hash(key, (uint32_t)p), n);
    }
#pragma omp critical
    {
        for (int p = 0; p < MIX_PLANS; p++) {
            sums->variance[scene_index][p] += v[p];
            sums->log_floor[p] += log(v[p] / v[MIX_FLOOR]);
            sums->log_king[p] += log(v[p] / v[MIX_KING]);
        }
        sums->entries++;
    }
}

// The mean over the scenes of one plan's variance over another's.
static double mix_mean(const mix_sums *sums, int plan, int over) {
    double mean = 0.0;
    for (int k = 0; k < MIX_SCENES; k++)
        mean += sums->variance[k][plan] / sums->variance[k][over] / MIX_SCENES;
    return mean;
}

static void mix_print(const mix_sums *sums) {
    printf("\nrelative variance of one lookup, over that of the floor, scenes by their sums; then "
           "over King's\n%-34s",
           "");
    for (int k = 0; k < MIX_SCENES; k++) printf("%9s", scenes_known[k].name);
    printf("%9s%9s%9s\n", "mean", "typical", "/ King");
    for (int p = 0; p < MIX_PLANS; p++) {
        printf("%-34s", mix_plans[p].name);
        for (int k = 0; k < MIX_SCENES; k++)
            printf("%9.3f", sums->variance[k][p] / sums->variance[k][MIX_FLOOR]);
        printf("%9.3f%9.3f%9.4f\n", mix_mean(sums, p, MIX_FLOOR),
               exp(sums->log_floor[p] / sums->entries), mix_mean(sums, p, MIX_KING));
    }
    printf("typical: geometric mean over all %d entries and media.\n", sums->entries);
}

// The default over 16 independent candidates: by scene, in the mean, and at a typical entry.
static void mix_print_memo(const mix_sums *sums) {
    double mean = mix_mean(sums, MIX_DEFAULT, MIX_FLOOR) / mix_mean(sums, MIX_MEMO, MIX_FLOOR);
    double typical = (sums->log_floor[MIX_DEFAULT] - sums->log_floor[MIX_MEMO]) / sums->entries;
    printf("\n8 stratified candidates over 16 independent ones:");
    for (int k = 0; k < MIX_SCENES; k++)
        printf(" %s %.2f,", scenes_known[k].name,
               sums->variance[k][MIX_DEFAULT] / sums->variance[k][MIX_MEMO]);
    printf(" mean %.3f, typical %.2f.\n", mean, exp(typical));
}

// As demos/study/README.md shows it: means over the scenes.
static void mix_print_table(const mix_sums *sums) {
    static const struct {
        const char *name;
        int plan;
    } row[] = {{"plain: one probe on three axes", MIX_KING},
               {"16 candidates, independent (the memo)", MIX_MEMO},
               {"**default: 8 candidates, stratified**", MIX_DEFAULT},
               {"floor: 256 candidates", MIX_FLOOR},
               {"**default, with a light hint** (n.l + 0.05)", MIX_HINTED}};
    printf("\n| one lookup, one shaded exit | over plain | over the floor |\n|---|---|---|\n");
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        printf("| %s | %.3f | %.3f |\n", row[i].name, mix_mean(sums, row[i].plan, MIX_KING),
               mix_mean(sums, row[i].plan, MIX_FLOOR));
}

int main(int argc, char **argv) {
    static mix_sums sums;
    static scene s;
    const char *profile = "burley";
    int entries = 12, lookups = 1600;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--quick") == 0) entries = 2, lookups = 400;
        else if (strcmp(argv[i], "dipole") == 0 || strcmp(argv[i], "better-dipole") == 0)
            profile = argv[i];
        else return fprintf(stderr, "usage: mix [--quick] [dipole|better-dipole]\n"), 2;
    }
    for (int k = 0; k < MIX_SCENES * MIX_MEDIA; k++) {
        scenes_optics optics = scenes_make(&s, k / MIX_MEDIA);
        camera_entry entry[64];
        mix_medium(&s, &optics, k % MIX_MEDIA, profile);
        camera_entries(&s, 11u, entry, entries);
#pragma omp parallel for schedule(dynamic)
        for (int i = 0; i < entries; i++) {
            mix_measure(&sums, &s, k / MIX_MEDIA, entry[i], sss_hash((uint32_t)k, (uint32_t)i),
                        lookups);
        }
        fprintf(stderr, "\rmix: %d of %d media", k + 1, MIX_SCENES * MIX_MEDIA);
    }
    fprintf(stderr, "\n");
    mix_print(&sums);
    mix_print_memo(&sums);
    mix_print_table(&sums);
    return 0;
}
