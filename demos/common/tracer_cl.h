// tracer_cl.h - the path tracer on an OpenCL device: batches of lookups, and pictures. Host only; link with cl/sss_cl.c
// and -lOpenCL. SPDX-License-Identifier: MIT
#ifndef TRACER_CL_H
#define TRACER_CL_H

#include <stdio.h>
#include <stdlib.h>

#include "cl/sss_cl.h"
#include "tracer.h"
#include "tracer_cl_source.h"

typedef struct tracer_cl {
    sss_cl cl;
    cl_kernel lookups, render;
} tracer_cl;

// As sss_cl_open(); `more` is OpenCL C that is appended to the tracer's, or NULL. Call tracer_cl_close() in every case.
static inline sss_cl_result tracer_cl_open(tracer_cl *t, const char *name, const char *more) {
    const char *const texts[] = {(const char *)tracer_cl_source, more ? more : ""};
    t->lookups = t->render = NULL;
    sss_cl_result result = sss_cl_open(&t->cl, name, 2, texts);
    if (result != SSS_CL_OK) return result;
    t->lookups = sss_cl_kernel(&t->cl, "tracer_lookups");
    t->render = t->lookups ? sss_cl_kernel(&t->cl, "tracer_render") : NULL;
    return t->render ? SSS_CL_OK : SSS_CL_FAILED;
}

static inline void tracer_cl_close(tracer_cl *t) {
    if (t->render) clReleaseKernel(t->render);
    if (t->lookups) clReleaseKernel(t->lookups);
    t->lookups = t->render = NULL;
    sss_cl_close(&t->cl);
}

// One lookup for each entry, as the tracer makes it: settings.plan, settings.light_aware and the scene's medium count.
static inline sss_cl_result tracer_cl_lookups(tracer_cl *t, const scene *s, tracer_settings settings,
                                              const sss_cl_batch *batch) {
    cl_mem on_device = sss_cl_buffer(&t->cl, sizeof *s, s);
    const sss_cl_argument own[] = {{sizeof on_device, &on_device}, {sizeof settings, &settings}};
    if (!on_device) return SSS_CL_FAILED;
    sss_cl_result result = sss_cl_lookups(&t->cl, t->lookups, batch, own, 2);
    sss_cl_release(&on_device, 1);
    return result;
}

// Adds samples first .. first + count - 1 of each pixel in rows top .. bottom - 1 to a picture of settings.width x
// settings.height pixels: rgb is the whole picture, three floats a pixel, begun black. What they cost is added to
// probes and shaded.
static inline sss_cl_result tracer_cl_render(tracer_cl *t, const scene *s, tracer_settings settings, int top,
                                             int bottom, uint32_t first, uint32_t count, float *rgb,
                                             unsigned long long *probes, unsigned long long *shaded) {
    enum { SCENE, RGB, WORK, BUFFERS };
    sss_cl *cl = &t->cl;
    cl_mem b[BUFFERS] = {0};
    cl_uint width = (cl_uint)settings.width, begin = (cl_uint)top * width, end = (cl_uint)bottom * width;
    size_t pixels = end - begin, rgb_size = pixels * 3 * sizeof *rgb, work_size = pixels * 2 * sizeof(cl_uint);
    const sss_cl_argument arguments[] = {{sizeof b[0], &b[SCENE]}, {sizeof settings, &settings}, {sizeof begin, &begin},
                                         {sizeof end, &end},       {sizeof first, &first},       {sizeof count, &count},
                                         {sizeof b[0], &b[RGB]},   {sizeof b[0], &b[WORK]}};
    if (pixels == 0) return SSS_CL_OK;
    cl_uint *work = (cl_uint *)calloc(pixels, 2 * sizeof *work);
    if (!work) {
        snprintf(cl->error, sizeof cl->error, "out of memory");
        return SSS_CL_FAILED;
    }
    rgb += 3 * (size_t)begin;
    int good = (b[SCENE] = sss_cl_buffer(cl, sizeof *s, s)) && (b[RGB] = sss_cl_buffer(cl, rgb_size, rgb)) &&
               (b[WORK] = sss_cl_buffer(cl, work_size, work)) &&
               sss_cl_set(cl, t->render, 0, arguments, sizeof arguments / sizeof *arguments) &&
               sss_cl_run(cl, t->render, pixels) == SSS_CL_OK && sss_cl_read(cl, b[RGB], rgb_size, rgb) &&
               sss_cl_read(cl, b[WORK], work_size, work);
    for (size_t i = 0; good && i < pixels; i++) {
        *probes += work[2 * i];
        *shaded += work[2 * i + 1];
    }
    free(work);
    sss_cl_release(b, BUFFERS);
    return good ? SSS_CL_OK : SSS_CL_FAILED;
}

#endif
