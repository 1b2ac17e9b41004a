// mesh_share.c - what sharing exits brings on a mesh, where rays take nearly all of the time: noise
// and time of one core against the default plan, over media from narrower than a pixel to much
// wider. SPDX-License-Identifier: MIT
#define _XOPEN_SOURCE 700

#define COMMAND "mesh_share"
#include "demos/common/command.h"
#include "demos/common/mesh_tracer.h"

enum { AROUND = 250, ACROSS = 100, SIDE = 128, SPP = 8, METHODS = 3, MEDIA = 8 };
static const char *const method_name[METHODS] = {"default", "default, told", "shared, told"};

static mesh_world world;
static unsigned char mask[SIDE * SIDE]; // pixels that show nothing but the object

// A torus with a wave about it, 50,000 triangles.
static void make_torus(void) {
    static float xyz[3 * AROUND * ACROSS];
    static uint32_t corner[6 * AROUND * ACROSS];
    for (uint32_t i = 0; i < AROUND * ACROSS; i++) {
        uint32_t u = i / ACROSS, v = i % ACROSS, next = (u + 1) % AROUND, up = (v + 1) % ACROSS;
        double a = 2.0 * 3.14159265358979 * u / AROUND, b = 2.0 * 3.14159265358979 * v / ACROSS;
        double r = 0.4 + 0.03 * sin(9.0 * a + 5.0 * b);
        const uint32_t two[6] = {i, next * ACROSS + v,  next * ACROSS + up,
                                 i, next * ACROSS + up, u * ACROSS + up};
        xyz[3 * i] = (float)((1.0 + r * cos(b)) * cos(a));
        xyz[3 * i + 1] = (float)(r * sin(b));
        xyz[3 * i + 2] = (float)((1.0 + r * cos(b)) * sin(a));
        memcpy(corner + 6 * i, two, sizeof two);
    }
    const char *wrong = mesh_make(&world.m, xyz, AROUND * ACROSS, corner, 2 * AROUND * ACROSS);
    if (!wrong) wrong = mesh_open(&world);
    if (wrong) fail(1, "%s", wrong);
}

// As in mesh.c: the lamp behind the object, the sky in front.
static void set_scene(void) {
    scene *s = &world.s;
    float r = (float)MESH_RADIUS, turn = -98.0f * (SCENE_PI / 180.0f);
    sss_vec3 middle = scene_vec(0.0f, (float)(0.5 * world.m.size[1] * world.m.unit), 0.0f);
    sss_vec3 lamp = scene_vec(2.6f * r * sinf(turn), middle.y + 2.2f * r, 2.6f * r * cosf(turn));
    s->floor_lit = 0.6f;
    s->sky_horizon = scene_vec(0.36f, 0.40f, 0.46f);
    s->sky_zenith = scene_vec(0.30f, 0.36f, 0.46f);
    s->floor_albedo = scene_vec(0.27f, 0.24f, 0.215f);
    scenes_light(s, lamp, middle, 0.5f * r, scene_vec(64.0f, 58.0f, 49.0f));
    scenes_camera(s,
                  scene_along(middle, scene_normalize(scene_vec(0.475f, 0.3f, 0.817f)), 5.2f * r),
                  middle, 22.0f);
}

static int shows_object(int x, int y) {
    for (int i = 0; i < 25; i++) {
        float px = (float)x + 0.25f * (float)(i % 5), py = (float)y + 0.25f * (float)(i / 5);
        sss_vec3 d = tracer_camera(&world.s, SIDE, SIDE, px, py);
        if (mesh_nearest(&world, world.s.eye, d, NULL).geometry != MESH_OBJECT) return 0;
    }
    return 1;
}

