// figures.c - what the live figures of the page ask of sss_resample.h: compiled to WebAssembly for
// the page, and with a main of its own (-DNATIVE) to the program that the test of the page compares
// with. SPDX-License-Identifier: MIT
//
// No libc and no libm: sqrt is an instruction, and exp, log, sine and cosine are the header's own.
// So the page computes the same bits as the native program. Each figure has its section; they share
// the random numbers and the media.
#ifdef NATIVE
#include <stdio.h>
#include <stdlib.h>
#define EXPORT(name)
#else
#define EXPORT(name) __attribute__((export_name(#name)))
#endif

#include "sss_resample.h"

enum { BALLS_FROM = 10, BALLS = 4, MEDIA = BALLS_FROM + BALLS };

static sss_medium medium[MEDIA]; // by the number of the figure; balls have their own

// ---- Shared: random numbers, vectors, media

static uint32_t random_seed, random_count;

static void random_begin(uint32_t seed) {
    random_seed = seed;
    random_count = 0;
}

// Uniform in (0, 1).
static float rnd(void) {
    uint32_t bits = sss_hash(random_seed, random_count++);
    return ((float)(bits >> 9) + 0.5f) * 1.1920929e-7f;
}

static float square_root(float x) { return __builtin_sqrtf(x); }
static float positive(float x) { return x > 0.0f ? x : 0.0f; }

