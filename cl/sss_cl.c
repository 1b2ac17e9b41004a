// sss_cl.c - see sss_cl.h. SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "sss_cl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sss_cl_source.h"

// Without it a runtime may put a whole small batch into one group, and so on one core.
#define SSS_CL_LOCAL 64

// ---- Errors

const char *sss_cl_error_name(cl_int code) {
#define SSS_CL_NAME(name)                                                                          \
    case name: return #name;
    switch (code) {
        SSS_CL_NAME(CL_SUCCESS)
        SSS_CL_NAME(CL_DEVICE_NOT_FOUND)
        SSS_CL_NAME(CL_DEVICE_NOT_AVAILABLE)
        SSS_CL_NAME(CL_COMPILER_NOT_AVAILABLE)
        SSS_CL_NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE)
        SSS_CL_NAME(CL_OUT_OF_RESOURCES)
        SSS_CL_NAME(CL_OUT_OF_HOST_MEMORY)
        SSS_CL_NAME(CL_BUILD_PROGRAM_FAILURE)
        SSS_CL_NAME(CL_MAP_FAILURE)
        SSS_CL_NAME(CL_LINKER_NOT_AVAILABLE)
        SSS_CL_NAME(CL_LINK_PROGRAM_FAILURE)
        SSS_CL_NAME(CL_INVALID_VALUE)
        SSS_CL_NAME(CL_INVALID_PLATFORM)
        SSS_CL_NAME(CL_INVALID_DEVICE)
        SSS_CL_NAME(CL_INVALID_CONTEXT)
        SSS_CL_NAME(CL_INVALID_COMMAND_QUEUE)
        SSS_CL_NAME(CL_INVALID_MEM_OBJECT)
        SSS_CL_NAME(CL_INVALID_BINARY)
        SSS_CL_NAME(CL_INVALID_BUILD_OPTIONS)
        SSS_CL_NAME(CL_INVALID_PROGRAM)
        SSS_CL_NAME(CL_INVALID_PROGRAM_EXECUTABLE)
        SSS_CL_NAME(CL_INVALID_KERNEL_NAME)
        SSS_CL_NAME(CL_INVALID_KERNEL)
        SSS_CL_NAME(CL_INVALID_ARG_INDEX)
        SSS_CL_NAME(CL_INVALID_ARG_VALUE)
        SSS_CL_NAME(CL_INVALID_ARG_SIZE)
        SSS_CL_NAME(CL_INVALID_KERNEL_ARGS)
        SSS_CL_NAME(CL_INVALID_WORK_GROUP_SIZE)
        SSS_CL_NAME(CL_INVALID_GLOBAL_WORK_SIZE)
        SSS_CL_NAME(CL_INVALID_BUFFER_SIZE)
        SSS_CL_NAME(CL_INVALID_OPERATION)
    default: return "an error without a name here";
    }
#undef SSS_CL_NAME
}

int sss_cl_check(sss_cl *cl, cl_int code, const char *call) {
    if (code == CL_SUCCESS) return 1;
    snprintf(cl->error, sizeof cl->error, "%s: %s (%d)", call, sss_cl_error_name(code), (int)code);
    return 0;
}

// ---- Devices

static cl_int sss_cl_name_device(sss_cl_device *device) {
    char own[96] = "", platform[48] = "";
    cl_int code = clGetDeviceInfo(device->id, CL_DEVICE_NAME, sizeof own, own, NULL);
    if (code != CL_SUCCESS && code != CL_INVALID_VALUE)
        return code; // the latter: longer than there is room
    clGetPlatformInfo(device->platform, CL_PLATFORM_NAME, sizeof platform, platform, NULL);
    snprintf(device->name, sizeof device->name, "%s (%s)",
             own[0] ? own : "a device with a long name", platform);
    return CL_SUCCESS;
}

