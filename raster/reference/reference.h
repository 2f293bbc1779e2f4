/* SPDX-License-Identifier: MIT */
/* The reference: what a picture must show, in double precision. A user has to believe this room. It
 * knows vectors and elementary functions, and nothing else of the program. draw.c draws:
 * transform.c places vertices in the window, light.c lights them, clip.c cuts triangles at the near
 * and the far plane, cover.c finds the pixels they cover, shade.c interpolates, texel.c looks
 * textures up.
 *
 * Illumination is linear: the radiance of a pixel is the sum over the terms of its material of
 * weight x spectrum, times its texture. Weights depend on geometry only: one drawing serves every
 * wavelength.
 *
 * Eye space has the eye at the origin, looks along -z and has y upwards. The window counts pixels,
 * x to the right and y downwards; pixel centres lie at half-integers; depth goes from 0 (near)
 * to 1. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "data/maths/maths.h"

struct rectangle {
    int x, y, width, height; /* in pixels, from the top left corner of the picture */
};
struct eye_light {
    bool directional, attenuated, spot;
    struct vector position; /* in eye space; of a directional light the unit vector towards it */
    double attenuation[3];  /* constant, linear, quadratic */
    struct vector axis;     /* of a spot, a unit vector */
    double cutoff_cosine, spot_exponent;
    int first;    /* the light that stands for all of the same spectrum; perhaps this one */
    double share; /* this light's radiation as a part of that one's */
};
enum shading_model { GOURAUD, FLAT, PHONG };
struct view {
    int width, height;        /* of the picture */
    struct matrix projection; /* eye space to clip space */
    bool local_viewer;        /* highlights are seen from the eye; otherwise from far along +z */
    enum shading_model shading;
    const struct eye_light *lights;
    int n_lights;
};
enum reflection { CONSTANT, DIFFUSE, SPECULAR }; /* constant: the weight is 1 */
struct term {
    enum reflection reflection;
    int light; /* the first light of its spectrum; -1: none */
};
struct texels { /* rows from the bottom upwards; the texture repeats without end */
    const float *values;
    int width, height;
    bool linear; /* between texel centres; otherwise the nearest texel */
};
struct instance { /* a placed mesh; owns nothing */
    const struct vertex *vertices;
    const int32_t (*triangles)[3]; /* counter-clockwise seen from outside */
    int n_vertices, n_triangles;
    struct matrix model_view, normal_matrix;
    bool mirrored, two_sided; /* model_view turns outsides clockwise; the back is lit by itself */
    const struct term *terms;
    int n_terms;
    double gloss;
    bool textured, varied; /* varied: texels differ from band to band; pixels keep their place */
    struct texels texels;
};

/* transform.c: an instance in the window. Attributes are the weights of terms, then s and t of a
 * textured instance. surface_open allocates, false: no memory; surface_close accepts what it left.
 * surface_light does one vertex; several may be done at the same time. */
struct window_vertex {
    double clip[4], x, y, z, inverse_w; /* x, y, z and 1 / w hold where clip[3] > 0 */
};
struct surface {
    const struct instance *instance;
    struct window_vertex *vertices;
    int n_sides, n_attributes;
    double *weights; /* [vertex][side][attribute] */
};
struct light_work {
    long vertices_lit, points_lit, specular_vertices, power_functions;
};
bool surface_open(const struct instance *instance, struct surface *out);
void surface_light(const struct view *view, struct surface *surface, int vertex,
                   struct light_work *work);
void surface_close(struct surface *surface);
size_t surface_attributes(const struct surface *surface, int vertex, int side); /* in weights */
void window_place(const struct view *view, struct window_vertex *vertex); /* from clip, w > 0 */

/* light.c: the attributes of a point of the mesh, and what they are made of in eye space. */
struct incidence {
    struct vector towards;    /* unit vector to the light */
    double distance, divisor; /* to the light, 0 if directional; attenuation divides by the other */
};
struct incidence incidence_at(const struct eye_light *light, struct vector eye);
struct vector half_vector(const struct view *view, struct vector towards,
                          struct vector eye); /* not of unit length */
bool reflects(const struct instance *instance, const struct eye_light *light); /* any term of it */
void light_point(const struct view *view, const struct instance *instance,
                 const struct vertex *point, int side, double *attributes, struct light_work *work);

