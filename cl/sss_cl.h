// sss_cl.h - lookups and pictures on OpenCL devices, for C99 programs. SPDX-License-Identifier: MIT
//
//     sss_cl cl;
//     if (sss_cl_open(&cl, "opencl", NULL) != SSS_CL_OK) { fputs(cl.log, stderr); puts(cl.error); }
//     else sss_cl_exits(&cl, &scene, settings, entries, positions, normals, seeds, counts, exits);
//     sss_cl_close(&cl);
//
// Build sss_cl.c into the program and link with -lOpenCL. The kernels' text is inside: no file is read at run
// time. A call that fails leaves one line in cl.error, which names the OpenCL call and its error; nothing is
// printed here. The same sss_cl serves one thread at a time; different ones do not know of each other.
#ifndef SSS_CL_H
#define SSS_CL_H

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>
#include <stddef.h>

#include "tracer.h"

// A program's exit codes, as they stand.
typedef enum sss_cl_result {
    SSS_CL_OK = 0,
    SSS_CL_FAILED = 1,     // an OpenCL call failed, or there is no memory
    SSS_CL_BAD_DEVICE = 2, // the device's name is not of the form below, or there is no device of that number
    SSS_CL_NO_DEVICE = 3   // this machine has no OpenCL device at all
} sss_cl_result;

typedef struct sss_cl_device {
    cl_platform_id platform;
    cl_device_id id;
    char name[160]; // of the device and its platform
} sss_cl_device;

#define SSS_CL_MAX_DEVICES 32
#define SSS_CL_MAX_ERROR   512

typedef struct sss_cl_devices {
    int count;
    sss_cl_device device[SSS_CL_MAX_DEVICES];
} sss_cl_devices;

typedef struct sss_cl {
    sss_cl_device device;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
    cl_kernel exits, render;
    size_t local; // work-items in a group, chosen at opening; may be changed
    int exact;    // the device divides and takes roots with IEEE rounding: its bits are those of the CPU
    int cpu;      // it has vector registers, so a work-item works in lanes; others have more work-items instead
    int unified;  // it works in the host's memory, so nothing is copied; may be set to 0
    char *log;    // of the last build when it failed, else ""
    char error[SSS_CL_MAX_ERROR];
} sss_cl;

// All devices, in the order of their numbers: first those that are not the CPU. With no device the result is
// SSS_CL_NO_DEVICE. `error` has room for SSS_CL_MAX_ERROR characters.
sss_cl_result sss_cl_list(sss_cl_devices *devices, char *error);

// Opens the device "opencl" (the first of the list) or "opencl:NUMBER" and builds the kernels; `more` is
// OpenCL C that is appended to them, or NULL. Call sss_cl_close() in every case.
sss_cl_result sss_cl_open(sss_cl *cl, const char *name, const char *more);
void sss_cl_close(sss_cl *cl);

// One lookup for each entry, as the tracer makes it: settings.plan, settings.light_aware and the scene's medium
// count. Entry i gets counts[i] exits from exits[i * room], room = max(settings.plan.exits, 1); what lies beyond
// is as it was.
sss_cl_result sss_cl_exits(sss_cl *cl, const scene *s, tracer_settings settings, size_t entries,
                           const sss_vec3 *positions, const sss_vec3 *normals, const uint32_t *seeds, int *counts,
                           sss_exit *exits);

// Adds samples first .. first + count - 1 of each pixel in rows top .. bottom - 1 to a picture of settings.width x
// settings.height pixels: rgb is the whole picture, three floats a pixel, begun black. What they cost is added to
// probes and shaded.
sss_cl_result sss_cl_render(sss_cl *cl, const scene *s, tracer_settings settings, int top, int bottom, uint32_t first,
                            uint32_t count, float *rgb, unsigned long long *probes, unsigned long long *shaded);

// For kernels of one's own: keeps the error line, and says whether the call went well.
int sss_cl_check(sss_cl *cl, cl_int code, const char *call);
// Runs a kernel over at least `count` items, in whole work-groups, and waits for it.
sss_cl_result sss_cl_run(sss_cl *cl, cl_kernel kernel, size_t count);
const char *sss_cl_error_name(cl_int code);

#endif
