// render.c - pictures of translucent things, and how far each is from the truth. See --help.
// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "render"
#include "common/command.h"
#include "common/device.h"
#include "common/progress.h"
#include "common/files.h"
#include "common/tracer.h"

#define RENDER_COMPARE_SPP       8     // of the resampled panels
#define RENDER_COMPARE_REFERENCE 24    // samples a pixel in each half of the reference
#define RENDER_COMPARE_SECONDS   40.0  // the reference stops early on a slow machine

static const char usage[] =
    "usage: render [options]\n"
    "Renders a scene with subsurface scattering; writes render.png when no output file is named.\n"
    "\n"
    "  --scene NAME       bear (default), sphere, slab, corner, needles\n"
    "  --method NAME      resampled (default), shared (exits serve a tile of pixels), plain (one probe a "
    "lookup,\n"
    "                     three axes), reference (brute force)\n"
    "  --profile NAME     burley (default), dipole, better-dipole\n"
    "  --spp N            samples a pixel (16)\n"
    "  --size WxH         picture size in pixels (360x400)\n"
    "  --seed S           0..4294967295 (1)\n"
    "  --first-sample K   samples K .. K + N - 1 of each pixel (0): parts of one picture, for "
    "--merge\n"
    "  --device NAME      cpu (default), opencl, opencl:NUMBER or opencl:all\n"
    "\n"
    "for --method resampled and shared:\n"
    "  --model NAME       profile (default), volume (random walks), lambert; auto chooses for each lookup\n"
    "  --tolerance E      with --model auto: the relative error of the model that is good enough (0.1)\n"
    "  --candidates M     probes a lookup (8; as the plan advises where exits are shared), or walks (2)\n"
    "  --exits N          exits a lookup (1)\n"
    "  --techniques LIST  of disk,tangents,sphere,chord; default: the library's mix\n"
    "  --per-channel      every colour picks its own exit\n"
    "  --share N          shared: the side of the tiles in pixels, 0 to 8 (0: none; default: what the plan advises)\n"
    "  --independent      draw every candidate anew, not stratified\n"
    "  --light-aware      tell the library a guess of the light at each candidate\n"
    "\n"
    "  --png FILE         tone-mapped picture\n"
    "  --pfm FILE         linear picture; behind its pixels stands which samples it holds\n"
    "  --stats FILE       numbers, as JSON\n"
    "  --against FILE     measure the error against this PFM of the same size\n"
    "  --compare          plain, resampled and light-aware side by side in one PNG, with the error "
    "of each\n"
    "  --merge FILE...    join PFM files of one picture, each by its number of samples, into --pfm "
    "or --png\n"
    "  --list-devices\n"
    "  --help\n"
    "\n"
    "Ctrl-C ends a picture or a comparison early: what is done by then is written, and the exit "
    "code is 130.\n";

typedef struct options {
    int scene;
    const char *method, *profile, *model;
    tracer_settings settings;
    int share; // the side of a tile; below 0: as the plan advises
    int spp, compare, merge_count;
    uint32_t first_sample;
    const char *png, *pfm, *stats, *against, *device;
    char **merge;           // files to join
    const char *resampling; // the first option that only means something to --method resampled
    const char *rendering;  // the first option that means nothing to --merge
} options;

static device_set devices; // they live as long as the program

// ---- Command line

static void list_devices(void) {
    sss_cl_devices known;
    char error[SSS_CL_MAX_ERROR];
    sss_cl_result result = sss_cl_list(&known, error);
    if (result != SSS_CL_OK) device_explain(error);
    if (result == SSS_CL_FAILED) fail((int)result, "%s", error);
    puts("cpu");
    for (int i = 0; i < known.count; i++) printf("opencl:%d  %s\n", i, known.device[i].name);
    if (result == SSS_CL_NO_DEVICE) puts(error);
    exit(fflush(stdout) == 0 ? 0 : 1);
}

static int parse_flag(options *o, const char *name) {
    if (strcmp(name, "--independent") == 0) {
        o->settings.plan.independent = 1;
        o->resampling = name;
    } else if (strcmp(name, "--per-channel") == 0) {
        o->settings.plan.per_channel = 1;
        o->resampling = name;
    } else if (strcmp(name, "--light-aware") == 0) {
        o->settings.light_aware = 1;
        o->resampling = name;
    } else if (strcmp(name, "--compare") == 0) {
        o->compare = 1;
    } else if (strcmp(name, "--list-devices") == 0) {
        list_devices();
    } else if (strcmp(name, "--help") == 0) {
        fputs(usage, stdout);
        exit(fflush(stdout) == 0 ? 0 : 1);
    } else {
        return 0;
    }
    o->rendering = name;
    return 1;
}

