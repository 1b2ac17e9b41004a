// files.h - what the programs read from files and write to them. Host only.
// SPDX-License-Identifier: MIT
//
// A program tries its outputs before it works, and loses nothing afterwards: each is written into a
// new file beside the one that is meant, and takes its name when it is complete. What was there
// stays until then. Symbolic links are followed. Devices and pipes are written in place, as is a
// file in a folder that takes no new ones. Results are as image.h says.
//
// Define _XOPEN_SOURCE as 700 before the first include.
#ifndef FILES_H
#define FILES_H

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image.h"

#define FILES_BESIDE 100 // names that are tried for the file beside it

// An output: found, then opened, then written, then closed.
typedef struct output {
    const char *path;
    FILE *file;
    struct stat there; // what the path means already
    int is_there;
    char *target; // the file without links; NULL: a device or a pipe
    char *beside; // what is written; NULL: the file itself
} output;

// ---- Outputs

static inline const char *output_find(output *o, const char *path) {
    memset(o, 0, sizeof *o);
    o->path = path;
    o->is_there = stat(path, &o->there) == 0;
    if (o->is_there && S_ISDIR(o->there.st_mode)) return strerror(EISDIR);
    if (o->is_there && !S_ISREG(o->there.st_mode)) return NULL;

    int file = open(path, O_WRONLY | O_CREAT, 0666); // a link to what is not there makes it
    if (file < 0) return strerror(errno);
    close(file);

    o->target = realpath(path, NULL);
    const char *wrong = o->target ? NULL : strerror(errno);
    if (!o->is_there) unlink(o->target ? o->target : path);
    return wrong;
}

static inline void output_free(output *o) {
    free(o->target);
    free(o->beside);
}

// A new file beside the target, with the rights of what is there. Below 0: no such file can be.
static inline int output_open_beside(output *o) {
    size_t room = strlen(o->target) + 16;
    int file = -1;
    o->beside = (char *)malloc(room);
    for (int i = 1; o->beside && file < 0 && i <= FILES_BESIDE; i++) {
        snprintf(o->beside, room, i == 1 ? "%s.part" : "%s.part%d", o->target, i);
        file = open(o->beside, O_WRONLY | O_CREAT | O_EXCL, 0666);
        if (file < 0 && errno != EEXIST) break;
    }
    if (file >= 0 && o->is_there) fchmod(file, o->there.st_mode & 07777);
    return file;
}

// A pipe that nobody reads would wait forever, so it is opened without waiting; and if its reader
// leaves, that is an error like others, not the end of the program.
static inline int output_open_in_place(const output *o) {
    int file = open(o->target ? o->target : o->path, O_WRONLY | O_CREAT | O_NONBLOCK, 0666);
    if (file < 0) return -1;
    fcntl(file, F_SETFL, fcntl(file, F_GETFL) & ~O_NONBLOCK);
    if (!o->target) signal(SIGPIPE, SIG_IGN);
    return file;
}

static inline const char *output_open(output *o, int *file) {
    *file = o->target ? output_open_beside(o) : -1;
    if (*file >= 0) return NULL;

    int no_beside = errno == EACCES || errno == EPERM || errno == EROFS || errno == ENAMETOOLONG;
    if (o->target && !no_beside) return strerror(errno);
    free(o->beside);
    o->beside = NULL;

    *file = output_open_in_place(o);
    if (*file >= 0) return NULL;
    return errno == ENXIO ? "nobody reads from this pipe" : strerror(errno);
}

// Can this file be written? Leaves the disk as it was. A pipe stays open, or its reader would take
// this for the end.
static inline const char *output_try(const char *path) {
    output o;
    int file = -1;
    const char *wrong = output_find(&o, path);
    if (!wrong) wrong = output_open(&o, &file);
    if (!wrong && o.target) close(file);
    if (!wrong && o.beside) unlink(o.beside);
    if (!wrong && o.target && !o.beside && !o.is_there) unlink(o.target);
    output_free(&o);
    return wrong;
}

