// chart.c - speed against accuracy: measures the rivals of rivals.h in all scenes and writes one row of CSV for each
// method, setting and repeat. chart.awk and chart.gp make the charts from it. See --help.
// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define COMMAND "chart"
#include "demos/common/command.h"
#include "demos/common/progress.h"
#include "rivals.h"

#define CHART_SIZES   5
#define CHART_SCENES  SCENES_RABBIT // those before it: it is for the picture of the README
#define CHART_ENTRIES 16
#define CHART_LEVELS  6 // errors after 1, 4, 16 .. 1024 lookups
#define CHART_WIDTH   480
#define CHART_HEIGHT  270 // of the picture whose pixels share a point cloud
#define CHART_KEY     96

static const char usage[] =
    "usage: chart [--quick] [--csv FILE]\n"
    "Measures noise, bias and CPU time of ten ways to sample subsurface scattering: build/chart.csv.\n"
    "\n"
    "  --csv FILE   where the rows go; rows that it holds are not measured again\n"
    "  --quick      few lookups: checks that all works, its figures say nothing\n"
    "  --help\n"
    "\n"
    "Ctrl-C keeps the finished rows, and the next run of the same program goes on from there.\n";

typedef struct chart_settings {
    const char *name;
    int entries, lookups, repeats, sizes;
    int sets, points; // of area points for each entry's reference; at most, of the point cloud
} chart_settings;
static const chart_settings chart_full = {"full", 16, 1024, 5, 5, 100000, 65536};
static const chart_settings chart_quick = {"quick", 4, 256, 1, 2, 2000, 1024};

// Factors of each scene's dmfp. At the first all methods and costs of shading race, at the others one of each.
static const float chart_sizes[CHART_SIZES] = {1.0f, 0.0625f, 0.25f, 4.0f, 16.0f};
#define CHART_SIZE_COST       1 // index in rivals_octaves
#define CHART_SIZE_CANDIDATES 8

// A scene at a size: what all its rows share. shading_cost and probe_seconds are measured once in a run.
typedef struct chart_world {
    rivals_world world;
    camera_entry entry[CHART_ENTRIES];
    rivals_truth truth[CHART_ENTRIES];
    double probe_seconds, shade_seconds[RIVALS_COSTS];
    double dmfp; // the longest, over the radius of the sphere of the object's area
    int pixels;  // that see the object
} chart_world;

typedef struct chart_row {
    int candidates;
    double seconds, probes, shaded, variance, bias, bias_error, error[CHART_LEVELS]; // for each lookup, and relative
    double build_seconds, bytes;
} chart_row;

// What one entry adds to a row.
typedef struct chart_sums {
    double sum[3], squares[3], along, along_squares, error[CHART_LEVELS], seconds;
    rivals_work work;
} chart_sums;

static volatile sig_atomic_t interrupted = 0;
static void interrupt(int signal) {
    (void)signal;
    interrupted = 1;
}

static double clock_seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
static double cpu_seconds(void) { return clock_seconds(CLOCK_THREAD_CPUTIME_ID); }

// ---- Worlds

// CPU seconds of a probe with all that belongs to it, and of shading an exit, by octaves.
static void measure_costs(chart_world *w, int entries, int lookups) {
    double sink[3], many = 1e30, few = 1e30;
    rivals_work work = {0, 0};
    sss_plan plan = {0, 1, 0, 0, 0, 0};
    for (int round = 0; round < 3; round++) { // the least of three
        for (int k = 0; k < 2; k++) {
            double start = cpu_seconds();
            plan.candidates = k ? 64 : 8;
            for (int i = 0; i < lookups; i++)
                rivals_probe_lookup(&w->world, &plan, 0, w->entry[i % entries], (uint32_t)i, &work, sink);
            double each = (cpu_seconds() - start) / lookups;
            if (k && each < many) many = each;
            if (!k && each < few) few = each;
        }
    }
    w->probe_seconds = (many - few) / 56.0;
    for (int k = 0; k < RIVALS_COSTS; k++) {
        float total = 0.0f;
        w->shade_seconds[k] = 1e30;
        w->world.octaves = rivals_octaves[k];
        for (int round = 0; round < 3; round++) {
            double start = cpu_seconds();
            for (int i = 0; i < 4 * lookups; i++) {
                camera_entry e = w->entry[i % entries];
                tracer_point point = {e.position, e.normal, e.position, e.shape};
                total += rivals_shade(&w->world, point, (uint32_t)i).x;
            }
            double each = (cpu_seconds() - start) / (4 * lookups) + 1e-30 * (double)total;
            if (each < w->shade_seconds[k]) w->shade_seconds[k] = each;
        }
    }
    w->world.octaves = 0;
}

