// tracer.cl - the library and the tracer on an OpenCL 1.2 device: load, call, store, and nothing
// else. SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "scene.h"
#include "tracer.h"

// One lookup for each entry: the exits that light takes which enters the scene's object there.
// Entry i has room for `room` exits from exits[i * room] and uses counts[i] of them.
__kernel void tracer_lookups(uint entries, uint room, __global const sss_vec3 *positions,
                             __global const sss_vec3 *normals, __global const uint *seeds,
                             __global int *counts, __global sss_exit *exits,
                             __global const scene *s, tracer_settings settings) {
    uint i = (uint)get_global_id(0), probes = 0u;
    sss_exit own[SSS_MAX_EXITS];
    if (i >= entries) return; // the global size is rounded up to whole work-groups
    int count = tracer_exits(s, settings, positions[i], normals[i], seeds[i], own, &probes);
    for (int k = 0; k < count; k++) exits[i * room + (uint)k] = own[k];
    counts[i] = count;
}

// Adds samples first .. first + count - 1 of pixels begin .. end - 1 to their sums: rgb[0] is pixel
// `begin`. Pixels are numbered by rows from the top left corner. work gets two numbers a pixel:
// probes and shaded points.
__kernel void tracer_render(__global const scene *s, tracer_settings settings, uint begin, uint end,
                            uint first, uint count, __global sss_vec3 *rgb, __global uint *work) {
    uint i = (uint)get_global_id(0), pixel = begin + i, probes = 0u, shaded = 0u;
    if (pixel >= end) return;
    uint y = pixel / (uint)settings.width, x = pixel - y * (uint)settings.width;
    sss_vec3 sum = rgb[i];
    for (uint k = 0u; k < count; k++) {
        tracer_result r = tracer_sample(s, settings, (int)x, (int)y, first + k);
        sum = scene_add(sum, r.radiance);
        probes += r.probes;
        shaded += r.shaded;
    }
    rgb[i] = sum;
    work[2u * i] = probes;
    work[2u * i + 1u] = shaded;
}

// One sample of each pixel, in tiles: a work-group for each tile of the rows of tiles from `row`
// on. rgb[0] and work[0] are those of the first pixel in the row of pixels `top`.
__kernel void tracer_tiles(__global const scene *s, tracer_settings settings, uint row, uint tiles,
                           uint top, uint sample, __global sss_vec3 *rgb, __global uint *work) {
    __local tracer_tile tile;
    uint number = (uint)get_group_id(0), columns = (uint)tracer_tile_count(settings, sample, 0u);
    int first = (int)get_local_id(0), step = (int)get_local_size(0), x, y;
    int at_column = (int)(number % columns), at_row = (int)(row + number / columns);
    if (number >= tiles) return; // as a whole work-group
    for (int i = first; i < TRACER_TILE_PIXELS; i += step) {
        tracer_tile_clear(&tile, i);
        if (!tracer_tile_pixel(settings, sample, at_column, at_row, i, &x, &y)) continue;
        uint pixel = ((uint)y - top) * (uint)settings.width + (uint)x;
        tracer_result r = tracer_tile_begin(s, settings, x, y, sample, i, &tile);
        if (tile.group[i] < 0) rgb[pixel] = scene_add(rgb[pixel], r.radiance);
        work[2u * pixel] = r.probes;
        work[2u * pixel + 1u] = r.shaded;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int i = first; i < TRACER_TILE_PIXELS; i += step) tracer_tile_densities(s, i, &tile);
    barrier(CLK_LOCAL_MEM_FENCE);
    for (int i = first; i < TRACER_TILE_PIXELS; i += step) {
        if (tile.group[i] < 0) continue;
        tracer_tile_pixel(settings, sample, at_column, at_row, i, &x, &y);
        uint pixel = ((uint)y - top) * (uint)settings.width + (uint)x;
        rgb[pixel] = scene_add(rgb[pixel], tracer_tile_gather(s, i, &tile));
    }
}
