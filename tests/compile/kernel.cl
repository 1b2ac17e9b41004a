/* All of the header's interface in a kernel. */
#include "sss_resample.h"

kernel void lookup(global const sss_medium *media, global const sss_vec3 *points,
                   global sss_exit *out, global float *numbers) {
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
    float weight[3];

    sss_result result = sss_burley(&own, albedo, length);
    if (result == SSS_OK) result = sss_burley_mfp(&own, albedo, length);
    if (result == SSS_OK) result = sss_dipole(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_better_dipole(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_dipole_from_albedo(&own, albedo, length, 1.3f);
    if (result == SSS_OK) result = sss_better_dipole_from_albedo(&own, albedo, length, 1.3f);

    need.footprint = need.curvature_radius = need.shading_cost = need.tolerance = 1.0f;
    need.hinted = 1;
    plan = sss_plan_for(&own, &need);
    uint seed = sss_hash((uint)i, 1u);
    if (sss_begin_sample(&s, &m, &plan, points[0], points[1], seed, 2u) != SSS_OK) return;
    while (sss_next_probe(&s, &probe)) sss_add_hit(&s, probe.origin, probe.direction, probe.length);
    int count = sss_finish(&s, exits);
    for (int k = 0; k < count; ++k) out[k] = exits[k];

    if (sss_is_shared(&m, 0, 1.0f)) {
        float density = sss_share_density(&m, points[0], &exits[0]);
        density += sss_share_density(&own, points[1], &exits[0]);
        sss_share_weight(&m, points[0], &exits[0], density, weight);
        numbers[3] = weight[0];
    }

    numbers[0] = sss_profile(&m, 0, 1.0f) + sss_within(&own, 1, 2.0f);
    numbers[1] = (float)sss_result_string(result)[0];
    numbers[2] = sss_intensity(&s, points[0], points[1]);
}