// What resampling alone takes; 0 when it is another option.
static int parse_resampling(options *o, const char *name, const char *value) {
    sss_plan *plan = &o->settings.plan;
    if (is_option("--candidates", name, value)) {
        plan->candidates = (int)parse_number(name, value, 1, SSS_MAX_CANDIDATES);
    } else if (is_option("--exits", name, value)) {
        plan->exits = (int)parse_number(name, value, 1, SSS_MAX_EXITS);
    } else if (is_option("--techniques", name, value)) {
        plan->techniques = parse_techniques(value);
    } else if (is_option("--model", name, value)) {
        o->model = parse_word(name, value, "auto lambert profile volume");
    } else if (is_option("--tolerance", name, value)) {
        o->settings.tolerance = (float)parse_real(name, value, 1e-3, 10.0);
    } else if (is_option("--share", name, value)) {
        o->share = (int)parse_number(name, value, 0, TRACER_MAX_TILE);
    } else {
        return 0;
    }
    o->resampling = o->rendering = name;
    return 1;
}

// What --merge takes too; 0 when it is another option.
static int parse_picture(options *o, const char *name, const char *value) {
    if (is_option("--png", name, value)) {
        o->png = value;
    } else if (is_option("--pfm", name, value)) {
        o->pfm = value;
    } else {
        return 0;
    }
    return 1;
}

// An option with a value; 0 when there is no option of this name. `value` is NULL when it is missing.
static int parse_value(options *o, const char *name, const char *value) {
    if (parse_picture(o, name, value)) return 1;
    if (parse_resampling(o, name, value)) return 1;
    if (is_option("--scene", name, value)) {
        o->scene = parse_scene(name, value);
    } else if (is_option("--method", name, value)) {
        o->method = parse_word(name, value, "resampled shared plain reference");
    } else if (is_option("--profile", name, value)) {
        o->profile = parse_word(name, value, "burley dipole better-dipole");
    } else if (is_option("--spp", name, value)) {
        o->spp = (int)parse_number(name, value, 1, 1000000);
    } else if (is_option("--size", name, value)) {
        parse_size(value, &o->settings.width, &o->settings.height);
    } else if (is_option("--seed", name, value)) {
        o->settings.seed = (uint32_t)parse_number(name, value, 0, 4294967295LL);
    } else if (is_option("--stats", name, value)) {
        o->stats = value;
    } else if (is_option("--against", name, value)) {
        o->against = value;
    } else if (is_option("--first-sample", name, value)) {
        o->first_sample = (uint32_t)parse_number(name, value, 0, 4294967295LL);
    } else if (is_option("--device", name, value)) {
        o->device = parse_device(name, value);
    } else {
        return 0;
    }
    o->rendering = name;
    return 1;
}

// Takes the files of --merge; returns their number.
static int parse_merge(options *o, int count, char **words) {
    int files = 0;
    while (files < count && strncmp(words[files], "--", 2) != 0) files++;
    if (files == 0) fail(2, "--merge wants PFM files");
    if (o->merge) fail(2, "--merge stands twice: name all files after one");
    o->merge = words;
    o->merge_count = files;
    return files;
}

static void check_merge(options *o) {
    if (o->rendering) fail(2, "--merge renders nothing: it takes no %s", o->rendering);
    if (!o->pfm && !o->png) fail(2, "--merge wants --pfm or --png, to know where the picture goes");
}

static int is_model(const options *o, const char *name) { return strcmp(o->model, name) == 0; }

// The model, and what goes with which.
static void check_model(options *o) {
    sss_plan *plan = &o->settings.plan;
    int profile = is_model(o, "profile") || is_model(o, "auto");
    if (plan->techniques && !is_model(o, "profile")) fail(2, "--techniques are of --model profile");
    if (plan->per_channel && plan->exits > 1) fail(2, "--per-channel is in place of --exits");
    if (is_model(o, "volume")) {
        plan->techniques = SSS_WALK;
        if (!plan->candidates) plan->candidates = 2;
    }
    if (is_model(o, "lambert")) plan->techniques = SSS_LAMBERT;

    if (!is_model(o, "auto") && o->settings.tolerance > 0.0f) fail(2, "--tolerance is of --model auto");
    if (is_model(o, "auto") && !(o->settings.tolerance > 0.0f)) o->settings.tolerance = 0.1f;
    if (strcmp(o->method, "shared") != 0) {
        if (o->share > 1 && !o->compare) fail(2, "--share is of --method shared");
        return;
    }
    if (!profile) fail(2, "--method shared wants --model profile or auto: the others share nothing");
    if (!tracer_may_share(o->settings, *plan)) fail(2, "--method shared wants chord among the --techniques");
}

