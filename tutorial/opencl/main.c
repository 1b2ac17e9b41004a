// opencl - the same text on OpenCL. Appendix of the tutorial; SPDX-License-Identifier: MIT
// This file is compiled twice: by the C compiler and, when the program runs, by that of the OpenCL device.
#include "sss_resample.h"
// [languages]
#if defined(__OPENCL_VERSION__)
#define TABLE __constant
#define sqrtf sqrt
#else
#define TABLE static const
#endif
// [/languages]
// Change these and see what happens.
TABLE float ball[4][4] = {
    {0, -0.15f, 0, 0.85f}, {-0.64f, 0.55f, 0, 0.36f}, {0.64f, 0.55f, 0, 0.36f}, {0, -0.35f, 0.68f, 0.34f}};
enum { BALLS = 4, SIDE = 240, SAMPLES = 4 };
#define TO_SUN vector(-0.8295614f, 0.5184759f, 0.2073903f)
#define SUN    5.0f
#define SKY    0.4f

typedef struct crossing {
    float t;
    sss_vec3 y, n;
} crossing;

static sss_vec3 vector(float x, float y, float z) { return (sss_vec3){x, y, z}; }
static float inner(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static float squared(sss_vec3 a) { return inner(a, a); }
static sss_vec3 move(sss_vec3 o, sss_vec3 w, float t) { return vector(o.x + t * w.x, o.y + t * w.y, o.z + t * w.z); }
static sss_vec3 centre(int i) { return vector(ball[i][0], ball[i][1], ball[i][2]); }

static int all_hits(sss_vec3 o, sss_vec3 w, float t0, float t1, crossing *hits) {
    int count = 0;
    for (int i = 0; i < 2 * BALLS; i++) {
        sss_vec3 from = move(o, centre(i / 2), -1.0f);
        float r = ball[i / 2][3], b = inner(from, w);
        float rest = r * r - squared(move(from, w, -b)), reach = rest > 0.0f ? sqrtf(rest) : 0.0f;
        float t = (i % 2 ? reach : -reach) - b;
        sss_vec3 y = move(o, w, t);
        int seen = rest > 0.0f && t >= t0 && t <= t1;
        for (int k = 0; k < BALLS; k++)
            seen = seen && (k == i / 2 || squared(move(y, centre(k), -1)) > ball[k][3] * ball[k][3]);
        if (seen) hits[count++] = (crossing){t, y, move(y, centre(i / 2), -1.0f)};
    }
    return count;
}
static crossing first_hit(sss_vec3 o, sss_vec3 w) {
    crossing hits[2 * BALLS], best = {-1.0f, {0, 0, 0}, {0, 0, 0}};
    int count = all_hits(o, w, 1e-3f, 1e9f, hits);
    for (int i = 0; i < count; i++)
        if (best.t < 0.0f || hits[i].t < best.t) best = hits[i];
    return best;
}
static float facing(crossing h) { return inner(h.n, TO_SUN) > 0.0f ? inner(h.n, TO_SUN) / sqrtf(squared(h.n)) : 0.0f; }
static float irradiance(crossing h) { return first_hit(h.y, TO_SUN).t < 0.0f ? SUN * facing(h) + SKY : SKY; }

// [pixel]
// The sum of a pixel's samples.
static sss_vec3 pixel(sss_medium wax, uint32_t i) {
    sss_vec3 sum = vector(0.0f, 0.0f, 0.0f);
    for (uint32_t k = 0; k < SAMPLES; k++) {
        uint32_t seed = sss_hash(i, k);
        float u = (float)(sss_hash(seed, 1) >> 8) / 16777216.0f, v = (float)(sss_hash(seed, 2) >> 8) / 16777216.0f;
        float x = 0.36f * (((float)(i % SIDE) + u) / SIDE - 0.5f), y = 0.36f * (0.5f - ((float)(i / SIDE) + v) / SIDE);
        float far = sqrtf(x * x + y * y + 1.0f);
        crossing hits[2 * BALLS], entry = first_hit(vector(0.0f, 0.0f, 7.0f), vector(x / far, y / far, -1.0f / far));
        sss_resampler s;
        sss_probe p;
        sss_exit e;
        if (entry.t < 0.0f) sum = move(sum, vector(0.05f, 0.055f, 0.07f), 1.0f);
        if (entry.t < 0.0f) continue;
        sss_begin(&s, &wax, 0, entry.y, entry.n, seed);
        while (sss_next_probe(&s, &p)) {
            int count = all_hits(p.origin, p.direction, 0.0f, p.length, hits);
            for (int j = 0; j < count; j++) sss_add_hit(&s, hits[j].y, hits[j].n, SUN * facing(hits[j]) + SKY);
        }
        if (!sss_finish(&s, &e)) continue;
        entry.y = e.position, entry.n = e.normal;
        sum = move(sum, vector(e.weight[0], e.weight[1], e.weight[2]), irradiance(entry) / 3.14159265f);
    }
    return sum;
}
// [/pixel]

#if defined(__OPENCL_VERSION__)
// [kernel]
__kernel void render(sss_medium wax, __global sss_vec3 *picture) {
    picture[get_global_id(0)] = pixel(wax, (uint)get_global_id(0));
}
// [/kernel]
#else
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include "tutorial/tutorial.h"

static void stop_if(int wrong, const char *what, int code) {
    if (wrong) fprintf(stderr, "opencl: %s\n", what), exit(code);
}
static void show(sheet *s, int panel, int i, sss_vec3 sum) {
    vec colour = {(double)sum.x, (double)sum.y, (double)sum.z};
    sheet_pixel(s, panel, i % SIDE, i / SIDE, scale(colour, 1.0 / SAMPLES));
}

// [host]
static void render_on_device(sss_medium wax, sss_vec3 *picture) {
    const char *text = "#include \"tutorial/opencl/main.c\"\n", *options = "-cl-std=CL1.2 -I.";
    size_t count = SIDE * SIDE, group = 16, bytes = count * sizeof *picture;
    cl_platform_id platform;
    cl_device_id device;
    cl_device_fp_config can = 0;
    stop_if(clGetPlatformIDs(1, &platform, NULL) != CL_SUCCESS, "there is no OpenCL device: make setup", 3);
    stop_if(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 1, &device, NULL) != CL_SUCCESS, "no OpenCL device", 3);
    clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof can, &can, NULL);
    if (can & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) options = "-cl-std=CL1.2 -I. -cl-fp32-correctly-rounded-divide-sqrt";
    cl_context context = clCreateContext(NULL, 1, &device, NULL, NULL, NULL);
    cl_command_queue queue = clCreateCommandQueue(context, device, 0, NULL);
    cl_program program = clCreateProgramWithSource(context, 1, &text, NULL, NULL);
    stop_if(clBuildProgram(program, 1, &device, options, NULL, NULL) != CL_SUCCESS, "the kernel does not build", 1);
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
        show(&s, 0, i, i % SIDE < SIDE / 2 ? here[i] : there[i]);
        differ += memcmp(&here[i], &there[i], sizeof here[i]) != 0;
    }
    sheet_title(&s, 0, "by C     |     by OpenCL");
    printf("pixels whose bits differ: %d of %d\n", differ, SIDE * SIDE);
    return sheet_end(&s);
}
#endif
