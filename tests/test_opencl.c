// test_opencl.c - an OpenCL device computes the bits of the CPU: layouts, mathematics, lookups,
// pictures. With --long the mathematics is tried over all floats; --small is for slow simulators of
// a device. Without a device every test is skipped and counted. SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "sss_test.h"
#include "demos/common/entries.h"
#include "demos/common/scenes.h"
#include "demos/common/tracer_cl.h"
#include "layout.h"
#include "layout_source.h"

#include <errno.h>
#include <sys/stat.h>
#include <time.h>

// Where a device is not IEEE-correct: OpenCL 1.2 allows division 2.5 ulp and sqrt 3 ulp, and of the
// up to twenty roundings between a hit and a weight most pass on with a factor near 1.
#define LOOSE_ULP   256
#define LOOSE_FLIPS 1e-3 // share of lookups that may pick another exit there
#define POISON      0x7fc0deadu

static int exhaustive = 0, small = 0;
static tracer_cl tracer;
static sss_cl *const device = &tracer.cl;
static sss_cl_result opened;

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// ---- One text for both sides: SHARED compiles it here and keeps it as a string for the device.

#define SHARED(name, ...)                                                                          \
    __VA_ARGS__                                                                                    \
    static const char name[] = #__VA_ARGS__;

// `which` names a function; arguments outside its domain become 1. (normalize and frame take a
// vector made of one.)
// clang-format off
SHARED(math_text,
static inline float math_domain(float x, float low, float high) {
    return x >= low && x <= high ? x : 1.0f;
}
static inline sss_vec3 math_vector(float x) {
    float y = sssi_unit(sss_hash(sssi_bits(x), 1u)) - 0.5f;
    float z = sssi_unit(sss_hash(sssi_bits(x), 2u)) - 0.5f;
    return sssi_vec3(x, y, z);
}
static inline float math_of(int which, float x) {
    float u = math_domain(x, 5.9604645e-8f, 0.99999994f);
    float a = 0.0f;
    float b = 0.0f;
    sss_vec3 v = math_vector(x);
    sss_vec3 w;
    sss_vec3 q;
    switch (which) {
    case 0: return sssi_exp(math_domain(x, -3e38f, 80.0f));
    case 1: return sssi_expm1(math_domain(x, -3e38f, 80.0f));
    case 2: return sssi_mean_exp(math_domain(x, 0.0f, 3e38f));
    case 3: return sssi_log(math_domain(x, 1.17549435e-38f, 3.402823466e38f));
    case 4: sssi_sincos_turn(math_domain(x, 0.0f, 1.0f), &a, &b); return a;
    case 5: sssi_sincos_turn(math_domain(x, 0.0f, 1.0f), &a, &b); return b;
    case 6: return SSSI_SQRT(math_domain(x, 0.0f, 3.402823466e38f));
    case 7: return 1.0f / x;
    case 8: return sssi_burley_radius(1.7f, u);
    case 9: return sssi_burley_chord(1.7f, sssi_unit(sss_hash(sssi_bits(x), 8u)), u);
    case 10: return sssi_pole_radius(0.3f, u);
    case 11: return sssi_pole_chord(0.3f, u);
    case 12: return sssi_burley_unit(0.3f, math_domain(x, 0.0f, 1e30f));
    case 13: return sssi_normalize(&v) ? v.x : 2.0f;
    case 14: if (!sssi_normalize(&v)) return 2.0f; sssi_frame(v, &w, &q); return w.x + q.y;
    case 15: return sssi_unit(sss_hash(sssi_bits(x), 7u));
    }
    return 0.0f;
}
)
enum { MATH_FUNCTIONS = 16 };
static const char *const math_name[MATH_FUNCTIONS] = {
    "exp", "expm1", "(1 - e^-t) / t", "log", "sin", "cos", "sqrt", "1 / x",
    "Burley's radius", "Burley's chord",
    "a pole's radius", "a pole's chord", "Burley's profile", "normalize", "frame", "hash"};

// A whole lookup, of a sample, with all that an exit tells, and the shares of one exit by halves:
// the sum of the entries' densities in order, then each entry's weights.
SHARED(whole_text,
static inline int whole_lookup(const SCENE_SPACE scene *s, sss_plan plan, int aware,
                               uint32_t sample, sss_vec3 position, sss_vec3 normal, uint32_t seed,
                               sss_exit *exits) {
    sss_medium medium = s->medium;
    sss_resampler resampler;
    sss_begin_sample(&resampler, &medium, &plan, position, normal, seed, sample);
    sss_probe probe;
    scene_hits hits;
    while (sss_next_probe(&resampler, &probe)) {
        scene_segment_hits(s, probe.origin, probe.direction, probe.length, &hits);
        for (int i = 0; i < hits.count; ++i) {
            sss_vec3 at = scene_along(probe.origin, probe.direction, hits.hit[i].t);
            sss_vec3 facing = scene_normal(&s->shape[hits.hit[i].shape], at);
            sss_add_hit(&resampler, at, facing, aware ? tracer_light_guess(s, at, facing) : 1.0f);
        }
    }
    return sss_finish(&resampler, exits);
}
static inline float share_sum(sss_medium m, const SCENE_SPACE sss_vec3 *group, int count,
                              sss_exit exit) {
    float sum = 0.0f;
    for (int i = 0; i < count; ++i) sum += sss_share_density(&m, group[i], &exit);
    return sum;
}
static inline sss_vec3 share_of(sss_medium m, sss_vec3 entry, sss_exit exit, float sum) {
    float weight[3];
    sss_share_weight(&m, entry, &exit, sum, weight);
    return scene_vec(weight[0], weight[1], weight[2]);
}
)
// clang-format on

