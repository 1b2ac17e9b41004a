// layout.h - every struct that host and device share, field by field; C99 and OpenCL C 1.2.
// SPDX-License-Identifier: MIT
//
// The kernel `layout` and the test expand this one list, each with its own compiler, and must agree
// on every number. SIZE(type) stands for sizeof, FIELD(type, field) for an offset. A sss_resampler
// is not shared: it lives on one of the two, with as many lanes as suit there.
#ifndef LAYOUT_H
#define LAYOUT_H

// clang-format off
#define LAYOUT_LIBRARY(SIZE, FIELD)                                                               \
    SIZE(sss_vec3) FIELD(sss_vec3, x) FIELD(sss_vec3, y) FIELD(sss_vec3, z)                       \
    SIZE(sss_medium) FIELD(sss_medium, dipole) FIELD(sss_medium, albedo)                          \
    FIELD(sss_medium, length) FIELD(sss_medium, zv) FIELD(sss_medium, sigma)                      \
    FIELD(sss_medium, flux) FIELD(sss_medium, fluence) FIELD(sss_medium, r_max)                   \
    FIELD(sss_medium, extinction) FIELD(sss_medium, similarity)                                   \
    SIZE(sss_plan) FIELD(sss_plan, candidates) FIELD(sss_plan, exits)                             \
    FIELD(sss_plan, techniques) FIELD(sss_plan, independent) FIELD(sss_plan, per_channel)         \
    FIELD(sss_plan, tile)                                                                         \
    SIZE(sss_need) FIELD(sss_need, footprint) FIELD(sss_need, curvature_radius)                   \
    FIELD(sss_need, shading_cost) FIELD(sss_need, tolerance) FIELD(sss_need, hinted)              \
    SIZE(sss_probe) FIELD(sss_probe, origin) FIELD(sss_probe, direction)                          \
    FIELD(sss_probe, length)                                                                      \
    SIZE(sss_exit) FIELD(sss_exit, position) FIELD(sss_exit, normal) FIELD(sss_exit, weight)      \
    FIELD(sss_exit, hit) FIELD(sss_exit, mass)

#define LAYOUT_TRACER(SIZE, FIELD)                                                                \
    SIZE(scene_shape) FIELD(scene_shape, kind) FIELD(scene_shape, rounding)                       \
    FIELD(scene_shape, area) FIELD(scene_shape, center) FIELD(scene_shape, axis)                  \
    FIELD(scene_shape, extent) FIELD(scene_shape, inverse_extent)                                 \
    SIZE(scene_light) FIELD(scene_light, center) FIELD(scene_light, u) FIELD(scene_light, v)      \
    FIELD(scene_light, normal) FIELD(scene_light, radiance) FIELD(scene_light, area)              \
    FIELD(scene_light, radius)                                                                    \
    SIZE(scene) FIELD(scene, shape_count) FIELD(scene, shape) FIELD(scene, medium)                \
    FIELD(scene, light) FIELD(scene, sky_horizon) FIELD(scene, sky_zenith)                        \
    FIELD(scene, floor_albedo) FIELD(scene, floor_lit)                                            \
    FIELD(scene, eye) FIELD(scene, right) FIELD(scene, up) FIELD(scene, forward)                  \
    SIZE(tracer_settings) FIELD(tracer_settings, method) FIELD(tracer_settings, light_aware)      \
    FIELD(tracer_settings, plan) FIELD(tracer_settings, tolerance) FIELD(tracer_settings, width)  \
    FIELD(tracer_settings, height)                                                                \
    FIELD(tracer_settings, seed)                                                                  \
    SIZE(tracer_result) FIELD(tracer_result, radiance) FIELD(tracer_result, probes)               \
    FIELD(tracer_result, shaded)

// clang-format on
#define LAYOUT(SIZE, FIELD) LAYOUT_LIBRARY(SIZE, FIELD) LAYOUT_TRACER(SIZE, FIELD)

#ifdef __OPENCL_VERSION__
// Sizes and offsets of all shared structs, in the order of the list.
#define LAYOUT_SIZE(type) out[i++] = (uint)sizeof(type);
#define LAYOUT_FIELD(type, field)                                                                 \
    {                                                                                             \
        type it;                                                                                  \
        out[i++] = (uint)((char *)&it.field - (char *)&it);                                       \
    }
__kernel void layout(__global uint *out) {
    int i = 0;
    LAYOUT(LAYOUT_SIZE, LAYOUT_FIELD)
}
#endif

#endif
