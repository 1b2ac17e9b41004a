// render.c - pictures of translucent things, and how far each is from the truth. See --help.
// SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "render"
#include "common/command.h"
#include "common/device.h"
#include "common/progress.h"
#include "common/files.h"
#include "common/tracer.h"

#define RENDER_COMPARE_SPP       12  // of the resampled panel
#define RENDER_COMPARE_REFERENCE 96  // samples a pixel in each half of the reference
#define RENDER_COMPARE_COST      1.0 // of one of these, over one of the resampled panel, roughly
// Of the processors: the reference stops early on a slow machine.
#define RENDER_COMPARE_SECONDS 70.0

static const char usage[] =
    "usage: render [options]\n"
    "Renders a scene with subsurface scattering; writes render.png when no output file is named.\n"
    "\n"
    "  --scene NAME       bear (default), rabbit, sphere, slab, corner, needles\n"
    "  --method NAME      resampled (default), shared (exits serve a tile of pixels), plain (one "
    "probe a "
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
    "  --model NAME       profile (default), volume (random walks), lambert; auto chooses for each "
    "lookup\n"
    "  --tolerance E      with --model auto: the relative error of the model that is good enough "
    "(0.1)\n"
    "  --candidates M     probes a lookup (8; as the plan advises where exits are shared), or "
    "walks (2)\n"
    "  --exits N          exits a lookup (1)\n"
    "  --techniques LIST  of disk,tangents,sphere,chord; default: the library's mix\n"
    "  --per-channel      every colour picks its own exit\n"
    "  --share N          shared: the side of the tiles in pixels, 0 to 8 (0: none; default: what "
    "the plan advises)\n"
    "  --independent      draw every candidate anew, not stratified\n"
    "  --light-aware      give the library a light hint at each candidate\n"
    "\n"
    "  --png FILE         tone-mapped picture\n"
    "  --pfm FILE         linear picture; behind its pixels stands which samples it holds\n"
    "  --stats FILE       numbers, as JSON\n"
    "  --against FILE     measure the error against this PFM of the same size\n"
    "  --compare          Lambert, plain, resampled, shared and a reference side by side in one "
    "PNG,\n"
    "                     in the same time but for the last, with the error of each\n"
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

