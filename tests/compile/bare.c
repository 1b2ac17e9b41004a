/* All of the header's interface, compiled without any library. */
#include "sss_resample.h"

int bare(const float *albedo, const float *length, const sss_vec3 *at, sss_exit *exits);

int bare(const float *albedo, const float *length, const sss_vec3 *at, sss_exit *exits) {
    sss_medium m;
    sss_plan plan;
    sss_need need;
    sss_resampler s;
    sss_probe probe;
    if (sss_burley(&m, albedo, length) != SSS_OK) return 0;
    if (sss_dipole(&m, albedo, length, 1.3f) != SSS_OK) return 0;
    if (sss_better_dipole_from_albedo(&m, albedo, length, 1.3f) != SSS_OK) return 0;

    need.footprint = need.curvature_radius = need.shading_cost = sss_within(&m, 0, sss_profile(&m, 1, 1.0f));
    plan = sss_plan_for(&m, &need, 0);

    if (sss_begin(&s, &m, &plan, at[0], at[1], 1u) != SSS_OK) return 0;
    while (sss_next_probe(&s, &probe)) sss_add_hit(&s, probe.origin, probe.direction, sss_intensity(&s, at[0], at[1]));
    return sss_finish(&s, exits);
}
