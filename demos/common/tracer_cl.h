// tracer_cl.h - the path tracer on an OpenCL device: batches of lookups, and pictures. Host only;
// link with cl/sss_cl.c and -lOpenCL. SPDX-License-Identifier: MIT
#ifndef TRACER_CL_H
#define TRACER_CL_H

#include <stdio.h>
#include <stdlib.h>

#include "cl/sss_cl.h"
#include "tracer.h"
#include "tracer_cl_source.h"

typedef struct tracer_cl {
    sss_cl cl;
    cl_kernel lookups, render, tiles;
} tracer_cl;

// As sss_cl_open(); `more` is OpenCL C that is appended to the tracer's, or NULL. Call
// tracer_cl_close() in every case.
static inline sss_cl_result tracer_cl_open(tracer_cl *t, const char *name, const char *more) {
    const char *const texts[] = {(const char *)tracer_cl_source, more ? more : ""};
    t->lookups = t->render = t->tiles = NULL;
    sss_cl_result result = sss_cl_open(&t->cl, name, 2, texts);
    if (result != SSS_CL_OK) return result;
    t->lookups = sss_cl_kernel(&t->cl, "tracer_lookups");
    t->render = t->lookups ? sss_cl_kernel(&t->cl, "tracer_render") : NULL;
    t->tiles = t->render ? sss_cl_kernel(&t->cl, "tracer_tiles") : NULL;
    return t->tiles ? SSS_CL_OK : SSS_CL_FAILED;
}

static inline void tracer_cl_close(tracer_cl *t) {
    if (t->render) clReleaseKernel(t->render);
    if (t->lookups) clReleaseKernel(t->lookups);
    if (t->tiles) clReleaseKernel(t->tiles);
    t->lookups = t->render = t->tiles = NULL;
    sss_cl_close(&t->cl);
}

// One lookup for each entry, as the tracer makes it: settings.plan, settings.light_aware and the
// scene's medium count.
static inline sss_cl_result tracer_cl_lookups(tracer_cl *t, const scene *s,
                                              tracer_settings settings, const sss_cl_batch *batch) {
    cl_mem on_device = sss_cl_buffer(&t->cl, sizeof *s, s);
    const sss_cl_argument own[] = {{sizeof on_device, &on_device}, {sizeof settings, &settings}};
    if (!on_device) return SSS_CL_FAILED;
    sss_cl_result result = sss_cl_lookups(&t->cl, t->lookups, batch, own, 2);
    sss_cl_release(&on_device, 1);
    return result;
}

// A kernel over `items` that adds to `pixels` pixels: its parameters are the scene, the settings,
// four numbers, the pixels and two counts for each of them.
static inline sss_cl_result tracer_cl_run(tracer_cl *t, cl_kernel kernel, const scene *s,
                                          tracer_settings settings, const cl_uint number[4],
                                          size_t items, size_t pixels, float *rgb,
                                          unsigned long long *probes, unsigned long long *shaded) {
    enum { SCENE, RGB, WORK, BUFFERS };
    sss_cl *cl = &t->cl;
    cl_mem b[BUFFERS] = {0};
    size_t rgb_size = pixels * 3 * sizeof *rgb, work_size = pixels * 2 * sizeof(cl_uint);
    const sss_cl_argument arguments[] = {
        {sizeof b[0], &b[SCENE]},       {sizeof settings, &settings},
        {sizeof number[0], &number[0]}, {sizeof number[1], &number[1]},
        {sizeof number[2], &number[2]}, {sizeof number[3], &number[3]},
        {sizeof b[0], &b[RGB]},         {sizeof b[0], &b[WORK]}};
    if (pixels == 0) return SSS_CL_OK;
    cl_uint *work = (cl_uint *)calloc(pixels, 2 * sizeof *work);
    if (!work) {
        snprintf(cl->error, sizeof cl->error, "out of memory");
        return SSS_CL_FAILED;
    }
    int good = (b[SCENE] = sss_cl_buffer(cl, sizeof *s, s)) &&
               (b[RGB] = sss_cl_buffer(cl, rgb_size, rgb)) &&
               (b[WORK] = sss_cl_buffer(cl, work_size, work)) &&
               sss_cl_set(cl, kernel, 0, arguments, sizeof arguments / sizeof *arguments) &&
               sss_cl_run(cl, kernel, items) == SSS_CL_OK &&
               sss_cl_read(cl, b[RGB], rgb_size, rgb) && sss_cl_read(cl, b[WORK], work_size, work);
    for (size_t i = 0; good && i < pixels; i++) {
        *probes += work[2 * i];
        *shaded += work[2 * i + 1];
    }
    free(work);
    sss_cl_release(b, BUFFERS);
    return good ? SSS_CL_OK : SSS_CL_FAILED;
}

// Adds samples first .. first + count - 1 of each pixel in rows top .. bottom - 1 to a picture of
// settings.width x settings.height pixels: rgb is the whole picture, three floats a pixel, begun
// black. What they cost is added to probes and shaded.
static inline sss_cl_result tracer_cl_render(tracer_cl *t, const scene *s, tracer_settings settings,
                                             int top, int bottom, uint32_t first, uint32_t count,
                                             float *rgb, unsigned long long *probes,
                                             unsigned long long *shaded) {
    cl_uint width = (cl_uint)settings.width, begin = (cl_uint)top * width,
            end = (cl_uint)bottom * width;
    const cl_uint number[4] = {begin, end, first, count};
    return tracer_cl_run(t, t->render, s, settings, number, end - begin, end - begin,
                         rgb + 3 * (size_t)begin, probes, shaded);
}

// The same for one sample in tiles, of the rows of tiles top .. bottom - 1.
static inline sss_cl_result tracer_cl_render_tiles(tracer_cl *t, const scene *s,
                                                   tracer_settings settings, int top, int bottom,
                                                   uint32_t sample, float *rgb,
                                                   unsigned long long *probes,
                                                   unsigned long long *shaded) {
    if (top >= bottom) return SSS_CL_OK; // no tiles
    int side = tracer_tile_side(settings), shift = tracer_tile_shift(settings, sample, 1u);
    int first = top * side - shift, last = bottom * side - shift;
    if (first < 0) first = 0;
    if (last > settings.height) last = settings.height;
    size_t tiles = (size_t)(bottom - top) * (size_t)tracer_tile_count(settings, sample, 0u);
    size_t row = (size_t)settings.width, pixels = (size_t)(last - first) * row;
    const cl_uint number[4] = {(cl_uint)top, (cl_uint)tiles, (cl_uint)first, sample};
    return tracer_cl_run(t, t->tiles, s, settings, number, tiles * t->cl.local, pixels,
                         rgb + 3 * row * (size_t)first, probes, shaded);
}

#endif