static void make_world(chart_world *w, const chart_settings *settings, int scene_index, float size) {
    memset(w, 0, sizeof *w);
    float area = 0.0f;
    scenes_optics optics = scenes_make(&w->world.s, scene_index);
    for (int i = 0; i < w->world.s.shape_count; i++) area += w->world.s.shape[i].area;
    for (int c = 0; c < 3; c++) {
        optics.dmfp[c] *= size;
        w->dmfp = fmax(w->dmfp, (double)(optics.dmfp[c] / scene_sqrt(area / (4.0f * SCENE_PI))));
    }
    sss_burley(&w->world.s.medium, optics.albedo, optics.dmfp);
    w->world.volume = walk_from_albedo(optics.albedo, optics.dmfp);
    camera_entries(&w->world.s, 11u, w->entry, settings->entries);
    for (int y = 0; y < CHART_HEIGHT; y++)
        for (int x = 0; x < CHART_WIDTH; x++)
            w->pixels += tracer_sees_object(&w->world.s, CHART_WIDTH, CHART_HEIGHT, x, y);
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < settings->entries; i++)
        rivals_brute_force(&w->world.s, w->entry[i], sss_hash(77u, (uint32_t)i), settings->sets, &w->truth[i]);
    measure_costs(w, settings->entries, settings->lookups);
}

// Root mean square, over the entries, of the reference's own relative error.
static double truth_error(const chart_world *w, const chart_settings *settings, int cost) {
    double sum = 0.0;
    for (int i = 0; i < settings->entries; i++) {
        const double *m = w->truth[i].mean[cost], *v = w->truth[i].variance[cost];
        sum += (v[0] + v[1] + v[2]) / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    }
    return sqrt(sum / settings->entries);
}

// ---- One row

static double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void measure_entry(chart_sums *sums, const rivals_world *w, const rivals_method *m, const sss_plan *plan,
                          camera_entry at, const double truth[3], uint32_t seed, int lookups) {
    double block[CHART_LEVELS][3] = {{0.0}}, power = dot3(truth, truth);
    int blocks[CHART_LEVELS] = {0};
    memset(sums, 0, sizeof *sums);
    double start = cpu_seconds();
    for (int i = 0; i < lookups; i++) {
        double value[3];
        rivals_lookup(w, m, plan, at, sss_hash(seed, (uint32_t)i), &sums->work, value);
        double along = dot3(value, truth) / power;
        sums->along += along;
        sums->along_squares += along * along;
        for (int c = 0; c < 3; c++) {
            sums->sum[c] += value[c];
            sums->squares[c] += value[c] * value[c];
            block[0][c] += value[c];
        }
        for (int l = 0, size = 1; l < CHART_LEVELS && (i + 1) % size == 0; l++, size *= 4) {
            for (int c = 0; c < 3; c++) {
                double error = block[l][c] / size - truth[c];
                sums->error[l] += error * error / power;
                if (l + 1 < CHART_LEVELS) block[l + 1][c] += block[l][c];
                block[l][c] = 0.0;
            }
            blocks[l]++;
        }
    }
    sums->seconds = cpu_seconds() - start;
    for (int l = 0; l < CHART_LEVELS; l++) sums->error[l] /= blocks[l] > 0 ? blocks[l] : 1;
}

