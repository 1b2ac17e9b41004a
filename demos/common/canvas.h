// canvas.h - one sheet to draw on: a GLFW window, or a picture in memory by OSMesa where there is
// no display. Host only; link with -lglfw -lstb -ldl. SPDX-License-Identifier: MIT
//
// The sheet has units of its own: at least as many as asked for, as many pixels to a unit as fit.
// So a layout stays whole in every window, and text is cut for the pixels at hand. (0, 0) is the
// top left corner. Colours are 0xRRGGBBAA. OpenGL 1.4 does, and its functions are asked of whoever
// made the context: nothing links to a libGL, OSMesa is opened only when it is needed, and no order
// of libraries matters.
#ifndef CANVAS_H
#define CANVAS_H

#include <dlfcn.h>
#define GLFW_INCLUDE_GLEXT
#include <GLFW/glfw3.h>

#include "image.h"

#ifndef CANVAS_OSMESA
#define CANVAS_OSMESA "libOSMesa.so.8"
#endif

#define CANVAS_GLYPHS   99
#define CANVAS_SIZES    12    // sizes of text held ready
#define CANVAS_ATLAS    1024  // pixels a side
#define CANVAS_DISC     64    // pixels a side
#define CANVAS_RIM      1.25f // see canvas_make_disc()
#define CANVAS_EVENTS   256
#define CANVAS_CONTROLS 24

enum { CANVAS_LEFT = -1, CANVAS_CENTRE = 0, CANVAS_RIGHT = 1 }; // where a text's place is within it

// ---- OpenGL, and OSMesa as far as it is used

typedef void (*canvas_function)(void);

// clang-format off
#define CANVAS_GL(GL) \
    GL(void, Begin, (GLenum)) GL(void, End, (void)) GL(void, Enable, (GLenum)) \
    GL(void, Disable, (GLenum)) GL(void, Vertex2f, (GLfloat, GLfloat)) \
    GL(void, TexCoord2f, (GLfloat, GLfloat)) \
    GL(void, Color4ub, (GLubyte, GLubyte, GLubyte, GLubyte)) \
    GL(void, BlendFunc, (GLenum, GLenum)) GL(void, Viewport, (GLint, GLint, GLsizei, GLsizei)) \
    GL(void, Scissor, (GLint, GLint, GLsizei, GLsizei)) GL(void, LoadIdentity, (void)) \
    GL(void, Ortho, (GLdouble, GLdouble, GLdouble, GLdouble, GLdouble, GLdouble)) \
    GL(void, ClearColor, (GLfloat, GLfloat, GLfloat, GLfloat)) GL(void, Clear, (GLbitfield)) \
    GL(void, Finish, (void)) GL(void, GenTextures, (GLsizei, GLuint *)) \
    GL(void, BindTexture, (GLenum, GLuint)) GL(void, TexParameteri, (GLenum, GLenum, GLint)) \
    GL(void, PixelStorei, (GLenum, GLint)) \
    GL(void, TexImage2D, \
       (GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const GLvoid *)) \
    GL(void, ReadPixels, (GLint, GLint, GLsizei, GLsizei, GLenum, GLenum, GLvoid *))
// clang-format on

#define CANVAS_MEMBER(result, name, arguments) result(APIENTRY *name) arguments;
typedef struct canvas_gl {
    CANVAS_GL(CANVAS_MEMBER)
} canvas_gl;

typedef struct canvas_mesa {
    void *(*create)(GLenum format, GLint depth, GLint stencil, GLint accumulation, void *share);
    GLboolean (*current)(void *context, void *pixels, GLenum type, GLsizei width, GLsizei height);
    canvas_function (*find)(const char *name);
    void (*destroy)(void *context);
} canvas_mesa;

// ---- The sheet

typedef struct canvas_glyphs {
    int pixels; // the size
    GLuint texture;
    stbtt_packedchar glyph[CANVAS_GLYPHS];
} canvas_glyphs;

