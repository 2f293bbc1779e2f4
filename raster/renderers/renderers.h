/* SPDX-License-Identifier: MIT */
/* The room "renderers": the pixels that are to be checked, from wherever they come, and the known
 * properties of each implementation of OpenGL, which bounds, candidates and check read. A room that
 * has such pixels opens a renderer; the loop over tiles, the check and the report know no more of
 * it than this. A renderer may not know what the reference shows. */
#ifndef RASTER_RENDERERS_RENDERERS_H
#define RASTER_RENDERERS_RENDERERS_H

#include "raster/reference/reference.h"
#include "spectral.h"

struct lit_scene;
struct plan;
struct plan_options;

/* ---- detail.c: the level of detail of a texture with mipmaps ---- */

/* How it follows from the places of pixels in the texture. All of 0: the specification's
 * definition, by partial derivatives at the pixel's centre. */
enum detail_logarithm { LOGARITHM_EXACT, LOGARITHM_LINEAR, LOGARITHM_TABLE };
struct detail_rule {
    bool quad;         /* by differences in a quad of 2 x 2 pixels, from one of its corners on: */
    bool right, lower; /* this one */
    int first_row;     /* rows first_row + 2 i and the next one make quads; columns 2 i do */
    bool largest;      /* the largest component of the steps counts; otherwise their length */
    enum detail_logarithm logarithm;
};
/* The pixels whose centres a rule looks at: x[i], y[i]; steps run from the first to the others. */
struct detail_pixels {
    int x[3], y[3];
};
struct detail_pixels detail_pixels(const struct detail_rule *rule, int x, int y);
/* Finds the steps of a textured triangle's place, in texels: [to pixel 1, to pixel 2][s, t]. */
void detail_steps(const struct detail_rule *rule, const struct screen_triangle *triangle, int x,
                  int y, double steps[2][2]);
/* Returns the level of detail for such steps: not below 0, nor beyond the last level. It never
 * falls where a step grows. */
double detail_of(const struct detail_rule *rule, int n_levels, double steps[2][2]);
detail_finder detail_find; /* by the specification's definition */

/* ---- driver.c: the known properties of drivers ---- */

/* The rule that gives a pixel to a triangle when its centre lies exactly on an edge. */
enum fill_rule { FILL_ANY, FILL_LEFT_BOTTOM };
struct driver {
    const char *name; /* what GL_RENDERER begins with; "unknown": the worst of all others;
                         "measured", "measured before": see raster/beside/measure */
    bool is_measured;
    double grid_px; /* corners are moved to a grid before edges are followed: by up to this */
    double edge_roundings;  /* of the largest window coordinate, while an edge is followed */
    double depth_roundings; /* of a depth of 1, while it is stored: half is a step of 24 bits */
    double value_roundings; /* of a plane at a pixel, relative to its value there */
    double corner_px;       /* planes of values run through corners that are moved by up to this */
    double filter_texels;   /* linear filtering mixes as for a place that is off by up to this */
    double lighting;        /* errors of lighting are at most so many times Mesa's */
    bool left_origin;       /* planes of values begin at the left of the picture */
    bool watertight;        /* a pixel where triangles meet belongs to exactly one of them */
    enum fill_rule fill_rule;
    struct detail_rule detail; /* with another one, OpenGL's level of detail is off by up to */
    double detail_error;       /* this; negative: it is any that the specification allows */
};
/* NULL stands for an unknown one. */
const struct driver *driver_of(const char *gl_renderer);
bool driver_is_known(const struct driver *driver); /* by its name: neither unknown nor measured */
/* Changes a driver that is known to one of an older Mesa, if GL_VERSION names such a one. */
void driver_of_version(struct driver *driver, const char *gl_version);

/* Writes the properties of a driver in words. */
enum { DRIVER_WORDS = 224 };
void driver_print(const struct driver *driver, char out[DRIVER_WORDS]);

/* The way in which OpenGL draws: with lighting of its own (OpenGL 1.x); with our shaders, by OpenGL
 * 3.3 core or by OpenGL ES 3.0. */
enum gl_way { GL_WITHOUT_SHADERS, GL_CORE, GL_ES, GL_WAYS };
/* driver.c. The words of --renderer: for each way its own word, then that with each of Mesa's
 * drivers; "raster", NULL. */
enum { WAY_WORDS = 3 };
extern const char *const renderer_words[GL_WAYS * WAY_WORDS + 2];
/* Returns the way of such a word, NULL: none was given. *driver: Mesa's; NULL: any. */
enum gl_way driver_way(const char *renderer, const char **driver);
/* Accepts the words of --gl: "osmesa", "egl", "egl:N", "auto". */
bool driver_accepts_library(const char *option, const char *value, struct error *err);
int driver_device(const char *library); /* N of "egl:N"; -1 of other words */

/* driver_threads.c. Refuses a driver that has fewer threads than it has asked for. Where the system
 * gives llvmpipe fewer, Mesa 22.3.6 goes on, and then waits for ever: its fences count the threads
 * that were asked for (lp_fence_create in lp_setup.c). */
bool driver_has_threads(const char *gl_renderer, struct error *err);