static sss_vec3 vec(float x, float y, float z) {
    sss_vec3 v = {x, y, z};
    return v;
}
static sss_vec3 along(sss_vec3 o, sss_vec3 d, float t) {
    return vec(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
}
static float dot(sss_vec3 a, sss_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static float distance(sss_vec3 a, sss_vec3 b) {
    sss_vec3 v = along(b, a, -1.0f);
    return square_root(dot(v, v));
}

static sss_vec3 on_sphere(void) {
    float z = 1.0f - 2.0f * rnd(), rim = square_root(positive(1.0f - z * z)), s, c;
    sssi_sincos_turn(rnd(), &s, &c);
    return vec(rim * c, rim * s, z);
}

// Returns 0, or the number of the error.
EXPORT(set_burley)
int set_burley(int figure, float red, float green, float blue, float dmfp_red, float dmfp_green,
               float dmfp_blue) {
    float albedo[3] = {red, green, blue}, dmfp[3] = {dmfp_red, dmfp_green, dmfp_blue};
    return (int)sss_burley(&medium[figure], albedo, dmfp);
}

EXPORT(set_burley_mfp)
int set_burley_mfp(int figure, float red, float green, float blue, float mfp) {
    float albedo[3] = {red, green, blue}, path[3] = {mfp, mfp, mfp};
    return (int)sss_burley_mfp(&medium[figure], albedo, path);
}

EXPORT(profile)
float profile(int figure, int channel, float r) { return sss_profile(&medium[figure], channel, r); }

EXPORT(within)
float within(int figure, int channel, float r) { return sss_within(&medium[figure], channel, r); }

// Probes and hits that a figure draws: x and z of both ends; x, z, distance from the entry, weight,
// number of the probe.
enum { DRAWN = 4096 };
static float probe_ends[DRAWN][6];
static float hit_list[DRAWN][6];
static int probes_drawn, hits_drawn;

EXPORT(probe_data)
float *probe_data(void) { return &probe_ends[0][0]; }
EXPORT(probe_count)
int probe_count(void) { return probes_drawn; }
EXPORT(hit_data)
float *hit_data(void) { return &hit_list[0][0]; }
EXPORT(hit_count)
int hit_count(void) { return hits_drawn; }

static void draw_probe(const sss_probe *p) {
    if (probes_drawn == DRAWN) return;
    sss_vec3 end = along(p->origin, p->direction, p->length);
    float *to = probe_ends[probes_drawn++];
    to[0] = p->origin.x;
    to[1] = p->origin.y;
    to[2] = p->origin.z;
    to[3] = end.x;
    to[4] = end.y;
    to[5] = end.z;
}
static void draw_hit(sss_vec3 y, float r, float weight) {
    if (hits_drawn == DRAWN) return;
    float *to = hit_list[hits_drawn++];
    to[0] = y.x;
    to[1] = y.y;
    to[2] = y.z;
    to[3] = r;
    to[4] = weight;
    to[5] = (float)(probes_drawn - 1);
}

// What the samples of an estimator add up to.
typedef struct tally {
    double count, sum, squares;
    float largest;
} tally;

static void count_sample(tally *t, double value) {
    t->count += 1;
    t->sum += value;
    t->squares += value * value;
}
static double tally_mean(const tally *t) { return t->count > 0 ? t->sum / t->count : 0; }
static double tally_variance(const tally *t) { // relative: over the square of the mean
    double mean = tally_mean(t);
    return mean > 0 ? t->squares / t->count / (mean * mean) - 1 : 0;
}
static double tally_error(const tally *t) { // one standard error of the mean
    double mean = tally_mean(t);
    return t->count > 0 ? __builtin_sqrt((t->squares / t->count - mean * mean) / t->count) : 0;
}

// ---- Figure 1: a walk through a half space, depth downwards

enum { PATH_MAX = 600, WALK_BINS = 48 };
static float path[PATH_MAX][2];
static double
    walk_bin[2][WALK_BINS]; // exits to the left and to the right of the laser, by their distance
static float walk_survival, walk_mfp, walk_width;
static double walks, walks_back;

// The albedo of one scattering for which a half space has this diffuse albedo: the exact value's
// fit, inverted.
static float scattering_albedo(float diffuse) {
    float low = 0.0f, high = 1.0f;
    for (int i = 0; i < 40; i++) {
        float s = 0.5f * (low + high);
        float a = (1.0f - s) * (1.0f + s * (0.38313089f - 0.00319767f * s)) /
                  (1.0f + s * (1.69256344f + 0.6802289f * s));
        if (a > diffuse) low = s;
        else high = s;
    }
    return 1.0f - low * low;
}

EXPORT(walk_begin)
void walk_begin(float albedo, float mfp, float bin_width, uint32_t seed) {
    walk_survival = scattering_albedo(albedo);
    walk_mfp = mfp;
    walk_width = bin_width;
    walks = walks_back = 0;
    for (int i = 0; i < WALK_BINS; i++) walk_bin[0][i] = walk_bin[1][i] = 0;
    random_begin(seed);
    set_burley_mfp(1, albedo, albedo, albedo, mfp);
}

// One walk. Returns how many points of it are in `path`; the last one has depth 0 if the light came
// back.
EXPORT(walk_one)
int walk_one(void) {
    sss_vec3 x = vec(0.0f, 0.0f, 0.0f), d = on_sphere();
    int points = 1;

    d.z += 1.0f; // cosine-distributed about the axis that points down
    d = along(vec(0.0f, 0.0f, 0.0f), d, 1.0f / (square_root(dot(d, d)) + 1e-9f));
    path[0][0] = path[0][1] = 0.0f;
    walks += 1;
    for (;;) {
        float step = -walk_mfp * sssi_log(rnd());
        int out = x.z + step * d.z < 0.0f;
        if (out) step = -x.z / d.z;
        x = along(x, d, step);
        if (points < PATH_MAX || out) {
            float *to = path[points < PATH_MAX ? points++ : PATH_MAX - 1];
            to[0] = x.x;
            to[1] = out ? 0.0f : x.z;
        }
        if (out) break;
        if (rnd() > walk_survival) return points;
        d = on_sphere();
    }

    walks_back += 1;
    int bin = (int)(square_root(x.x * x.x + x.y * x.y) / walk_width);
    if (bin < WALK_BINS) walk_bin[x.x > 0.0f][bin] += 1;
    return points;
}

EXPORT(walk_many)
void walk_many(int count) {
    while (count-- > 0) walk_one();
}
EXPORT(walk_path)
float *walk_path(void) { return &path[0][0]; }
EXPORT(walk_bins)
double *walk_bins(void) { return &walk_bin[0][0]; }
EXPORT(walk_count)
double walk_count(void) { return walks; }
EXPORT(walk_returned)
double walk_returned(void) { return walks_back; }

// ---- Figure 2: a ball of radius 1 in the sun, without noise

// On a ball the area within the distance r is pi r^2, and the light that arrives there is a mean
// over a ring. So the exitance is a sum over rings, and depends on the angle to the sun alone: a
// table over its cosine.
enum { COSINES = 256, RINGS = 128, TURNS = 64, BALL_MAX = 720, TONES = 4096 };
static float ring_light[COSINES][RINGS]; // the mean over the ring of max(0, cosine)
static float ball_exitance[BALLS][COSINES][3];
static const float EXPOSURE = 1.25f;
static unsigned char ball_pixel[BALL_MAX * BALL_MAX * 4];
static unsigned char tone[TONES];

static float ring_radius(int i) {
    float x = (float)i / RINGS;
    return 2.0f * x * x;
}

static unsigned char to_byte(float linear) {
    float x = linear > 1.0f ? 1.0f : linear;
    x = x < 0.0031308f ? 12.92f * x : 1.055f * sssi_exp(sssi_log(x) / 2.4f) - 0.055f;
    return (unsigned char)(255.0f * x + 0.5f);
}

static float ring_mean(float cosine, float r) {
    float turn_cosine = 1.0f - 0.5f * r * r,
          turn_sine = square_root(positive(1.0f - turn_cosine * turn_cosine));
    float sine = square_root(positive(1.0f - cosine * cosine)), sum = 0.0f;
    for (int i = 0; i < TURNS; i++) {
        float s, c;
        sssi_sincos_turn(((float)i + 0.5f) / (2 * TURNS), &s, &c);
        sum += positive(turn_cosine * cosine + turn_sine * sine * c);
    }
    return sum / TURNS;
}

EXPORT(ball_begin)
void ball_begin(void) {
    for (int i = 0; i < TONES; i++) tone[i] = to_byte((float)i / (TONES - 1));
    for (int i = 0; i < COSINES; i++)
        for (int k = 0; k < RINGS; k++)
            ring_light[i][k] = ring_mean(2.0f * (float)i / (COSINES - 1) - 1.0f,
                                         0.5f * (ring_radius(k) + ring_radius(k + 1)));
}

// The table of a ball anew, for the medium BALLS_FROM + ball and the light of a sky. A channel of
// length 0 is Lambert.
EXPORT(ball_set)
void ball_set(int ball, float sky) {
    int from = BALLS_FROM + ball;
    for (int c = 0; c < 3; c++) {
        float share[RINGS], from_sky = sky * within(from, c, 2.0f);
        int lambert = !(profile(from, c, 1.0f) > 0.0f);
        for (int k = 0; k < RINGS; k++)
            share[k] = within(from, c, ring_radius(k + 1)) - within(from, c, ring_radius(k));
        for (int i = 0; i < COSINES; i++) {
            float sum = 0.0f;
            for (int k = 0; k < RINGS; k++) sum += share[k] * ring_light[i][k];
            if (lambert)
                sum = within(from, c, 1.0f) * positive(2.0f * (float)i / (COSINES - 1) - 1.0f);
            ball_exitance[ball][i][c] = sum + from_sky;
        }
    }
}

// What leaves a ball where the sun has this cosine: all three channels.
static sss_vec3 ball_colour(int ball, float cosine) {
    float x = (0.5f + 0.5f * cosine) * (COSINES - 1), last = COSINES - 1.0001f;
    int i = (int)(x = x > last ? last : positive(x));
    const float *a = ball_exitance[ball][i], *b = ball_exitance[ball][i + 1];
    float t = x - (float)i;
    return vec(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]));
}