typedef enum canvas_kind {
    CANVAS_KEY,
    CANVAS_PRESS,
    CANVAS_RELEASE,
    CANVAS_MOVE,
    CANVAS_WHEEL
} canvas_kind;

typedef struct canvas_event {
    canvas_kind kind;
    int code;   // the character of a key (a letter as a capital), the number of a mouse button
    float x, y; // the mouse, in sheet units
    float wheel;
} canvas_event;

// A key that is shown on the sheet: a click on it is the key.
typedef struct canvas_control {
    int code;
    float x, y, width, height;
} canvas_control;

typedef struct canvas {
    canvas_gl gl;
    canvas_mesa mesa;
    GLFWwindow *window; // NULL: OSMesa draws into `pixels`
    void *context;      // OSMesa's
    unsigned char *pixels;
    int pixel_width, pixel_height;
    float least_width, least_height, width, height; // of the sheet: asked for, and what there is
    float unit;                                     // pixels in a sheet unit
    image_font font;
    canvas_glyphs glyphs[CANVAS_SIZES];
    int glyphs_next;
    GLuint disc, spot, using; // the texture of the quads that are being drawn; 0: none are
    canvas_event event[CANVAS_EVENTS];
    int event_first, event_count;
    float mouse_x, mouse_y;
    double answered, longest; // seconds: when events were last taken, the longest time between
    canvas_control control[CANVAS_CONTROLS]; // of this frame
    int controls;
} canvas;

// ---- Events

static inline void canvas_push(GLFWwindow *window, canvas_kind kind, int code, double wheel) {
    canvas *c = (canvas *)glfwGetWindowUserPointer(window);
    if (c->event_count == CANVAS_EVENTS) return;
    canvas_event *e = &c->event[(c->event_first + c->event_count++) % CANVAS_EVENTS];
    e->kind = kind;
    e->code = code;
    e->x = c->mouse_x;
    e->y = c->mouse_y;
    e->wheel = (float)wheel;
}

static inline void canvas_on_character(GLFWwindow *window, unsigned code) {
    int small = code >= 'a' && code <= 'z'; // letters are keys, and count as capitals
    canvas_push(window, CANVAS_KEY, (int)code - (small ? 'a' - 'A' : 0), 0.0);
}
static inline void canvas_on_key(GLFWwindow *window, int key, int scancode, int action,
                                 int modifiers) {
    (void)scancode, (void)modifiers;
    if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) glfwSetWindowShouldClose(window, GLFW_TRUE);
}
static inline void canvas_on_button(GLFWwindow *window, int button, int action, int modifiers) {
    (void)modifiers;
    canvas_push(window, action == GLFW_PRESS ? CANVAS_PRESS : CANVAS_RELEASE, button, 0.0);
}
// Where the mouse was when this event happened: asking for its place would tell where it is by now.
static inline void canvas_on_move(GLFWwindow *window, double x, double y) {
    canvas *c = (canvas *)glfwGetWindowUserPointer(window);
    int width, height;
    glfwGetWindowSize(window, &width, &height); // not pixels everywhere
    c->mouse_x = (float)x / (float)width * c->width;
    c->mouse_y = (float)y / (float)height * c->height;
    canvas_push(window, CANVAS_MOVE, 0, 0.0);
}
static inline void canvas_on_wheel(GLFWwindow *window, double x, double y) {
    (void)x;
    canvas_push(window, CANVAS_WHEEL, 0, y);
}

static inline int canvas_next_event(canvas *c, canvas_event *e) {
    if (c->event_count == 0) return 0;
    *e = c->event[c->event_first];
    c->event_first = (c->event_first + 1) % CANVAS_EVENTS;
    c->event_count--;
    for (int i = 0; i < c->controls && e->kind == CANVAS_PRESS; i++) {
        const canvas_control *k = &c->control[i];
        if (e->x < k->x || e->x > k->x + k->width || e->y < k->y || e->y > k->y + k->height)
            continue;
        e->kind = CANVAS_KEY;
        e->code = k->code;
    }
    return 1;
}

