/* SPDX-License-Identifier: MIT */
/* Only the files of the room "measure" include this. */
#ifndef RASTER_BESIDE_MEASURE_INSIDE_H
#define RASTER_BESIDE_MEASURE_INSIDE_H

#include "data/base/base.h"
#include "data/maths/maths.h"
#include "raster/beside/measure/measure.h"

/* ---- values.c ---- */

enum { SIDE_LEFT, SIDE_RIGHT, SIDE_TOP, SIDE_BOTTOM, SIDES };
struct traits {
    int subpixel_bits, depth_bits; /* as the driver says: GL_SUBPIXEL_BITS, GL_DEPTH_BITS */
    /* coverage.c */
    double edge_px;            /* the largest distance of an edge from its place: of x and of y */
    bool draws[SIDES];         /* pixels whose centres lie on such an edge of a rectangle */
    long centres, odd_centres; /* on edges of any slope; of them against that rule, or off edges */
    long shared_pixels, holes, doubles;                 /* where triangles share edges */
    long sliver_pixels, undefined_pixels, shown_pixels; /* of triangles without area: not
                                             finite ones; those that pass a depth test */
    /* values.c */
    double depth_low, depth_high; /* stored - true depth, in steps of 24 bits */
    int provoking;                /* the corner, from 0, that gives a flat triangle its colour */
    double value_px;      /* how far interpolated values are off, as a shift of the corners */
    double filter_texels; /* how far weights of linear filtering are off */
    bool clamps;          /* colours above 1, although clamps are switched off */
    double power_error, power_ratio; /* of highlights: relative; as a multiple of its bound */
    double normal_roundings;         /* of diffuse light under GL_NORMALIZE */
    /* detail_target.c: the rule for the level of detail that fits best, and the error that it
     * leaves; pixels that differ when they are drawn again */
    struct detail_rule detail;
    double detail_residual;
    long detail_changes;
    /* values.c */
    long seen_pixels, varying_pixels; /* where lit and flat drawings differ in coverage or depth */
};
/* Draws and measures. Fails with EXIT_SYSTEM where OpenGL cannot draw. The canvas that the caller
 * uses must be used again afterwards. */
bool traits_measure(struct contexts *contexts, struct traits *out, struct error *err);

/* ---- driver_profile.c ---- */

/* Makes the profile. Fails, with the row of the table as reason, where the specification does not
 * allow what was measured, or no bound covers it. */
bool traits_profile(const struct traits *traits, struct driver *out, struct error *err);
/* Prints what was measured beside what the specification allows. */
void traits_print(const struct traits *traits, struct printed *to);
void traits_json(const struct traits *traits, struct json *json);

/* A corner in the window: x to the right and y downwards in pixels, z from 0 (near) to 1. */
struct target_corner {
    float position[3], colour[3], normal[3], s_t[2];
};
/* A small picture. Its size is a power of two, so that single precision keeps the places of corners
 * to 1/65536 pixel. */
enum { TARGET = 128, BUFFERED_TRIANGLES = 300 };
enum target_mode {
    TARGET_COLOURS,   /* those of the corners */
    TARGET_FLAT,      /* that of one corner */
    TARGET_TEXTURE,   /* those of the corners, times the bound texture */
    TARGET_HIGHLIGHT, /* (0, 0, 1) . normal, to the power of the gloss; normals are not normalised
                       */
    TARGET_DIFFUSE,   /* (0, 0, 1) . normal, normalised; 0 on backs */
    TARGET_MODES
};
struct target {
    const struct gl_functions *call;
    const struct contexts *contexts;
    struct canvas *canvas;
    unsigned programs[TARGET_MODES], buffers[2]; /* names; programs: of ways with shaders */
    float to_clip[16];                           /* by columns */
    uint64_t random;
    float colours[TARGET][TARGET][4]; /* from the top, as all that follows */
    uint32_t depths[TARGET][TARGET];  /* as OpenGL gives them: see target_depth */
};
/* Every fragment passes, and is counted. */
bool target_open(struct contexts *contexts, struct target **out, struct error *err);
void target_close(struct target *target); /* NULL is fine */
void target_clear(struct target *target);
void target_draw(const struct target *target, const struct target_corner *corners, int n_triangles);
/* Draws BUFFERED_TRIANGLES, with vertices and indices in buffers of OpenGL's. */
void target_draw_buffered(const struct target *target, const struct target_corner *corners);
/* Replaces both matrices, given by columns: corners are then those of an object. */
void target_place(struct target *target, const double projection[16], const double model[16]);
void target_read(struct target *target);
/* Clears the target, draws the triangles, and reads it. */
void target_show(struct target *target, const struct target_corner *corners, int n_triangles);
uint32_t target_depth(const struct target *target, int x, int y); /* in steps of 24 bits */
int target_fragments(const struct target *target, int x, int y);
/* Numbers that are the same on every machine. */
double random_in(struct target *target, double low, double high);
int random_below(struct target *target, int n);
/* Makes the two triangles of a rectangle, of equal depth, colour and normal. */
void rectangle_corners(double left, double top, double right, double bottom,
                       const struct target_corner *like, struct target_corner out[6]);

/* Makes the next triangles be coloured so; gloss: of a highlight. */
void target_shade(const struct target *target, enum target_mode mode, double gloss);

/* Leaves the matrices of its own behind. */
bool measure_detail(struct target *target, struct traits *out, struct error *err);
void measure_coverage(struct target *target, struct traits *out);

#endif
