/* which_model.c - which model sss_plan_for chooses, over the thickness of the object and the width
   of a pixel. Prints a grid for which_model.gp: log10 of both over the dmfp, and the model for a
   tolerance of 10 %. Model 4 is a walk that an error of 30 % would spare. SPDX-License-Identifier:
   MIT */
#include <stdio.h>

#include "sss_resample.h"

#define ALBEDO 0.6f

enum { LAMBERT, DISK, RESAMPLED, WALK, SPARED };

static int model(const sss_medium *m, double radius, double footprint, float tolerance) {
    sss_need need = {0.0f, 0.0f, 0.0f, 0.0f, 0};

    need.curvature_radius = (float)radius;
    need.footprint = (float)footprint;
    need.tolerance = tolerance;
    unsigned techniques = sss_plan_for(m, &need).techniques;
    if (techniques == SSS_LAMBERT) return LAMBERT;
    if (techniques == SSS_WALK) return WALK;
    return techniques == SSS_DISK ? DISK : RESAMPLED;
}

int main(void) {
    static const float albedo[3] = {ALBEDO, ALBEDO, ALBEDO}, dmfp[3] = {1.0f, 1.0f, 1.0f};
    sss_medium m;

    if (sss_burley(&m, albedo, dmfp) != SSS_OK) return 1;
    for (double y = -2.0; y < 1.5; y += 0.01) {
        for (double x = -0.7; x < 1.48; x += 0.01) {
            double radius = pow(10.0, x), footprint = pow(10.0, y);

            int strict = model(&m, radius, footprint, 0.1f);
            int lax = model(&m, radius, footprint, 0.3f);

            printf("%.3f %.3f %d\n", x, y, strict == WALK && lax == RESAMPLED ? SPARED : strict);
        }
        printf("\n");
    }
    return 0;
}