// The tile, and what else the plan advises for it and the user leaves open.
static void set_sharing(const options *o, const scene *s, tracer_settings *settings) {
    sss_vec3 middle = s->shape[0].center;
    float footprint = tracer_footprint(s, *settings, middle);
    sss_plan advice = tracer_sharing(&s->medium, footprint, settings->light_aware);
    settings->plan.tile = o->share >= 0 ? o->share : advice.tile;
    if (!settings->plan.candidates) settings->plan.candidates = advice.candidates;
    if (!settings->plan.exits) settings->plan.per_channel |= advice.per_channel;
}

static void parse(options *o, int count, char **words) {
    memset(o, 0, sizeof *o);
    o->model = "profile";
    o->share = -1;
    o->scene = SCENES_BEAR;
    o->profile = "burley";
    o->device = "cpu";
    o->settings.width = 360;
    o->settings.height = 400;
    o->settings.seed = 1;
    for (int i = 1; i < count; i++) {
        if (parse_flag(o, words[i])) continue;
        if (strcmp(words[i], "--merge") == 0) {
            i += parse_merge(o, count - i - 1, words + i + 1);
            continue;
        }
        if (!parse_value(o, words[i], i + 1 < count ? words[i + 1] : NULL)) {
            fail(2, "unknown option '%s'; --help lists what there is", words[i]);
        }
        i++;
    }
    if (o->merge) {
        check_merge(o);
        return;
    }
    if (o->compare && (o->method || o->pfm || o->against || o->first_sample)) {
        fail(2, "--compare renders all methods and a reference: it takes no --method, --pfm, --against or "
                "--first-sample");
    }
    if (!o->method) o->method = o->share > 1 && !o->compare ? "shared" : "resampled";
    check_model(o);
    o->settings.method = strcmp(o->method, "plain") == 0       ? TRACER_PLAIN
                         : strcmp(o->method, "reference") == 0 ? TRACER_REFERENCE
                                                               : TRACER_RESAMPLED;
    if (!o->spp) o->spp = o->compare ? RENDER_COMPARE_SPP : 16;
    if ((uint64_t)o->first_sample + (uint64_t)o->spp > 4294967296u) fail(2, "samples are numbered up to 4294967295");
    if (!o->png && (o->compare || (!o->pfm && !o->stats))) o->png = o->compare ? "compare.png" : "render.png";
    if (o->resampling && o->settings.method != TRACER_RESAMPLED) {
        fprintf(stderr, "render: note: %s has no effect with --method %s\n", o->resampling, o->method);
    }
}

static void check_outputs(const options *o) {
    static const char *const names[3] = {"--png", "--pfm", "--stats"};
    const char *const paths[3] = {o->png, o->pfm, o->stats};
    for (int i = 0; i < 3; i++) {
        const char *wrong = paths[i] ? output_try(paths[i]) : NULL;
        if (wrong) fail(2, "cannot write %s: %s", paths[i], wrong);
        for (int k = 0; k < i; k++) {
            if (!paths[i] || !paths[k] || !output_same(paths[i], paths[k])) continue;
            fail(2, "%s and %s are the same file, %s", names[k], names[i], paths[i]);
        }
    }
}

// ---- Rendering

typedef struct samples_progress {
    progress *p;
    double cost;
} samples_progress;

static void show_samples(void *user, double share) {
    const samples_progress *mine = (const samples_progress *)user;
    progress_show(mine->p, mine->p->done + mine->cost * share);
}

// Adds samples first .. first + count - 1 of every pixel to `sum`. `cost` is the work of one sample of every
// pixel.
static void render_samples(const scene *s, const tracer_settings *settings, image *sum, uint32_t first, int count,
                           device_work *work, progress *p, double cost) {
    samples_progress mine;
    mine.p = p;
    mine.cost = cost * count;
    if (device_render(&devices, s, settings, sum, first, count, work, show_samples, &mine) != SSS_CL_OK) {
        fail(1, "%s", devices.error);
    }
    p->done += cost * count;
}