// Adds an entry. All is relative to the reference, but what the walk has to say is relative to its own mean: its noise,
// and its distance from the reference, which is the error of the model.
static void add_entry(chart_row *row, const chart_sums *s, const rivals_method *m, const rivals_truth *truth, int cost,
                      int lookups, int entries) {
    const double *mean = truth->mean[cost], *noise = truth->variance[cost];
    double variance = 0.0, n = lookups, part = 1.0 / entries, own = 0.0, of_truth = 0.0;
    for (int c = 0; c < 3; c++) {
        variance += (s->squares[c] - s->sum[c] * s->sum[c] / n) / (n - 1.0);
        own += s->sum[c] / n * (s->sum[c] / n);
        of_truth += mean[c] * sqrt(noise[c]) / dot3(mean, mean); // as if the channels' noise were one
    }
    if (m->kind != RIVALS_WALK) own = dot3(mean, mean);
    row->variance += part * variance / own;
    row->bias += part * (s->along / n - 1.0);
    variance = (s->along_squares - s->along * s->along / n) / (n - 1.0);
    row->bias_error += part * part * (variance / n + of_truth * of_truth);
    for (int l = 0; l < CHART_LEVELS; l++) row->error[l] += part * s->error[l] * dot3(mean, mean) / own;
    row->seconds += part * s->seconds / n;
    row->probes += part * (double)s->work.probes / n;
    row->shaded += part * (double)s->work.shaded / n;
}

static chart_row measure_row(chart_world *w, const chart_settings *settings, const rivals_method *m, int setting,
                             int cost, int repeat) {
    static chart_sums sums[CHART_ENTRIES];
    chart_row row;
    uint32_t key = sss_hash((uint32_t)repeat, (uint32_t)(16 * setting + (int)(m - rivals_methods)));
    memset(&row, 0, sizeof row);
    w->world.octaves = rivals_octaves[cost];
    w->world.shading_cost = (float)(w->shade_seconds[cost] / w->probe_seconds);
    if (m->kind == RIVALS_CLOUD) {
        double start = cpu_seconds();
        if (!rivals_build_cloud(&w->world, setting, key)) fail(1, "out of memory");
        row.build_seconds = cpu_seconds() - start;
        row.bytes = (double)cloud_bytes(&w->world.cloud);
    }
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < settings->entries; i++) {
        sss_plan plan = rivals_plan(&w->world, m, setting);
        int lookups = m->kind == RIVALS_CLOUD ? 2 : settings->lookups; // the same each time
        measure_entry(&sums[i], &w->world, m, &plan, w->entry[i], w->truth[i].mean[cost], sss_hash(key, (uint32_t)i),
                      lookups);
    }
    for (int i = 0; i < settings->entries; i++) {
        add_entry(&row, &sums[i], m, &w->truth[i], cost, m->kind == RIVALS_CLOUD ? 2 : settings->lookups,
                  settings->entries);
    }
    row.bias_error = sqrt(row.bias_error);
    for (int l = 0; l < CHART_LEVELS; l++) row.error[l] = sqrt(row.error[m->kind == RIVALS_CLOUD ? 0 : l]);
    if (m->kind <= RIVALS_PLANNED) row.candidates = rivals_plan(&w->world, m, setting).candidates;
    cloud_free(&w->world.cloud);
    return row;
}

// ---- The file

static const char chart_columns[] =
    "scene,size,octaves,method,setting,repeat,candidates,seconds,probes,shaded,variance,bias,bias_error,"
    "error_1,error_4,error_16,error_64,error_256,error_1024,shading_over_probe,reference_error,exact,"
    "build_seconds,pixels,bytes,dmfp";

typedef struct chart_file {
    FILE *file;
    char (*key)[CHART_KEY];
    int keys, room;
} chart_file;

static const char *machine(void) {
    static char name[160] = "unknown processor";
    char line[256];
    FILE *f = fopen("/proc/cpuinfo", "r");
    while (f && fgets(line, sizeof line, f)) {
        if (strncmp(line, "model name", 10) != 0 || !strchr(line, ':')) continue;
        snprintf(name, sizeof name, "%.150s", strchr(line, ':') + 2);
        name[strcspn(name, "\n")] = '\0';
        break;
    }
    if (f) fclose(f);
    return name;
}

