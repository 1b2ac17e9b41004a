// device.h - where samples are traced: on the CPU's threads, or on one or several OpenCL devices.
// Host only; link with cl/sss_cl.c and -lOpenCL. SPDX-License-Identifier: MIT
//
// Whatever the device, the same sums come out, bit for bit, as long as it is IEEE-correct: see
// device_note().
#ifndef DEVICE_H
#define DEVICE_H

#include <unistd.h>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "command.h"
#include "image.h"
#include "tracer_cl.h"

// Samples in one launch: enough to hide its cost, short enough to see it move.
#define DEVICE_BAND 131072

#ifdef _OPENMP
static inline int device_thread(void) { return omp_get_thread_num(); }
static inline int device_cpu_threads(void) { return omp_get_max_threads(); }
#else
static inline int device_thread(void) { return 0; }
static inline int device_cpu_threads(void) { return 1; }
#endif

typedef struct device_set {
    int count; // of OpenCL devices; 0: the CPU
    tracer_cl cl[SSS_CL_MAX_DEVICES];
    char error[SSS_CL_MAX_ERROR];
} device_set;

typedef struct device_work {
    unsigned long long probes, shaded;
} device_work;

// Called now and then, by one thread at a time, with the share that is done.
typedef void device_progress(void *user, double share);

// Is this the name of a device or of several? cpu, opencl, opencl:NUMBER, opencl:all.
static inline int device_is_name(const char *name) {
    if (strcmp(name, "cpu") == 0 || strcmp(name, "opencl") == 0 || strcmp(name, "opencl:all") == 0)
        return 1;
    return strncmp(name, "opencl:", 7) == 0 && name[7] &&
           strspn(name + 7, "0123456789") == strlen(name + 7);
}

static inline const char *parse_device(const char *option, const char *value) {
    if (!device_is_name(value))
        fail(2, "%s wants cpu, opencl, opencl:NUMBER or opencl:all, not '%s'", option, value);
    return value;
}

// PoCL keeps what it compiles in a folder. Where it cannot write to it, it has no device or does
// not compile, and does not say why: this adds it to `error`.
static inline void device_explain(char *error) {
    static const char *const names[] = {"POCL_CACHE_DIR", "XDG_CACHE_HOME", "HOME"};
    int i = 0;
    while (i < 2 && !getenv(names[i])) i++;
    const char *folder = getenv(names[i]);
    size_t length = strlen(error);
    if (!folder || access(folder, W_OK | X_OK) == 0) return;
    snprintf(error + length, SSS_CL_MAX_ERROR - length,
             "; PoCL wants a folder that it can write to, and %s is %s", names[i], folder);
}

static inline sss_cl_result device_open_all(device_set *set, const char *name) {
    sss_cl_devices known;
    memset(set, 0, sizeof *set);
    if (strcmp(name, "cpu") == 0) return SSS_CL_OK;
    int all = strcmp(name, "opencl:all") == 0, wanted = 1;
    if (all) {
        sss_cl_result result = sss_cl_list(&known, set->error);
        if (result != SSS_CL_OK) return result;
        wanted = known.count;
    }
    for (int i = 0; i < wanted; i++) {
        char number[32];
        snprintf(number, sizeof number, "opencl:%d", i);
        tracer_cl *t = &set->cl[set->count++];
        sss_cl_result result = tracer_cl_open(t, all ? number : name, NULL);
        if (result == SSS_CL_OK) continue;
        if (t->cl.log) fputs(t->cl.log, stderr);
        memcpy(set->error, t->cl.error, sizeof set->error);
        return result;
    }
    return SSS_CL_OK;
}

static inline sss_cl_result device_open(device_set *set, const char *name) {
    sss_cl_result result = device_open_all(set, name);
    if (result != SSS_CL_OK) device_explain(set->error);
    return result;
}

static inline void device_close(device_set *set) {
    for (int i = 0; i < set->count; i++) tracer_cl_close(&set->cl[i]);
    set->count = 0;
}

static inline int device_threads(const device_set *set) {
    return set->count > 0 ? set->count : device_cpu_threads();
}

// What a user should know of the devices before trusting bits: NULL when there is nothing.
static inline const char *device_note(const device_set *set) {
    for (int i = 0; i < set->count; i++) {
        if (!set->cl[i].cl.exact)
            return "this device does not round as IEEE wants: single samples may differ from the "
                   "CPU's";
    }
    return NULL;
}

static inline void device_add(float *rgb, sss_vec3 radiance) {
    rgb[0] += radiance.x;
    rgb[1] += radiance.y;
    rgb[2] += radiance.z;
}

static inline void device_rows_on_cpu(const scene *s, tracer_settings settings, int y,
                                      uint32_t first, int count, float *row, device_work *work) {
    for (int x = 0; x < settings.width; x++) {
        for (int k = 0; k < count; k++) {
            tracer_result r = tracer_sample(s, settings, x, y, first + (uint32_t)k);
            device_add(row + 3 * x, r.radiance);
            work->probes += r.probes;
            work->shaded += r.shaded;
        }
    }
}