static void add_sample(tracer_settings settings, uint32_t sample, mesh_hits *hits, float *rgb) {
    int tiles = tracer_tile_side(settings) > 1;
    int columns = tiles ? tracer_tile_count(settings, sample, 0) : SIDE;
    int rows = tiles ? tracer_tile_count(settings, sample, 1) : SIDE;
    for (int unit = 0; unit < columns * rows; unit++) {
        sss_vec3 radiance[TRACER_TILE_PIXELS];
        int x = unit % columns, y = unit / columns, count = tiles ? TRACER_TILE_PIXELS : 1;
        if (tiles) mesh_tile_sample(&world, settings, x, y, sample, hits, radiance);
        else radiance[0] = mesh_sample(&world, settings, x, y, sample, hits).radiance;
        for (int i = 0; i < count; i++) {
            int px = x, py = y;
            if (tiles && !tracer_tile_pixel(settings, sample, x, y, i, &px, &py)) continue;
            float *to = rgb + 3 * (py * SIDE + px);
            to[0] += radiance[i].x;
            to[1] += radiance[i].y;
            to[2] += radiance[i].z;
        }
    }
}

// The squared error of 16 samples a pixel over the mean square, by the difference of two halves,
// and the seconds of the processor that they take.
static double measure(tracer_settings settings, double *seconds) {
    static float half[2][3 * SIDE * SIDE];
    mesh_hits hits = {0, 0, NULL};
    struct timespec start, end;
    double squares = 0.0, power = 0.0;
    memset(half, 0, sizeof half);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    for (uint32_t k = 0; k < 2 * SPP; k++) {
        settings.seed = 1u + k % 2;
        add_sample(settings, k / 2, &hits, half[k % 2]);
    }
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    *seconds = (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
    for (int i = 0; i < 3 * SIDE * SIDE; i++) {
        if (!mask[i / 3]) continue;
        double difference = (double)half[0][i] - (double)half[1][i];
        squares += difference * difference;
        power += (double)half[0][i] * (double)half[1][i];
    }
    free(hits.hit);
    return squares / power / 4.0;
}

static void set_method(tracer_settings *settings, int method, float footprint) {
    memset(&settings->plan, 0, sizeof settings->plan);
    settings->light_aware = method > 0;
    if (method < 2) return;
    sss_plan advice = tracer_sharing(&world.s.medium, footprint, 1);
    settings->plan.tile = 8; // also where the plan advises none
    settings->plan.candidates = advice.candidates;
    settings->plan.per_channel = advice.per_channel;
}

int main(void) {
    static const float pixels[MEDIA / 2] = {60.0f, 20.0f, 5.0f, 1.5f},
                                      part[3] = {1.0f, 0.4f, 0.17f};
    static const float colours[3] = {0.93f, 0.42f, 0.14f}, grey[3] = {0.5f, 0.5f, 0.5f};
    tracer_settings settings;
    make_torus();
    set_scene();
    memset(&settings, 0, sizeof settings);
    settings.method = TRACER_RESAMPLED;
    settings.width = settings.height = SIDE;
    for (int i = 0; i < SIDE * SIDE; i++) mask[i] = (unsigned char)shows_object(i % SIDE, i / SIDE);
    float pixel = tracer_footprint(&world.s, settings, scene_vec(0.0f, 0.0f, 0.0f));

    printf("%u triangles, %d samples a pixel; error over the default's in equal time\n",
           world.m.triangles, 2 * SPP);
    for (int k = 0; k < MEDIA; k++) {
        int is_grey = k < MEDIA / 2;
        float dmfp[3];
        double error[METHODS], seconds[METHODS];
        for (int c = 0; c < 3; c++)
            dmfp[c] = pixels[k % (MEDIA / 2)] * pixel * (is_grey ? 1.0f : part[c]);
        sss_burley(&world.s.medium, is_grey ? grey : colours, dmfp);
        const float *d = world.s.medium.length;
        printf("%s, dmfp up to %4.1f pixels, length %5.2f %5.2f %5.2f:",
               is_grey ? "grey  " : "colour", (double)pixels[k % (MEDIA / 2)],
               (double)(d[0] / pixel), (double)(d[1] / pixel), (double)(d[2] / pixel));
        for (int i = 0; i < METHODS; i++) {
            set_method(&settings, i, pixel);
            error[i] = measure(settings, &seconds[i]);
            printf("  %s %.5f in %.2f s (%.3f)", method_name[i], error[i], seconds[i],
                   error[i] * seconds[i] / (error[0] * seconds[0]));
        }
        printf("\n");
        fflush(stdout);
    }
    mesh_close(&world);
    return 0;
}
