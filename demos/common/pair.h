// pair.h - the sheet of two pictures side by side, in noise and in mesh: where they are, and what
// stands in their corners. Host only. Part of each program, so its measures have no prefix.
// SPDX-License-Identifier: MIT
#ifndef PAIR_H
#define PAIR_H

#include "window.h"

#define MARGIN 32.0f
#define GAP    16.0f // between the two pictures of a sheet
#define TOP    96.0f // of the pictures
#define FOOTER 104.0f

// Where the left (0) or the right one (1) of this shape is: as large as fits, at the middle of the
// sheet.
static inline box pair_box(const canvas *c, int which, int across, int down) {
    float width = 0.5f * (c->width - 2.0f * MARGIN - GAP);
    float height = c->height - TOP - FOOTER;
    float scale = scene_min(width / (float)across, height / (float)down);
    box b = {0.0f, TOP, (float)across * scale, (float)down * scale};
    b.x = 0.5f * c->width + (which == 0 ? -0.5f * GAP - b.width : 0.5f * GAP);
    return b;
}

static inline const char *pair_resampled_name(int light_aware) {
    return light_aware ? "resampled, light hint" : "resampled";
}

// In a corner of a picture.
static inline void pair_label(canvas *c, float x, float y, int side, unsigned colour,
                              const char *text) {
    float width = canvas_text_width(c, 19.0f, text) + 16.0f;
    canvas_rectangle(c, side == CANVAS_LEFT ? x : x - width, y, width, 27.0f, 0x12151bb0u);
    canvas_text(c, side == CANVAS_LEFT ? x + 8.0f : x - 8.0f, y + 20.0f, 19.0f, side, colour, text);
}

#endif