static const char kernels_text[] =
    "__kernel void whole_lookups(uint entries, uint room, __global const sss_vec3 *positions,\n"
    "        __global const sss_vec3 *normals, __global const uint *seeds, __global int *counts,\n"
    "        __global sss_exit *exits, __global const scene *s, sss_plan plan, int aware, uint "
    "sample) {\n"
    "    uint i = (uint)get_global_id(0);\n"
    "    sss_exit mine[SSS_MAX_EXITS];\n"
    "    if (i >= entries) return;\n"
    "    counts[i] = whole_lookup(s, plan, aware, sample, positions[i], normals[i], seeds[i], "
    "mine);\n"
    "    for (int k = 0; k < counts[i]; ++k) exits[i * room + (uint)k] = mine[k];\n"
    "}\n"
    "__kernel void shares(uint exits, int count, __global const scene *s, __global const sss_vec3 "
    "*group,\n"
    "        __global const sss_exit *exit, __global sss_vec3 *weight) {\n"
    "    uint i = (uint)get_global_id(0);\n"
    "    if (i >= exits) return;\n"
    "    float sum = share_sum(s->medium, group, count, exit[i]);\n"
    "    for (int j = 0; j < count; ++j) weight[i * (uint)count + (uint)j] =\n"
    "        share_of(s->medium, group[j], exit[i], sum);\n"
    "}\n";

static const char math_kernel_text[] =
    "__kernel void math(int which, uint first, uint step, __global uint *out) {\n"
    "    uint i = (uint)get_global_id(0);\n"
    "    out[i] = sssi_bits(math_of(which, sssi_float(first + i * step)));\n"
    "}\n";

// ---- The device

// Nothing is written into a home directory: kernels are cached below build/.
static void place_cache(void) {
    const char *build = getenv("BUILD");
    char path[512];
    snprintf(path, sizeof path, "%s/pocl", build ? build : "build");
    if (mkdir(path, 0777) == 0 || errno == EEXIST) setenv("POCL_CACHE_DIR", path, 0);
}

static int open_device(void **state) {
    size_t size = sizeof math_text + sizeof math_kernel_text + sizeof whole_text +
                  sizeof kernels_text + sizeof layout_source + 5u;
    double start = seconds();
    (void)state;
    place_cache();
    char *text = (char *)malloc(size);
    if (!text) return -1;
    snprintf(text, size, "%s\n%s\n%s\n%s\n%s", math_text, math_kernel_text, whole_text,
             kernels_text, (const char *)layout_source);
    opened = tracer_cl_open(&tracer, "opencl", text);
    free(text);
    if (opened == SSS_CL_OK)
        print_message("    %s: %s, opened in %.2f s\n", device->device.name,
                      device->exact ? "IEEE-correct division and square root" : "NOT IEEE-correct",
                      seconds() - start);
    else print_message("    %s%s\n", device->log ? device->log : "", device->error);
    return 0;
}

static int close_device(void **state) {
    (void)state;
    tracer_cl_close(&tracer);
    return 0;
}

static void need_device(void) {
    if (opened == SSS_CL_NO_DEVICE) skip();
    if (opened != SSS_CL_OK) fail_msg("%s", device->error);
}

static void check_call(sss_cl_result result) {
    if (result != SSS_CL_OK) fail_msg("%s", device->error);
}

static void check_code(cl_int code, const char *call) {
    if (!sss_cl_check(device, code, call)) fail_msg("%s", device->error);
}

// A buffer full of poison.
static cl_mem poisoned(size_t words) {
    uint32_t *poison = (uint32_t *)malloc(words * sizeof *poison);
    assert_non_null(poison);
    for (size_t i = 0; i < words; ++i) poison[i] = POISON;
    cl_int code;
    cl_mem buffer = clCreateBuffer(device->context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                                   words * sizeof *poison, poison, &code);
    check_code(code, "clCreateBuffer");
    free(poison);
    return buffer;
}

static void read_words(cl_mem buffer, size_t words, uint32_t *to) {
    check_code(clEnqueueReadBuffer(device->queue, buffer, CL_TRUE, 0, words * sizeof *to, to, 0,
                                   NULL, NULL),
               "clEnqueueReadBuffer");
}

// ---- Comparison of bits

typedef struct tally {
    unsigned long compared, different, far; // far: more than LOOSE_ULP apart
    double worst;                           // ulps
} tally;

static int is_nan(uint32_t bits) { return (bits & 0x7fffffffu) > 0x7f800000u; }

// Floats in order as integers, so that neighbours differ by 1.
static int64_t rank_of(uint32_t bits) {
    return bits & 0x80000000u ? -(int64_t)(bits & 0x7fffffffu) : (int64_t)bits;
}

// Equal, or two NaN.
static int compare_bits(tally *t, uint32_t cpu, uint32_t cl) {
    ++t->compared;
    if (cpu == cl || (is_nan(cpu) && is_nan(cl))) return 1;
    ++t->different;
    if (is_nan(cpu) || is_nan(cl)) t->worst = (double)INFINITY;
    else t->worst = fmax(t->worst, fabs((double)(rank_of(cpu) - rank_of(cl))));
    if (!(fabs((double)(rank_of(cpu) - rank_of(cl))) <= LOOSE_ULP)) ++t->far;
    return 0;
}