static void scale_image(image *i, float factor) {
    size_t count = image_count(i->width, i->height);
    for (size_t k = 0; k < count; k++) i->rgb[k] *= factor;
}

static image new_image(const tracer_settings *settings) {
    image i;
    if (!image_new(&i, settings->width, settings->height)) fail(1, "out of memory");
    return i;
}

// Which pixels' centre rays meet the object.
static unsigned char *object_mask(const scene *s, const tracer_settings *settings) {
    unsigned char *mask = (unsigned char *)malloc(image_count(settings->width, settings->height));
    if (!mask) fail(1, "out of memory");
    for (int y = 0; y < settings->height; y++) {
        for (int x = 0; x < settings->width; x++) {
            mask[(size_t)y * (size_t)settings->width + (size_t)x] =
                (unsigned char)tracer_sees_object(s, settings->width, settings->height, x, y);
        }
    }
    return mask;
}

// One rendering and what is known of it.
typedef struct run {
    const char *method;
    tracer_settings settings;
    uint32_t first; // sample
    int spp;
    image picture;
    device_work work;
    double seconds, relative_mse; // relative_mse below 0: not measured
} run;

// The picture in passes of about a second, so that Ctrl-C need not wait long; then r->spp is what there is.
static void render_run(const scene *s, run *r, progress *p, const char *label, double cost) {
    double start = now();
    int done = 0, count = 1;
    p->label = label;
    r->picture = new_image(&r->settings);
    while (done == 0 || (done < r->spp && !interrupted())) {
        render_samples(s, &r->settings, &r->picture, r->first + (uint32_t)done, count, &r->work, p, cost);
        done += count;
        double a_second = done / (now() - start + 1e-6);
        count = a_second < r->spp - done ? (int)a_second : r->spp - done;
        if (count < 1) count = 1;
    }
    r->spp = done;
    scale_image(&r->picture, 1.0f / (float)r->spp);
    r->seconds = now() - start;
}

static void write_run(FILE *file, const options *o, const run *r) {
    double mean[3];
    image_mean(&r->picture, mean);
    fprintf(file, "{\"scene\": \"%s\", \"method\": \"%s\", \"device\": \"%s\", \"spp\": %d, \"seconds\": %.6g, ",
            scenes_known[o->scene].name, r->method, o->device, r->spp, r->seconds);
    fprintf(file, "\"probes\": %llu, \"shaded\": %llu, \"mean\": [%.9g, %.9g, %.9g]", r->work.probes, r->work.shaded,
            mean[0], mean[1], mean[2]);
    if (r->relative_mse >= 0.0) fprintf(file, ", \"relative_mse\": %.9g", r->relative_mse);
    fputc('}', file);
}

// One run is a JSON object, several are an array of those that Ctrl-C has left time for.
static const char *write_stats(const options *o, const run *runs, int count) {
    output out;
    const char *wrong = output_begin(&out, o->stats);
    if (wrong) return wrong;
    if (count > 1) fputs("[", out.file);
    for (int i = 0, written = 0; i < count; i++) {
        if (!runs[i].spp) continue;
        if (written++) fputs(",\n ", out.file);
        write_run(out.file, o, &runs[i]);
    }
    fputs(count > 1 ? "]\n" : "\n", out.file);
    return output_end(&out, 1);
}

static const char *write_png(const char *path, const image *picture) {
    image_bytes bytes;
    if (!image_bytes_new(&bytes, picture->width, picture->height, 0))
        return "does not fit into memory";
    image_blit(&bytes, picture, 1.0f, 0, 0);
    const char *wrong = file_write_png(path, &bytes);
    free(bytes.rgb);
    return wrong;
}

// One output that fails leaves the others as they are. Returns whether it failed.
static int tell_written(const char *path, const char *wrong) {
    if (wrong) fprintf(stderr, "render: cannot write %s: %s\n", path, wrong);
    else printf("wrote %s\n", path);
    return wrong != NULL;
}

// ---- Which samples a picture holds: lines behind the pixels of a PFM, one for each unbroken range

#define NOTE_LINE 128

typedef struct sample_range {
    unsigned long long first, count, seed;
    char of[64]; // scene and profile
    const char *file;
} sample_range;

typedef struct sample_ranges {
    int count, room;
    sample_range *range;
} sample_ranges;