EXPORT(ball_light)
float ball_light(int ball, int channel, float cosine) {
    sss_vec3 light = ball_colour(ball, cosine);
    return channel == 0 ? light.x : channel == 1 ? light.y : light.z;
}

static unsigned char ball_tone(float light) {
    return tone[(int)((light > 1.0f ? 1.0f : light) * (TONES - 1))];
}

// A square picture, side pixels wide, of the ball with this radius in pixels; the sun's direction
// is of unit length, x to the right, y up, z towards the eye. Returns red, green, blue and
// coverage.
EXPORT(ball_render)
unsigned char *ball_render(int ball, int side, float radius, float sun_x, float sun_y,
                           float sun_z) {
    float half = 0.5f * (float)side;
    unsigned char *out = ball_pixel;
    for (int j = 0; j < side; j++) {
        for (int i = 0; i < side; i++, out += 4) {
            float x = ((float)i + 0.5f - half) / radius, y = (half - (float)j - 0.5f) / radius,
                  rho2 = x * x + y * y;
            float edge = (1.0f - square_root(rho2)) * radius + 0.5f;
            out[3] = (unsigned char)(255.0f * (edge > 1.0f ? 1.0f : positive(edge)));
            if (!(edge > 0.0f)) continue;
            float z = square_root(positive(1.0f - rho2)),
                  cosine = x * sun_x + y * sun_y + z * sun_z;
            sss_vec3 light = ball_colour(ball, cosine);
            out[0] = ball_tone(EXPOSURE * light.x);
            out[1] = ball_tone(EXPOSURE * light.y);
            out[2] = ball_tone(EXPOSURE * light.z);
        }
    }
    return ball_pixel;
}

// ---- Figure 3: a disk probe and a plane through the entry, tilted by an angle against the disk

static sss_vec3 tilt_normal;
static tally tilt_with, tilt_without;
static uint32_t tilt_seed;

EXPORT(tilt_begin)
void tilt_begin(float sine, float cosine, uint32_t seed) {
    tally none = {0, 0, 0, 0.0f};
    set_burley(3, 1.0f, 0.0f, 0.0f, 12.0f, 12.0f, 12.0f);
    tilt_normal = vec(sine, 0.0f, cosine);
    tilt_with = tilt_without = none;
    tilt_seed = seed;
}

static void tilt_lookup(sss_resampler *s, uint32_t seed) {
    sss_plan plan = {0};
    plan.techniques = SSS_DISK;
    sss_begin(s, &medium[3], &plan, vec(0.0f, 0.0f, 0.0f), vec(0.0f, 0.0f, 1.0f), seed);
}

// Lookups of eight probes each, weighed with the cosine and without it.
EXPORT(tilt_run)
void tilt_run(int count) {
    while (count-- > 0) {
        sss_resampler s;
        sss_probe p;
        double with = 0, without = 0, cosine = (double)tilt_normal.z;
        tilt_lookup(&s, tilt_seed++);
        while (sss_next_probe(&s, &p)) {
            float t = -dot(p.origin, tilt_normal) / dot(p.direction, tilt_normal);
            sss_vec3 y = along(p.origin, p.direction, t);
            if (!(t >= 0.0f && t <= p.length)) continue;
            float r = square_root(dot(y, y));
            double weight =
                (double)(sss_profile(&medium[3], 0, r) / sss_intensity(&s, y, tilt_normal)) / 8;
            with += weight;
            without += weight * cosine;
        }
        count_sample(&tilt_with, with);
        count_sample(&tilt_without, without);
    }
}
EXPORT(tilt_energy)
double tilt_energy(int cosine) { return tally_mean(cosine ? &tilt_with : &tilt_without); }
// One standard error of it.
EXPORT(tilt_error)
double tilt_error(int cosine) { return tally_error(cosine ? &tilt_with : &tilt_without); }
EXPORT(tilt_count)
double tilt_count(void) { return tilt_with.count; }

// The weight of a hit at the distance r_a from the axis, in the plane of the drawing.
EXPORT(tilt_weight)
float tilt_weight(float r_a) {
    sss_resampler s;
    sss_vec3 y = vec(r_a, 0.0f, -r_a * tilt_normal.x / tilt_normal.z);
    tilt_lookup(&s, 1);
    return sss_profile(&medium[3], 0, square_root(dot(y, y))) / sss_intensity(&s, y, tilt_normal);
}

// ---- Figure 4: a crease. Two walls rise from the edge, the y axis; the object is below them.

static sss_medium crease_probed; // the colours that probes are drawn for
static sss_vec3 crease_wall[2], crease_normal[2], crease_entry;
static unsigned crease_techniques;
static uint32_t crease_seed;
static tally crease_tally;

// half: sine and cosine of half the angle between the walls. The entry is on the left wall.
EXPORT(crease_begin)
void crease_begin(int techniques, int colours, float half_sine, float half_cosine, float from_edge,
                  uint32_t seed) {
    static const float dmfp[3] = {1.0f, 0.35f, 0.12f};
    float albedo[3];
    tally none = {0, 0, 0, 0.0f};

    for (int c = 0; c < 3; c++) albedo[c] = (colours >> c & 1) ? 0.8f : 0.0f;
    sss_burley(&crease_probed, albedo, dmfp);
    set_burley(4, 0.8f, 0.8f, 0.8f, dmfp[0], dmfp[1], dmfp[2]);

    crease_wall[0] = vec(-half_sine, 0.0f, half_cosine);
    crease_wall[1] = vec(half_sine, 0.0f, half_cosine);
    crease_normal[0] = vec(half_cosine, 0.0f, half_sine);
    crease_normal[1] = vec(-half_cosine, 0.0f, half_sine);
    crease_entry = along(vec(0.0f, 0.0f, 0.0f), crease_wall[0], from_edge);

    crease_techniques = (unsigned)techniques;
    crease_seed = seed;
    crease_tally = none;
}