// ---- Layouts

static void test_layouts(void **state) {
    enum { ROOM = 256 };
#define SIZE(type)         host[count++] = (uint32_t)sizeof(type);
#define FIELD(type, field) host[count++] = (uint32_t)offsetof(type, field);
    uint32_t host[ROOM];
    size_t count = 0, local = device->local;
    (void)state;
    need_device();
    LAYOUT(SIZE, FIELD)
    assert_true(count < ROOM);
    cl_int code;
    cl_kernel kernel = clCreateKernel(device->program, "layout", &code);
    check_code(code, "clCreateKernel");
    cl_mem out = poisoned(ROOM);
    check_code(clSetKernelArg(kernel, 0, sizeof out, &out), "clSetKernelArg");
    device->local = 1;
    check_call(sss_cl_run(device, kernel, 1));
    device->local = local;
    uint32_t cl[ROOM];
    read_words(out, ROOM, cl);
    for (size_t i = 0; i < count; ++i)
        if (host[i] != cl[i])
            fail_msg("number %lu of layout.h: %u here, %u there", (unsigned long)i, host[i], cl[i]);
    assert_int_equal(cl[count], POISON);
    print_message("    %lu sizes and offsets\n", (unsigned long)count);
    clReleaseMemObject(out);
    clReleaseKernel(kernel);
#undef SIZE
#undef FIELD
}

// ---- What goes wrong

// The log of the compiler and one line that names the call.
static void test_build_failure(void **state) {
    (void)state;
    need_device();
    tracer_cl broken;
    assert_int_equal(
        tracer_cl_open(&broken, "opencl", "__kernel void broken(void) { no_such_function(); }\n"),
        SSS_CL_FAILED);
    print_message("    %s\n", broken.cl.error);
    assert_non_null(strstr(broken.cl.error, "clBuildProgram: CL_BUILD_PROGRAM_FAILURE"));
    assert_null(strchr(broken.cl.error, '\n'));
    assert_non_null(strstr(broken.cl.log, "no_such_function"));
    tracer_cl_close(&broken);
}

static void test_device_names(void **state) {
    static const char *const bad[] = {
        "",          "cpu",      "opencl:",   "opencl:x", "opencl:-1",
        "opencl:1x", "opencl 0", "opencl:99", "opencl0",  "opencl:4294967296"};
    (void)state;
    need_device();
    sss_cl none;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        assert_int_equal(sss_cl_open(&none, bad[i], 0, NULL), SSS_CL_BAD_DEVICE);
        assert_true(none.error[0] != '\0' && !strchr(none.error, '\n'));
        sss_cl_close(&none);
    }
}

// ---- Mathematics

enum { MATH_BATCH = 1 << 20, MATH_SMALL_BATCH = 1 << 8 };
static int math_count(void) { return small ? MATH_SMALL_BATCH : MATH_BATCH; }

static void math_batch(cl_kernel kernel, cl_mem out, int which, uint32_t first, uint32_t step,
                       uint32_t *cl, tally *sum) {
    unsigned long different = 0;
    double worst = 0.0;
    int n = math_count();
    check_code(clSetKernelArg(kernel, 0, sizeof which, &which), "clSetKernelArg");
    check_code(clSetKernelArg(kernel, 1, sizeof first, &first), "clSetKernelArg");
    check_code(clSetKernelArg(kernel, 2, sizeof step, &step), "clSetKernelArg");
    check_code(clSetKernelArg(kernel, 3, sizeof out, &out), "clSetKernelArg");
    check_call(sss_cl_run(device, kernel, (size_t)n));
    read_words(out, (size_t)n, cl);
#pragma omp parallel for reduction(+ : different) reduction(max : worst)
    for (int i = 0; i < n; ++i) {
        tally one = {0, 0, 0, 0.0};
        compare_bits(&one, sssi_bits(math_of(which, sssi_float(first + (uint32_t)i * step))),
                     cl[i]);
        different += one.different;
        worst = fmax(worst, one.worst);
    }
    sum->compared += (unsigned long)n;
    sum->different += different;
    sum->worst = fmax(sum->worst, worst);
}

// The bits of the floats that a function is for: `number` of them from `low`.
static void math_range(int which, uint32_t *low, uint64_t *number) {
    *low = which >= 8 && which <= 11 ? 0x33800000u : 0u; // uniform numbers, from 2^-24
    *number = (uint64_t)1 << 32;
    if (which == 4 || which == 5) *number = 0x3f800001u; // turns, 0..1
    if (which >= 8 && which <= 11) *number = 0x3f800000u - *low;
    if (which >= 13)
        *low = 0x3f000000u, *number = 1u << 26; // of several arguments, so all cannot be tried
}

