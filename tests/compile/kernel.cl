/* All of the header's interface in a kernel. */
#include "sss_resample.h"

kernel void lookup(global const sss_medium *media, global const sss_vec3 *points, global sss_exit *out,
                   global float *numbers) {
    size_t i = get_global_id(0);
    const float albedo[3] = {0.9f, 0.5f, 0.1f};
    const float length[3] = {1.0f, 0.5f, 0.1f};
    sss_medium m = media[i];
    sss_medium own;
    sss_plan plan;
    sss_need need;
    sss_resampler s;
    sss_probe probe;
    sss_exit exits[SSS_MAX_EXITS];
    unsigned advice;

    sss_result result = sss_burley(&own, albedo, length);
    if (result == SSS_OK) result = sss_burley_mfp(&own, albedo, length);
    if (result == SSS_OK) result = sss_dipole(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_better_dipole(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_dipole_from_albedo(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_better_dipole_from_albedo(&own, albedo, length, 1.3f);

    need.footprint = need.curvature_radius = need.shading_cost = 1.0f;
    plan = sss_plan_for(&own, &need, &advice);
    if (sss_begin(&s, &m, &plan, points[0], points[1], sss_hash((uint)i, advice)) != SSS_OK) return;
    while (sss_next_probe(&s, &probe)) sss_add_hit(&s, probe.origin, probe.direction, probe.length);
    int count = sss_finish(&s, exits);
    for (int k = 0; k < count; ++k) out[k] = exits[k];

    numbers[0] = sss_profile(&m, 0, 1.0f) + sss_within(&own, 1, 2.0f);
    numbers[1] = (float)sss_result_string(result)[0];
    numbers[2] = sss_intensity(&s, points[0], points[1]);
}
