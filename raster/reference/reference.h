/* SPDX-License-Identifier: MIT */
/* The reference: what a picture must show, in double precision. A user has to believe this room. It
 * knows vectors and elementary functions, and nothing else of the program. Contracts of functions
 * that a picture is made of stand above their definitions.
 * Illumination is linear: a pixel's radiance is the sum over the terms of its material of weight x
 * spectrum, times its texture. Weights depend on geometry only: one drawing serves all wavelengths.
 * Eye space has the eye at the origin, looks along -z, and has y upwards. The window counts pixels,
 * x to the right and y downwards; pixel centres lie at half-integers; depth is 0 near, 1 far. */
#ifndef RASTER_REFERENCE_REFERENCE_H
#define RASTER_REFERENCE_REFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "data/maths/maths.h"

struct rectangle {
    int x, y, width, height; /* in pixels, from the top left corner of the picture */
};
struct eye_light {
    bool directional, attenuated, spot;
    struct vector position, axis; /* if directional: unit vector towards it; axis: of a spot */
    double attenuation[3], cutoff_cosine, spot_exponent; /* constant, linear, quadratic */
    int first;    /* a number that all lights of the same spectrum share */
    double share; /* this light's radiation as a part of that one's */
};
enum shading_model { GOURAUD, FLAT, PHONG };
struct screen_triangle;
/* Finds the level of detail of a textured triangle at a pixel, from 0 to its last level: the binary
 * logarithm of how many texels a step to the next pixel takes in. */
typedef double detail_finder(const struct screen_triangle *triangle, int x, int y);
struct view {
    int width, height;        /* of the picture */
    struct matrix projection; /* eye space to clip space */
    bool local_viewer;        /* highlights are seen from the eye; otherwise from far along +z */
    enum shading_model shading;
    const struct eye_light *lights;
    int n_lights, n_shadowed;   /* n_shadowed: the last ones, each with terms of its own */
    detail_finder *find_detail; /* only of mipmaps */
};
enum reflection { CONSTANT, DIFFUSE, SPECULAR }; /* constant: the weight is 1 */
struct term {
    enum reflection reflection;
    int light; /* `first` of the lights of its spectrum; -1: none */
};
struct texels { /* rows from the bottom upwards; the texture repeats without end */
    const float *values;
    int width, height;
    bool linear;  /* between texel centres; otherwise the nearest texel */
    int n_levels; /* 1: no mipmaps; otherwise each level lies behind the one before: texel_level */
};
struct instance { /* a placed mesh; owns nothing */
    const struct vertex *vertices;
    const int32_t (*triangles)[3]; /* counter-clockwise seen from outside */
    int n_vertices, n_triangles, n_terms;
    struct matrix model_view, normal_matrix;
    bool mirrored, two_sided; /* model_view turns outsides clockwise; the back is lit by itself */
    const struct term *terms;
    double gloss;
    bool textured, varied; /* varied: texels differ from band to band; pixels keep their place */
    struct texels texels;
};

/* transform.c: surface_open allocates; surface_light does vertex i, in any order or at once. */
struct window_vertex {
    double clip[4], x, y, z, inverse_w; /* x, y, z and 1 / w hold where clip[3] > 0 */
};
struct surface { /* attributes: the weights of terms, then s and t if textured */
    const struct instance *instance;
    struct window_vertex *vertices;
    int n_sides, n_attributes;
    double *weights; /* [vertex][side][attribute]; surface_attributes: where they begin */
};
struct light_work {
    long vertices_lit, points_lit, specular_vertices, power_functions;
};
bool surface_open(const struct instance *instance, struct surface *out); /* false: no memory */
void surface_light(const struct view *view, struct surface *of, int i, struct light_work *work);
void surface_close(struct surface *surface);
size_t surface_attributes(const struct surface *surface, int vertex, int side);
void window_place(const struct view *view, struct window_vertex *vertex); /* from clip, w > 0 */

/* light.c: attributes of a point of the mesh; of a light, as it is seen from a point in eye space:
 * the unit vector towards it, its distance (0 if directional), and what attenuation divides by. */