// All arguments of one function, or as many as a batch holds, all over the range.
static double math_function(cl_kernel kernel, int which, uint32_t *cl) {
    tally sum = {0, 0, 0, 0.0};
    cl_mem out = poisoned(MATH_BATCH);
    uint32_t low;
    uint64_t number, done = 0;
    math_range(which, &low, &number);
    uint32_t step = exhaustive ? 1u : (uint32_t)(number / (unsigned)math_count()) | 1u;
    do {
        math_batch(kernel, out, which, low + (uint32_t)done, step, cl, &sum);
        done += (uint64_t)math_count();
    } while (exhaustive && done < number);
    clReleaseMemObject(out);
    if (sum.different || exhaustive)
        print_message("    %s: %lu of %lu differ, worst %.0f ulp\n", math_name[which],
                      sum.different, sum.compared, sum.worst);
    check_at_most(math_name[which], sum.worst, device->exact ? 0.0 : LOOSE_ULP);
    return (double)sum.compared;
}

static void test_mathematics(void **state) {
    uint32_t *cl = (uint32_t *)malloc(MATH_BATCH * sizeof *cl);
    double compared = 0.0;
    (void)state;
    need_device();
    assert_non_null(cl);
    cl_int code;
    cl_kernel kernel = clCreateKernel(device->program, "math", &code);
    check_code(code, "clCreateKernel");
    for (int which = 0; which < MATH_FUNCTIONS; ++which)
        compared += math_function(kernel, which, cl);
    print_message("%d functions, %.4g numbers\n", MATH_FUNCTIONS, compared);
    clReleaseKernel(kernel);
    free(cl);
}

// ---- Lookups

enum { BATCH = 64 * 9, SMALL_BATCH = 64 * 3, PROFILES = 3 }; // the small one where lookups are long

static scene load(int which, int profile) {
    scene s;
    sss_result result;
    scenes_optics optics = scenes_make(&s, which);
    if (profile == 0) result = sss_burley(&s.medium, optics.albedo, optics.dmfp);
    else if (profile == 1)
        result = sss_dipole_from_albedo(&s.medium, optics.albedo, optics.dmfp, 1.35f);
    else result = sss_better_dipole_from_albedo(&s.medium, optics.albedo, optics.dmfp, 1.35f);
    assert_int_equal(result, SSS_OK);
    return s;
}

typedef struct batch {
    int size;
    sss_vec3 position[BATCH], normal[BATCH];
    uint32_t seed[BATCH];
    int count[BATCH];
    sss_exit exit[BATCH * SSS_MAX_EXITS];
} batch;

// A few of the entries are refused ones.
static void make_entries(const scene *s, uint32_t name, int size, batch *b) {
    static camera_entry entry[BATCH];
    b->size = size;
    camera_entries(s, 2u * name, entry, size);
    for (int i = 0; i < size; ++i) {
        b->position[i] = entry[i].position;
        b->normal[i] = entry[i].normal;
        b->seed[i] = sss_hash(name, 0x10000u + (uint32_t)i);
    }
    b->normal[7] = scene_vec(0.0f, 0.0f, 0.0f);
    b->normal[8].y = NAN;
    b->position[9].x = INFINITY;
}

static void poison_results(batch *b) {
    static const uint32_t poison = POISON;
    for (size_t i = 0; i < sizeof b->count / 4u; ++i)
        memcpy((char *)b->count + 4u * i, &poison, 4u);
    for (size_t i = 0; i < sizeof b->exit / 4u; ++i) memcpy((char *)b->exit + 4u * i, &poison, 4u);
}

static void exits_on_cpu(const scene *s, tracer_settings settings, int room, batch *b) {
#pragma omp parallel for schedule(dynamic, 16)
    for (int i = 0; i < b->size; ++i) {
        sss_exit own[SSS_MAX_EXITS];
        uint32_t probes = 0;
        b->count[i] =
            tracer_exits(s, settings, b->position[i], b->normal[i], b->seed[i], own, &probes);
        memcpy(&b->exit[i * room], own, sizeof *own * (size_t)b->count[i]);
    }
}

typedef struct lookups {
    unsigned long lookups, exits, flips, nan;
    tally bits;
} lookups;

// Position, normal and weight of one exit. Another count or an exit elsewhere is a flipped pick.
static void compare_lookup(const batch *cpu, const batch *cl, int i, int room, lookups *sum) {
    enum {
        WORDS = sizeof(sss_exit) / 4,
        HIT = offsetof(sss_exit, hit) / 4
    }; // the one that is no float
    tally mine = {0, 0, 0, 0.0};
    int flipped = cpu->count[i] != cl->count[i];
    ++sum->lookups;
    for (int k = 0; k < room && !flipped; ++k) {
        uint32_t a[WORDS];
        memcpy(a, &cpu->exit[i * room + k], sizeof a);
        uint32_t b[WORDS];
        memcpy(b, &cl->exit[i * room + k], sizeof b);
        if (k >= cpu->count[i]) {
            flipped |= memcmp(a, b, sizeof a) != 0; // still poison
            continue;
        }
        ++sum->exits;
        for (int w = 0; w < WORDS; ++w) {
            sum->nan += (unsigned long)(w != HIT && (is_nan(a[w]) || is_nan(b[w])));
            if (!compare_bits(&mine, a[w], b[w]) && w < 3 && mine.worst > LOOSE_ULP) flipped = 1;
        }
    }
    sum->flips += (unsigned long)flipped;
    if (flipped) return;
    sum->bits.compared += mine.compared;
    sum->bits.different += mine.different;
    sum->bits.worst = fmax(sum->bits.worst, mine.worst);
}