static void note_samples(char *line, unsigned long long first, unsigned long long count, unsigned seed,
                         const char *scene_name, const char *profile) {
    snprintf(line, NOTE_LINE, "samples %llu %llu seed %u of %s %s\n", first, count, seed, scene_name, profile);
}

static void add_range(sample_ranges *ranges, const sample_range *range) {
    if (ranges->count == ranges->room) {
        ranges->room = 2 * ranges->room + 16;
        ranges->range = (sample_range *)realloc(ranges->range, (size_t)ranges->room * sizeof *ranges->range);
        if (!ranges->range) fail(1, "out of memory");
    }
    ranges->range[ranges->count++] = *range;
}

// Adds the ranges that a note tells of; returns how many samples a pixel they are, 0 for a note that is none.
static unsigned long long read_note(sample_ranges *ranges, const char *note, const char *file) {
    unsigned long long total = 0, most = 4294967296u;
    while (*note) {
        sample_range r;
        int length = 0; // ten digits: a longer number ends the reading, and does not wrap around
        r.file = file;
        if (sscanf(note, "samples %10llu %10llu seed %10llu of %63[a-z -]%n", &r.first, &r.count,
                   &r.seed, r.of, &length) != 4 ||
            note[length] != '\n' || r.seed >= most || r.count < 1 || r.count > most ||
            r.first > most - r.count) {
            return 0;
        }
        add_range(ranges, &r);
        total += r.count;
        note += length + 1;
    }
    return total;
}

static int by_seed_and_first(const void *a, const void *b) {
    const sample_range *x = (const sample_range *)a, *y = (const sample_range *)b;
    if (x->seed != y->seed) return x->seed < y->seed ? -1 : 1;
    return x->first < y->first ? -1 : x->first > y->first;
}

// Sorts the ranges and joins neighbours. Samples must not be counted twice, nor scenes mixed.
static void join_ranges(sample_ranges *ranges) {
    int kept = 0;
    qsort(ranges->range, (size_t)ranges->count, sizeof *ranges->range, by_seed_and_first);
    for (int i = 1; i < ranges->count; i++) {
        sample_range *last = &ranges->range[kept], *next = &ranges->range[i];
        if (strcmp(last->of, next->of) != 0) fail(2, "%s shows %s, %s %s", last->file, last->of, next->file, next->of);
        if (last->seed == next->seed && next->first < last->first + last->count) {
            fail(2, "%s and %s share samples, from %llu of seed %llu", last->file, next->file,
                 next->first, next->seed);
        }
        if (last->seed == next->seed && next->first == last->first + last->count)
            last->count += next->count;
        else
            ranges->range[++kept] = *next;
    }
    ranges->count = kept + 1;
}

// ---- One picture

static image load_against(const options *o) {
    image against;
    const char *wrong = file_read_pfm(&against, o->against, NULL);
    if (wrong) fail(2, "cannot read %s: %s", o->against, wrong);
    if (against.width != o->settings.width || against.height != o->settings.height) {
        fail(2, "%s is %dx%d, the picture %dx%d", o->against, against.width, against.height, o->settings.width,
             o->settings.height);
    }
    return against;
}

// Returns whether some output failed.
static int write_picture(const options *o, const image *picture, const char *note) {
    int failed = 0;
    if (o->pfm) failed |= tell_written(o->pfm, file_write_pfm(o->pfm, picture, note));
    if (o->png) failed |= tell_written(o->png, write_png(o->png, picture));
    return failed;
}

static int write_outputs(const options *o, const run *r) {
    char note[NOTE_LINE];
    char model[32];
    snprintf(model, sizeof model, is_model(o, "profile") ? "%s" : "%s %s", o->profile, o->model);
    note_samples(note, r->first, (unsigned long long)r->spp, r->settings.seed,
                 scenes_known[o->scene].name, model);
    int failed = write_picture(o, &r->picture, note);
    if (o->stats) failed |= tell_written(o->stats, write_stats(o, r, 1));
    return failed;
}