// Would one of two outputs overwrite the other?
static inline int output_same(const char *path, const char *other) {
    output a, b;
    const char *wrong = output_find(&a, path);
    if (!wrong) wrong = output_find(&b, other);
    else memset(&b, 0, sizeof b);
    int same = !wrong && a.target && b.target && strcmp(a.target, b.target) == 0;
    output_free(&a);
    output_free(&b);
    return same;
}

// Opens the output for writing, as o->file; output_end() must follow.
static inline const char *output_begin(output *o, const char *path) {
    int file = -1;
    const char *wrong = output_find(o, path);
    if (!wrong) wrong = output_open(o, &file);
    if (!wrong && o->target && !o->beside && ftruncate(file, 0) != 0) wrong = strerror(errno);
    if (!wrong && !(o->file = fdopen(file, "wb"))) wrong = strerror(errno);
    if (wrong && file >= 0) close(file);
    if (wrong && o->beside) unlink(o->beside);
    if (wrong) output_free(o);
    errno = 0; // so that output_end() knows whether writing set it
    return wrong;
}

// `wrong`: NULL, or why not all was written that was to be. The system's reason comes first.
static inline const char *output_end(output *o, const char *wrong) {
    int cut = ferror(o->file) != 0;
    cut |= fclose(o->file) != 0;
    if (cut && !wrong) wrong = IMAGE_CUT;
    if (!wrong && o->beside && rename(o->beside, o->target) != 0) wrong = IMAGE_CUT;
    if (wrong && errno) wrong = strerror(errno);
    if (wrong && o->beside) unlink(o->beside);
    output_free(o);
    return wrong;
}

static inline const char *file_write_png(const char *path, const image_bytes *in) {
    output o;
    const char *wrong = output_begin(&o, path);
    return wrong ? wrong : output_end(&o, image_write_png(in, o.file));
}

static inline const char *file_write_pfm(const char *path, const image *in, const char *note) {
    output o;
    const char *wrong = output_begin(&o, path);
    return wrong ? wrong : output_end(&o, image_write_pfm(in, o.file, note));
}

// ---- Ctrl-C: the program goes on to write what is done by then

static inline volatile sig_atomic_t *interrupt_flag(void) {
    static volatile sig_atomic_t flag = 0;
    return &flag;
}

static inline int interrupted(void) { return *interrupt_flag(); }

static inline void interrupt_at_signal(int number) {
    (void)number;
    *interrupt_flag() = 1;
}

// Once: a second Ctrl-C ends the program as ever.
static inline void interrupt_await(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = interrupt_at_signal;
    action.sa_flags = (int)(SA_RESETHAND | SA_RESTART);
    sigaction(SIGINT, &action, NULL);
}

// ---- Inputs

// Opens without waiting for somebody to write into a pipe: a pipe that nobody writes into is empty.
static inline const char *file_open(FILE **out, const char *path) {
    unsigned char first;
    struct stat opened;
    int file = open(path, O_RDONLY | O_NONBLOCK);
    if (file < 0) return strerror(errno);

    ssize_t count = read(file, &first, 1);
    const char *wrong = NULL;
    if (count < 0 && errno != EAGAIN) wrong = strerror(errno);
    if (count == 0) {
        int pipe = fstat(file, &opened) == 0 && S_ISFIFO(opened.st_mode);
        wrong = pipe ? "nobody writes into this pipe" : "it is empty";
    }
    fcntl(file, F_SETFL, fcntl(file, F_GETFL) & ~O_NONBLOCK);
    *out = wrong ? NULL : fdopen(file, "rb");
    if (!*out) {
        if (!wrong) wrong = strerror(errno);
        close(file);
        return wrong;
    }
    if (count == 1) ungetc(first, *out);
    return NULL;
}

// `note`: see image_read_pfm().
static inline const char *file_read_pfm(image *out, const char *path, char **note) {
    FILE *file;
    const char *wrong = file_open(&file, path);
    if (wrong) return wrong;
    wrong = image_read_pfm(out, file, note);
    fclose(file);
    return wrong;
}

#endif