static void compare_batch(const scene *s, tracer_settings settings, batch *cpu, batch *cl,
                          lookups *sum) {
    int room =
        settings.plan.exits > 1 && settings.plan.exits <= SSS_MAX_EXITS ? settings.plan.exits : 1;
    *cl = *cpu;
    poison_results(cpu);
    poison_results(cl);
    exits_on_cpu(s, settings, room, cpu);
    const sss_cl_batch all = {(size_t)cl->size, (cl_uint)room, cl->position, cl->normal,
                              cl->seed,         cl->count,     cl->exit};
    check_call(tracer_cl_lookups(&tracer, s, settings, &all));
    for (int i = 0; i < cl->size; ++i) compare_lookup(cpu, cl, i, room, sum);
}

static void report_lookups(const lookups *sum) {
    print_message(
        "%lu lookups, %lu exits: %lu picks differ, %lu of %lu numbers differ, worst %.0f ulp\n",
        sum->lookups, sum->exits, sum->flips, sum->bits.different, sum->bits.compared,
        sum->bits.worst);
    assert_int_equal(sum->nan, 0);
    check_at_most("share of flipped picks", (double)sum->flips / (double)sum->lookups,
                  device->exact ? 0.0 : LOOSE_FLIPS);
    check_at_most("ulps", sum->bits.worst, device->exact ? 0.0 : LOOSE_ULP);
}

// In make test a third.
static int batch_of(int all) { return exhaustive ? all : all / 3; }

// Every profile, scene, mix, number of candidates and exits, with and without strata and hints.
static void test_lookups(void **state) {
    static const unsigned mixes[] = {0u, SSS_DISK | SSS_DISK_TANGENTS, SSS_CHORD, 15u};
    static const int candidates[] = {1, 3, 8, 64}, exits[] = {1, SSS_MAX_EXITS};
    enum { CASES = PROFILES * SCENES * 4 * 4 * 2 * 2 * 2 };
    static batch cpu, cl;
    (void)state;
    need_device();
    lookups sum;
    memset(&sum, 0, sizeof sum);
    for (unsigned c = 0; c < CASES; c += small ? 127u : 1u) {
        unsigned outer = c / (4 * 4 * 2 * 2 * 2);
        scene s = load((int)(outer % SCENES), (int)(outer / SCENES));
        tracer_settings settings;
        memset(&settings, 0, sizeof settings);
        settings.method = TRACER_RESAMPLED;
        settings.light_aware = (int)(c & 1u);
        settings.plan.independent = (int)(c >> 1 & 1u);
        settings.plan.exits = exits[c >> 2 & 1u];
        settings.plan.candidates = candidates[c >> 3 & 3u];
        settings.plan.techniques = mixes[c >> 5 & 3u];
        make_entries(&s, c,
                     small                            ? 16
                     : settings.plan.candidates == 64 ? batch_of(SMALL_BATCH)
                                                      : batch_of(BATCH),
                     &cpu);
        compare_batch(&s, settings, &cpu, &cl, &sum);
    }
    report_lookups(&sum);
    check_at_least("lookups", (double)sum.lookups, small ? 100.0 : exhaustive ? 1e6 : 3e5);
}

// Channels that are black or scatter like Lambert, lengths far apart, and coefficients instead of
// lengths.
static void odd_medium(int which, sss_medium *m) {
    static const float some[3] = {0.9f, 0.5f, 0.2f}, black[3] = {0.0f, 0.8f, 0.0f},
                       all[3] = {1.0f, 1.0f, 1.0f}, none[3] = {0.0f, 0.0f, 0.0f},
                       gap[3] = {0.3f, 0.0f, 0.1f}, wide[3] = {1e12f, 1.0f, 1e-12f},
                       thin[3] = {1e-12f, 1e-11f, 1e-12f};
    switch (which) {
    case 0: sss_burley(m, black, some); break;
    case 1: sss_burley(m, some, gap); break;
    case 2: sss_burley(m, some, none); break;
    case 3: sss_burley(m, none, some); break;
    case 4: sss_burley(m, some, wide); break;
    case 5: sss_burley(m, some, thin); break;
    case 6: sss_burley_mfp(m, some, gap); break;
    case 7: sss_dipole(m, none, some, 1.5f); break;
    case 8: sss_better_dipole(m, gap, some, 0.7f); break;
    case 9: sss_dipole_from_albedo(m, all, some, 5.0f); break;
    default: sss_better_dipole_from_albedo(m, some, wide, 1.0f); break;
    }
}

// Odd media under all plans that there are, and some that there are not.
static void test_odd_lookups(void **state) {
    enum { MEDIA = 11 };
    static batch cpu, cl;
    int unified = device->unified;
    (void)state;
    need_device();
    lookups sum;
    memset(&sum, 0, sizeof sum);
    for (int which = 0; which < MEDIA; which += small ? 3 : 1) {
        scene s = load(which % SCENES, 0);
        odd_medium(which, &s.medium);
        for (int k = 0; k < 18; ++k) {
            tracer_settings settings;
            memset(&settings, 0, sizeof settings);
            settings.method = TRACER_RESAMPLED;
            settings.light_aware = k % 2;
            settings.plan.techniques = (unsigned)k; // 16 is the walk, 17 no plan
            settings.plan.exits = k % (SSS_MAX_EXITS + 2);
            settings.plan.candidates = k == 7 ? -1 : k == 9 ? SSS_MAX_CANDIDATES + 1 : k;
            make_entries(&s, (uint32_t)(1000 * which + k), small ? 12 : batch_of(SMALL_BATCH),
                         &cpu);
            device->unified = k % 3 != 0 && unified; // copied or not
            compare_batch(&s, settings, &cpu, &cl, &sum);
        }
    }
    device->unified = unified;
    report_lookups(&sum);
}

