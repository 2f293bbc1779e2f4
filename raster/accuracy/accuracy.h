/* SPDX-License-Identifier: MIT */
/* The room "accuracy": by how much a picture differs from one that lights every point of the true
 * surfaces, before it is drawn. */
#ifndef ACCURACY_H
#define ACCURACY_H

#include "data/choice/choice.h"
#include "data/shape/shape.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"

/* ---- measure.c: differences as a detector sees them ---- */

/* CIEDE2000, for an observer who has adapted to the lights; or counts, of the band with most. */
enum measure_unit { MEASURE_CIEDE2000, MEASURE_COUNTS };
struct measure {
    const struct plan *plan;
    enum measure_unit unit;
    double good;       /* of a difference that is certainly not larger a bound comes out */
    double full_scale; /* of counts; 0 until measure_scale has found it */
    double white[3];   /* XYZ of the lights; of a radiance of 1 where the observer sees none */
    int *first;        /* of each shaded material: where its terms are in xyz; owned */
    double (*xyz)[3];  /* of a term of weight 1; owned */
    double (*fine)[3]; /* the same at every nm; NULL: wavelengths do not count; owned */
};
/* Makes the measure of a plan: for its sampling's observer, or for `observer`, a detector's name,
 * where the scene is not sampled. *known: false if the detector is no observer, which CIEDE2000
 * needs; *out is then undefined. The caller always frees *out. */
bool measure_make(const struct plan *plan, enum measure_unit unit, const char *observer,
                  struct measure *out, bool *known, struct error *err);
/* Lets measure_whole count the wavelengths, too: the exact light then has a page at every nm. Does
 * nothing for counts, which are those of single bands. */
bool measure_wavelengths(struct measure *measure, const char *observer, struct error *err);
/* Finds the full scale of counts: the plan's, or the largest radiance of a lit vertex. */
void measure_scale(struct measure *measure, const struct surface *surfaces);
void measure_free(struct measure *measure);
/* A point of a shaded material: the weights of its terms, and its texture. */
struct shaded_point {
    const double *weights;
    double texel;
};
double measure_difference(const struct measure *measure, int shaded, const struct shaded_point *a,
                          const struct shaded_point *b);
/* Returns the difference of a point that is drawn from the exact one, with wavelengths. */
double measure_whole(const struct measure *measure, int shaded, const struct shaded_point *drawn,
                     const struct shaded_point *exact);

/* ---- exact.c: the true surface ---- */

/* A surface whose shading is judged, and the surface that its mesh approximates. */
struct judged_surface {
    const struct plan *plan;
    int shaded;                          /* index of its material */
    const struct surface *surface;       /* lit */
    const struct parameters *parameters; /* of its vertices; NULL: its facets are exact */
    const struct patches *patches;       /* of its shape, if there are parameters */
    struct vector centre;                /* of plan_mesh, as the next */
    double unit;
};
/* Compares a place of a triangle, with its barycentric coordinates there: the drawn light, and the
 * light of the point of the true surface that the window shows. On a mesh file the facets are true,
 * with interpolated normals (Phong 1975). `attributes`: room for those of two points, twice the
 * plan's max_rows + 2. Returns false where the true surface is not seen. */
struct compared_point {
    struct shaded_point drawn, exact;
};
bool compare_point(const struct judged_surface *of, const struct screen_triangle *triangle,
                   const double at[2], const double share[3], double *attributes,
                   struct compared_point *out);
/* Places a point of the mesh in the window; false if it is not in front of the eye. */
bool window_of(const struct judged_surface *of, struct vector position, struct window_vertex *out);
/* Returns whether the outside of a point of the mesh is turned to the eye. */
bool is_front(const struct judged_surface *of, const struct vertex *point);

/* ---- lattice.c: some pixels ---- */

/* A lattice of pixels: each has the same share of the picture, and no row or column has many. */
struct lattice {
    int width, height;              /* of the picture */
    int step, shear, rows, columns; /* pixel (i, j): x = step i + shear j, y = step j */
};
struct lattice_pixel {
    double depth;
    int32_t surface;                 /* -1: background */
    struct screen_triangle triangle; /* that is seen */
};
struct seen_pixels {
    struct lattice lattice;
    struct lattice_pixel *pixels; /* [row][column] that the reference shows; owned */
};
/* Looks at about `wanted` pixels of the picture. Of the surfaces only the window matters. */
bool seen_find(const struct plan *plan, const struct surface *surfaces, int wanted,
               struct seen_pixels *out, struct error *err);
void seen_free(struct seen_pixels *seen);
/* A triangle where it covers a pixel of the lattice. */
struct lattice_fragment {
    const struct screen_triangle *triangle;
    int index; /* of the pixel */
    double at[2], depth;
};
/* Finds the parts of a triangle between the near and the far plane; returns how many. */
int seen_parts(const struct view *view, const struct surface *surface, int triangle,
               struct screen_triangle out[SCREEN_TRIANGLES]);
typedef void lattice_visit(void *context, const struct lattice_fragment *fragment);
/* Visits the pixels that the triangle covers. */
void lattice_scan(const struct lattice *lattice, const struct screen_triangle *triangle,
                  lattice_visit *visit, void *context);
/* Returns whether a triangle in front of the eye lies between the places of the lattice. */
bool lattice_misses(const struct lattice *lattice, const struct surface *surface,
                    const int32_t vertex[3]);
/* Returns the pixel beside a place in the window, or near its border. */
int lattice_beside(const struct lattice *lattice, double x, double y);
/* Writes the centre of a pixel of the lattice; returns false if that lies outside the picture. */
bool lattice_place(const struct lattice *lattice, int index, double at[2]);

/* ---- estimate.c: the error of a picture ---- */

struct accuracy_object {
    int surface;        /* the first of its instances that is seen */
    double quantile_95; /* 95 % of its pixels have at most this error */
    int points;         /* of it that were judged */
};
struct accuracy_estimate { /* wavelengths count if the measure knows them */
    enum measure_unit unit;
    double quantile_95;                /* of all objects' pixels */
    double shading_95, wavelengths_95; /* the same of shading and shape alone; of wavelengths */
    struct accuracy_object *objects;   /* those in view, worst first; owned */
    int n_objects, n_points;           /* n_points: at which the picture was judged */
    bool known; /* or empty: the detector is no observer, or shading is flat or phong */
};
/* Judges pixels that are seen, of surfaces that are lit at the corners that are needed. */
bool accuracy_judge(const struct measure *measure, const struct surface *surfaces,
                    const struct seen_pixels *seen, struct accuracy_estimate *out,
                    struct error *err);
/* Finds the colours of the true surfaces at pixels that are seen. The caller always frees *out. */
struct shown_colours {
    const struct material_terms **materials; /* of each shaded material; owned, as the next */
    struct stimulus *list;
    double *weights;
    int n;
};
bool accuracy_colours(const struct plan *plan, const struct surface *surfaces,
                      const struct seen_pixels *seen, struct shown_colours *out, struct error *err);
void shown_colours_free(struct shown_colours *colours);
/* Judges about `wanted` pixels in CIEDE2000. surfaces: those of the plan, lit. */
bool accuracy_estimate(const struct plan *plan, const struct surface *surfaces, int wanted,
                       struct accuracy_estimate *out, struct error *err);
void accuracy_estimate_free(struct accuracy_estimate *estimate);

#endif
