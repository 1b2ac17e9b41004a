// opencl - the same text on OpenCL. Appendix of the tutorial; SPDX-License-Identifier: MIT
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include "tutorial/pixel.h"
#include "tutorial/tutorial.h"

static void stop_if(int wrong, const char *what, int code) {
    if (wrong) fprintf(stderr, "opencl: %s\n", what), exit(code);
}

// [host]
static void render_on_device(sss_medium wax, sss_vec3 *picture) {
    static const char exact[] = "-cl-std=CL1.2 -I. -cl-fp32-correctly-rounded-divide-sqrt";
    const char *text = "#include \"tutorial/pixel.h\"\n", *options = "-cl-std=CL1.2 -I.";
    size_t count = SIDE * SIDE, group = 16, bytes = count * sizeof *picture;
    cl_platform_id platform;
    cl_device_id device;
    cl_device_fp_config can = 0;

    stop_if(clGetPlatformIDs(1, &platform, NULL) != CL_SUCCESS, "no OpenCL device: make setup", 3);
    cl_int found = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL);
    stop_if(found != CL_SUCCESS, "no OpenCL device: make setup", 3);
    clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof can, &can, NULL);
    if (can & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) options = exact;

    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
    cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
    cl_program program = clCreateProgramWithSource(context, 1, &text, NULL, NULL);
    cl_int built = clBuildProgram(program, 1, &device, options, NULL, NULL);
    stop_if(built != CL_SUCCESS, "the kernel does not build", 1);

    cl_kernel kernel = clCreateKernel(program, "render", NULL);
    cl_mem buffer = clCreateBuffer(context, CL_MEM_WRITE_ONLY, bytes, NULL, NULL);
    clSetKernelArg(kernel, 0, sizeof wax, &wax);
    clSetKernelArg(kernel, 1, sizeof buffer, &buffer);
    clEnqueueNDRangeKernel(queue, kernel, 1, NULL, &count, &group, 0, NULL, NULL);
    cl_int read = clEnqueueReadBuffer(queue, buffer, CL_TRUE, 0, bytes, picture, 0, NULL, NULL);
    stop_if(read != CL_SUCCESS, "the kernel does not run", 1);
}
// [/host]

int main(int argc, char **argv) {
    static sss_vec3 here[SIDE * SIDE], there[SIDE * SIDE];
    static const float albedo[3] = {0.8f, 0.5f, 0.35f}, dmfp[3] = {2.0f, 0.35f, 0.15f};
    sheet s = sheet_begin(argc, argv, 1, SIDE, SIDE);
    sss_medium wax;
    int differ = 0;

    sss_burley(&wax, albedo, dmfp);
    render_on_device(wax, there);
    for (int i = 0; i < SIDE * SIDE; i++) {
        here[i] = pixel(wax, (uint32_t)i);
        sss_vec3 sum = i % SIDE < SIDE / 2 ? here[i] : there[i];
        vec colour = scale((vec){(double)sum.x, (double)sum.y, (double)sum.z}, 1.0 / SAMPLES);
        sheet_pixel(&s, 0, i % SIDE, i / SIDE, colour);
        differ += memcmp(&here[i], &there[i], sizeof here[i]) != 0;
    }
    sheet_title(&s, 0, "by C     |     by OpenCL");
    printf("pixels whose bits differ: %d of %d\n", differ, SIDE * SIDE);
    return sheet_end(&s);
}