// The exit code.
static int render_one(const options *o) {
    scene s;
    image against = {0, 0, NULL};
    run r;
    memset(&r, 0, sizeof r);
    r.method = o->method;
    r.settings = o->settings;
    r.first = o->first_sample;
    r.spp = o->spp;
    r.relative_mse = -1.0;
    load_scene(&s, o->scene, o->profile, 1.0f);
    if (strcmp(o->method, "shared") == 0) set_sharing(o, &s, &r.settings);
    if (o->against) against = load_against(o);
    progress p;
    progress_begin(&p, scenes_known[o->scene].name, r.spp);
    render_run(&s, &r, &p, scenes_known[o->scene].name, 1.0);
    progress_end(&p);
    if (r.spp < o->spp) fprintf(stderr, "render: stopped after %d of %d samples a pixel\n", r.spp, o->spp);
    printf("%s, %s: %d spp in %.2f s, %llu probes, %llu points shaded", scenes_known[o->scene].name, o->method, r.spp, r.seconds,
           r.work.probes, r.work.shaded);
    if (o->against) {
        unsigned char *mask = object_mask(&s, &r.settings);
        r.relative_mse = image_relative_mse(&r.picture, &against, &against, mask);
        if (r.relative_mse >= 0.0) printf(", relative MSE %.4g", r.relative_mse);
        else printf(", relative MSE not defined: %s is black there", o->against);
        free(mask);
        free(against.rgb);
    }
    printf("\n");
    int failed = write_outputs(o, &r);
    free(r.picture.rgb);
    return failed ? 1 : r.spp < o->spp ? 130 : 0;
}

// ---- Parts of a picture, joined

// Adds a file's picture to the sum as often as it has samples; returns their number. The first file sets the size.
static unsigned long long add_part(const char *file, image *size, double **sum, sample_ranges *ranges) {
    image part;
    char *note = NULL;
    const char *wrong = file_read_pfm(&part, file, &note);
    if (wrong) fail(2, "cannot read %s: %s", file, wrong);
    size_t numbers = image_count(part.width, part.height);
    if (!*sum) {
        size->width = part.width;
        size->height = part.height;
        *sum = (double *)calloc(numbers, sizeof **sum);
        if (!*sum) fail(1, "out of memory");
    }
    if (part.width != size->width || part.height != size->height) {
        fail(2, "%s is %dx%d, those before %dx%d", file, part.width, part.height, size->width, size->height);
    }
    unsigned long long count = read_note(ranges, note, file);
    if (!count) fail(2, "%s does not say which samples it holds", file);
    for (size_t i = 0; i < numbers; i++) (*sum)[i] += (double)count * (double)part.rgb[i];
    free(part.rgb);
    free(note);
    return count;
}

// The exit code, like those of the other tasks.
static int merge(const options *o) {
    image whole = {0, 0, NULL};
    sample_ranges ranges = {0, 0, NULL};
    double *sum = NULL;
    unsigned long long total = 0;
    for (int i = 0; i < o->merge_count; i++) total += add_part(o->merge[i], &whole, &sum, &ranges);
    join_ranges(&ranges);
    char *note = (char *)calloc((size_t)ranges.count, NOTE_LINE), *end = note;
    if (!note || !image_new(&whole, whole.width, whole.height)) fail(1, "out of memory");
    for (int i = 0; i < ranges.count; i++) {
        const sample_range *r = &ranges.range[i];
        end += snprintf(end, NOTE_LINE, "samples %llu %llu seed %llu of %s\n", r->first, r->count,
                        r->seed, r->of);
    }
    for (size_t i = 0; i < image_count(whole.width, whole.height); i++) whole.rgb[i] = (float)(sum[i] / (double)total);
    printf("%d files, %llu samples a pixel\n", o->merge_count, total);
    int failed = write_picture(o, &whole, note);
    free(note);
    free(sum);
    free(whole.rgb);
    free(ranges.range);
    return failed;
}

// ---- Three pictures at the same number of shaded points, and one in the time of the third

enum { PLAIN, RESAMPLED, AWARE, SHARED, RUNS };

// A plain probe that misses shades nothing, so plain gets more samples: as many as shade what the resampled
// picture did.
static int plain_spp(const scene *s, const run *plain, const run *resampled, progress *p) {
    device_work pilot = {0, 0};
    image scrap = new_image(&plain->settings);
    tracer_settings settings = plain->settings;
    settings.seed ^= 0x70696c6fu;
    render_samples(s, &settings, &scrap, 0, 1, &pilot, p, 0.0);
    free(scrap.rgb);
    if (!pilot.shaded) return resampled->spp;
    int spp = (int)((double)resampled->work.shaded / (double)pilot.shaded + 0.5);
    return spp < 1 ? 1 : spp;
}