struct incidence {
    struct vector towards;
    double distance, divisor;
};
struct incidence incidence_at(const struct eye_light *light, struct vector eye);
struct vector half_vector(const struct view *view, struct vector towards, struct vector eye);
void light_point(const struct view *view, const struct instance *of, const struct vertex *point,
                 int side, double *attributes, struct light_work *work);

/* clip.c: cuts a convex polygon; returns how many corners are left, n + 1 at most. */
enum { CLIP_PLANES = 6, CLIP_CORNERS = 3 + CLIP_PLANES };
struct corner {
    double clip[4], share[3]; /* share: barycentric coordinates in the whole triangle */
    int inner, outer;         /* ends of the edge that was cut last; a kept corner itself, twice */
};
struct clip_plane {
    double normal[4], offset; /* inside: normal . clip + offset >= 0 */
};
extern const struct clip_plane depth_planes[2]; /* near, then far */
int clip_polygon(const struct clip_plane *by, const struct corner *in, int n, struct corner *out);

/* cover.c: parts of triangles in the window, and where they are. */
enum { SCREEN_TRIANGLES = 3 }; /* parts that two planes leave, at most */
struct screen_triangle {
    const struct surface *surface;
    int32_t triangle, vertex[3], provoking; /* of the whole; provoking: colours it if flat */
    int side;                               /* 1: the back is seen, and lit by itself */
    bool clockwise; /* with y downwards, before its corners were turned to be so */
    double x[3], y[3], z[3], inverse_w[3], share[3][3], twice_area; /* not negative */
};
struct edge_functions {
    double dx[3], dy[3], e[3]; /* corners minus the point; e[i], opposite to corner i */
};
void whole_corners(const struct surface *surface, const int32_t vertex[3], struct corner out[3]);
void screen_corner(const struct view *view, const struct corner *from, int i,
                   struct screen_triangle *out);
int screen_triangles(const struct view *view, const struct surface *of, int triangle,
                     const struct clip_plane *planes, int n, struct screen_triangle out[]);
int outcode(const struct window_vertex *vertex, const struct rectangle *at, double margin);
void edges_at(const double x[3], const double y[3], double px, double py, struct edge_functions *e);
bool owns_edge(const struct screen_triangle *triangle, int edge, int sense);
bool edges_cover(const struct screen_triangle *triangle, const struct edge_functions *edges);
double depth_at(const struct screen_triangle *triangle, const struct edge_functions *edges);
double covered_depth(const struct screen_triangle *triangle, double px, double py);
double shares_at(const struct screen_triangle *triangle, double px, double py, double out[3]);
bool scan_triangle(const struct screen_triangle *triangle, const struct rectangle *at,
                   double margin, bool (*visit)(void *context, int x, int y), void *context);

/* shade.c, texel.c: a pixel keeps pixel_rows numbers, `stride` apart: the weight of each term times
 * the texture; or, where that varies, the weights and the place in it: in texels of level 0, and
 * with mipmaps the level of detail. */
enum { PLACE_ACROSS, PLACE_UP, PLACE_DETAIL, TEXEL_PLACE };
void shade(const struct view *view, const struct screen_triangle *triangle, const double share[3],
           double *attributes, struct light_work *work);
int pixel_rows(const struct instance *instance);
int place_rows(const struct texels *texels); /* the part of a place that counts: 2, 3 of mipmaps */
void put_rows(const struct instance *instance, const double *attributes,
              const double place[TEXEL_PLACE], double *rows, size_t stride);
void add_term(const double *row, double spectrum, size_t n, double *radiance);
void texel_place(const struct texels *texels, const double s_t[2], double place[2]);
struct texels texel_level(const struct texels *texels, int level);
double texel_at(const struct texels *texels, const double place[TEXEL_PLACE]);
size_t texel_wrapped(double whole, int n); /* a column or row, in [0, n) */

/* draw.c: a rectangle of the picture. No pixel depends on the rectangle. False: no memory. */
struct picture {
    struct rectangle at;
    int32_t *surface, *triangle; /* of each pixel; -1: background */
    double *depth, *rows;        /* of each pixel; [row][pixel], n_rows >= every pixel_rows */
    struct light_work work;      /* of Phong shading */
};
bool picture_draw(const struct view *view, const struct surface *surfaces, int n_surfaces,
                  const struct rectangle *at, int n_rows, struct picture *out);
void picture_free(struct picture *picture);

#endif
