/* SPDX-License-Identifier: MIT */
/* Notes on objects that are not in view: why, and what to change in the camera. */
#include <math.h>

#include "raster/notes/notes.h"

/* ---- why an object is not in view ---- */

enum hidden {
    BEHIND,
    TOO_NEAR,
    TOO_FAR,
    OFF_LEFT,
    OFF_RIGHT,
    OFF_BELOW,
    OFF_ABOVE,
    EDGE_ON,
    BESIDE
};
static const char *const where[] = {
    [BEHIND] = "behind the eye",
    [TOO_NEAR] = "before the near plane",
    [TOO_FAR] = "beyond the far plane",
    [OFF_LEFT] = "to the left of the view",
    [OFF_RIGHT] = "to the right of the view",
    [OFF_BELOW] = "below the view",
    [OFF_ABOVE] = "above the view",
    [EDGE_ON] = "exactly edge-on",
    [BESIDE] = "beside the view, or exactly edge-on",
};

/* Vertices in front of the eye, in scene units, and in eye space. */
struct extent {
    double nearest, farthest;
    struct vector low, high;
};

/* Returns how far a vertex lies in front of the eye. */
static double distance_of(const struct plan *plan, const struct window_vertex *vertex)
{
    const struct camera *camera = &plan->scene->camera;
    return camera->perspective ? vertex->clip[3] * plan->unit
                               : 0.5 * (vertex->clip[2] * (camera->far - camera->near) +
                                        camera->far + camera->near);
}

static void extend(const struct lit_scene *lit, int surface, struct extent *extent)
{
    const struct surface *of = &lit->surfaces[surface];
    for (int i = 0; i < of->instance->n_vertices; i++) {
        const double distance = distance_of(lit->plan, &of->vertices[i]);
        const struct vector eye =
            matrix_point(&of->instance->model_view, of->instance->vertices[i].position);
        extent->nearest = fmin(extent->nearest, distance);
        extent->farthest = fmax(extent->farthest, distance);
        extent->low = (struct vector){fmin(extent->low.x, eye.x), fmin(extent->low.y, eye.y),
                                      fmin(extent->low.z, eye.z)};
        extent->high = (struct vector){fmax(extent->high.x, eye.x), fmax(extent->high.y, eye.y),
                                       fmax(extent->high.z, eye.z)};
    }
}

