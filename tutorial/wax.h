// wax.h - the wax of all chapters and its profile, as chapter 2 has it.
// SPDX-License-Identifier: MIT
#ifndef WAX_H
#define WAX_H

#include "tutorial/tutorial.h"

// Change these and see what happens. Red, green, blue:
static const double albedo[3] = {0.8, 0.5, 0.35}; // the share of the light that comes back
static const double dmfp[3] = {2, 0.35, 0.15};    // how far it goes: diffuse mean free path

// [burley]
// The length d of Burley's profile for colour c, and the profile for an albedo of 1.
static inline double burley_length(int c) {
    double u = albedo[c] - 0.33;

    return dmfp[c] / (3.5 + 100 * u * u * u * u);
}
static inline double unit_profile(int c, double r) {
    double d = burley_length(c), e = exp(-r / (3 * d));

    return (e * e * e + e) / (8 * pi * d * r);
}
// [/burley]

// [within]
// The integral of the unit profile over the disk of radius r.
static inline double unit_within(int c, double r) {
    double d = burley_length(c);

    return 1 - exp(-r / d) / 4 - exp(-r / (3 * d)) * 3 / 4;
}
// [/within]

// Rd for the three colours.
static inline vec profile(double r) {
    return (vec){albedo[0] * unit_profile(0, r), albedo[1] * unit_profile(1, r),
                 albedo[2] * unit_profile(2, r)};
}

// [radius]
// A distance with the density 2 pi r P(r). It is an exponential random number. Its mean is d with
// probability 1/4 and 3 d with probability 3/4.
static inline double disk_radius(int c) {
    double d = burley_length(c);
    double mean_radius = rnd() < 0.25 ? d : 3 * d;

    return -mean_radius * log(rnd());
}
// [/radius]

#endif
