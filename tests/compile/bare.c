/* All of the header's interface, compiled without any library. */
#include "sss_resample.h"

int bare(const float *albedo, const float *length, const sss_vec3 *at, sss_exit *exits);

int bare(const float *albedo, const float *length, const sss_vec3 *at, sss_exit *exits) {
    sss_medium m;
    sss_plan plan;
    sss_need need;
    sss_resampler s;
    sss_probe probe;
    sss_entry group[2];
    float weight[2][3] = {{0.0f}};
    int count;

    if (sss_burley(&m, albedo, length) != SSS_OK) return 0;
    if (sss_dipole(&m, albedo, length, 1.3f) != SSS_OK) return 0;
    if (sss_better_dipole_from_albedo(&m, albedo, length, 1.3f) != SSS_OK) return 0;

    need.footprint = need.curvature_radius = sss_within(&m, 0, sss_profile(&m, 1, 1.0f));
    need.shading_cost = need.tolerance = 1.0f;
    need.hinted = 0;
    plan = sss_plan_for(&m, &need);

    if (sss_begin_sample(&s, &m, &plan, at[0], at[1], 1u, 1u) != SSS_OK) return 0;
    while (sss_next_probe(&s, &probe)) {
        sss_add_hit(&s, probe.origin, probe.direction, sss_intensity(&s, at[0], at[1]));
    }
    count = sss_finish(&s, exits);

    group[0].position = at[0];
    group[1].position = at[1];
    group[0].medium = group[1].medium = &m;
    if (count > 0 && sss_is_shared(&m, 0, 1.0f)) sss_share(&exits[0], group, 2, 0, 1.0f, weight);
    return count > 0 && weight[0][0] > 0.0f ? count : 0;
}