// Appends a platform's devices, either those that are the CPU or all others.
static cl_int sss_cl_add_devices(sss_cl_devices *devices, cl_platform_id platform, int cpu) {
    cl_device_id ids[SSS_CL_MAX_DEVICES];
    cl_uint count = 0;
    cl_int code = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, SSS_CL_MAX_DEVICES, ids, &count);
    if (code == CL_DEVICE_NOT_FOUND) return CL_SUCCESS;
    if (count > SSS_CL_MAX_DEVICES) count = SSS_CL_MAX_DEVICES;
    for (cl_uint i = 0; code == CL_SUCCESS && i < count; i++) {
        cl_device_type type = 0;
        code = clGetDeviceInfo(ids[i], CL_DEVICE_TYPE, sizeof type, &type, NULL);
        if (code != CL_SUCCESS || ((type & CL_DEVICE_TYPE_CPU) != 0) != cpu) continue;
        if (devices->count == SSS_CL_MAX_DEVICES) break;
        sss_cl_device *device = &devices->device[devices->count++];
        device->platform = platform;
        device->id = ids[i];
        code = sss_cl_name_device(device);
    }
    return code;
}

sss_cl_result sss_cl_list(sss_cl_devices *devices, char *error) {
    cl_platform_id platforms[SSS_CL_MAX_DEVICES];
    cl_uint count = 0;
    memset(devices, 0, sizeof *devices);
    // The loader answers with an error of its own when no platform is installed: that is no device,
    // too.
    if (clGetPlatformIDs(SSS_CL_MAX_DEVICES, platforms, &count) != CL_SUCCESS) count = 0;
    if (count > SSS_CL_MAX_DEVICES) count = SSS_CL_MAX_DEVICES;
    for (int cpu = 0; cpu < 2; cpu++) {
        for (cl_uint i = 0; i < count; i++) {
            cl_int code = sss_cl_add_devices(devices, platforms[i], cpu);
            if (code == CL_SUCCESS) continue;
            snprintf(error, SSS_CL_MAX_ERROR, "clGetDeviceIDs: %s (%d)", sss_cl_error_name(code),
                     (int)code);
            return SSS_CL_FAILED;
        }
    }
    if (devices->count > 0) return SSS_CL_OK;
    snprintf(error, SSS_CL_MAX_ERROR, "this machine has no OpenCL device");
    return SSS_CL_NO_DEVICE;
}

// The device that a name means.
static sss_cl_result sss_cl_find(sss_cl *cl, const char *name) {
    sss_cl_devices devices;
    const char *number = strncmp(name, "opencl:", 7) == 0 ? name + 7
                         : strcmp(name, "opencl") == 0    ? "0"
                                                          : "";
    size_t digits = strspn(number, "0123456789");
    if (digits == 0 || digits > 6 || number[digits] != '\0') {
        snprintf(cl->error, sizeof cl->error,
                 "a device is named opencl or opencl:NUMBER, not '%.64s'", name);
        return SSS_CL_BAD_DEVICE;
    }
    sss_cl_result result = sss_cl_list(&devices, cl->error);
    if (result != SSS_CL_OK) return result;
    int index = atoi(number);
    if (index >= devices.count) {
        snprintf(cl->error, sizeof cl->error,
                 "there is no device opencl:%d, the last one is opencl:%d", index,
                 devices.count - 1);
        return SSS_CL_BAD_DEVICE;
    }
    cl->device = devices.device[index];
    return SSS_CL_OK;
}

// ---- Opening

static void sss_cl_keep_log(sss_cl *cl) {
    size_t size = 0;
    if (clGetProgramBuildInfo(cl->program, cl->device.id, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) !=
        CL_SUCCESS) {
        return;
    }
    char *log = (char *)malloc(size + 1);
    if (!log) return;
    log[size] = '\0';
    if (clGetProgramBuildInfo(cl->program, cl->device.id, CL_PROGRAM_BUILD_LOG, size, log, NULL) ==
        CL_SUCCESS) {
        free(cl->log);
        cl->log = log;
    } else {
        free(log);
    }
}

static int sss_cl_build(sss_cl *cl, cl_uint count, const char *const *texts) {
    const char *text[1 + SSS_CL_MAX_TEXTS] = {(const char *)sss_cl_source};
    char options[160];
    cl_int code;
    if (count > SSS_CL_MAX_TEXTS) return sss_cl_check(cl, CL_INVALID_VALUE, "sss_cl_open");
    for (cl_uint i = 0; i < count; i++) text[1 + i] = texts[i];
    cl->program = clCreateProgramWithSource(cl->context, 1 + count, text, NULL, &code);
    if (!sss_cl_check(cl, code, "clCreateProgramWithSource")) return 0;
    snprintf(options, sizeof options,
             "-cl-std=CL1.2 -DSSS_MAX_EXITS=%d -DSSS_MAX_CANDIDATES=%d%s%s", SSS_MAX_EXITS,
             SSS_MAX_CANDIDATES, cl->cpu ? "" : " -DSSS_LANES=1",
             cl->exact ? " -cl-fp32-correctly-rounded-divide-sqrt" : "");
    code = clBuildProgram(cl->program, 1, &cl->device.id, options, NULL, NULL);
    if (code != CL_SUCCESS) sss_cl_keep_log(cl);
    return sss_cl_check(cl, code, "clBuildProgram");
}

