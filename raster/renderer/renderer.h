/* SPDX-License-Identifier: MIT */
/* The room "renderer": the pixels that are to be checked, from wherever they come. A room that has
 * such pixels opens a renderer; the loop over tiles, the check and the report know no more of it
 * than this. A renderer may not know what the reference shows. */
#ifndef RENDERER_H
#define RENDERER_H

#include "raster/bounds/bounds.h"
#include "raster/driver/driver.h"
#include "raster/reference/reference.h"
#include "spectral.h"

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
struct renderer_work {
    long passes, draw_calls;
};

/* Parts of struct shown that a renderer does not have. They are not judged. */
struct renderer_lacks {
    bool numbers; /* surfaces and triangles */
    bool depths;  /* depths and fragments */
};

/* An open renderer of a plan. A room embeds it as the first member of a struct of its own. One
 * thread draws, the one that opened it. A buffer keeps its pixels until something is drawn there
 * again; other threads may read them meanwhile. */
struct renderer {
    const struct renderer_kind *kind;
    struct renderer_names names;
    struct driver driver;      /* by which it is judged */
    struct renderer_work work; /* of all that was drawn so far */
    struct renderer_lacks lacks;
};
struct renderer_kind {
    /* Takes the lit scene of the plan, before the first `aim`. It must outlive the renderer. */
    bool (*take_scene)(struct renderer *of, const struct lit_scene *lit, struct error *err);
    /* Aims at a tile of the picture, of at most the plan's tile size in pixels. */
    void (*aim)(struct renderer *of, const struct rectangle *tile);
    /* Says which first bands `draw` will get on each tile, in this order. Comes before the first
     * `aim`. NULL: any order will do. */
    bool (*expect)(struct renderer *of, const int *first_bands, int n, struct error *err);
    /* Draws bands first_band .. first_band + BANDS_PER_PASS - 1 (those that exist) of the aimed
     * tile into a buffer. Where the plan asks for a check, `identify` comes before. */
    bool (*draw)(struct renderer *of, int buffer, int first_band, double full_scale,
                 struct error *err);
    /* Returns what was last drawn into the buffer: radiances divided by full_scale, rounded to the
     * nearest step where the colour buffer has steps; 4 floats a pixel, rows of the plan's
     * tile_width from the top. */
    const float *(*pixels)(const struct renderer *of, int buffer);
    /* Finds triangles, depths and fragments of the aimed tile. The plan asks for a check. */
    bool (*identify)(struct renderer *of, struct error *err);
    /* Returns what the last `identify` found. x and y count from the tile's top left pixel. A
     * number that no instance has becomes surface n_instances. */
    struct shown (*shown)(const struct renderer *of, int x, int y);
    /* Frees the renderer, also after a failure of the function that opens it. */
    void (*close)(struct renderer *of);
};

/* renderer.c. Takes a pixel from the colours of its triangle's number, and from its depth in 24
 * bits above 8 of fragments. The number is three that single precision holds exactly: the low 16
 * bits of the triangle, its high bits, and the instance + 1. */
struct shown shown_of(const struct plan *plan, const float number[3], uint32_t depth);

#endif