// Lookups of one probe each. A hit weighs, for each colour, its unit profile over the intensity;
// the estimate is the mean over the three colours, and the largest weight is that of the colour
// that has it. The last probes are drawn.
EXPORT(crease_run)
void crease_run(int count) {
    sss_plan plan = {0};
    plan.candidates = 1;
    plan.techniques = crease_techniques;
    probes_drawn = hits_drawn = 0;
    while (count-- > 0) {
        sss_resampler s;
        sss_probe p;
        double sum = 0;
        sss_begin(&s, &crease_probed, &plan, crease_entry, crease_normal[0], crease_seed++);
        while (sss_next_probe(&s, &p)) {
            draw_probe(&p);
            for (int i = 0; i < 2; i++) {
                float t = -dot(p.origin, crease_normal[i]) / dot(p.direction, crease_normal[i]),
                      largest = 0.0f;
                sss_vec3 y = along(p.origin, p.direction, t);
                if (!(t >= 0.0f && t <= p.length && dot(y, crease_wall[i]) > 0.0f)) continue;
                float r = distance(y, crease_entry), mu = sss_intensity(&s, y, crease_normal[i]);
                for (int c = 0; c < 3; c++) {
                    float weight = sss_profile(&medium[4], c, r) / 0.8f / mu;
                    largest = weight > largest ? weight : largest;
                    sum += (double)weight / 3;
                }
                draw_hit(y, r, largest);
                if (largest > crease_tally.largest) crease_tally.largest = largest;
            }
        }
        count_sample(&crease_tally, sum);
    }
}
EXPORT(crease_mean)
double crease_mean(void) { return tally_mean(&crease_tally); }
EXPORT(crease_error)
double crease_error(void) { return tally_error(&crease_tally); }
EXPORT(crease_variance)
double crease_variance(void) { return tally_variance(&crease_tally); }
EXPORT(crease_largest)
double crease_largest(void) { return (double)crease_tally.largest; }
EXPORT(crease_count)
double crease_count(void) { return crease_tally.count; }

// ---- Figure 5: chords

static double patch_crossings, patch_lines;

EXPORT(patch_begin)
void patch_begin(uint32_t seed) {
    patch_crossings = patch_lines = 0;
    random_begin(seed);
}

// Chords of the unit sphere (or, for comparison, parallel lines through it), and how many of them
// cross a round patch with this centre, normal and radius; the patch stands upright on the plane of
// the drawing, y = 0. The weight of what is drawn is 1 for those that cross.
EXPORT(patch_run)
void patch_run(int count, int parallel, float x, float z, float normal_x, float normal_z,
               float radius) {
    sss_vec3 centre = vec(x, 0.0f, z), normal = vec(normal_x, 0.0f, normal_z);
    probes_drawn = hits_drawn = 0;
    while (count-- > 0) {
        sss_vec3 a = on_sphere(), b = on_sphere();
        if (parallel) { // uniform over the disk, along z
            float r = square_root(rnd()), s, c;
            sssi_sincos_turn(rnd(), &s, &c);
            a = vec(r * c, r * s, -square_root(1.0f - r * r));
            b = vec(a.x, a.y, -a.z);
        }
        sss_vec3 way = along(b, a, -1.0f);
        float t = dot(along(centre, a, -1.0f), normal) / dot(way, normal);
        sss_probe p = {a, way, 1.0f};
        sss_vec3 y = along(a, way, t);
        int crosses = t >= 0.0f && t <= 1.0f && distance(y, centre) < radius;
        draw_probe(&p);
        if (crosses) draw_hit(y, 0.0f, 1.0f);
        patch_crossings += crosses;
        patch_lines += 1;
    }
}
EXPORT(patch_rate)
double patch_rate(void) { return patch_lines > 0 ? patch_crossings / patch_lines : 0; }
EXPORT(patch_count)
double patch_count(void) { return patch_lines; }

// A spike: an ellipsoid, 1 long and `spike_width` wide, about the z axis. The entry is on its side.
static float spike_width;
static sss_vec3 spike_entry, spike_normal;
static uint32_t spike_seed;
static tally spike_tally[2];

static sss_vec3 spike_normal_at(sss_vec3 y) {
    float k = 1.0f / (spike_width * spike_width);
    sss_vec3 n = vec(y.x * k, y.y * k, y.z);
    return along(vec(0.0f, 0.0f, 0.0f), n, 1.0f / square_root(dot(n, n)));
}

EXPORT(spike_begin)
void spike_begin(float width, float height, uint32_t seed) {
    tally none = {0, 0, 0, 0.0f};
    set_burley(5, 1.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.0f);
    spike_width = width;
    spike_entry = vec(width * square_root(1.0f - height * height), 0.0f, height);
    spike_normal = spike_normal_at(spike_entry);
    spike_seed = seed;
    spike_tally[0] = spike_tally[1] = none;
}

