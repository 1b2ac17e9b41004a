// window.h - what the two programs with a window have in common: colours, options, keys. Host only.
// Like command.h part of each program, so some names have no prefix. SPDX-License-Identifier: MIT
#ifndef WINDOW_H
#define WINDOW_H

#include <pthread.h>

#include "canvas.h"
#include "command.h"
#include "files.h"

#define PAGE   0x12151bffu
#define TEXT   0xf2f4f8ffu
#define QUIET  0xa9b3c1ffu
#define CHOSEN 0xffb454ffu // what resampling gives, and what it is held against

#define WINDOW_PROFILES "burley dipole better-dipole"

// Their lines of --help; the options of one program alone stand before and between.
#define WINDOW_HELP_SCENE                                                                          \
    "  --scene NAME       one of " SCENES_NAMES " (bear)\n"                                        \
    "  --profile NAME     burley (default), dipole, better-dipole\n"                               \
    "  --candidates M     probes of each resampled lookup (8)\n"                                   \
    "  --seed S           0..4294967295 (1)\n"
#define WINDOW_HELP_FILES                                                                          \
    "  --size WxH         window or picture size in pixels (1280x720)\n"                           \
    "  --png FILE         where key W saves a picture (" COMMAND ".png)\n"                         \
    "  --headless         no window: write the picture and end\n"                                  \
    "  --help\n"                                                                                   \
    "\n"                                                                                           \
    "The window lists its keys. Without a display: --headless.\n"

#define WINDOW_HELP_INTERRUPT                                                                      \
    "Ctrl-C ends --headless early: what is done by then is written, and the exit code is 130.\n"

static const char *const window_profile[3] = {"burley", "dipole", "better-dipole"};

typedef struct box {
    float x, y, width, height;
} box;

// What takes longer than a frame may, in a thread of its own.
typedef struct job {
    void (*work)(void *argument);
    void *argument;
    pthread_t thread;
    pthread_mutex_t lock;
    int runs, threaded, ended; // ended: under the lock
} job;

typedef struct window {
    canvas c;
    int scene, profile, candidates, headless, width, height;
    uint32_t seed;
    const char *png;
    char note[256];               // one line for the user, until the next key
    int save;                     // this frame
    image_bytes waiting, written; // pictures that the writer takes next, has now; bottom row first
    const char *wrong;            // with what the writer wrote last
    job writer;
    int failed; // some picture is not written
} window;

// ---- Jobs

static inline void *job_run(void *argument) {
    job *j = (job *)argument;
    j->work(j->argument);
    pthread_mutex_lock(&j->lock);
    j->ended = 1;
    pthread_mutex_unlock(&j->lock);
    glfwPostEmptyEvent(); // the window need not wait any longer
    return NULL;
}

static inline void job_begin(job *j, void (*work)(void *argument), void *argument) {
    j->work = work;
    j->argument = argument;
    j->runs = 1;
    j->ended = 0;
    j->threaded = pthread_create(&j->thread, NULL, job_run, j) == 0;
    if (!j->threaded) job_run(j); // the window stops for it, but it is done
}

// Whether it has ended since this was last asked; with `wait`, when it has.
static inline int job_ends(job *j, int wait) {
    pthread_mutex_lock(&j->lock);
    int ended = j->ended;
    pthread_mutex_unlock(&j->lock);
    if (!j->runs || (!ended && !wait)) return 0;
    if (j->threaded) pthread_join(j->thread, NULL);
    j->runs = 0;
    return 1;
}

// ---- Command line

static inline void window_defaults(window *w) {
    w->scene = SCENES_BEAR;
    w->candidates = 8;
    w->seed = 1;
    w->width = 1280;
    w->height = 720;
    w->png = COMMAND ".png";
    pthread_mutex_init(&w->writer.lock, NULL);
}

static inline int index_of(const char *const *names, const char *name) {
    int i = 0;
    while (strcmp(names[i], name) != 0) i++;
    return i;
}

