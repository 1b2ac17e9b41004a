// progress.h - how far the work is: one line that is overwritten on a terminal, a line every few
// seconds elsewhere. Define COMMAND, the program's name, before the include. Host only.
// SPDX-License-Identifier: MIT
#ifndef PROGRESS_H
#define PROGRESS_H

#include <stdio.h>
#include <unistd.h>

#include "command.h"

typedef struct progress {
    const char *label;  // what is under way
    double done, total; // in any unit of work
    double start, printed;
    int terminal;
} progress;

static inline void progress_begin(progress *p, const char *label, double total) {
    p->label = label;
    p->done = 0.0;
    p->total = total;
    p->start = p->printed = now();
    p->terminal = isatty(STDERR_FILENO);
}

static inline void progress_show(progress *p, double done) {
    double time = now();
    if (done <= 0.0 || done >= p->total || time - p->printed < (p->terminal ? 0.1 : 5.0)) return;

    double share = done / p->total;
    double left = (time - p->start) * (1.0 / share - 1.0);
    const char *format =
        p->terminal ? "\r%s: %-24s %3.0f %%, %.0f s left   " : "%s: %s: %.0f %%, %.0f s left\n";
    p->printed = time;
    fprintf(stderr, format, COMMAND, p->label, 100.0 * share, left);
    fflush(stderr);
}

static inline void progress_end(const progress *p) {
    if (p->terminal) fprintf(stderr, "\r%70s\r", "");
}

#endif