static struct extent nothing(void)
{
    return (struct extent){
        HUGE_VAL, -HUGE_VAL, {HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
}

static enum hidden reason_of(const struct scene_survey *survey, int surface)
{
    const unsigned outside = survey->surfaces[surface].outside;
    const struct camera *camera = &survey->lit->plan->scene->camera;
    struct extent extent = nothing();
    if (outside & 1U << VIEW_NEAR) {
        extend(survey->lit, surface, &extent);
        return camera->perspective && extent.nearest <= 0 ? BEHIND : TOO_NEAR;
    }
    return outside & 1U << VIEW_FAR            ? TOO_FAR
           : outside & 1U << VIEW_LEFT         ? OFF_LEFT
           : outside & 1U << VIEW_RIGHT        ? OFF_RIGHT
           : outside & 1U << VIEW_BELOW        ? OFF_BELOW
           : outside & 1U << VIEW_ABOVE        ? OFF_ABOVE
           : survey->surfaces[surface].reaches ? EDGE_ON
                                               : BESIDE;
}

/* ---- what to change ---- */

/* Returns the middle of an extent in the scene's space. The rows of world_to_eye are the axes of
 * eye space divided by plan->unit. */
static struct vector middle_of(const struct plan *plan, const struct extent *extent)
{
    const struct vector eye = vector_scale(vector_add(extent->low, extent->high), 0.5);
    const double at[3] = {eye.x, eye.y, eye.z};
    struct vector out = plan->scene->camera.eye;
    for (int i = 0; i < 3; i++) {
        const double *row = plan->world_to_eye.row[i];
        out = vector_add(out, vector_scale((struct vector){row[0], row[1], row[2]},
                                           at[i] * plan->unit * plan->unit));
    }
    return out;
}

/* A plane is proposed so much beyond the objects. */
static const double margin = 0.05;

static void advice_text(const struct plan *plan, enum hidden reason, const struct extent *extent,
                        char *out, size_t capacity)
{
    const struct camera *camera = &plan->scene->camera;
    const double depth = extent->farthest - extent->nearest;
    const struct vector middle = middle_of(plan, extent);
    if (reason == TOO_FAR)
        snprintf(out, capacity,
                 "far is %.6g, but the distances there are %.6g to %.6g; write far %.3g",
                 camera->far, extent->nearest, extent->farthest,
                 extent->farthest + margin * fmax(depth, extent->farthest));
    else if (reason == TOO_NEAR)
        snprintf(out, capacity,
                 "near is %.6g, but the distances there are %.6g to %.6g; write near %.3g",
                 camera->near, extent->nearest, extent->farthest,
                 camera->perspective ? extent->nearest * (1 - margin)
                                     : extent->nearest - margin * fmax(depth, camera->far));
    else if (reason == EDGE_ON)
        snprintf(out, capacity, "move the eye");
    else
        snprintf(out, capacity, "turn the camera, as by look %.3g %.3g %.3g", middle.x, middle.y,
                 middle.z);
}

/* ---- notes ---- */

/* The objects that are not in view. */
struct unseen {
    int objects, n, first; /* of all objects; out of view; the first of them */
    enum hidden reason;    /* of the first */
    int alike;             /* out of view for the same reason */
    struct extent extent;  /* of these */
};

/* Returns the first surface of the next object; *area is that of the object in view. */
static int next_object(const struct scene_survey *survey, int surface, double *area)
{
    const struct plan *plan = survey->lit->plan;
    *area = 0;
    do
        *area += survey->surfaces[surface++].area;
    while (surface < plan->n_instances && !begins_object(plan, surface));
    return surface;
}

static struct unseen find_unseen(const struct scene_survey *survey)
{
    struct unseen out = {.first = -1, .extent = nothing()};
    double area;
    for (int s = 0, next; s < survey->lit->plan->n_instances; s = next) {
        next = next_object(survey, s, &area);
        out.objects++;
        if (area > 0)
            continue;
        const enum hidden reason = reason_of(survey, s);
        if (out.n++ == 0) {
            out.first = s;
            out.reason = reason;
        }
        if (reason != out.reason)
            continue;
        out.alike++;
        for (int i = s; i < next; i++)
            extend(survey->lit, i, &out.extent);
    }
    return out;
}

bool note_view(const struct scene_survey *survey, struct notes *notes, struct error *err)
{
    const struct plan *plan = survey->lit->plan;
    const struct unseen unseen = find_unseen(survey);
    char first[256], advice[256], others[96] = "";
    if (unseen.n == 0)
        return survey->area >= 1 ||
               note_add(notes, "small", err,
                        "all objects together cover %.2g pixels: they are too small, or seen "
                        "almost edge-on; move the camera, or make its view narrower",
                        survey->area);
    object_text(plan, unseen.first, first, sizeof first);
    if (unseen.n < unseen.objects)
        return note_add(notes, "out-of-view", err,
                        "%d of %d objects are not in view; the first, %s, lies %s", unseen.n,
                        unseen.objects, first, where[unseen.reason]);
    advice_text(plan, unseen.reason, &unseen.extent, advice, sizeof advice);
    if (unseen.objects > 1)
        snprintf(others, sizeof others, "%d of %d objects lie %s, first ", unseen.alike,
                 unseen.objects, where[unseen.reason]);
    return note_add(notes, "nothing-in-view", err, "nothing is in view: %s%s%s%s; %s", others,
                    first, unseen.objects > 1 ? "" : " lies ",
                    unseen.objects > 1 ? "" : where[unseen.reason], advice);
}