// Takes an option that both programs know. Returns how many words it is, 0 when it is another.
static inline int window_option(window *w, const char *usage, const char *name, const char *value) {
    if (strcmp(name, "--help") == 0) {
        fputs(usage, stdout);
        exit(fflush(stdout) == 0 ? 0 : 1);
    }
    if (strcmp(name, "--headless") == 0) return w->headless = 1;
    if (is_option("--scene", name, value)) {
        w->scene = parse_scene(name, value);
    } else if (is_option("--profile", name, value)) {
        w->profile = index_of(window_profile, parse_word(name, value, WINDOW_PROFILES));
    } else if (is_option("--candidates", name, value)) {
        w->candidates = (int)parse_number(name, value, 1, SSS_MAX_CANDIDATES);
    } else if (is_option("--seed", name, value)) {
        w->seed = (uint32_t)parse_number(name, value, 0, 4294967295LL);
    } else if (is_option("--size", name, value)) {
        parse_size(value, &w->width, &w->height);
    } else if (is_option("--png", name, value)) {
        w->png = value;
    } else {
        return 0;
    }
    return 2;
}

// ---- Pictures and frames

static inline void window_write(void *argument) {
    window *w = (window *)argument;
    stbi_flip_vertically_on_write(1);
    w->wrong = file_write_png(w->png, &w->written);
}

static inline void window_tell(window *w, const char *wrong) {
    snprintf(w->note, sizeof w->note, wrong ? "cannot write %s: %s" : "wrote %s", w->png, wrong);
    fprintf(wrong ? stderr : stdout, "%s%s\n", wrong ? COMMAND ": " : "", w->note);
    fflush(stdout); // whoever waits for the file may read along
    w->failed |= wrong != NULL;
}

// Takes what is drawn. One that still waits for the writer gives way: this one would overwrite it
// at once.
static inline void window_save(window *w) {
    free(w->waiting.rgb);
    const char *wrong = canvas_read(&w->c, &w->waiting);
    if (wrong) window_tell(w, wrong);
    w->save = 0;
}

// Tells of the picture that the writer has finished, and gives it the next. With `wait`, until
// there is none left.
static inline void window_write_pictures(window *w, int wait) {
    do {
        if (job_ends(&w->writer, wait)) {
            window_tell(w, w->wrong);
            free(w->written.rgb);
        }
        if (w->writer.runs || !w->waiting.rgb) continue;
        w->written = w->waiting;
        w->waiting.rgb = NULL;
        job_begin(&w->writer, window_write, w);
    } while (wait && w->writer.runs);
}

static inline void window_show(window *w) {
    if (w->save) canvas_look(&w->c), window_save(w), canvas_look(&w->c);
    window_write_pictures(w, 0);
    canvas_show(&w->c);
}

static inline void window_close(window *w) {
    if (w->c.window) {
        glfwHideWindow(w->c.window);
        printf("the window went %.0f ms without an answer at most\n", 1e3 * w->c.longest);
    }
    window_write_pictures(w, 1);
    canvas_close(&w->c);
}

// ---- Keys

typedef enum window_change {
    WINDOW_NOTHING,
    WINDOW_SCENE,
    WINDOW_PROFILE,
    WINDOW_CANDIDATES,
    WINDOW_QUIT
} window_change;

// A key that both programs know, as a capital letter: what it changed.
static inline window_change window_key(window *w, int code) {
    int candidates = code == '-' ? w->candidates / 2 : w->candidates * 2;
    w->note[0] = '\0';
    switch (code) {
    case 'S': w->scene = (w->scene + 1) % SCENES; return WINDOW_SCENE;
    case 'F': w->profile = (w->profile + 1) % 3; return WINDOW_PROFILE;
    case '-':
    case '=':
    case '+':
        if (candidates < 1 || candidates > SSS_MAX_CANDIDATES) return WINDOW_NOTHING;
        w->candidates = candidates;
        return WINDOW_CANDIDATES;
    case 'W': w->save = 1; return WINDOW_NOTHING;
    case 'Q': return WINDOW_QUIT;
    default: return WINDOW_NOTHING;
    }
}

// The first keys of the list on the sheet, and its last. Both return where the next may stand.
static inline float window_first_keys(window *w, float x, float y) {
    char text[64];
    snprintf(text, sizeof text, "scene: %s", scenes_known[w->scene].name);
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