static inline void device_tile_on_cpu(const scene *s, tracer_settings settings, int column, int row,
                                      uint32_t sample, float *rgb, device_work *work) {
    tracer_tile tile;
    sss_vec3 radiance[TRACER_TILE_PIXELS];
    tracer_result all = tracer_tile_sample(s, settings, column, row, sample, &tile, radiance);
    int x, y;
    work->probes += all.probes;
    work->shaded += all.shaded;
    for (int i = 0; i < TRACER_TILE_PIXELS; i++) {
        if (!tracer_tile_pixel(settings, sample, column, row, i, &x, &y)) continue;
        device_add(rgb + image_count(settings.width, y) + 3 * x, radiance[i]);
    }
}

// What a picture is rendered in: rows of pixels or, where exits are shared, rows of tiles. These
// lie elsewhere in each sample.
static inline int device_bands(tracer_settings settings, uint32_t sample) {
    return tracer_tile_count(settings, sample, 1u);
}

// The first row of pixels in a band.
static inline int device_band_top(tracer_settings settings, uint32_t sample, int band) {
    int y = band * tracer_tile_side(settings) - tracer_tile_shift(settings, sample, 1u);
    return y < 0 ? 0 : y > settings.height ? settings.height : y;
}

// How many samples may be rendered in one go.
static inline int device_samples(tracer_settings settings, int count) {
    return tracer_tile_side(settings) > 1 ? 1 : count;
}

// Bands top .. bottom - 1 on the device of the calling thread, or on the CPU.
static inline sss_cl_result device_band(device_set *set, int thread, const scene *s,
                                        tracer_settings settings, int top, int bottom,
                                        uint32_t first, int count, float *rgb, device_work *work) {
    int tiles = tracer_tile_side(settings) > 1;
    if (set->count > 0 && tiles) {
        return tracer_cl_render_tiles(&set->cl[thread], s, settings, top, bottom, first, rgb,
                                      &work->probes, &work->shaded);
    }
    if (set->count > 0) {
        return tracer_cl_render(&set->cl[thread], s, settings, top, bottom, first, (uint32_t)count,
                                rgb, &work->probes, &work->shaded);
    }
    for (int y = top; y < bottom; y++) {
        if (!tiles)
            device_rows_on_cpu(s, settings, y, first, count, rgb + image_count(settings.width, y),
                               work);
        for (int x = 0; tiles && x < tracer_tile_count(settings, first, 0u); x++)
            device_tile_on_cpu(s, settings, x, y, first, rgb, work);
    }
    return SSS_CL_OK;
}

// Who is told of how much is done, and what share of the whole a pass is.
typedef struct device_listener {
    device_progress *progress;
    void *user;
    double before, share;
} device_listener;

// Bands go to whoever is free: threads of the CPU, or one thread for each device.
static inline sss_cl_result device_pass(device_set *set, const scene *s,
                                        const tracer_settings *settings, image *sum, uint32_t first,
                                        int count, device_work *work, device_listener listener) {
    unsigned long long probes = 0, shaded = 0;
    int height = device_bands(*settings, first), rows = 1, finished = 0, failed = 0;
    if (set->count > 0)
        rows = DEVICE_BAND / set->count / settings->width / tracer_tile_side(*settings) + 1;
    int bands = (height + rows - 1) / rows;
#pragma omp parallel for num_threads(device_threads(set)) schedule(dynamic, 1) \
    reduction(+ : probes, shaded)
    for (int band = 0; band < bands; band++) {
        device_work mine = {0, 0};
        int thread = device_thread(), done, stop, top = band * rows;
        int bottom = top + rows < height ? top + rows : height;
#pragma omp atomic read
        stop = failed;
        if (stop) continue;
        if (device_band(set, thread, s, *settings, top, bottom, first, count, sum->rgb, &mine) !=
            SSS_CL_OK) {
#pragma omp atomic write
            failed = thread + 1;
        }
        probes += mine.probes;
        shaded += mine.shaded;
#pragma omp atomic capture
        done = finished += bottom - top;
        if (thread == 0)
            listener.progress(listener.user, listener.before + listener.share * done / height);
    }
    work->probes += probes;
    work->shaded += shaded;
    if (failed) memcpy(set->error, set->cl[failed - 1].cl.error, sizeof set->error);
    return failed ? SSS_CL_FAILED : SSS_CL_OK;
}

// Adds samples first .. first + count - 1 of every pixel to `sum`. A pixel's samples are added in
// their order, so the picture does not depend on who did what.
static inline sss_cl_result device_render(device_set *set, const scene *s,
                                          const tracer_settings *settings, image *sum,
                                          uint32_t first, int count, device_work *work,
                                          device_progress *progress, void *user) {
    int at_once = device_samples(*settings, count);
    sss_cl_result result = SSS_CL_OK;
    for (int k = 0; k < count && result == SSS_CL_OK; k += at_once) {
        device_listener listener = {progress, user, (double)k / count, (double)at_once / count};
        result = device_pass(set, s, settings, sum, first + (uint32_t)k, at_once, work, listener);
    }
    return result;
}

#endif