// ---- Whole lookups: walks, exits by channel, samples, Lambert; with hit and mass

typedef struct whole_case {
    sss_plan plan;
    int aware;
    cl_uint sample;
} whole_case;

static void compare_whole(cl_kernel kernel, const scene *s, const whole_case *k, batch *cpu,
                          batch *cl, lookups *sum) {
    cl_mem on_device = sss_cl_buffer(device, sizeof *s, s);
    const sss_cl_argument own[] = {{sizeof on_device, &on_device},
                                   {sizeof k->plan, &k->plan},
                                   {sizeof k->aware, &k->aware},
                                   {sizeof k->sample, &k->sample}};

    assert_non_null(on_device);
    *cl = *cpu;
    poison_results(cpu);
    poison_results(cl);
#pragma omp parallel for schedule(dynamic, 16)
    for (int i = 0; i < cpu->size; ++i) {
        sss_exit mine[SSS_MAX_EXITS];

        cpu->count[i] = whole_lookup(s, k->plan, k->aware, k->sample, cpu->position[i],
                                     cpu->normal[i], cpu->seed[i], mine);
        for (int e = 0; e < cpu->count[i]; ++e) cpu->exit[i * SSS_MAX_EXITS + e] = mine[e];
    }
    sss_cl_batch all;
    all.entries = (size_t)cl->size;
    all.room = SSS_MAX_EXITS;
    all.positions = cl->position;
    all.normals = cl->normal;
    all.seeds = cl->seed;
    all.counts = cl->count;
    all.exits = cl->exit;
    check_call(sss_cl_lookups(device, kernel, &all, own, 4));
    sss_cl_release(&on_device, 1);
    for (int i = 0; i < cl->size; ++i) compare_lookup(cpu, cl, i, SSS_MAX_EXITS, sum);
}

// Plans of the second stage, each with the exits that the other tests of lookups leave out.
static whole_case whole_of(int number) {
    static const sss_plan plans[] = {
        {1, 0, SSS_WALK, 0, 0, 0},  {2, 1, SSS_WALK, 0, 1, 0},    {5, 4, SSS_WALK, 0, 0, 0},
        {2, 0, SSS_WALK, 1, 0, 0},  {0, 0, SSS_LAMBERT, 0, 0, 0}, {8, 0, 0u, 0, 1, 0},
        {3, 1, SSS_CHORD, 0, 1, 0}, {8, 4, 0u, 0, 0, 0},          {8, 1, 15u, 1, 1, 0},
        {8, 2, 0u, 0, 1, 0}, /* refused */
    };
    whole_case k;

    k.plan = plans[number % 10];
    k.aware = number / 10 % 2;
    k.sample = number % 3 == 0 ? 0u : (cl_uint)(7 * number);
    return k;
}
enum { WHOLE = 20 };

static void test_whole_lookups(void **state) {
    enum { MEDIA = SCENES * PROFILES + 11 };
    static batch cpu, cl;

    (void)state;
    need_device();
    cl_kernel kernel = sss_cl_kernel(device, "whole_lookups");
    assert_non_null(kernel);
    lookups sum;
    memset(&sum, 0, sizeof sum);
    for (int which = 0; which < MEDIA; which += small ? 5 : 1) {
        scene s = load(which % SCENES, which / SCENES % PROFILES);

        if (which >= SCENES * PROFILES) odd_medium(which - SCENES * PROFILES, &s.medium);
        for (int number = which % 3; number < WHOLE; number += small ? 3 : 1) {
            whole_case k = whole_of(number);

            make_entries(&s, (uint32_t)(7000 + 100 * which + number), small ? 10 : 64, &cpu);
            compare_whole(kernel, &s, &k, &cpu, &cl, &sum);
        }
    }
    clReleaseKernel(kernel);
    report_lookups(&sum);
    check_at_least("exits", (double)sum.exits, small ? 100.0 : 2e4);
}

// ---- Shares by halves on the device against the whole on the CPU

static void compare_shares(cl_kernel kernel, const scene *s, const batch *b, const sss_exit *exits,
                           int found, tally *sum) {
    enum { SCENE, GROUP, EXITS, WEIGHTS, BUFFERS };
    static sss_vec3 weight[BATCH * 64];
    static sss_entry group[64];
    cl_mem on[BUFFERS];
    cl_uint n = (cl_uint)found;
    cl_int count = 64;
    size_t size = (size_t)found * 64u * sizeof *weight;

    on[SCENE] = sss_cl_buffer(device, sizeof *s, s);
    on[GROUP] = sss_cl_buffer(device, 64u * sizeof *b->position, b->position);
    on[EXITS] = sss_cl_buffer(device, (size_t)found * sizeof *exits, exits);
    on[WEIGHTS] = sss_cl_buffer(device, size, weight);
    const sss_cl_argument arguments[] = {{sizeof n, &n},
                                         {sizeof count, &count},
                                         {sizeof on[0], &on[SCENE]},
                                         {sizeof on[0], &on[GROUP]},
                                         {sizeof on[0], &on[EXITS]},
                                         {sizeof on[0], &on[WEIGHTS]}};
    assert_true(sss_cl_set(device, kernel, 0, arguments, 6));
    check_call(sss_cl_run(device, kernel, (size_t)found));
    assert_true(sss_cl_read(device, on[WEIGHTS], size, weight));
    sss_cl_release(on, BUFFERS);

    for (int i = 0; i < 64; ++i) {
        group[i].position = b->position[i];
        group[i].medium = &s->medium;
    }
    for (int i = 0; i < found; ++i) {
        float whole[64][3];

        sss_share(&exits[i], group, 64, -1, 0.0f, whole);
        for (int j = 0; j < 64; ++j) {
            const sss_vec3 *w = &weight[i * 64 + j];
            float half[3];

            half[0] = w->x;
            half[1] = w->y;
            half[2] = w->z;
            for (int c = 0; c < 3; ++c) {
                if (is_nan(sssi_bits(whole[j][c]))) fail_msg("NaN in a share");
                compare_bits(sum, sssi_bits(whole[j][c]), sssi_bits(half[c]));
            }
        }
    }
}

