// sss_cl.h - batches of lookups on OpenCL devices, for C99 programs. SPDX-License-Identifier: MIT
//
// clang-format off
//     sss_cl cl;
//     cl_kernel lookups;
//     if (sss_cl_open(&cl, "opencl", 1, &text) != SSS_CL_OK) {
//         fputs(cl.log, stderr);
//         puts(cl.error);
//     } else if ((lookups = sss_cl_kernel(&cl, "lookups"))) {
//         sss_cl_lookups(&cl, lookups, &batch, own, own_count);
//     }
//     sss_cl_close(&cl);
// clang-format on
//
// Build sss_cl.c into the program and link with -lOpenCL. The text of sss_resample.h is inside: no
// file is read at run time. The kernels are the program's own, as only the program knows how its
// probes meet its scene; demos/common/tracer.cl and tracer_cl.h are an example. A call that fails
// leaves one line in cl.error, which names the OpenCL call and its error; nothing is printed here.
// The same sss_cl serves one thread at a time; different ones do not know of each other.
#ifndef SSS_CL_H
#define SSS_CL_H

#ifndef CL_TARGET_OPENCL_VERSION
#define CL_TARGET_OPENCL_VERSION 120
#endif
#include <CL/cl.h>
#include <stddef.h>

#include "sss_resample.h"

// A program's exit codes, as they stand.
typedef enum sss_cl_result {
    SSS_CL_OK = 0,
    SSS_CL_FAILED = 1, // an OpenCL call failed, or there is no memory
    SSS_CL_BAD_DEVICE =
        2, // the device's name is not of the form below, or there is no device of that number
    SSS_CL_NO_DEVICE = 3 // this machine has no OpenCL device at all
} sss_cl_result;

typedef struct sss_cl_device {
    cl_platform_id platform;
    cl_device_id id;
    char name[160]; // of the device and its platform
} sss_cl_device;

#define SSS_CL_MAX_DEVICES 32
#define SSS_CL_MAX_ERROR   512
#define SSS_CL_MAX_TEXTS   8

typedef struct sss_cl_devices {
    int count;
    sss_cl_device device[SSS_CL_MAX_DEVICES];
} sss_cl_devices;

typedef struct sss_cl {
    sss_cl_device device;
    cl_context context;
    cl_command_queue queue;
    cl_program program;
    size_t local; // work-items in a group, chosen at opening; may be changed
    int exact; // the device divides and takes roots with IEEE rounding: its bits are those of the
               // CPU
    int cpu; // it has vector registers, so a work-item works in lanes; others have more work-items
             // instead
    int unified; // it works in the host's memory, so nothing is copied; may be set to 0
    char *log;   // of the last build when it failed, else ""
    char error[SSS_CL_MAX_ERROR];
} sss_cl;

// All devices, in the order of their numbers: first those that are not the CPU. With no device the
// result is SSS_CL_NO_DEVICE. `error` has room for SSS_CL_MAX_ERROR characters.
sss_cl_result sss_cl_list(sss_cl_devices *devices, char *error);

// Opens the device "opencl" (the first of the list) or "opencl:NUMBER" and builds one program from
// sss_resample.h and the `count` texts of OpenCL C that follow it in this order, SSS_CL_MAX_TEXTS
// at most. Call sss_cl_close() in every case.
sss_cl_result sss_cl_open(sss_cl *cl, const char *name, cl_uint count, const char *const *texts);
void sss_cl_close(sss_cl *cl);

// A kernel of the program, or NULL; release it with clReleaseKernel() before sss_cl_close().
cl_kernel sss_cl_kernel(sss_cl *cl, const char *name);

typedef struct sss_cl_argument {
    size_t size;
    const void *value;
} sss_cl_argument;

// One lookup for each entry. Entry i gets counts[i] exits from exits[i * room]; what lies beyond is
// as it was. No plan may ask for more exits than `room`, which is at least 1.
typedef struct sss_cl_batch {
    size_t entries;
    cl_uint room;
    const sss_vec3 *positions, *normals;
    const uint32_t *seeds;
    int *counts;
    sss_exit *exits;
} sss_cl_batch;

// Runs the batch through a kernel whose parameters begin with
//     uint entries, uint room,
//     __global const sss_vec3 *positions, __global const sss_vec3 *normals,
//     __global const uint *seeds, __global int *counts, __global sss_exit *exits
// and end with `count` of the program's own. The global size is rounded up to whole work-groups.
sss_cl_result sss_cl_lookups(sss_cl *cl, cl_kernel kernel, const sss_cl_batch *batch,
                             const sss_cl_argument *own, cl_uint count);

// ---- For other kernels. Those that return an int say whether the call went well.

int sss_cl_check(sss_cl *cl, cl_int code, const char *call); // keeps the error line
const char *sss_cl_error_name(cl_int code);

// A buffer that holds what `host` does, NULL when that fails. A device that shares the host's
// memory works in `host` itself; both ways sss_cl_read() brings the results there.
cl_mem sss_cl_buffer(sss_cl *cl, size_t size, const void *host);
int sss_cl_read(sss_cl *cl, cl_mem buffer, size_t size, void *host);
void sss_cl_release(cl_mem *buffers, int count); // those that are not NULL

// Sets a kernel's arguments from number `first`.
int sss_cl_set(sss_cl *cl, cl_kernel kernel, cl_uint first, const sss_cl_argument *arguments,
               cl_uint count);
// Runs a kernel over at least `count` items, in whole work-groups, and waits for it.
sss_cl_result sss_cl_run(sss_cl *cl, cl_kernel kernel, size_t count);

#endif