// Bits as on the CPU need IEEE rounding of every operation and denormal numbers.
static int sss_cl_ask(sss_cl *cl) {
    const cl_device_fp_config wanted =
        CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT | CL_FP_DENORM | CL_FP_ROUND_TO_NEAREST;
    cl_device_fp_config has = 0;
    cl_int code =
        clGetDeviceInfo(cl->device.id, CL_DEVICE_SINGLE_FP_CONFIG, sizeof has, &has, NULL);
    if (!sss_cl_check(cl, code, "clGetDeviceInfo")) return 0;
    cl_bool unified = CL_FALSE;
    code = clGetDeviceInfo(cl->device.id, CL_DEVICE_HOST_UNIFIED_MEMORY, sizeof unified, &unified,
                           NULL);
    cl->exact = (has & wanted) == wanted;
    cl->unified = unified == CL_TRUE;
    if (!sss_cl_check(cl, code, "clGetDeviceInfo")) return 0;
    cl_device_type type = 0;
    code = clGetDeviceInfo(cl->device.id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
    cl->cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    return sss_cl_check(cl, code, "clGetDeviceInfo");
}

sss_cl_result sss_cl_open(sss_cl *cl, const char *name, cl_uint count, const char *const *texts) {
    cl_int code;
    memset(cl, 0, sizeof *cl);
    cl->local = SSS_CL_LOCAL;
    cl->log = (char *)calloc(1, 1);
    if (!cl->log) {
        snprintf(cl->error, sizeof cl->error, "out of memory");
        return SSS_CL_FAILED;
    }
    sss_cl_result result = sss_cl_find(cl, name);
    if (result != SSS_CL_OK) return result;
    if (!sss_cl_ask(cl)) return SSS_CL_FAILED;
    cl->context = clCreateContext(NULL, 1, &cl->device.id, NULL, NULL, &code);
    if (!sss_cl_check(cl, code, "clCreateContext")) return SSS_CL_FAILED;
    cl->queue = clCreateCommandQueue(cl->context, cl->device.id, 0, &code);
    if (!sss_cl_check(cl, code, "clCreateCommandQueue")) return SSS_CL_FAILED;
    return sss_cl_build(cl, count, texts) ? SSS_CL_OK : SSS_CL_FAILED;
}

void sss_cl_close(sss_cl *cl) {
    if (cl->program) clReleaseProgram(cl->program);
    if (cl->queue) clReleaseCommandQueue(cl->queue);
    if (cl->context) clReleaseContext(cl->context);
    free(cl->log);
    memset(cl, 0, sizeof *cl);
}

// ---- Work

cl_kernel sss_cl_kernel(sss_cl *cl, const char *name) {
    cl_int code;
    cl_kernel kernel = clCreateKernel(cl->program, name, &code);
    return sss_cl_check(cl, code, "clCreateKernel") ? kernel : NULL;
}

sss_cl_result sss_cl_run(sss_cl *cl, cl_kernel kernel, size_t count) {
    size_t most = 0, local = cl->local;
    if (count == 0) return SSS_CL_OK;
    cl_int code = clGetKernelWorkGroupInfo(kernel, cl->device.id, CL_KERNEL_WORK_GROUP_SIZE,
                                           sizeof most, &most, NULL);
    if (!sss_cl_check(cl, code, "clGetKernelWorkGroupInfo")) return SSS_CL_FAILED;
    if (local > most) local = most;
    size_t global = (count + local - 1) / local * local;
    code = clEnqueueNDRangeKernel(cl->queue, kernel, 1, NULL, &global, &local, 0, NULL, NULL);
    if (!sss_cl_check(cl, code, "clEnqueueNDRangeKernel")) return SSS_CL_FAILED;
    return sss_cl_check(cl, clFinish(cl->queue), "clFinish") ? SSS_CL_OK : SSS_CL_FAILED;
}

int sss_cl_set(sss_cl *cl, cl_kernel kernel, cl_uint first, const sss_cl_argument *arguments,
               cl_uint count) {
    for (cl_uint i = 0; i < count; i++) {
        cl_int code = clSetKernelArg(kernel, first + i, arguments[i].size, arguments[i].value);
        if (!sss_cl_check(cl, code, "clSetKernelArg")) return 0;
    }
    return 1;
}

cl_mem sss_cl_buffer(sss_cl *cl, size_t size, const void *host) {
    cl_int code;
    // A buffer that no kernel writes never changes its source, but the call takes what is not
    // const.
    union {
        const void *in;
        void *out;
    } source;
    source.in = host;
    cl_mem_flags flags =
        CL_MEM_READ_WRITE | (cl->unified ? CL_MEM_USE_HOST_PTR : CL_MEM_COPY_HOST_PTR);
    cl_mem buffer = clCreateBuffer(cl->context, flags, size, source.out, &code);
    return sss_cl_check(cl, code, "clCreateBuffer") ? buffer : NULL;
}

int sss_cl_read(sss_cl *cl, cl_mem buffer, size_t size, void *host) {
    cl_int code;
    if (!cl->unified) {
        code = clEnqueueReadBuffer(cl->queue, buffer, CL_TRUE, 0, size, host, 0, NULL, NULL);
        return sss_cl_check(cl, code, "clEnqueueReadBuffer");
    }
    void *same =
        clEnqueueMapBuffer(cl->queue, buffer, CL_TRUE, CL_MAP_READ, 0, size, 0, NULL, NULL, &code);
    if (!sss_cl_check(cl, code, "clEnqueueMapBuffer")) return 0;
    code = clEnqueueUnmapMemObject(cl->queue, buffer, same, 0, NULL, NULL);
    return sss_cl_check(cl, code, "clEnqueueUnmapMemObject") &&
           sss_cl_check(cl, clFinish(cl->queue), "clFinish");
}

void sss_cl_release(cl_mem *buffers, int count) {
    for (int i = 0; i < count; i++) {
        if (buffers[i]) clReleaseMemObject(buffers[i]);
        buffers[i] = NULL;
    }
}

sss_cl_result sss_cl_lookups(sss_cl *cl, cl_kernel kernel, const sss_cl_batch *batch,
                             const sss_cl_argument *own, cl_uint count) {
    enum { POSITIONS, NORMALS, SEEDS, COUNTS, EXITS, BUFFERS };
    cl_mem b[BUFFERS] = {0};
    cl_uint entries = (cl_uint)batch->entries;
    const size_t vector_size = sizeof(sss_vec3) * batch->entries,
                 count_size = sizeof(int) * batch->entries,
                 exit_size = sizeof(sss_exit) * batch->entries * batch->room;
    const sss_cl_argument arguments[] = {
        {sizeof entries, &entries},   {sizeof batch->room, &batch->room},
        {sizeof b[0], &b[POSITIONS]}, {sizeof b[0], &b[NORMALS]},
        {sizeof b[0], &b[SEEDS]},     {sizeof b[0], &b[COUNTS]},
        {sizeof b[0], &b[EXITS]}};
    enum { ARGUMENTS = sizeof arguments / sizeof *arguments };
    if (entries == 0) return SSS_CL_OK;
    int good = (b[POSITIONS] = sss_cl_buffer(cl, vector_size, batch->positions)) &&
               (b[NORMALS] = sss_cl_buffer(cl, vector_size, batch->normals)) &&
               (b[SEEDS] = sss_cl_buffer(cl, sizeof(uint32_t) * batch->entries, batch->seeds)) &&
               (b[COUNTS] = sss_cl_buffer(cl, count_size, batch->counts)) &&
               (b[EXITS] = sss_cl_buffer(cl, exit_size, batch->exits)) &&
               sss_cl_set(cl, kernel, 0, arguments, ARGUMENTS) &&
               sss_cl_set(cl, kernel, ARGUMENTS, own, count) &&
               sss_cl_run(cl, kernel, batch->entries) == SSS_CL_OK &&
               sss_cl_read(cl, b[COUNTS], count_size, batch->counts) &&
               sss_cl_read(cl, b[EXITS], exit_size, batch->exits);
    sss_cl_release(b, BUFFERS);
    return good ? SSS_CL_OK : SSS_CL_FAILED;
}