// ---- Opening and closing

static inline const char *canvas_load(canvas_gl *gl, canvas_function (*find)(const char *name)) {
#define CANVAS_FIND(result, name, arguments)                                                       \
    if (!(gl->name = (result(APIENTRY *) arguments)find("gl" #name)))                              \
        return "OpenGL lacks gl" #name;
    CANVAS_GL(CANVAS_FIND)
    return NULL;
}

// C casts no pointer to data, which is what dlsym gives, to one to a function: the bytes are
// copied.
static inline void canvas_symbol(void *library, const char *name, void *function) {
    void *symbol = dlsym(library, name);
    memcpy(function, &symbol, sizeof symbol);
}

static inline const char *canvas_open_memory(canvas *c) {
    void *library = dlopen(CANVAS_OSMESA, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return "drawing without a display needs " CANVAS_OSMESA
               ", in Debian the package libosmesa6";
    canvas_symbol(library, "OSMesaCreateContextExt", &c->mesa.create);
    canvas_symbol(library, "OSMesaMakeCurrent", &c->mesa.current);
    canvas_symbol(library, "OSMesaGetProcAddress", &c->mesa.find);
    canvas_symbol(library, "OSMesaDestroyContext", &c->mesa.destroy);
    if (!c->mesa.create || !c->mesa.current || !c->mesa.find || !c->mesa.destroy)
        return CANVAS_OSMESA " lacks functions";
    c->pixels = (unsigned char *)malloc((size_t)c->pixel_width * (size_t)c->pixel_height * 4u);
    c->context = c->mesa.create(GL_RGBA, 0, 0, 0, NULL);
    if (!c->pixels || !c->context ||
        !c->mesa.current(c->context, c->pixels, GL_UNSIGNED_BYTE, c->pixel_width,
                         c->pixel_height)) {
        return "OSMesa cannot draw a picture of this size";
    }
    return canvas_load(&c->gl, c->mesa.find);
}

static inline const char *canvas_open_window(canvas *c, const char *title) {
    if (!glfwInit())
        return "there is no display to open a window on; --headless --png FILE works without";
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    c->window = glfwCreateWindow(c->pixel_width, c->pixel_height, title, NULL, NULL);
    if (!c->window)
        return "this display opens no window with OpenGL; --headless --png FILE works without";
    glfwMakeContextCurrent(c->window);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(c->window, c);
    glfwSetCharCallback(c->window, canvas_on_character);
    glfwSetKeyCallback(c->window, canvas_on_key);
    glfwSetMouseButtonCallback(c->window, canvas_on_button);
    glfwSetCursorPosCallback(c->window, canvas_on_move);
    glfwSetScrollCallback(c->window, canvas_on_wheel);
    return canvas_load(&c->gl, glfwGetProcAddress);
}

// All that is drawn is quads with a texture. Those of the same one go into one batch, for speed.
static inline void canvas_use(canvas *c, GLuint texture) {
    if (c->using == texture) return;
    if (c->using) c->gl.End();
    c->using = texture;
    if (!texture) return;
    c->gl.BindTexture(GL_TEXTURE_2D, texture);
    c->gl.Begin(GL_QUADS);
}

// Gives a texture its pixels: 1 channel is coverage of white, 2 are brightness and coverage, 3 are
// a colour. `sharp` shows each pixel as a square where it is magnified.
static inline void canvas_upload(canvas *c, GLuint *texture, int width, int height, int channels,
                                 const unsigned char *pixels, int sharp) {
    GLenum format = channels == 1 ? GL_ALPHA : channels == 2 ? GL_LUMINANCE_ALPHA : GL_RGB;
    canvas_use(c, 0);
    if (!*texture) c->gl.GenTextures(1, texture);
    c->gl.BindTexture(GL_TEXTURE_2D, *texture);
    c->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    c->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, sharp ? GL_NEAREST : GL_LINEAR);
    c->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    c->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    c->gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    c->gl.TexImage2D(GL_TEXTURE_2D, 0, (GLint)format, width, height, 0, format, GL_UNSIGNED_BYTE,
                     pixels);
}

// A soft disc, from which points and lines are made: their edges are smooth on every OpenGL. The
// texture reaches CANVAS_RIM times as far as the disc, so that it stays round when it is drawn a
// few pixels wide. Beyond `inner` of its radius it is a half transparent black rim.
static inline void canvas_make_disc(canvas *c, GLuint *texture, float inner) {
    unsigned char pixels[2 * CANVAS_DISC * CANVAS_DISC]; // brightness and coverage
    const float middle = 0.5f * (CANVAS_DISC - 1), radius = 0.5f * CANVAS_DISC / CANVAS_RIM,
                soft = 4.0f;
    for (int i = 0; i < CANVAS_DISC * CANVAS_DISC; i++) {
        float x = (float)(i % CANVAS_DISC) - middle, y = (float)(i / CANVAS_DISC) - middle,
              r = sqrtf(x * x + y * y);
        float inside = fminf(fmaxf(0.5f + (radius - r) / soft, 0.0f), 1.0f);
        float bright = fminf(fmaxf(0.5f + (inner * radius - r) / soft, 0.0f), 1.0f);
        pixels[2 * i] = (unsigned char)(255.0f * bright);
        pixels[2 * i + 1] = (unsigned char)(255.0f * inside * (0.5f + 0.5f * bright));
    }
    c->gl.GenTextures(1, texture);
    c->gl.BindTexture(GL_TEXTURE_2D, *texture);
    c->gl.TexParameteri(GL_TEXTURE_2D, GL_GENERATE_MIPMAP, GL_TRUE);
    canvas_upload(c, texture, CANVAS_DISC, CANVAS_DISC, 2, pixels, 0);
    c->gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
}

// A window, or with `headless` a picture in memory, of this many pixels; the sheet is never smaller
// than `least`. NULL, or a reason to print. Call canvas_close() in every case.
static inline const char *canvas_open(canvas *c, const char *title, int headless, int width,
                                      int height, float least_width, float least_height) {
    memset(c, 0, sizeof *c);
    c->pixel_width = width;
    c->pixel_height = height;
    c->least_width = least_width;
    c->least_height = least_height;
    if (image_font_open(&c->font)) return "cannot read the font " FONT_FILE;
    const char *wrong = headless ? canvas_open_memory(c) : canvas_open_window(c, title);
    if (wrong) return wrong;
    canvas_make_disc(c, &c->disc, 2.0f);
    canvas_make_disc(c, &c->spot, 0.8f);
    if (c->window) c->answered = glfwGetTime();
    return NULL;
}

static inline void canvas_close(canvas *c) {
    if (c->window) glfwDestroyWindow(c->window);
    glfwTerminate();
    if (c->context) c->mesa.destroy(c->context);
    free(c->pixels);
    free(c->font.file);
}

// ---- Frames

static inline int canvas_closing(const canvas *c) { return glfwWindowShouldClose(c->window); }

static inline void canvas_begin(canvas *c, unsigned background) {
    if (c->window) glfwGetFramebufferSize(c->window, &c->pixel_width, &c->pixel_height);
    float across = (float)c->pixel_width / c->least_width,
          down = (float)c->pixel_height / c->least_height;
    c->unit = across < down ? across : down;
    if (!(c->unit > 0.0f)) c->unit = 1.0f; // an iconified window has no pixels
    c->width = (float)c->pixel_width / c->unit;
    c->height = (float)c->pixel_height / c->unit;
    c->gl.Viewport(0, 0, c->pixel_width, c->pixel_height);
    c->gl.LoadIdentity();
    c->gl.Ortho(0.0, (double)c->width, (double)c->height, 0.0, -1.0, 1.0);
    c->gl.ClearColor((float)(background >> 24) / 255.0f, (float)(background >> 16 & 255) / 255.0f,
                     (float)(background >> 8 & 255) / 255.0f, 1.0f);
    c->gl.Clear(GL_COLOR_BUFFER_BIT);
    c->gl.Enable(GL_TEXTURE_2D);
    c->gl.Enable(GL_BLEND);
    c->gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    c->controls = 0;
}

// Takes the events that are there, or waits this long for one; whether there are any. Call it
// often: how long the window went without an answer is kept, from its opening on.
static inline int canvas_poll(canvas *c, double wait) {
    double gap = glfwGetTime() - c->answered;
    if (gap > c->longest) c->longest = gap;
    if (wait > 0.0 && c->event_count == 0) glfwWaitEventsTimeout(wait);
    else glfwPollEvents();
    c->answered = glfwGetTime();
    return c->event_count > 0 || canvas_closing(c);
}

// A look at the events amid a frame. What has been drawn is done first: OpenGL in software would
// leave all of it to the frame's end, and take long there.
static inline void canvas_look(canvas *c) {
    if (!c->window) return;
    canvas_use(c, 0);
    c->gl.Finish();
    canvas_poll(c, 0.0);
}

static inline void canvas_show(canvas *c) {
    canvas_use(c, 0);
    glfwSwapBuffers(c->window);
}

// What is drawn so far, before it is shown: afterwards OpenGL promises nothing. NULL, or why there
// is no picture.
static inline const char *canvas_read(canvas *c, image_bytes *out) {
    const char *wrong = image_bytes_new(out, c->pixel_width, c->pixel_height, 0);
    if (wrong) return wrong;
    canvas_use(c, 0);
    c->gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    c->gl.ReadPixels(0, 0, c->pixel_width, c->pixel_height, GL_RGB, GL_UNSIGNED_BYTE, out->rgb);
    return NULL;
}

// ---- Drawing

static inline void canvas_colour(canvas *c, unsigned colour) {
    c->gl.Color4ub((GLubyte)(colour >> 24), (GLubyte)(colour >> 16), (GLubyte)(colour >> 8),
                   (GLubyte)colour);
}

static inline void canvas_corner(canvas *c, float x, float y, float u, float v) {
    c->gl.TexCoord2f(u, v);
    c->gl.Vertex2f(x, y);
}

// The part u0, v0, u1, v1 of a texture ((0, 0) is where its pixels begin), times a colour, at x, y,
// width, height.
static inline void canvas_image(canvas *c, GLuint texture, const float at[4], const float uv[4],
                                unsigned colour) {
    canvas_use(c, texture);
    canvas_colour(c, colour);
    canvas_corner(c, at[0], at[1], uv[0], uv[1]);
    canvas_corner(c, at[0] + at[2], at[1], uv[2], uv[1]);
    canvas_corner(c, at[0] + at[2], at[1] + at[3], uv[2], uv[3]);
    canvas_corner(c, at[0], at[1] + at[3], uv[0], uv[3]);
}

static inline void canvas_rectangle(canvas *c, float x, float y, float width, float height,
                                    unsigned colour) {
    const float at[4] = {x, y, width, height}, middle[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    canvas_image(c, c->disc, at, middle, colour);
}

// The lines around a rectangle, a pixel wide at least: what is thinner may fall between the pixels.
static inline void canvas_frame(canvas *c, float x, float y, float width, float height, float wide,
                                unsigned colour) {
    wide = fmaxf(wide, 1.0f / c->unit);
    canvas_rectangle(c, x - wide, y - wide, width + 2.0f * wide, wide, colour);
    canvas_rectangle(c, x - wide, y + height, width + 2.0f * wide, wide, colour);
    canvas_rectangle(c, x - wide, y, wide, height, colour);
    canvas_rectangle(c, x + width, y, wide, height, colour);
}

static inline void canvas_disc(canvas *c, GLuint texture, float x, float y, float radius,
                               unsigned colour) {
    float r = CANVAS_RIM * radius;
    const float at[4] = {x - r, y - r, 2.0f * r, 2.0f * r}, uv[4] = {0.0f, 0.0f, 1.0f, 1.0f};
    canvas_image(c, texture, at, uv, colour);
}
static inline void canvas_point(canvas *c, float x, float y, float radius, unsigned colour) {
    canvas_disc(c, c->disc, x, y, radius, colour);
}
// With a dark rim, so that one shows before others of its colour.
static inline void canvas_spot(canvas *c, float x, float y, float radius, unsigned colour) {
    canvas_disc(c, c->spot, x, y, radius, colour);
}

// Its ends are round: half discs, with the disc's middle drawn out between them.
static inline void canvas_line(canvas *c, float x0, float y0, float x1, float y1, float width,
                               unsigned colour) {
    float x = x1 - x0, y = y1 - y0, length = sqrtf(x * x + y * y), r = 0.5f * CANVAS_RIM * width;
    if (!(length > 0.0f)) return;
    x *= r / length;
    y *= r / length;
    const float px[4] = {x0 - x, x0, x1, x1 + x}, py[4] = {y0 - y, y0, y1, y1 + y},
                u[4] = {0.0f, 0.5f, 0.5f, 1.0f};
    canvas_use(c, c->disc);
    canvas_colour(c, colour);
    for (int i = 0; i < 3; i++) {
        canvas_corner(c, px[i] + y, py[i] - x, u[i], 0.0f);
        canvas_corner(c, px[i] - y, py[i] + x, u[i], 1.0f);
        canvas_corner(c, px[i + 1] - y, py[i + 1] + x, u[i + 1], 1.0f);
        canvas_corner(c, px[i + 1] + y, py[i + 1] - x, u[i + 1], 0.0f);
    }
}

// Nothing is drawn outside of this rectangle until canvas_unclip().
static inline void canvas_clip(canvas *c, float x, float y, float width, float height) {
    canvas_use(c, 0);
    c->gl.Enable(GL_SCISSOR_TEST);
    c->gl.Scissor((GLint)(x * c->unit), (GLint)((float)c->pixel_height - (y + height) * c->unit),
                  (GLsizei)(width * c->unit), (GLsizei)(height * c->unit));
}
static inline void canvas_unclip(canvas *c) {
    canvas_use(c, 0);
    c->gl.Disable(GL_SCISSOR_TEST);
}

// Viridis: perceptually even, and readable for the colour-blind. t from 0 to 1; the colour is
// opaque.
static inline unsigned canvas_scale(float t) {
    static const unsigned char rgb[9][3] = {{68, 1, 84},    {71, 45, 123},  {59, 82, 139},
                                            {44, 114, 142}, {33, 145, 140}, {40, 174, 128},
                                            {94, 201, 98},  {173, 220, 48}, {253, 231, 37}};
    float place = t > 0.0f ? (t < 1.0f ? 8.0f * t : 8.0f) : 0.0f;
    int i = place < 7.0f ? (int)place : 7;
    unsigned colour = 0;
    for (int k = 0; k < 3; k++) {
        float low = (float)rgb[i][k], high = (float)rgb[i + 1][k];
        colour = colour << 8 | (unsigned)(low + (high - low) * (place - (float)i) + 0.5f);
    }
    return colour << 8 | 255u;
}

// ---- Text

// Which glyph a character of UTF-8 is, and where the text goes on: ASCII, and what a formula needs.
static inline int canvas_glyph(const char **text) {
    static const char *const more[4] = {"\xcf\x80", "\xc3\x97", "\xc2\xb7",
                                        "\xc2\xb2"}; // pi, times, dot, squared
    for (int i = 0; i < 4; i++) {
        if (strncmp(*text, more[i], 2) == 0) return *text += 2, 95 + i;
    }
    int code = (unsigned char)*(*text)++;
    return code >= 32 && code < 127 ? code - 32 : '?' - 32;
}

// The glyphs of one size, drawn anew when it is not among the last few.
static inline const canvas_glyphs *canvas_glyphs_of(canvas *c, int pixels) {
    static unsigned char coverage[CANVAS_ATLAS * CANVAS_ATLAS];
    for (int i = 0; i < CANVAS_SIZES; i++) {
        if (c->glyphs[i].pixels == pixels) return &c->glyphs[i];
    }
    canvas_glyphs *g = &c->glyphs[c->glyphs_next++ % CANVAS_SIZES];
    int codes[CANVAS_GLYPHS];
    for (int i = 0; i < 95; i++) codes[i] = 32 + i;
    codes[95] = 0x3c0, codes[96] = 0xd7, codes[97] = 0xb7, codes[98] = 0xb2;
    stbtt_pack_context context;
    stbtt_pack_range range;
    memset(&range, 0, sizeof range);
    range.font_size = (float)pixels;
    range.array_of_unicode_codepoints = codes;
    range.num_chars = CANVAS_GLYPHS;
    range.chardata_for_range = g->glyph;
    if (stbtt_PackBegin(&context, coverage, CANVAS_ATLAS, CANVAS_ATLAS, 0, 1, NULL)) {
        stbtt_PackFontRanges(&context, c->font.file, 0, &range, 1);
        stbtt_PackEnd(&context);
    }
    g->pixels = pixels;
    canvas_upload(c, &g->texture, CANVAS_ATLAS, CANVAS_ATLAS, 1, coverage, 0);
    return g;
}

static inline float canvas_text_width(canvas *c, float size, const char *text) {
    const canvas_glyphs *g = canvas_glyphs_of(c, (int)(size * c->unit + 0.5f));
    float x = 0.0f;
    while (*text) x += g->glyph[canvas_glyph(&text)].xadvance;
    return x / c->unit;
}

// `y` is the baseline. Returns the width.
static inline float canvas_text(canvas *c, float x, float y, float size, int side, unsigned colour,
                                const char *text) {
    const canvas_glyphs *g = canvas_glyphs_of(c, (int)(size * c->unit + 0.5f));
    float width = canvas_text_width(c, size, text), inverse = 1.0f / c->unit;
    float px = floorf((x - 0.5f * (float)(side + 1) * width) * c->unit + 0.5f),
          py = floorf(y * c->unit + 0.5f);
    canvas_use(c, g->texture);
    canvas_colour(c, colour);
    while (*text) {
        stbtt_aligned_quad q;
        stbtt_GetPackedQuad(g->glyph, CANVAS_ATLAS, CANVAS_ATLAS, canvas_glyph(&text), &px, &py, &q,
                            1);
        canvas_corner(c, q.x0 * inverse, q.y0 * inverse, q.s0, q.t0);
        canvas_corner(c, q.x1 * inverse, q.y0 * inverse, q.s1, q.t0);
        canvas_corner(c, q.x1 * inverse, q.y1 * inverse, q.s1, q.t1);
        canvas_corner(c, q.x0 * inverse, q.y1 * inverse, q.s0, q.t1);
    }
    return width;
}

// A key as a small cap with what it does beside it, in place of a menu. Returns where the next may
// stand.
static inline float canvas_key(canvas *c, float x, float y, int code, const char *label) {
    const char name[2] = {(char)code, '\0'};
    const char *text = code == ' ' ? "space" : name;
    float cap = canvas_text_width(c, 13.0f, text) + 10.0f;
    canvas_rectangle(c, x, y - 14.0f, cap, 18.0f, 0x3a4453ffu);
    canvas_text(c, x + 5.0f, y, 13.0f, CANVAS_LEFT, 0xffffffffu, text);
    float width =
        cap + 5.0f + canvas_text(c, x + cap + 5.0f, y, 13.0f, CANVAS_LEFT, 0xa9b3c1ffu, label);
    if (c->controls < CANVAS_CONTROLS) {
        const canvas_control control = {code, x, y - 16.0f, width, 22.0f};
        c->control[c->controls++] = control;
    }
    return x + width + (*label ? 13.0f : 3.0f);
}

#endif