// Lookups of one probe each: disks (0) or chords (1).
EXPORT(spike_run)
void spike_run(int count, int chords) {
    sss_plan plan = {0};
    plan.candidates = 1;
    plan.techniques = chords ? SSS_CHORD : SSS_DISK;
    probes_drawn = hits_drawn = 0;
    while (count-- > 0) {
        sss_resampler s;
        sss_probe p;
        double sum = 0;
        sss_begin(&s, &medium[5], &plan, spike_entry, spike_normal, spike_seed++);
        while (sss_next_probe(&s, &p)) {
            float k = 1.0f / spike_width;
            sss_vec3 o = vec(p.origin.x * k, p.origin.y * k, p.origin.z);
            sss_vec3 d = vec(p.direction.x * k, p.direction.y * k, p.direction.z);
            float a = dot(d, d), b = dot(o, d), rest = b * b - a * (dot(o, o) - 1.0f);
            draw_probe(&p);
            for (int side = -1; side <= 1 && rest > 0.0f; side += 2) {
                float t = (-b + (float)side * square_root(rest)) / a;
                if (!(t >= 0.0f && t <= p.length)) continue;
                sss_vec3 y = along(p.origin, p.direction, t);
                float r = distance(y, spike_entry);
                float weight =
                    sss_profile(&medium[5], 0, r) / sss_intensity(&s, y, spike_normal_at(y));
                draw_hit(y, r, weight);
                sum += (double)weight;
                if (weight > spike_tally[chords].largest) spike_tally[chords].largest = weight;
            }
        }
        count_sample(&spike_tally[chords], sum);
    }
}
EXPORT(spike_mean)
double spike_mean(int chords) { return tally_mean(&spike_tally[chords]); }
EXPORT(spike_variance)
double spike_variance(int chords) { return tally_variance(&spike_tally[chords]); }
EXPORT(spike_largest)
double spike_largest(int chords) { return (double)spike_tally[chords].largest; }
EXPORT(spike_count)
double spike_count(int chords) { return spike_tally[chords].count; }

// ---- Figure 6: resampling on a ball of radius 1, the entry on top

enum { PICK_BINS = 40 };
static double pick_bin[PICK_BINS]; // picks by their distance from the entry, 0..2
static double picks;
static uint32_t pick_seed;
static const sss_vec3 top = {0.0f, 0.0f, 1.0f};

EXPORT(pick_begin)
void pick_begin(float dmfp, uint32_t seed) {
    set_burley(6, 0.6f, 0.0f, 0.0f, dmfp, dmfp, dmfp);
    for (int i = 0; i < PICK_BINS; i++) pick_bin[i] = 0;
    picks = 0;
    pick_seed = seed;
}

// One lookup of m disk probes. What it would draw is kept when asked for. 1 and the pick, or 0.
static int pick_lookup(int m, int draw, sss_exit *exit) {
    sss_resampler s;
    sss_probe p;
    sss_plan plan = {0};
    plan.candidates = m;
    plan.techniques = SSS_DISK;
    plan.independent = 1;
    sss_begin(&s, &medium[6], &plan, top, top, pick_seed++);
    while (sss_next_probe(&s, &p)) {
        float b = dot(p.origin, p.direction), rest = b * b - dot(p.origin, p.origin) + 1.0f;
        if (draw) draw_probe(&p);
        for (int side = -1; side <= 1 && rest > 0.0f; side += 2) {
            float t = -b + (float)side * square_root(rest);
            sss_vec3 y = along(p.origin, p.direction, t);
            if (!(t >= 0.0f && t <= p.length)) continue;
            sss_add_hit(&s, y, y, 1.0f);
            if (!draw) continue;
            float r = distance(y, top);
            draw_hit(y, r,
                     sss_profile(&medium[6], 0, r) / 0.6f / sss_intensity(&s, y, y) / (float)m);
        }
    }
    return sss_finish(&s, exit);
}

static void count_pick(float r) {
    int bin = (int)(r * 0.5f * PICK_BINS);
    pick_bin[bin < PICK_BINS ? bin : PICK_BINS - 1] += 1;
    picks += 1;
}

// Draws a lookup; returns which of the hits drawn the header picked, or -1.
EXPORT(pick_one)
int pick_one(int m) {
    sss_exit exit[SSS_MAX_EXITS];
    probes_drawn = hits_drawn = 0;
    if (!pick_lookup(m, 1, exit)) return -1;
    count_pick(distance(exit[0].position, top));
    for (int i = 0; i < hits_drawn; i++)
        if (distance(exit[0].position, vec(hit_list[i][0], hit_list[i][1], hit_list[i][2])) == 0.0f)
            return i;
    return -1;
}
EXPORT(pick_many)
void pick_many(int count, int m) {
    while (count-- > 0) {
        sss_exit exit[SSS_MAX_EXITS];
        if (pick_lookup(m, 0, exit)) count_pick(distance(exit[0].position, top));
    }
}
EXPORT(pick_bins)
double *pick_bins(void) { return pick_bin; }
EXPORT(pick_count)
double pick_count(void) { return picks; }

// ---- Figure 7: a plane in uneven light, and a guess of that light

enum { CELLS = 24 };
static float hint_light[CELLS][CELLS], hint_guess[CELLS][CELLS];
static const float hint_reach =
    1.5f; // the picture shows -reach..reach; the light goes on beyond as at its border
static sss_vec3 hint_entry;
static uint32_t hint_seed;
static tally hint_tally;

static int hint_cell(float x) {
    float i = (0.5f + 0.5f * x / hint_reach) * CELLS;
    return i >= CELLS - 1 ? CELLS - 1 : i > 0.0f ? (int)i : 0;
}

EXPORT(hint_light_data)
float *hint_light_data(void) { return &hint_light[0][0]; }
EXPORT(hint_guess_data)
float *hint_guess_data(void) { return &hint_guess[0][0]; }

// Light through a window with four panes, on a surface that is dim elsewhere; and no guess yet.
EXPORT(hint_scene)
void hint_scene(void) {
    for (int j = 0; j < CELLS; j++) {
        for (int i = 0; i < CELLS; i++) {
            int column = i - 11, row = j - 4;
            int pane = column >= 0 && column < 9 && row >= 0 && row < 13 && column != 4 && row != 6;
            hint_light[j][i] = pane ? 4.0f : 0.15f;
            hint_guess[j][i] = 1.0f;
        }
    }
}

EXPORT(hint_begin)
void hint_begin(float x, float y, uint32_t seed) {
    tally none = {0, 0, 0, 0.0f};
    set_burley(7, 0.8f, 0.0f, 0.0f, 2.0f, 2.0f, 2.0f);
    hint_entry = vec(x, y, 0.0f);
    hint_seed = seed;
    hint_tally = none;
}

