// entries.h - entries of lookups: where the camera sees a scene's object. Host only.
// SPDX-License-Identifier: MIT
#ifndef ENTRIES_H
#define ENTRIES_H

#include "tracer.h"

typedef struct camera_entry {
    sss_vec3 position, normal;
    int shape;
    float distance; // from the camera
} camera_entry;

// What is seen at (x, y) of the central square, 0..1 each; 0 if it is not the object.
static inline int camera_sees(const scene *s, float x, float y, camera_entry *entry) {
    sss_vec3 direction = tracer_camera(s, 1, 1, x, y);
    scene_hit hit = scene_nearest(s, s->eye, direction, SCENE_NOTHING);
    if (hit.shape < 0) return 0;

    entry->position = scene_along(s->eye, direction, hit.t);
    entry->normal = scene_normal(&s->shape[hit.shape], entry->position);
    entry->shape = hit.shape;
    entry->distance = hit.t;
    return 1;
}

// `count` entries at random; `name` and the number after it name their random numbers.
static inline void camera_entries(const scene *s, uint32_t name, camera_entry *entry, int count) {
    int n = 0;
    for (uint32_t i = 0; n < count; i++) {
        float x = tracer_unit(sss_hash(name, i));
        float y = tracer_unit(sss_hash(name + 1u, i));
        n += camera_sees(s, x, y, &entry[n]);
    }
}

#endif
