// x11.c - what a desktop does to a window. SPDX-License-Identifier: MIT
//
//     x11 density DPI     tells programs that start from now on how dense the screen is
//     x11 close WINDOW    sends what the window's own close button sends
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <X11/Xatom.h>
#include <X11/Xlib.h>

static void set_density(Display *display, const char *dpi) {
    char text[64];
    snprintf(text, sizeof text, "Xft.dpi:\t%s\n", dpi);
    XChangeProperty(display, DefaultRootWindow(display), XA_RESOURCE_MANAGER, XA_STRING, 8,
                    PropModeReplace, (unsigned char *)text, (int)strlen(text));
}

static void close_window(Display *display, Window window) {
    XEvent event;
    memset(&event, 0, sizeof event);
    event.xclient.type = ClientMessage;
    event.xclient.window = window;
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = (long)XInternAtom(display, "WM_DELETE_WINDOW", False);
    XSendEvent(display, window, False, NoEventMask, &event);
}

int main(int count, char **words) {
    Display *display = XOpenDisplay(NULL);
    if (!display || count != 3) return 1;
    if (strcmp(words[1], "density") == 0) set_density(display, words[2]);
    else close_window(display, strtoul(words[2], NULL, 0));
    return XCloseDisplay(display);
}