// Lookups by the default plan, each with one exit that is shaded: its weight times the light there.
EXPORT(hint_run)
void hint_run(int count) {
    while (count-- > 0) {
        sss_resampler s;
        sss_probe p;
        sss_exit exit[SSS_MAX_EXITS];
        double value = 0;
        sss_vec3 up = vec(0.0f, 0.0f, 1.0f);
        sss_begin(&s, &medium[7], (const sss_plan *)0, hint_entry, up, hint_seed++);
        while (sss_next_probe(&s, &p)) {
            float t = -p.origin.z / p.direction.z;
            sss_vec3 y = vec(p.origin.x + t * p.direction.x, p.origin.y + t * p.direction.y, 0.0f);
            if (t >= 0.0f && t <= p.length)
                sss_add_hit(&s, y, up, hint_guess[hint_cell(y.y)][hint_cell(y.x)]);
        }
        if (sss_finish(&s, exit)) {
            sss_vec3 y = exit[0].position;
            value = (double)exit[0].weight[0] * (double)hint_light[hint_cell(y.y)][hint_cell(y.x)];
        }
        count_sample(&hint_tally, value);
    }
}
EXPORT(hint_mean)
double hint_mean(void) { return tally_mean(&hint_tally); }
EXPORT(hint_error)
double hint_error(void) { return tally_error(&hint_tally); }
EXPORT(hint_variance)
double hint_variance(void) { return tally_variance(&hint_tally); }
EXPORT(hint_count)
double hint_count(void) { return hint_tally.count; }

// The integral itself, over rings that hold the same light each.
EXPORT(hint_truth)
double hint_truth(void) {
    enum { ROUNDS = 1500, TURN = 256 };
    double sum = 0;
    for (int k = 0; k < ROUNDS; k++) {
        float inner = 12.0f * (float)k * (float)k / (ROUNDS * ROUNDS);
        float outer = 12.0f * (float)(k + 1) * (float)(k + 1) / (ROUNDS * ROUNDS),
              r = 0.5f * (inner + outer);
        double light = 0;
        for (int i = 0; i < TURN; i++) {
            float s, c;
            sssi_sincos_turn(((float)i + 0.5f) / TURN, &s, &c);
            light += (double)
                hint_light[hint_cell(hint_entry.y + r * s)][hint_cell(hint_entry.x + r * c)];
        }
        sum += light / TURN * (double)(within(7, 0, outer) - within(7, 0, inner));
    }
    return sum;
}

// ---- Figure 8: a bear of ellipsoids, as flat as one likes, by four ways at equal time

enum {
    BEAR_PARTS = 9,
    SIDE = 112,
    TILE = 8,
    TILE_ENTRIES = TILE * TILE,
    TILES = SIDE / TILE + 1,
    BEAR_HITS = 2 * BEAR_PARTS
};
enum { PLAIN, RESAMPLED, SHARED, VOLUME, WAYS };
typedef struct bear_hit {
    float t;
    sss_vec3 y, n;
} bear_hit;
static const float bear_shape[BEAR_PARTS][6] = { // centre, radii; y is up, z towards the eye
    {0.0f, -0.22f, 0.0f, 0.48f, 0.55f, 0.42f},  {0.0f, 0.48f, 0.04f, 0.39f, 0.35f, 0.35f},
    {-0.31f, 0.78f, 0.0f, 0.15f, 0.15f, 0.11f}, {0.31f, 0.78f, 0.0f, 0.15f, 0.15f, 0.11f},
    {0.0f, 0.4f, 0.34f, 0.18f, 0.14f, 0.15f},   {-0.42f, 0.02f, 0.22f, 0.17f, 0.27f, 0.2f},
    {0.42f, 0.02f, 0.22f, 0.17f, 0.27f, 0.2f},  {-0.3f, -0.72f, 0.2f, 0.21f, 0.22f, 0.3f},
    {0.3f, -0.72f, 0.2f, 0.21f, 0.22f, 0.3f}};
static sss_vec3 bear_centre[BEAR_PARTS], bear_inverse[BEAR_PARTS], bear_sun;
static sss_plan bear_plan[WAYS];
static int bear_shadow_rays, bear_tile[WAYS], bear_pass[WAYS];
static unsigned char bear_pixel[SIDE * SIDE * 4];
static const float bear_view = 1.08f;                  // half the side of the picture
static const float bear_light = 4.0f, bear_sky = 0.4f; // irradiances

// Of even and of odd passes: red, green, blue and the number of samples.
static float bear_sum[WAYS][2][SIDE * SIDE][4];

// The tile that is worked on: its lookups, and what they have gathered.
static int tile_count, tile_pixel[TILE_ENTRIES];
static sss_entry tile_entry[TILE_ENTRIES];
static sss_vec3 tile_normal[TILE_ENTRIES];
static float tile_value[TILE_ENTRIES][3];

static sss_vec3 scaled(sss_vec3 v, sss_vec3 by) { return vec(v.x * by.x, v.y * by.y, v.z * by.z); }
static sss_vec3 unit(sss_vec3 v) {
    return along(vec(0.0f, 0.0f, 0.0f), v, 1.0f / square_root(dot(v, v)));
}

// The two ends of what a line has in common with a part, or 0.
static int bear_interval(int part, sss_vec3 o, sss_vec3 d, float *near, float *far) {
    sss_vec3 from = scaled(along(o, bear_centre[part], -1.0f), bear_inverse[part]),
             way = scaled(d, bear_inverse[part]);
    float a = dot(way, way), b = dot(from, way), rest = b * b - a * (dot(from, from) - 1.0f);
    if (!(rest > 0.0f)) return 0;
    *near = (-b - square_root(rest)) / a;
    *far = (-b + square_root(rest)) / a;
    return 1;
}