// As many samples as take the time of the other's.
static int shared_spp(const scene *s, const run *shared, const run *other, progress *p) {
    device_work pilot = {0, 0};
    image scrap = new_image(&shared->settings);
    tracer_settings settings = shared->settings;
    settings.seed ^= 0x70696c6fu;
    double start = now();
    render_samples(s, &settings, &scrap, 0, 2, &pilot, p, 0.0);
    double each = 0.5 * (now() - start);
    free(scrap.rgb);
    int spp = (int)(other->seconds / each + 0.5);
    return spp < 1 ? 1 : spp;
}

// Two halves of a reference with independent noise, and the error of every run against them; see
// image_relative_mse(). Returns the samples a pixel in each half.
static int measure_runs(const scene *s, run *runs, progress *p, double deadline) {
    image half[2];
    tracer_settings settings = runs[PLAIN].settings;
    device_work ignored = {0, 0};
    int spp = 0;
    settings.method = TRACER_REFERENCE;
    p->label = "brute force reference";
    half[0] = new_image(&settings);
    half[1] = new_image(&settings);
    while (spp < RENDER_COMPARE_REFERENCE && !interrupted() && (spp == 0 || now() < deadline)) {
        for (int h = 0; h < 2; h++) {
            settings.seed = runs[PLAIN].settings.seed ^ (h == 0 ? 0x68616c66u : 0x48414c46u);
            render_samples(s, &settings, &half[h], (uint32_t)spp, 4, &ignored, p, 2.5);
        }
        spp += 4;
    }
    scale_image(&half[0], 1.0f / (float)(spp ? spp : 1));
    scale_image(&half[1], 1.0f / (float)(spp ? spp : 1));
    unsigned char *mask = object_mask(s, &settings);
    for (int i = 0; i < RUNS && spp; i++) {
        runs[i].relative_mse = image_relative_mse(&runs[i].picture, &half[0], &half[1], mask);
    }
    free(mask);
    free(half[0].rgb);
    free(half[1].rgb);
    return spp;
}

// What Ctrl-C leaves no time for has no samples.
static void compare_run(const scene *s, run *r, int spp, progress *p, const char *label,
                        double cost) {
    r->spp = spp;
    if (interrupted()) r->spp = 0;
    else render_run(s, r, p, label, cost);
}

static void compare_caption(image_bytes *sheet, const image_font *font, const run *runs, int i,
                            int measured, int left, int top) {
    static const char *const title[RUNS] = {"plain", "resampled", "resampled + light",
                                            "shared + light"};
    char line[160];
    const run *r = &runs[i];
    image_text(sheet, font, title[i], 24.0f, left, top + 22, 20);
    if (!measured) {
        snprintf(line, sizeof line, "stopped before %s",
                 r->spp ? "its error was measured" : "it was rendered");
    } else if (i == PLAIN) {
        snprintf(line, sizeof line, "relative MSE %.4f", r->relative_mse);
    } else {
        snprintf(line, sizeof line, "relative MSE %.4f, %.1f times less", r->relative_mse,
                 runs[PLAIN].relative_mse / r->relative_mse);
    }
    image_text(sheet, font, line, 18.0f, left, top + 46, 20);
    snprintf(line, sizeof line, "%.1f s, %d spp, %.2f million points shaded", r->seconds, r->spp,
             1e-6 * (double)r->work.shaded);
    image_text(sheet, font, line, 15.0f, left, top + 68, 80);
}

// Panels side by side, under each its caption; small print below. Returns why it could not be written, or NULL.
static const char *compare_sheet(const options *o, const run *runs, const image_font *font,
                                 int reference_spp) {
    const int margin = 16, caption = 84, print = 44;
    int width = o->settings.width, height = o->settings.height, panel = width > 330 ? width : 330;
    image_bytes sheet;
    if (!image_bytes_new(&sheet, RUNS * panel + (RUNS + 1) * margin, height + margin + caption + print, 250)) {
        fail(1, "out of memory");
    }
    for (int i = 0; i < RUNS; i++) {
        int left = margin + i * (panel + margin);
        if (runs[i].spp) image_blit(&sheet, &runs[i].picture, 1.0f, left, margin);
        compare_caption(&sheet, font, runs, i, reference_spp > 0, left, height + margin + 6);
    }
    char line[400];
    const sss_plan *shared = &runs[SHARED].settings.plan;
    snprintf(line, sizeof line,
             "Scene %s, profile %s. Plain traces one probe a lookup, resampling %d, sharing %d and its "
             "exits serve %d x %d pixels. %s",
             scenes_known[o->scene].name, o->profile,
             o->settings.plan.candidates ? o->settings.plan.candidates : 8,
             shared->candidates ? shared->candidates : 8, shared->tile, shared->tile,
             interrupted() ? "Stopped early: the panels may shade different numbers of points."
                           : "The first three shade as many points as whole samples a pixel (spp) "
                              "allow, the last had the time of the third.");
    image_text(&sheet, font, line, 13.0f, margin, height + margin + caption + 18, 110);
    snprintf(line, sizeof line,
             "Relative MSE: sum (a - r1)(a - r2) / sum r1 r2 over the object's pixels, r1 and r2 two "
             "independent brute "
             "force references of %d spp; their own noise cancels.",
             reference_spp);
    if (reference_spp)
        image_text(&sheet, font, line, 13.0f, margin, height + margin + caption + 35, 110);
    const char *wrong = file_write_png(o->png, &sheet);
    free(sheet.rgb);
    return wrong;
}