static void test_shares(void **state) {
    static batch cpu;
    tally sum = {0, 0, 0, 0.0};

    (void)state;
    need_device();
    cl_kernel kernel = sss_cl_kernel(device, "shares");
    assert_non_null(kernel);
    for (int which = 0; which < SCENES * PROFILES + 11; which += small ? 6 : 1) {
        static sss_exit exits[BATCH];
        sss_plan plan = {8, 0, 0u, 0, 1, 0};
        scene s = load(which % SCENES, which / SCENES % PROFILES);
        int found = 0;

        if (which >= SCENES * PROFILES) odd_medium(which - SCENES * PROFILES, &s.medium);
        make_entries(&s, (uint32_t)(9000 + which), 64, &cpu);
        for (int i = 0; i < (small ? 8 : 64); ++i) {
            sss_exit mine[SSS_MAX_EXITS];
            int count =
                whole_lookup(&s, plan, 0, 0u, cpu.position[i], cpu.normal[i], cpu.seed[i], mine);

            for (int e = 0; e < count; ++e)
                if (mine[e].mass > 0.0f) exits[found++] = mine[e];
        }
        if (found) compare_shares(kernel, &s, &cpu, exits, found, &sum);
    }
    clReleaseKernel(kernel);
    print_message("%lu of %lu weights differ, worst %.0f ulp\n", sum.different, sum.compared,
                  sum.worst);
    check_at_most("ulps", sum.worst, device->exact ? 0.0 : LOOSE_ULP);
    check_at_least("weights", (double)sum.compared, small ? 1e3 : 1e5);
}

// ---- Pictures

enum { WIDTH = 40, HEIGHT = 36, SPP = 4, NUMBERS = 3 * WIDTH * HEIGHT };
static int width = WIDTH, height = HEIGHT;

static void tiles_on_cpu(const scene *s, tracer_settings settings, uint32_t sample, float *rgb,
                         unsigned long long *probes, unsigned long long *shaded) {
    int columns = tracer_tile_count(settings, sample, 0),
        rows = tracer_tile_count(settings, sample, 1);
    int x, y;
    for (int number = 0; number < columns * rows; ++number) {
        static tracer_tile tile;
        sss_vec3 radiance[TRACER_TILE_PIXELS];
        int column = number % columns, row = number / columns;
        tracer_result all = tracer_tile_sample(s, settings, column, row, sample, &tile, radiance);
        *probes += all.probes;
        *shaded += all.shaded;
        for (int i = 0; i < TRACER_TILE_PIXELS; ++i) {
            if (!tracer_tile_pixel(settings, sample, column, row, i, &x, &y)) continue;
            rgb[3 * (y * width + x)] += radiance[i].x;
            rgb[3 * (y * width + x) + 1] += radiance[i].y;
            rgb[3 * (y * width + x) + 2] += radiance[i].z;
        }
    }
}

static void picture_on_cpu(const scene *s, tracer_settings settings, float *rgb,
                           unsigned long long *probes, unsigned long long *shaded) {
    unsigned long long p = 0, h = 0;
#pragma omp parallel for schedule(dynamic, 64) reduction(+ : p, h)
    for (int pixel = 0; pixel < width * height; ++pixel) {
        for (uint32_t k = 0; k < SPP; ++k) {
            tracer_result r = tracer_sample(s, settings, pixel % width, pixel / width, k);
            rgb[3 * pixel] += r.radiance.x;
            rgb[3 * pixel + 1] += r.radiance.y;
            rgb[3 * pixel + 2] += r.radiance.z;
            p += r.probes;
            h += r.shaded;
        }
    }
    *probes = p;
    *shaded = h;
}

// In bands and passes: one below the other, and the lower one in two.
static void picture_on_device(const scene *s, tracer_settings settings, float *rgb,
                              unsigned long long *probes, unsigned long long *shaded) {
    int middle = height / 2;
    check_call(tracer_cl_render(&tracer, s, settings, 0, middle, 0, SPP, rgb, probes, shaded));
    for (int i = 3 * width * middle; i < 3 * width * height; ++i) assert_true(rgb[i] == 0.0f);
    check_call(tracer_cl_render(&tracer, s, settings, middle, height, 0, 1, rgb, probes, shaded));
    check_call(
        tracer_cl_render(&tracer, s, settings, middle, height, 1, SPP - 1, rgb, probes, shaded));
}