static int bear_holds(sss_vec3 y, int but) {
    for (int i = 0; i < BEAR_PARTS; i++) {
        sss_vec3 v = scaled(along(y, bear_centre[i], -1.0f), bear_inverse[i]);
        if (i != but && dot(v, v) < 1.0f) return 1;
    }
    return 0;
}

static sss_vec3 bear_normal(int part, sss_vec3 y) {
    sss_vec3 v = scaled(along(y, bear_centre[part], -1.0f), bear_inverse[part]);
    return unit(scaled(v, bear_inverse[part]));
}

// A point on a part, to the last bits: the distance along a ray leaves an error that grows with its
// length.
static sss_vec3 bear_onto(int part, sss_vec3 y) {
    sss_vec3 c = bear_centre[part], k = bear_inverse[part], v = scaled(along(y, c, -1.0f), k);
    float length = square_root(dot(v, v));
    return vec(c.x + v.x / (length * k.x), c.y + v.y / (length * k.y), c.z + v.z / (length * k.z));
}

// All crossings of the surface on a segment, nearest first.
static int bear_hits(sss_vec3 o, sss_vec3 d, float length, bear_hit *hits) {
    int count = 0;
    for (int i = 0; i < BEAR_PARTS; i++) {
        float end[2];
        if (!bear_interval(i, o, d, &end[0], &end[1])) continue;
        for (int k = 0; k < 2; k++) {
            sss_vec3 y = along(o, d, end[k]);
            int at = count;
            if (!(end[k] > 0.0f && end[k] < length) || bear_holds(y, i)) continue;
            for (; at > 0 && hits[at - 1].t > end[k]; at--) hits[at] = hits[at - 1];
            hits[at].t = end[k];
            hits[at].y = bear_onto(i, y);
            hits[at].n = bear_normal(i, hits[at].y);
            count++;
        }
    }
    return count;
}

// What a point sees of the sky and the sun. Rays go to points of a wide sun; without rays it is the
// hint.
static float bear_irradiance(sss_vec3 y, sss_vec3 n, int rays) {
    float sky = bear_sky * (0.6f + 0.4f * n.y), sum = 0.0f;
    if (!rays) return sky + bear_light * positive(dot(n, bear_sun));
    for (int k = 0; k < rays; k++) {
        sss_vec3 way = unit(along(bear_sun, on_sphere(), 0.25f));
        float cosine = positive(dot(n, way)), near, far;
        int lit = cosine > 0.0f;
        for (int i = 0; i < BEAR_PARTS && lit; i++)
            if (bear_interval(i, y, way, &near, &far)) lit = far < 2e-3f;
        sum += lit ? cosine : 0.0f;
    }
    return sky + bear_light * sum / (float)rays;
}

// Thickness is that of the bear over its width. Albedo and the ratio of the dmfps are those of a
// sweet.
EXPORT(bear_begin)
void bear_begin(float thickness, float dmfp, int shadow_rays, float sun_x, float sun_y,
                float sun_z) {
    static const sss_plan none = {0};
    set_burley(8, 0.84f, 0.34f, 0.14f, dmfp, 0.16f * dmfp, 0.08f * dmfp);
    for (int i = 0; i < BEAR_PARTS; i++) {
        const float *s = bear_shape[i];
        bear_centre[i] = vec(s[0], s[1], s[2] * thickness);
        bear_inverse[i] = vec(1.0f / s[3], 1.0f / s[4], 1.0f / (s[5] * thickness));
    }
    bear_sun = unit(vec(sun_x, sun_y, sun_z));
    bear_shadow_rays = shadow_rays;

    for (int w = 0; w < WAYS; w++) {
        bear_plan[w] = none;
        bear_tile[w] = bear_pass[w] = 0;
        for (int i = 0; i < 2 * SIDE * SIDE; i++)
            for (int c = 0; c < 4; c++) bear_sum[w][i & 1][i >> 1][c] = 0.0f;
    }
    bear_plan[PLAIN].candidates = 1;
    bear_plan[SHARED].per_channel = 1;
    bear_plan[VOLUME].techniques = SSS_WALK;
}

// Probes or walks for each lookup of a way.
EXPORT(bear_candidates)
void bear_candidates(int way, int candidates) { bear_plan[way].candidates = candidates; }

// The exits of one lookup.
static int bear_lookup(int way, sss_vec3 x, sss_vec3 n, uint32_t seed, uint32_t sample,
                       sss_exit *exits) {
    sss_resampler s;
    sss_probe p;
    bear_hit hits[BEAR_HITS];
    sss_begin_sample(&s, &medium[8], &bear_plan[way], x, n, seed, sample);
    while (sss_next_probe(&s, &p)) {
        int count = bear_hits(p.origin, p.direction, p.length, hits);
        for (int i = 0; i < count; i++)
            sss_add_hit(&s, hits[i].y, hits[i].n,
                        way == PLAIN ? 1.0f : bear_irradiance(hits[i].y, hits[i].n, 0));
    }
    return sss_finish(&s, exits);
}

// Where the camera's rays through a tile meet the bear. Tiles are shifted from pass to pass.
static void bear_enter(int way, int tile, int pass) {
    uint32_t shift = sss_hash((uint32_t)pass, 77u);
    int left = tile % TILES * TILE - (int)(shift & (TILE - 1));
    int top_row = tile / TILES * TILE - (int)(shift >> 8 & (TILE - 1));

    tile_count = 0;
    for (int k = 0; k < TILE_ENTRIES; k++) {
        int i = left + k % TILE, j = top_row + k / TILE, n = tile_count;
        bear_hit hits[BEAR_HITS];
        if (i < 0 || j < 0 || i >= SIDE || j >= SIDE) continue;

        random_begin(sss_hash((uint32_t)(j * SIDE + i), (uint32_t)(pass * WAYS + way)));
        float u = 2.0f * ((float)i + rnd()) / SIDE - 1.0f;
        float v = 1.0f - 2.0f * ((float)j + rnd()) / SIDE;
        sss_vec3 eye = vec(bear_view * u, bear_view * v, 3.0f);
        bear_sum[way][pass & 1][j * SIDE + i][3] += 1.0f;
        if (!bear_hits(eye, vec(0.0f, 0.0f, -1.0f), 6.0f, hits)) continue;

        tile_pixel[n] = j * SIDE + i;
        tile_entry[n].position = hits[0].y;
        tile_entry[n].medium = &medium[8];
        tile_normal[n] = hits[0].n;
        for (int c = 0; c < 3; c++) tile_value[n][c] = 0.0f;
        tile_count++;
    }
}

