// window.h - what the two programs with a window have in common: colours, options, keys. Host only. Like command.h part
// of each program, so some names have no prefix. SPDX-License-Identifier: MIT
#ifndef WINDOW_H
#define WINDOW_H

#include "canvas.h"
#include "command.h"

#define PAGE   0x12151bffu
#define TEXT   0xf2f4f8ffu
#define QUIET  0xa9b3c1ffu
#define CHOSEN 0xffb454ffu // what resampling gives, and what it is held against

#define WINDOW_SCENES   "bear sphere slab corner needles"
#define WINDOW_PROFILES "burley dipole better-dipole"

// Their lines of --help; the options of one program alone stand before and between.
#define WINDOW_HELP_SCENE                                                                                              \
    "  --scene NAME       bear (default), sphere, slab, corner, needles\n"                                             \
    "  --profile NAME     burley (default), dipole, better-dipole\n"                                                   \
    "  --candidates M     probes of each resampled lookup (8)\n"                                                       \
    "  --seed S           0..4294967295 (1)\n"
#define WINDOW_HELP_FILES                                                                                              \
    "  --size WxH         window or picture size in pixels (1280x720)\n"                                               \
    "  --png FILE         where key W saves a picture (" COMMAND ".png)\n"                                             \
    "  --headless         no window: write the picture and end\n"                                                      \
    "  --help\n"                                                                                                       \
    "\n"                                                                                                               \
    "The window lists its keys. Without a display: --headless.\n"

static const char *const window_scene[5] = {"bear", "sphere", "slab", "corner", "needles"};
static const char *const window_profile[3] = {"burley", "dipole", "better-dipole"};

typedef struct box {
    float x, y, width, height;
} box;

typedef struct window {
    canvas c;
    int scene, profile, candidates, headless, width, height;
    uint32_t seed;
    const char *png;
    char note[256]; // one line for the user, until the next key
} window;

// ---- Command line

static inline void window_defaults(window *w) {
    w->candidates = 8;
    w->seed = 1;
    w->width = 1280;
    w->height = 720;
    w->png = COMMAND ".png";
}

static inline int index_of(const char *const *names, const char *name) {
    int i = 0;
    while (strcmp(names[i], name) != 0) i++;
    return i;
}

// Which of the options with a value this is; -1 for none. A value that is missing is an error.
static inline int option_index(const char *const *names, int count, const char *name, const char *value) {
    int i = 0;
    while (i < count && strcmp(name, names[i]) != 0) i++;
    if (i < count && !value) fail(2, "%s wants a value", name);
    return i < count ? i : -1;
}

// Takes an option that both programs know. Returns how many words it is, 0 when it is another.
static inline int window_option(window *w, const char *usage, const char *name, const char *value) {
    static const char *const names[] = {"--scene", "--profile", "--candidates", "--seed", "--size", "--png"};
    if (strcmp(name, "--help") == 0) {
        fputs(usage, stdout);
        exit(fflush(stdout) == 0 ? 0 : 1);
    }
    if (strcmp(name, "--headless") == 0) return w->headless = 1;
    switch (option_index(names, 6, name, value)) {
    case 0: w->scene = index_of(window_scene, parse_word(name, value, WINDOW_SCENES)); break;
    case 1: w->profile = index_of(window_profile, parse_word(name, value, WINDOW_PROFILES)); break;
    case 2: w->candidates = (int)parse_number(name, value, 1, SSS_MAX_CANDIDATES); break;
    case 3: w->seed = (uint32_t)parse_number(name, value, 0, 4294967295LL); break;
    case 4: parse_size(value, &w->width, &w->height); break;
    case 5: w->png = value; break;
    default: return 0;
    }
    return 2;
}

// ---- Keys

typedef enum window_change {
    WINDOW_NOTHING,
    WINDOW_SCENE,
    WINDOW_PROFILE,
    WINDOW_CANDIDATES,
    WINDOW_QUIT
} window_change;

static inline void window_save(window *w) {
    const char *wrong = canvas_save(&w->c, w->png);
    if (wrong && w->headless) fail(1, "cannot write %s: %s", w->png, wrong);
    snprintf(w->note, sizeof w->note, wrong ? "cannot write %s: %s" : "wrote %s", w->png, wrong);
    puts(w->note);
    fflush(stdout); // whoever waits for the file may read along
}

// A key that both programs know, as a capital letter: what it changed.
static inline window_change window_key(window *w, int code) {
    int candidates = code == '-' ? w->candidates / 2 : w->candidates * 2;
    w->note[0] = '\0';
    switch (code) {
    case 'S': w->scene = (w->scene + 1) % 5; return WINDOW_SCENE;
    case 'F': w->profile = (w->profile + 1) % 3; return WINDOW_PROFILE;
    case '-':
    case '=':
    case '+':
        if (candidates < 1 || candidates > SSS_MAX_CANDIDATES) return WINDOW_NOTHING;
        w->candidates = candidates;
        return WINDOW_CANDIDATES;
    case 'W': window_save(w); return WINDOW_NOTHING;
    case 'Q': return WINDOW_QUIT;
    default: return WINDOW_NOTHING;
    }
}

// The first keys of the list on the sheet, and its last. Both return where the next may stand.
static inline float window_first_keys(window *w, float x, float y) {
    char text[64];
    snprintf(text, sizeof text, "scene: %s", window_scene[w->scene]);
    x = canvas_key(&w->c, x, y, 'S', text);
    snprintf(text, sizeof text, "profile: %s", window_profile[w->profile]);
    x = canvas_key(&w->c, x, y, 'F', text);
    x = canvas_key(&w->c, x, y, '-', "");
    snprintf(text, sizeof text, "candidates: %d", w->candidates);
    return canvas_key(&w->c, x, y, '+', text);
}
static inline float window_last_keys(window *w, float x, float y) {
    return canvas_key(&w->c, canvas_key(&w->c, x, y, 'W', "save"), y, 'Q', "quit");
}

static inline void window_colour_bar(canvas *c, float x, float y, float width, float height) {
    for (float i = 0.0f; i < width; i += 1.0f) {
        canvas_rectangle(c, x + i, y, 1.3f, height, canvas_scale(i / (width - 1.0f)));
    }
}

#endif
