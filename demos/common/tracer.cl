// tracer.cl - the library and the tracer on an OpenCL 1.2 device: load, call, store, and nothing else.
// SPDX-License-Identifier: MIT
#include "sss_resample.h"
#include "scene.h"
#include "tracer.h"

// One lookup for each entry: the exits that light takes which enters the scene's object there. Entry i has
// room for `room` exits from exits[i * room] and uses counts[i] of them.
__kernel void tracer_lookups(uint entries, uint room, __global const sss_vec3 *positions,
                             __global const sss_vec3 *normals, __global const uint *seeds, __global int *counts,
                             __global sss_exit *exits, __global const scene *s, tracer_settings settings) {
    uint i = (uint)get_global_id(0), probes = 0u;
    sss_exit own[SSS_MAX_EXITS];
    if (i >= entries) return; // the global size is rounded up to whole work-groups
    int count = tracer_exits(s, settings, positions[i], normals[i], seeds[i], own, &probes);
    for (int k = 0; k < count; k++) exits[i * room + (uint)k] = own[k];
    counts[i] = count;
}

// Adds samples first .. first + count - 1 of pixels begin .. end - 1 to their sums: rgb[0] is pixel `begin`. Pixels
// are numbered by rows from the top left corner. work gets two numbers a pixel: probes and shaded points.
__kernel void tracer_render(__global const scene *s, tracer_settings settings, uint begin, uint end, uint first,
                            uint count, __global sss_vec3 *rgb, __global uint *work) {
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