/* The nearest fragment of a pixel, as the renderer draws it. */
struct shown {
    int32_t surface, triangle; /* -1: background */
    uint32_t depth;            /* in steps of 1 / (2^24 - 1) */
    uint8_t fragments;         /* drawn there, hidden ones too, modulo 256 */
};
struct renderer_names {
    char library[16], renderer[128], version[128]; /* "OSMesa" or "EGL", GL_RENDERER, GL_VERSION;
                                                      empty: nothing draws */
};
/* A library of OpenGL as it describes itself. */
struct context_description {
    struct renderer_names names;
    char vendor[128];
    int largest_viewport[2], largest_texture; /* pixels, texels, a side */
    int subpixel_bits, depth_bits;
};
struct renderer_work {
    long passes, draw_calls;
};

/* Parts of struct shown that a renderer does not have. They are not judged. */
struct renderer_lacks {
    bool numbers; /* surfaces and triangles */
    bool depths;  /* depths and fragments */
};

/* An open renderer of a plan. A room embeds it as the first member of a struct of its own. One
 * thread draws, the one that opened it. Frames drawn at once: every OpenGL ES 3.0 has four buffers
 * of colours; with more of them a render is not faster, measured on llvmpipe. */
enum { MOST_BUFFERS = 8, MOST_AT_ONCE = 4 };
struct renderer {
    const struct renderer_kind *kind;
    /* Each buffer has its last drawing, until something is drawn there again; other threads may
     * read it meanwhile: radiances divided by full_scale, rounded to the nearest step where the
     * colour buffer has steps; 4 floats a pixel, rows of the plan's tile_width from the top; owned
     */
    float *buffers[MOST_BUFFERS];
    int n_at_once; /* frames that it draws at once, each into a buffer of its own */
    struct renderer_names names;
    struct driver driver;      /* by which it is judged */
    struct renderer_work work; /* of all that was drawn so far */
    struct renderer_lacks lacks;
    bool unfiltered; /* it refuses linear textures */
};
/* Frames that are drawn at once: in each, bands first_band .. first_band + BANDS_PER_PASS - 1
 * (those that exist) go into a buffer. */
struct frame_batch {
    int n, buffers[MOST_AT_ONCE], first_bands[MOST_AT_ONCE];
};
/* All but `shown` may be NULL, where a renderer has nothing to do: its pixels are there already. */
struct renderer_kind {
    /* Takes the lit scene of the plan, with its full scale, before the first `aim`. It must outlive
     * the renderer. */
    bool (*take_scene)(struct renderer *of, const struct lit_scene *lit, struct error *err);
    /* Aims at a tile of the picture, of at most the plan's tile size in pixels. */
    void (*aim)(struct renderer *of, const struct rectangle *tile);
    /* Draws at most n_at_once frames of the aimed tile. Where the plan asks for a check, `identify`
     * comes before. */
    bool (*draw)(struct renderer *of, const struct frame_batch *batch, struct error *err);
    /* Finds triangles, depths and fragments of the aimed tile. The plan asks for a check. */
    bool (*identify)(struct renderer *of, struct error *err);
    /* Returns what the last `identify` found. x and y count from the tile's top left pixel. A
     * number that no instance has becomes surface n_instances. */
    struct shown (*shown)(const struct renderer *of, int x, int y);
    /* Frees the renderer, also after a failure of the function that opens it. NULL: another owns
     * it.
     */
    void (*close)(struct renderer *of);
};

/* renderer.c. Makes so many buffers of n pixels, of what `what` names; and frees them with the
 * struct that the renderer is the first member of. */
bool renderer_make_buffers(struct renderer *of, int n_buffers, size_t n, const char *what,
                           struct error *err);
void renderer_free(struct renderer *of);
/* Takes a pixel from the colours of its triangle's number, and from its depth in 24 bits above 8 of
 * fragments. The number is three that single precision holds exactly: the low 16 bits of the
 * triangle, its high bits, and the instance + 1. */
struct shown shown_of(int n_instances, const float number[3], uint32_t depth);

/* ---- the ways of drawing that this program has ---- */

/* How this program draws through OpenGL: see raster/beside/ways.c. */
struct drawing_ways {
    /* Opens a renderer of a plan, which must outlive *out, with so many buffers, and one more for
     * each frame that it draws at once beyond the first; at most MOST_BUFFERS. Fails with
     * EXIT_SYSTEM where there is no usable OpenGL, or not the driver that the plan asks for. The
     * caller closes *out unless it is NULL, also after a failure. One can be open at a time. NULL:
     * this program does not draw so. */
    bool (*open[GL_WAYS])(const struct plan *plan, int n_buffers, struct renderer **out,
                          struct error *err);
    /* Measures the driver that these options choose, by a renderer of its own; none is open. Fails
     * with EXIT_SYSTEM, and the reason, where the driver cannot be checked. NULL: cannot measure.
     */
    bool (*measure)(const struct plan_options *by, struct driver *out, struct error *err);
    /* Writes name, version and driver of the library that is used by default, or that it cannot
     * draw, and returns whether it can. NULL: no OpenGL. */
    bool (*library)(char *out, size_t capacity);
};
extern const struct drawing_ways drawing_ways;
bool gl_is_built(void); /* this program can draw through OpenGL */

#endif
