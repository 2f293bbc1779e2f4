/* SPDX-License-Identifier: MIT */
/* Only the files of the room "accuracy" include this. */
#ifndef RASTER_BESIDE_ACCURACY_INSIDE_H
#define RASTER_BESIDE_ACCURACY_INSIDE_H

#include "raster/beside/accuracy/accuracy.h"

/* CIEDE2000, for an observer who has adapted to the lights; or counts, of the band with most. */
enum measure_unit { MEASURE_CIEDE2000, MEASURE_COUNTS };

/* ---- shading_error.c: differences as a detector sees them ---- */

struct measure {
    const struct lit_scene *lit;
    enum measure_unit unit;
    bool known;       /* false: the detector is no observer, which CIEDE2000 needs */
    double white[3];  /* XYZ of the lights; of a radiance of 1 where the observer sees none */
    double (*xyz)[3]; /* [shaded material][max_rows]: of a term of weight 1; owned */
};
/* Makes the measure of a scene: for its sampling's observer, or for `observer`, a detector's name,
 * where the scene is not sampled. A measure that is not known measures nothing. The caller always
 * frees out->xyz. */
bool measure_make(const struct lit_scene *lit, enum measure_unit unit, const char *observer,
                  struct measure *out, struct error *err);
/* A point of a shaded material: the weights of its terms, and its texture. */
struct shaded_point {
    const double *weights;
    double texel;
};
double measure_difference(const struct measure *measure, int shaded, const struct shaded_point *a,
                          const struct shaded_point *b);

/* ---- per_pixel.c: the true surface ---- */

/* A surface whose shading is judged, and the surface that its mesh approximates. */
struct judged_surface {
    const struct lit_scene *lit;
    const struct placed_instance *placed;
    const struct plan_mesh *mesh;  /* without parameters its facets are exact */
    const struct surface *surface; /* lit */
    const struct patches *patches; /* of its shape, if there are parameters */
};
/* Finds both lights at a place of a triangle: the drawn light, and the light of the point of the
 * true surface that the window shows. On a mesh file the facets are true, with interpolated normals
 * (Phong 1975). Shadows are those of the facets, on all surfaces. `attributes`: room for those of
 * two points, twice the plan's max_rows + 2. Returns false where the true surface is not seen. */
bool compare_point(const struct judged_surface *of, const struct screen_triangle *triangle,
                   const double at[2], double *attributes, struct shaded_point out[2]);

/* ---- estimate.c: the error of a picture ---- */

struct accuracy_object {
    int surface;        /* the first of its instances that is seen */
    double quantile_95; /* 95 % of its pixels have at most this error */
    int points, n_fine; /* of it that were judged; of these, on triangles smaller than a pixel */
};
struct accuracy_estimate { /* of shading; outlines do not count */
    enum measure_unit unit;
    double quantile_95;              /* of all objects' pixels */
    struct accuracy_object *objects; /* those in view, worst first; owned */
    int n_objects, n_points;         /* n_points: at which the picture was judged */
    bool known; /* or empty: the detector is no observer, or shading is flat or phong */
};
/* Judges about `wanted` pixels, for an observer as measure_make takes him; none where no surface is
 * lit. Counts need the full scale. *out comes in with its unit, and otherwise zeroed or from an
 * earlier call. The caller frees out->objects, also after a failure. */
bool accuracy_estimate(const struct lit_scene *lit, const char *observer, int wanted,
                       struct accuracy_estimate *out, struct error *err);

#endif