static int compare(const options *o) {
    static const char *const method[RUNS] = {"plain", "resampled", "resampled, light-aware", "shared, light-aware"};
    double start = now();
    image_font font;
    const char *wrong = image_font_open(&font);
    if (wrong) fail(1, "cannot read the font %s: %s", FONT_FILE, wrong);
    scene s;
    load_scene(&s, o->scene, o->profile, 1.0f);
    run runs[RUNS];
    memset(runs, 0, sizeof runs);
    for (int i = 0; i < RUNS; i++) {
        runs[i].method = method[i];
        runs[i].settings = o->settings;
        runs[i].settings.method = i == PLAIN ? TRACER_PLAIN : TRACER_RESAMPLED;
        runs[i].settings.light_aware = i == AWARE || i == SHARED;
        runs[i].relative_mse = -1.0;
    }
    set_sharing(o, &s, &runs[SHARED].settings);
    progress p; // in rough units: a plain sample costs 1, a resampled one 3, one of the reference 2.5
    progress_begin(&p, "plain", o->spp * (3.0 + 3.0 + 3.0 + 1.4) + 2 * 2.5 * RENDER_COMPARE_REFERENCE);
    compare_run(&s, &runs[RESAMPLED], o->spp, &p, "resampled", 3.0);
    compare_run(&s, &runs[AWARE], o->spp, &p, "resampled + light", 3.0);
    p.label = "shared + light";
    int spp = interrupted() ? 0 : shared_spp(&s, &runs[SHARED], &runs[AWARE], &p);
    compare_run(&s, &runs[SHARED], spp, &p, "shared + light", 3.0);
    spp = interrupted() ? 0 : plain_spp(&s, &runs[PLAIN], &runs[RESAMPLED], &p);
    compare_run(&s, &runs[PLAIN], spp, &p, "plain", 1.0);
    int reference_spp =
        interrupted() ? 0 : measure_runs(&s, runs, &p, start + RENDER_COMPARE_SECONDS);
    progress_end(&p);
    if (interrupted()) fputs("render: stopped before the comparison was complete\n", stderr);
    for (int i = 0; i < RUNS; i++) {
        if (!runs[i].spp) continue;
        printf("%-24s %3d spp, %8llu points shaded, %5.2f s", runs[i].method, runs[i].spp,
               runs[i].work.shaded, runs[i].seconds);
        if (reference_spp) printf(", relative MSE %.4f", runs[i].relative_mse);
        printf("\n");
    }
    int failed = tell_written(o->png, compare_sheet(o, runs, &font, reference_spp));
    if (o->stats) failed |= tell_written(o->stats, write_stats(o, runs, RUNS));
    for (int i = 0; i < RUNS; i++) free(runs[i].picture.rgb);
    free(font.file);
    return failed ? 1 : interrupted() ? 130 : 0;
}

static void open_devices(const options *o) {
    sss_cl_result result = device_open(&devices, o->device);
    if (result != SSS_CL_OK) {
        device_close(&devices);
        fail((int)result, "%s", devices.error);
    }
    if (device_note(&devices)) fprintf(stderr, "render: note: %s\n", device_note(&devices));
}

int main(int count, char **words) {
    options o;
    int code = 0;
    parse(&o, count, words);
    check_outputs(&o);
    if (o.merge) return merge(&o);
    interrupt_await();
    open_devices(&o);
    code = o.compare ? compare(&o) : render_one(&o);
    device_close(&devices);
    return code;
}