// Adds the light of an exit of lookup k to it, or to all lookups of the tile.
static void bear_gather(int way, int k, const sss_exit *exit) {
    static float weight[TILE_ENTRIES][3];
    float light = bear_irradiance(exit->position, exit->normal, bear_shadow_rays);

    if (way != SHARED) {
        for (int c = 0; c < 3; c++) tile_value[k][c] += exit->weight[c] * light;
        return;
    }
    sss_share(exit, tile_entry, tile_count, k, 2.0f * bear_view / SIDE, weight);
    for (int m = 0; m < tile_count; m++)
        for (int c = 0; c < 3; c++) tile_value[m][c] += weight[m][c] * light;
}

// One sample for each pixel of a tile.
static void bear_run_tile(int way, int tile, int pass) {
    bear_enter(way, tile, pass);
    for (int k = 0; k < tile_count; k++) {
        sss_exit exits[SSS_MAX_EXITS];
        uint32_t seed = sss_hash((uint32_t)tile_pixel[k], (uint32_t)way);
        int found =
            bear_lookup(way, tile_entry[k].position, tile_normal[k], seed, (uint32_t)pass, exits);
        for (int e = 0; e < found; e++) bear_gather(way, k, &exits[e]);
    }
    for (int k = 0; k < tile_count; k++)
        for (int c = 0; c < 3; c++) bear_sum[way][pass & 1][tile_pixel[k]][c] += tile_value[k][c];
}

EXPORT(bear_run)
void bear_run(int way, int tiles) {
    while (tiles-- > 0) {
        bear_run_tile(way, bear_tile[way], bear_pass[way]);
        if (++bear_tile[way] < TILES * TILES) continue;
        bear_tile[way] = 0;
        bear_pass[way]++;
    }
}

EXPORT(bear_side)
int bear_side(void) { return SIDE; }
// Samples of each pixel so far.
EXPORT(bear_samples)
double bear_samples(int way) { return bear_pass[way] + (double)bear_tile[way] / (TILES * TILES); }

EXPORT(bear_picture)
unsigned char *bear_picture(int way) {
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float *a = bear_sum[way][0][i], *b = bear_sum[way][1][i];
        float n = a[3] + b[3], all = 0.0f;
        for (int c = 0; c < 3; c++) {
            float light = n > 0.0f ? (a[c] + b[c]) / n : 0.0f;
            all += light;
            bear_pixel[4 * i + c] =
                tone[(int)((1.0f - sssi_exp(-light)) * (TONES - 1))]; // does not burn out
        }
        bear_pixel[4 * i + 3] = all > 0.0f ? 255 : 0;
    }
    return bear_pixel;
}

// The mean of a channel over the picture, and the noise of a pixel: half the difference of even and
// odd passes, root of the mean of its square over the pixels of the bear, over their mean.
EXPORT(bear_mean)
double bear_mean(int way, int channel) {
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float *a = bear_sum[way][0][i], *b = bear_sum[way][1][i];
        if (a[3] + b[3] > 0.0f) sum += (double)((a[channel] + b[channel]) / (a[3] + b[3]));
    }
    return sum / (SIDE * SIDE);
}
EXPORT(bear_noise)
double bear_noise(int way) {
    double squares = 0, sum = 0;
    int n = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const float *a = bear_sum[way][0][i], *b = bear_sum[way][1][i];
        if (!(a[3] > 0.0f && b[3] > 0.0f && a[0] + b[0] + a[1] + b[1] > 0.0f)) continue;
        for (int c = 0; c < 3; c++) {
            double even = (double)(a[c] / a[3]), odd = (double)(b[c] / b[3]);
            squares += 0.25 * (even - odd) * (even - odd);
            sum += 0.5 * (even + odd);
            n++;
        }
    }
    return n > 0 && sum > 0 ? __builtin_sqrt(squares / n) * n / sum : 0;
}

// The plan for this bear: techniques, candidates, exits, an exit for each colour, side of the tile.
EXPORT(bear_advice)
int *bear_advice(float thickness, float tolerance) {
    static int advice[5];
    sss_need need = {0};
    need.footprint = 2.0f * bear_view / SIDE;
    need.curvature_radius = 0.42f * thickness;
    need.shading_cost = (float)bear_shadow_rays;
    need.tolerance = tolerance;
    need.hinted = 1;
    sss_plan plan = sss_plan_for(&medium[8], &need);
    advice[0] = (int)plan.techniques;
    advice[1] = plan.candidates ? plan.candidates : 8;
    advice[2] = plan.exits ? plan.exits : 1;
    advice[3] = plan.per_channel;
    advice[4] = plan.tile;
    return advice;
}

#ifdef NATIVE
// Prints the mean of figure 7 in hexadecimal: figures SEED COUNT.
int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: figures SEED COUNT\n");
        return 2;
    }
    hint_scene();
    hint_begin(-0.35f, 0.2f, (uint32_t)strtoul(argv[1], NULL, 10));
    hint_run(atoi(argv[2]));
    printf("%a\n", hint_mean());
    return 0;
}
#endif