// Names this very program (FNV-1a of its file), so that rows of another header or compiler are not mixed in.
static unsigned program_hash(void) {
    uint32_t hash = 2166136261u;
    FILE *f = fopen("/proc/self/exe", "rb");
    for (int c; f && (c = fgetc(f)) != EOF;) hash = (hash ^ (uint32_t)c) * 16777619u;
    if (f) fclose(f);
    return hash;
}

static void remember(chart_file *f, const char *line) {
    size_t length = 0;
    for (int commas = 0; line[length] && commas < 6; length++) commas += line[length] == ',';
    if (f->keys == f->room) {
        f->room = 2 * f->room + 1024;
        f->key = realloc(f->key, (size_t)f->room * sizeof *f->key);
        if (!f->key) fail(1, "out of memory");
    }
    snprintf(f->key[f->keys++], CHART_KEY, "%.*s", (int)length, line);
}
static int is_known(const chart_file *f, const char *key) {
    for (int i = 0; i < f->keys; i++)
        if (strcmp(f->key[i], key) == 0) return 1;
    return 0;
}

// Reads the finished rows, cuts off one that was torn, and stays open for more. Rows of other settings, another
// program or another machine are refused.
static void open_file(chart_file *f, const char *path, const chart_settings *settings) {
    char line[1024], head[256];
    long whole = 0;
    int n = 0;
    memset(f, 0, sizeof *f);
    snprintf(head, sizeof head, "# chart %s, program %08x, CPU time on %s\n", settings->name, program_hash(),
             machine());
    f->file = fopen(path, "a+");
    if (!f->file) fail(2, "cannot write %s: %s", path, strerror(errno));
    rewind(f->file);
    for (; fgets(line, sizeof line, f->file) && strchr(line, '\n'); n++) {
        whole = ftell(f->file);
        if (n == 0 && strcmp(line, head) != 0)
            fail(
                2,
                "%s was measured by another program, with other settings or elsewhere: name another file, or remove it",
                path);
        if (n > 1) remember(f, line);
    }
    if (ftruncate(fileno(f->file), whole) != 0) fail(1, "cannot cut %s: %s", path, strerror(errno));
    fseek(f->file, 0, SEEK_END);
    if (n == 0) fputs(head, f->file);
    if (n <= 1) fprintf(f->file, "%s\n", chart_columns);
}

static void write_row(chart_file *f, const char *key, const chart_row *r, const chart_world *w,
                      const chart_settings *settings, int cost, int exact) {
    char line[1024];
    int n = snprintf(line, sizeof line, "%s%d,%.5g,%.5g,%.5g,%.6g,%.6g,%.6g,", key, r->candidates, r->seconds,
                     r->probes, r->shaded, r->variance, r->bias, r->bias_error);
    for (int l = 0; l < CHART_LEVELS; l++) n += snprintf(line + n, sizeof line - (size_t)n, "%.6g,", r->error[l]);
    snprintf(line + n, sizeof line - (size_t)n, "%.4g,%.4g,%d,%.4g,%d,%.0f,%.4g\n",
             w->shade_seconds[cost] / w->probe_seconds, truth_error(w, settings, cost), exact, r->build_seconds,
             w->pixels, r->bytes, w->dmfp);
    if (fputs(line, f->file) < 0 || fflush(f->file) != 0) fail(1, "cannot write a row: %s", strerror(errno));
    remember(f, line);
}

// ---- The race

typedef struct chart_rows {
    int done, total, skipped;
} chart_rows;

// Does this method with this setting run at this size and cost of shading?
static int is_wanted(const chart_settings *settings, const rivals_method *m, int size, int cost, int setting) {
    if (size >= settings->sizes || (m->kind == RIVALS_CLOUD && setting > settings->points)) return 0;
    if (size == 0) return 1;
    return cost == CHART_SIZE_COST && (m->most != 64 || setting == CHART_SIZE_CANDIDATES);
}

