/* SPDX-License-Identifier: MIT */
/* The room "accuracy": by how much a picture differs from one that lights every point of the true
 * surfaces, before it is drawn; and finer triangles, until it differs by less. */
#ifndef RASTER_BESIDE_ACCURACY_ACCURACY_H
#define RASTER_BESIDE_ACCURACY_ACCURACY_H

#include "data/base/base.h"
#include "data/text/text.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "raster/render/render.h"
#include "spectral.h"

/* ---- estimate.c: the error of a picture ---- */

/* CIEDE2000, for an observer who has adapted to the lights; or counts, of the band with most. */
enum measure_unit { MEASURE_CIEDE2000, MEASURE_COUNTS };
struct accuracy_object {
    int surface;        /* the first of its instances that is seen */
    double quantile_95; /* 95 % of its pixels have at most this error */
    int points;         /* of it that were judged */
};
struct accuracy_estimate { /* of shading; outlines do not count */
    enum measure_unit unit;
    double quantile_95;              /* of all objects' pixels */
    struct accuracy_object *objects; /* those in view, worst first; owned */
    int n_objects, n_points;         /* n_points: at which the picture was judged */
    bool known; /* or empty: the detector is no observer, or shading is flat or phong */
};
/* Judges about `wanted` pixels in CIEDE2000. surfaces: those of the plan, lit. */
bool accuracy_estimate(const struct plan *plan, const struct surface *surfaces, int wanted,
                       struct accuracy_estimate *out, struct error *err);

/* ---- refine.c: from a plan to a finer one ---- */

/* An error that 95 % of the pixels of each object may have at most. */
struct wanted_accuracy {
    double error;
    enum measure_unit unit;
};

struct refined_object {
    int surface;        /* the first of its instances */
    long before, after; /* triangles */
};
struct refine_result {
    struct wanted_accuracy wanted;
    long most_triangles;                    /* that the picture may have */
    double error_before;                    /* quantile_95 of the plan that came in */
    struct accuracy_estimate estimate;      /* of the plan as it is now */
    struct refined_object *objects;         /* that were divided; owned */
    int n_objects, levels;                  /* levels: how often the worst object was divided */
    long triangles_before, triangles_after; /* of the plan */
    bool stopped; /* most_triangles does not allow to divide an object that is not good enough */
};
/* Refines the plan if the options ask for it; otherwise *out stays zeroed. Divides all triangles of
 * an object, again and again, until 95 % of its pixels have at most the wanted error: built-in
 * shapes get twice as many slices, stacks, ..., and edges of mesh files are halved. Objects that
 * are good enough stay as they are, and so does flat shading. The caller always frees *out; after
 * an error the plan can only be freed. */
bool refine_options(const struct options *options, struct plan *plan, struct refine_result *out,
                    struct error *err);
void refine_result_free(struct refine_result *result);

/* ---- refine.c: the error of a picture in words ---- */

extern const struct shading_judge accuracy_judge; /* see raster/render/render.h */

#endif