// An option with a value; 0 when there is no option of this name. `value` is NULL when it is
// missing.
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

    if (!is_model(o, "auto") && o->settings.tolerance > 0.0f)
        fail(2, "--tolerance is of --model auto");
    if (is_model(o, "auto") && !(o->settings.tolerance > 0.0f)) o->settings.tolerance = 0.1f;
    if (strcmp(o->method, "shared") != 0) {
        if (o->share > 1 && !o->compare) fail(2, "--share is of --method shared");
        return;
    }
    if (!profile)
        fail(2, "--method shared wants --model profile or auto: the others share nothing");
    if (!tracer_may_share(o->settings, *plan))
        fail(2, "--method shared wants chord among the --techniques");
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
        fail(2, "--compare renders all methods and a reference: it takes no --method, --pfm, "
                "--against or "
                "--first-sample");
    }
    if (!o->method) o->method = o->share > 1 && !o->compare ? "shared" : "resampled";
    check_model(o);
    o->settings.method = strcmp(o->method, "plain") == 0       ? TRACER_PLAIN
                         : strcmp(o->method, "reference") == 0 ? TRACER_REFERENCE
                                                               : TRACER_RESAMPLED;
    if (!o->spp) o->spp = o->compare ? RENDER_COMPARE_SPP : 16;
    if ((uint64_t)o->first_sample + (uint64_t)o->spp > 4294967296u)
        fail(2, "samples are numbered up to 4294967295");
    if (!o->png && (o->compare || (!o->pfm && !o->stats)))
        o->png = o->compare ? "compare.png" : "render.png";
    if (o->resampling && o->settings.method != TRACER_RESAMPLED) {
        fprintf(stderr, "render: note: %s has no effect with --method %s\n", o->resampling,
                o->method);
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

// Adds samples first .. first + count - 1 of every pixel to `sum`. `cost` is the work of one sample
// of every pixel.
static void render_samples(const scene *s, const tracer_settings *settings, image *sum,
                           uint32_t first, int count, device_work *work, progress *p, double cost) {
    samples_progress mine;
    mine.p = p;
    mine.cost = cost * count;
    if (device_render(&devices, s, settings, sum, first, count, work, show_samples, &mine) !=
        SSS_CL_OK) {
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
    if (image_new(&i, settings->width, settings->height)) fail(1, "out of memory");
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

// The picture in passes of about a second, so that Ctrl-C need not wait long; then r->spp is what
// there is.
static void render_run(const scene *s, run *r, progress *p, const char *label, double cost) {
    double start = now();
    int done = 0, count = 1;
    p->label = label;
    r->picture = new_image(&r->settings);
    while (done == 0 || (done < r->spp && !interrupted())) {
        render_samples(s, &r->settings, &r->picture, r->first + (uint32_t)done, count, &r->work, p,
                       cost);
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
    fprintf(file,
            "{\"scene\": \"%s\", \"method\": \"%s\", \"device\": \"%s\", \"spp\": %d, \"seconds\": "
            "%.6g, ",
            scenes_known[o->scene].name, r->method, o->device, r->spp, r->seconds);
    fprintf(file, "\"probes\": %llu, \"shaded\": %llu, \"mean\": [%.9g, %.9g, %.9g]",
            r->work.probes, r->work.shaded, mean[0], mean[1], mean[2]);
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
    return output_end(&out, NULL);
}

static const char *write_png(const char *path, const image *picture) {
    image_bytes bytes;
    if (image_bytes_new(&bytes, picture->width, picture->height, 0))
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

static void note_samples(char *line, unsigned long long first, unsigned long long count,
                         unsigned seed, const char *scene_name, const char *profile) {
    snprintf(line, NOTE_LINE, "samples %llu %llu seed %u of %s %s\n", first, count, seed,
             scene_name, profile);
}

static void add_range(sample_ranges *ranges, const sample_range *range) {
    if (ranges->count == ranges->room) {
        ranges->room = 2 * ranges->room + 16;
        ranges->range =
            (sample_range *)realloc(ranges->range, (size_t)ranges->room * sizeof *ranges->range);
        if (!ranges->range) fail(1, "out of memory");
    }
    ranges->range[ranges->count++] = *range;
}

// Adds the ranges that a note tells of; returns how many samples a pixel they are, 0 for a note
// that is none.
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
        if (strcmp(last->of, next->of) != 0)
            fail(2, "%s shows %s, %s %s", last->file, last->of, next->file, next->of);
        if (last->seed == next->seed && next->first < last->first + last->count) {
            fail(2, "%s and %s share samples, from %llu of seed %llu", last->file, next->file,
                 next->first, next->seed);
        }
        if (last->seed == next->seed && next->first == last->first + last->count)
            last->count += next->count;
        else ranges->range[++kept] = *next;
    }
    ranges->count = kept + 1;
}

// ---- One picture

static image load_against(const options *o) {
    image against;
    const char *wrong = file_read_pfm(&against, o->against, NULL);
    if (wrong) fail(2, "cannot read %s: %s", o->against, wrong);
    if (against.width != o->settings.width || against.height != o->settings.height) {
        fail(2, "%s is %dx%d, the picture %dx%d", o->against, against.width, against.height,
             o->settings.width, o->settings.height);
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
    if (r.spp < o->spp)
        fprintf(stderr, "render: stopped after %d of %d samples a pixel\n", r.spp, o->spp);
    printf("%s, %s: %d spp in %.2f s, %llu probes, %llu points shaded", scenes_known[o->scene].name,
           o->method, r.spp, r.seconds, r.work.probes, r.work.shaded);
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

// Adds a file's picture to the sum as often as it has samples; returns their number. The first file
// sets the size.
static unsigned long long add_part(const char *file, image *size, double **sum,
                                   sample_ranges *ranges) {
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
        fail(2, "%s is %dx%d, those before %dx%d", file, part.width, part.height, size->width,
             size->height);
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
    if (!note || image_new(&whole, whole.width, whole.height)) fail(1, "out of memory");
    for (int i = 0; i < ranges.count; i++) {
        const sample_range *r = &ranges.range[i];
        end += snprintf(end, NOTE_LINE, "samples %llu %llu seed %llu of %s\n", r->first, r->count,
                        r->seed, r->of);
    }
    for (size_t i = 0; i < image_count(whole.width, whole.height); i++)
        whole.rgb[i] = (float)(sum[i] / (double)total);
    printf("%d files, %llu samples a pixel\n", o->merge_count, total);
    int failed = write_picture(o, &whole, note);
    free(note);
    free(sum);
    free(whole.rgb);
    free(ranges.range);
    return failed;
}

// ---- Five pictures in the same time

enum { LAMBERT, PLAIN, RESAMPLED, SHARED, REFERENCE, RUNS };

// Seconds: of the processors, which other programs do not lengthen, or of the clock where a device
// renders.
static double spent(void) {
    struct timespec t;
    clock_gettime(devices.count > 0 ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void compare_settings(const options *o, const scene *s, run *runs) {
    static const char *const method[RUNS] = {"lambert", "plain", "resampled, light hint",
                                             "shared, light hint", "reference"};
    for (int i = 0; i < RUNS; i++) {
        tracer_settings *settings = &runs[i].settings;
        runs[i].method = method[i];
        runs[i].relative_mse = -1.0;
        *settings = o->settings;
        settings->method = i == PLAIN       ? TRACER_PLAIN
                           : i == REFERENCE ? TRACER_REFERENCE
                                            : TRACER_RESAMPLED;
        settings->light_aware = i == RESAMPLED || i == SHARED;
        if (i == LAMBERT) settings->plan.techniques = SSS_LAMBERT;
    }
    // Each with the plan that is advised for it: without a footprint nothing is shared.
    sss_plan own = tracer_sharing(&s->medium, 0.0f, 1);
    tracer_settings *resampled = &runs[RESAMPLED].settings;
    if (!resampled->plan.candidates) resampled->plan.candidates = own.candidates;
    if (!resampled->plan.exits) resampled->plan.per_channel |= own.per_channel;
    set_sharing(o, s, &runs[SHARED].settings);
}

// The time of one sample, measured on other samples. The first one is not counted: a device may
// have to build its program for it.
static double sample_time(const scene *s, const run *r, progress *p) {
    device_work ignored = {0, 0};
    image scrap = new_image(&r->settings);
    tracer_settings settings = r->settings;
    settings.seed ^= 0x70696c6fu;
    render_samples(s, &settings, &scrap, 0, 1, &ignored, p, 0.0);
    double start = spent();
    render_samples(s, &settings, &scrap, 1, 2, &ignored, p, 0.0);
    free(scrap.rgb);
    return 0.5 * (spent() - start);
}

// Renders as many samples as take the time of the other run, or o->spp where there is none. What
// Ctrl-C leaves no time for has no samples.
static void compare_run(const options *o, const scene *s, run *r, const run *other, progress *p) {
    p->label = r->method;
    double each = interrupted() ? 0.0 : sample_time(s, r, p);
    if (interrupted()) {
        r->spp = 0;
        return;
    }
    r->spp = other ? (int)(other->seconds / each + 0.5) : o->spp;
    if (r->spp < 1) r->spp = 1;
    double start = spent();
    render_run(s, r, p, r->method, (double)o->spp / r->spp);
    r->seconds = spent() - start;
}

// The reference in two halves with independent noise, and the error of every run against them; see
// image_relative_mse(). Their mean is the picture.
static void compare_reference(const scene *s, run *runs, progress *p) {
    run *r = &runs[REFERENCE];
    image half[2];
    tracer_settings settings = r->settings;
    double start = spent();
    int spp = 0;
    p->label = "brute force reference";
    half[0] = new_image(&settings);
    half[1] = new_image(&settings);
    while (spp < RENDER_COMPARE_REFERENCE && !interrupted() &&
           (spp == 0 || spent() - start < RENDER_COMPARE_SECONDS)) {
        for (int h = 0; h < 2; h++) {
            settings.seed = r->settings.seed ^ (h == 0 ? 0x68616c66u : 0x48414c46u);
            render_samples(s, &settings, &half[h], (uint32_t)spp, 4, &r->work, p,
                           RENDER_COMPARE_COST);
        }
        spp += 4;
    }
    if (spp) {
        unsigned char *mask = object_mask(s, &settings);
        r->picture = new_image(&settings);
        scale_image(&half[0], 1.0f / (float)spp);
        scale_image(&half[1], 1.0f / (float)spp);
        for (size_t i = 0; i < image_count(settings.width, settings.height); i++)
            r->picture.rgb[i] = 0.5f * (half[0].rgb[i] + half[1].rgb[i]);
        for (int i = 0; i < REFERENCE; i++)
            runs[i].relative_mse = image_relative_mse(&runs[i].picture, &half[0], &half[1], mask);
        free(mask);
    }
    r->spp = 2 * spp;
    r->seconds = spent() - start;
    free(half[0].rgb);
    free(half[1].rgb);
}

static void compare_caption(image_bytes *sheet, const image_font *font, const run *runs, int i,
                            int left, int top) {
    static const char *const title[RUNS] = {"Lambert", "plain probes", "resampled", "shared",
                                            "reference"};
    static const int grey[3] = {20, 20, 90};
    const run *r = &runs[i];
    char line[3][80];
    snprintf(line[0], sizeof line[0], "%s", title[i]);
    if (!runs[REFERENCE].spp) snprintf(line[1], sizeof line[1], "stopped early");
    else if (i == REFERENCE) snprintf(line[1], sizeof line[1], "brute force");
    else
        snprintf(line[1], sizeof line[1], "error %.0f %%",
                 100.0 * sqrt(fmax(r->relative_mse, 0.0)));
    snprintf(line[2], sizeof line[2], "%.1f s, %d samples", r->seconds, r->spp);
    for (int k = 0; k < 3; k++)
        image_text(sheet, font, line[k], k == 0 ? 34.0f : 27.0f, left, top + 36 * k, grey[k]);
}

// A detail of a picture, each pixel as a square, and where it is from.
#define DETAIL_X     0.36 // the left upper corner, as a share of the picture
#define DETAIL_Y     0.30
#define DETAIL_ZOOM  4
#define DETAIL_SHARE 1.5 // of its width over its height
static void compare_detail(image_bytes *sheet, const image *picture, int left, int top,
                           int detail_top) {
    int wide = picture->width / DETAIL_ZOOM, high = (int)(wide / DETAIL_SHARE);
    int x0 = (int)(DETAIL_X * picture->width), y0 = (int)(DETAIL_Y * picture->height);
    for (int y = 0; y < high * DETAIL_ZOOM; y++) {
        for (int x = 0; x < wide * DETAIL_ZOOM; x++) {
            int from_x = x0 + x / DETAIL_ZOOM, from_y = y0 + y / DETAIL_ZOOM;
            if (from_x >= picture->width || from_y >= picture->height) continue;
            size_t from = image_count(sheet->width, top + from_y) + (size_t)(3 * (left + from_x));
            size_t to = image_count(sheet->width, detail_top + y) + (size_t)(3 * (left + x));
            memcpy(sheet->rgb + to, sheet->rgb + from, 3);
        }
    }
    for (int y = -2; y < high + 2; y++) {
        for (int x = -2; x < wide + 2; x++) {
            int edge = y < 0 || x < 0 || y >= high || x >= wide, at_x = x0 + x, at_y = y0 + y;
            if (!edge || at_x < 0 || at_y < 0 || at_x >= picture->width || at_y >= picture->height)
                continue;
            memset(sheet->rgb + image_count(sheet->width, top + at_y) + (size_t)(3 * (left + at_x)),
                   255, 3);
        }
    }
}

// Panels side by side, under each its detail and its caption. Returns why it could not be written,
// or NULL.
static const char *compare_sheet(const options *o, const run *runs, const image_font *font) {
    const int margin = 12, caption = 120, print = 72;
    int width = o->settings.width, height = o->settings.height;
    int panel = width > 290 ? width : 290,
        detail = (int)(width / DETAIL_ZOOM / DETAIL_SHARE) * DETAIL_ZOOM;
    int below = margin + height + margin + detail;
    image_bytes sheet;
    if (image_bytes_new(&sheet, RUNS * (panel + margin) + margin, below + caption + print, 250)) {
        fail(1, "out of memory");
    }
    for (int i = 0; i < RUNS; i++) {
        int left = margin + i * (panel + margin);
        if (runs[i].spp) {
            image_blit(&sheet, &runs[i].picture, 1.0f, left, margin);
            compare_detail(&sheet, &runs[i].picture, left, margin, margin + height + margin);
        }
        compare_caption(&sheet, font, runs, i, left, below + 38);
    }
    const int print_top = below + caption + 22;
    const sss_plan *plan = &runs[RESAMPLED].settings.plan;
    const sss_plan *shared = &runs[SHARED].settings.plan;
    char line[240];
    snprintf(line, sizeof line,
             "%s Plain: one probe, on one of three axes. Resampled: one of %d candidates%s, with a "
             "light hint.",
             interrupted()       ? "Stopped early."
             : devices.count > 0 ? "The first four take the same time."
                                 : "The first four take the same processor time.",
             plan->candidates ? plan->candidates : 8, plan->per_channel ? " for each colour" : "");
    image_text(&sheet, font, line, 22.0f, margin, print_top, 90);
    snprintf(line, sizeof line,
             "Shared: one of %d%s, and each exit serves a tile of %d x %d pixels. Error: root mean "
             "square, relative.",
             shared->candidates ? shared->candidates : 8,
             shared->per_channel ? " for each colour" : "", tracer_tile_side(runs[SHARED].settings),
             tracer_tile_side(runs[SHARED].settings));
    image_text(&sheet, font, line, 22.0f, margin, print_top + 28, 90);
    const char *wrong = file_write_png(o->png, &sheet);
    free(sheet.rgb);
    return wrong;
}

static int compare(const options *o) {
    image_font font;
    const char *wrong = image_font_open(&font);
    if (wrong) fail(1, "cannot read the font %s: %s", FONT_FILE, wrong);
    scene s;
    load_scene(&s, o->scene, o->profile, 1.0f);
    run runs[RUNS];
    memset(runs, 0, sizeof runs);
    compare_settings(o, &s, runs);
    progress p; // in samples of the resampled run
    progress_begin(&p, runs[RESAMPLED].method,
                   o->spp * 4.0 + 2.0 * RENDER_COMPARE_COST * RENDER_COMPARE_REFERENCE);
    compare_run(o, &s, &runs[RESAMPLED], NULL, &p);
    compare_run(o, &s, &runs[SHARED], &runs[RESAMPLED], &p);
    compare_run(o, &s, &runs[PLAIN], &runs[RESAMPLED], &p);
    compare_run(o, &s, &runs[LAMBERT], &runs[RESAMPLED], &p);
    if (!interrupted()) compare_reference(&s, runs, &p);
    progress_end(&p);
    if (interrupted()) fputs("render: stopped before the comparison was complete\n", stderr);
    for (int i = 0; i < RUNS; i++) {
        if (!runs[i].spp) continue;
        printf("%-24s %3d spp, %8llu points shaded, %5.2f s", runs[i].method, runs[i].spp,
               runs[i].work.shaded, runs[i].seconds);
        if (runs[REFERENCE].spp && i != REFERENCE)
            printf(", relative MSE %.4f", runs[i].relative_mse);
        printf("\n");
    }
    for (int i = RESAMPLED; i <= SHARED && runs[REFERENCE].spp; i++)
        printf("%s: a squared error %.2g times lower than plain\n", runs[i].method,
               runs[PLAIN].relative_mse / runs[i].relative_mse);
    int failed = tell_written(o->png, compare_sheet(o, runs, &font));
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