// All methods of one repeat of one world, interleaved; `dry` only counts the rows.
static void race(chart_file *f, chart_world *w, const chart_settings *settings, int scene_index, int size, int repeat,
                 chart_rows *rows, progress *p, int dry) {
    for (int k = 0; k < RIVALS_COSTS * RIVALS_METHODS; k++) {
        int cost = k / RIVALS_METHODS, step;
        const rivals_method *m = &rivals_methods[k % RIVALS_METHODS];
        for (int setting = m->least; setting <= m->most && !interrupted; setting *= step) {
            char key[CHART_KEY];
            step = m->kind == RIVALS_CLOUD ? 8 : 2;
            if (is_wanted(settings, m, size, cost, setting)) {
                snprintf(key, sizeof key, "%s,%g,%d,%s,%d,%d,", scenes_known[scene_index].name, (double)chart_sizes[size],
                         rivals_octaves[cost], m->name, setting, repeat);
                int known = is_known(f, key);
                rows->total += dry;
                rows->skipped += dry && known;
                if (!dry) {
                    if (!known) {
                        chart_row row = measure_row(w, settings, m, setting, cost, repeat);
                        write_row(f, key, &row, w, settings, cost, m->exact);
                        rows->done++;
                    }
                    p->label = m->name;
                    progress_show(p, rows->done - rows->skipped);
                }
            }
            if (setting == 0) break;
        }
    }
}

static const chart_settings *parse(int count, char **words, const char **path) {
    const chart_settings *settings = &chart_full;
    *path = "build/chart.csv";
    for (int i = 1; i < count; i++) {
        if (strcmp(words[i], "--help") == 0) {
            fputs(usage, stdout);
            exit(fflush(stdout) == 0 ? 0 : 1);
        } else if (strcmp(words[i], "--quick") == 0) {
            settings = &chart_quick;
        } else if (strcmp(words[i], "--csv") == 0) {
            if (++i == count) fail(2, "--csv wants a file name");
            *path = words[i];
        } else {
            fail(2, "unknown option '%s'; --help lists what there is", words[i]);
        }
    }
    return settings;
}

int main(int argc, char **argv) {
    static chart_world worlds[CHART_SCENES * CHART_SIZES];
    const char *path;
    const chart_settings *settings = parse(argc, argv, &path);
    chart_file f;
    chart_rows rows = {0, 0, 0};
    progress p;
    open_file(&f, path, settings);
    signal(SIGINT, interrupt);
    for (int i = 0; i < CHART_SCENES * CHART_SIZES * settings->repeats; i++)
        race(&f, NULL, settings, i % CHART_SCENES, i / CHART_SCENES % CHART_SIZES, i / (CHART_SCENES * CHART_SIZES), &rows,
             &p, 1);
    rows.done = rows.skipped;
    progress_begin(&p, "references", CHART_SCENES * settings->sizes);
    for (int i = 0; i < CHART_SCENES * settings->sizes && rows.done < rows.total && !interrupted; i++) {
        progress_show(&p, i);
        make_world(&worlds[i], settings, i % CHART_SCENES, chart_sizes[i / CHART_SCENES]);
    }
    progress_begin(&p, "rows", rows.total - rows.skipped);
    for (int repeat = 0; repeat < settings->repeats && !interrupted; repeat++)
        for (int i = 0; i < CHART_SCENES * CHART_SIZES && !interrupted; i++)
            race(&f, &worlds[i], settings, i % CHART_SCENES, i / CHART_SCENES, repeat, &rows, &p, 0);
    progress_end(&p);
    free(f.key);
    if (fclose(f.file) != 0) fail(1, "cannot write %s: %s", path, strerror(errno));
    if (interrupted) fprintf(stderr, "chart: interrupted; %d of %d rows are in %s\n", rows.done, rows.total, path);
    return interrupted ? 130 : 0;
}