/* clip.c: cuts a convex polygon of n corners at a plane. Returns the corners left, n + 1 at most.
 */
enum { CLIP_PLANES = 6, CLIP_CORNERS = 3 + CLIP_PLANES };
struct corner {
    double clip[4], share[3]; /* shares: barycentric coordinates in the whole triangle */
    int whole;                /* 0..2: this corner of the whole triangle; -1: made by a cut */
    int inner, outer; /* ends of the edge that was cut last; of a kept corner, itself twice */
};
struct clip_plane {
    double normal[4], offset; /* inside: normal . clip + offset >= 0 */
};
int clip_polygon(const struct clip_plane *plane, const struct corner *in, int n,
                 struct corner out[CLIP_CORNERS]);

/* cover.c: triangles in the window, and the pixel centres that they cover. */
enum { SCREEN_TRIANGLES = 3 }; /* that the near and the far plane leave of one, at most */
struct screen_triangle {
    int32_t surface, triangle, vertex[3]; /* vertex: of the whole triangle */
    int32_t provoking;                    /* the vertex that colours all of it in flat shading */
    int side;                             /* 1: the back is seen, and lit by itself */
    bool clockwise;                       /* with y downwards, before its corners were turned */
    double x[3], y[3], z[3], inverse_w[3], share[3][3]; /* share: as of struct corner */
    double twice_area;                                  /* not negative */
};
struct edge_functions {
    double dx[3], dy[3], e[3]; /* corners minus the point; e[i], opposite to corner i */
};
void whole_corners(const struct surface *surface, const int32_t vertex[3], struct corner out[3]);
void screen_corner(const struct view *view, const struct surface *surface,
                   const struct corner *corner, int i, struct screen_triangle *out);
void screen_turn(const struct surface *surface, struct screen_triangle *triangle);
int screen_triangles(const struct view *view, const struct surface *surfaces, int surface,
                     int triangle, struct screen_triangle out[SCREEN_TRIANGLES]);
void edges_at(const double x[3], const double y[3], double px, double py,
              struct edge_functions *out);
bool owns_edge(const struct screen_triangle *triangle, int edge, int sense);
bool edges_cover(const struct screen_triangle *triangle, const struct edge_functions *edges);
double depth_at(const struct screen_triangle *triangle, const struct edge_functions *edges);
double covered_depth(const struct screen_triangle *triangle, double px,
                     double py); /* -1: not covered */
double least_of(const double v[3]);
double most_of(const double v[3]);
/* Visits every pixel of `at` whose centre may be covered if corners move by up to `margin` pixels,
 * and a few more; until `visit` returns false, which is returned then. */
bool scan_triangle(const struct screen_triangle *triangle, const struct rectangle *at,
                   double margin, bool (*visit)(void *context, int x, int y), void *context);

/* shade.c, texel.c: a pixel keeps pixel_rows numbers, `stride` apart: the weight of each term times
 * the texture; or, where that varies, the weights and the place in it, in texels. */
double shares_at(const struct screen_triangle *triangle, double px, double py, double out[3]);
void shade(const struct view *view, const struct surface *surface,
           const struct screen_triangle *triangle, const double share[3], double *attributes,
           struct light_work *work);
int pixel_rows(const struct instance *instance);
void put_rows(const struct instance *instance, const double *attributes, const double place[2],
              double *rows, size_t stride);
void texel_place(const struct texels *texels, const double s_t[2], double place[2]);
double texel_at(const struct texels *texels, const double place[2]);
const float *texel_row(const struct texels *texels, double row); /* whole numbers of texels */
size_t texel_column(const struct texels *texels, double column);
void add_term(const double *weights, double spectrum, size_t n, double *radiance); /* n pixels */

/* draw.c: a rectangle of the picture. No pixel depends on the rectangle. False: no memory. */
struct picture {
    struct rectangle at;
    int32_t *surface, *triangle; /* of each pixel; -1: background */
    double *depth, *rows;        /* of each pixel; [row][pixel] */
    struct light_work work;      /* of Phong shading */
};
bool picture_draw(const struct view *view, const struct surface *surfaces, int n_surfaces,
                  const struct rectangle *at, int n_rows, struct picture *out);
void picture_free(struct picture *picture);

#endif