// Each sample in two bands of rows of tiles, the lower one first.
static void tiles_on_device(const scene *s, tracer_settings settings, float *rgb,
                            unsigned long long *probes, unsigned long long *shaded) {
    for (uint32_t k = 0; k < SPP; ++k) {
        int rows = tracer_tile_count(settings, k, 1), middle = rows / 2;
        check_call(
            tracer_cl_render_tiles(&tracer, s, settings, middle, rows, k, rgb, probes, shaded));
        check_call(tracer_cl_render_tiles(&tracer, s, settings, 0, middle, k, rgb, probes, shaded));
    }
}

static void compare_picture(int which, int profile, tracer_settings settings, tally *all) {
    static float cpu[NUMBERS], cl[NUMBERS];
    unsigned long long probes[2] = {0, 0}, shaded[2] = {0, 0};
    scene s = load(which, profile);
    tally sum = {0, 0, 0, 0.0};
    settings.width = width;
    settings.height = height;
    settings.seed = 20160505u;
    memset(cpu, 0, sizeof cpu);
    memset(cl, 0, sizeof cl);
    if (tracer_tile_side(settings) > 1) {
        for (uint32_t k = 0; k < SPP; ++k)
            tiles_on_cpu(&s, settings, k, cpu, &probes[0], &shaded[0]);
        tiles_on_device(&s, settings, cl, &probes[1], &shaded[1]);
    } else {
        picture_on_cpu(&s, settings, cpu, &probes[0], &shaded[0]);
        picture_on_device(&s, settings, cl, &probes[1], &shaded[1]);
    }
    for (int i = 0; i < 3 * width * height; ++i) {
        if (is_nan(sssi_bits(cpu[i])) || is_nan(sssi_bits(cl[i])))
            fail_msg("%s: NaN", scenes_known[which].name);
        compare_bits(&sum, sssi_bits(cpu[i]), sssi_bits(cl[i]));
    }
    if (sum.different)
        print_message(
            "    %s, profile %d, method %d%s: %lu of %lu numbers differ, worst %.0f ulp\n",
            scenes_known[which].name, profile, settings.method,
            settings.light_aware ? ", light hint" : "", sum.different, sum.compared, sum.worst);
    all->compared += sum.compared;
    all->different += sum.different;
    all->far += sum.far;
    assert_true(!device->exact || (probes[0] == probes[1] && shaded[0] == shaded[1]));
}

// Tiles of two sides, exits of each colour, and the other models, also chosen lookup by lookup.
static void compare_models(int which, int profile, tally *sum) {
    tracer_settings settings;
    memset(&settings, 0, sizeof settings);
    settings.method = TRACER_RESAMPLED;
    settings.plan.candidates = 2;
    settings.plan.tile = 5;
    settings.plan.exits = 2;
    compare_picture(which, profile, settings, sum);
    settings.plan.tile = 8;
    settings.plan.exits = 1;
    settings.plan.per_channel = 1;
    settings.light_aware = 1;
    compare_picture(which, profile, settings, sum);
    settings.tolerance = 0.4f;
    compare_picture(which, profile, settings, sum);
    settings.tolerance = 0.0f;
    settings.plan.techniques = SSS_WALK;
    compare_picture(which, profile, settings, sum);
    settings.plan.techniques = SSS_LAMBERT;
    compare_picture(which, profile, settings, sum);
}

// A path that takes another turn changes its pixel beyond any ulp. At most SPP x
// TRACER_MAX_SURFACES lookups and as many draws lie behind each pixel: where the device is not
// exact, so many times the flips of a lookup are allowed.
static void test_pictures(void **state) {
    tally sum = {0, 0, 0, 0.0};
    (void)state;
    need_device();
    if (small) width = height = 4;
    for (int which = 0; which < SCENES; ++which) {
        for (int profile = 0; profile < PROFILES; ++profile) {
            tracer_settings settings;
            memset(&settings, 0, sizeof settings);
            if (small && (which + profile) % 5 != 0) continue;
            settings.method = TRACER_PLAIN;
            compare_picture(which, profile, settings, &sum);
            settings.method = TRACER_REFERENCE;
            compare_picture(which, profile, settings, &sum);
            settings.method = TRACER_RESAMPLED;
            compare_picture(which, profile, settings, &sum);
            settings.light_aware = 1;
            settings.plan.exits = 2;
            compare_picture(which, profile, settings, &sum);
            compare_models(which, profile, &sum);
        }
    }
    print_message("    every scene, profile and method: %lu of %lu numbers differ\n", sum.different,
                  sum.compared);
    check_at_most("share of other numbers", (double)sum.far / (double)sum.compared,
                  2.0 * SPP * TRACER_MAX_SURFACES * LOOSE_FLIPS);
    if (device->exact) assert_int_equal(sum.different, 0);
}

int main(int count, char **words) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layouts),       cmocka_unit_test(test_build_failure),
        cmocka_unit_test(test_device_names),  cmocka_unit_test(test_mathematics),
        cmocka_unit_test(test_lookups),       cmocka_unit_test(test_odd_lookups),
        cmocka_unit_test(test_whole_lookups), cmocka_unit_test(test_shares),
        cmocka_unit_test(test_pictures),
    };
    exhaustive = count > 1 && strcmp(words[1], "--long") == 0;
    small = count > 1 && strcmp(words[1], "--small") == 0;
    return cmocka_run_group_tests_name("opencl", tests, open_device, close_device);
}
