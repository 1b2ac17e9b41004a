// command.h - what the programs do alike with their command line: parse words, refuse wrong ones in
// one line with exit code 2, load the scene that is asked for. Host only. SPDX-License-Identifier:
// MIT
//
// Define COMMAND, the program's name, before the include. Part of each program, so the names have
// no prefix.
#ifndef COMMAND_H
#define COMMAND_H

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "image.h"
#include "scenes.h"

#define COMMAND_ETA 1.35f // of the dipoles

static inline void fail(int code, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs(COMMAND ": ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(code);
}

static inline double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Is this the option that is meant? Then it must have a value.
static inline int is_option(const char *meant, const char *name, const char *value) {
    if (strcmp(name, meant) != 0) return 0;
    if (!value) fail(2, "%s wants a value", name);
    return 1;
}

static inline long long parse_number(const char *option, const char *text, long long least,
                                     long long most) {
    char *end = NULL;
    errno = 0;
    long long value = strtoll(text, &end, 10);
    if (end == text || *end != '\0' || errno || value < least || value > most) {
        fail(2, "%s wants a whole number from %lld to %lld, not '%s'", option, least, most, text);
    }
    return value;
}

static inline double parse_real(const char *option, const char *text, double least, double most) {
    char *end = NULL;
    double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= least && value <= most)) {
        fail(2, "%s wants a number from %g to %g, not '%s'", option, least, most, text);
    }
    return value;
}

static inline void parse_size(const char *text, int *width, int *height) {
    char *end = NULL;
    long w = strtol(text, &end, 10), h = 0;
    int good = end != text && *end == 'x';
    if (good) {
        const char *rest = end + 1;
        h = strtol(rest, &end, 10);
        good = end != rest && *end == '\0';
    }
    if (!good || w < 1 || h < 1 || w > IMAGE_MAX_SIDE || h > IMAGE_MAX_SIDE) {
        fail(2, "--size wants WxH, each from 1 to %d, not '%s'", IMAGE_MAX_SIDE, text);
    }
    *width = (int)w;
    *height = (int)h;
}

static inline unsigned parse_techniques(const char *text) {
    static const struct {
        const char *name;
        unsigned bit;
    } known[] = {{"disk", SSS_DISK},
                 {"tangents", SSS_DISK_TANGENTS},
                 {"sphere", SSS_SPHERE},
                 {"chord", SSS_CHORD}};
    unsigned bits = 0;
    for (const char *word = text;;) {
        size_t length = strcspn(word, ",");
        unsigned bit = 0;
        for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
            if (strlen(known[i].name) == length && memcmp(word, known[i].name, length) == 0)
                bit = known[i].bit;
        }
        if (!bit)
            fail(2, "--techniques wants some of disk,tangents,sphere,chord, not '%.*s'",
                 (int)length, word);
        bits |= bit;
        if (word[length] == '\0') return bits;
        word += length + 1;
    }
}

// Is `value` one of the words in the list (separated by blanks)?
static inline const char *parse_word(const char *option, const char *value, const char *list) {
    size_t length = strlen(value);
    for (const char *word = list; length && *word;) {
        size_t n = strcspn(word, " ");
        if (n == length && memcmp(word, value, n) == 0) return value;
        word += n + (word[n] == ' ');
    }
    fail(2, "%s wants one of: %s; not '%s'", option, list, value);
    return NULL;
}

// The number of a scene.
static inline int parse_scene(const char *option, const char *value) {
    parse_word(option, value, SCENES_NAMES);
    int which = 0;
    while (strcmp(scenes_known[which].name, value) != 0) which++;
    return which;
}

// `size` scales the mean free paths that come with the scene.
static inline void load_scene(scene *s, int which, const char *profile, float size) {
    scenes_optics optics = scenes_make(s, which);
    for (int c = 0; c < 3; c++) optics.dmfp[c] *= size;
    sss_result result = SSS_OK;
    if (strcmp(profile, "burley") == 0) {
        result = sss_burley(&s->medium, optics.albedo, optics.dmfp);
    } else if (strcmp(profile, "dipole") == 0) {
        result = sss_dipole_from_albedo(&s->medium, optics.albedo, optics.dmfp, COMMAND_ETA);
    } else {
        result = sss_better_dipole_from_albedo(&s->medium, optics.albedo, optics.dmfp, COMMAND_ETA);
    }
    if (result != SSS_OK)
        fail(1, "the medium of %s: %s", scenes_known[which].name, sss_result_string(result));
}

#endif
