/* SPDX-License-Identifier: MIT */
/* Refines a plan until its picture is as accurate as is wanted. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data/base/base.h"
#include "data/choice/choice.h"
#include "raster/refine/refine.h"

/* ---- what the picture shows ---- */

/* Lights the corners of the triangles that are seen; for a measure that needs the brightest vertex,
 * all vertices. */
static void light_seen(const struct refinement *of, const struct seen_pixels *seen,
                       struct surface *surfaces)
{
    const struct plan *plan = of->plan;
    struct light_work ignored = {0};
    if (of->measure.unit == MEASURE_COUNTS && !(plan->options.full_scale > 0)) {
        for (int i = 0; i < plan->n_instances; i++)
            if (surfaces[i].instance)
                light_vertices(plan, &plan->view, &surfaces[i], NULL);
        return;
    }
    for (int i = 0; i < seen->lattice.rows * seen->lattice.columns; i++)
        for (int k = 0; k < 3 && seen->pixels[i].surface >= 0; k++)
            surface_light(&plan->view, &surfaces[seen->pixels[i].surface],
                          seen->pixels[i].triangle.vertex[k], &ignored);
}

/* Pixels to be judged: enough to see whether there is work, and enough to rely on. */
enum { SOME_PIXELS = 2048, MANY_PIXELS = 8192 };

/* Looks at so many pixels of the picture, and judges them. The triangles of the pixels point to
 * surfaces that end here: only their depths are of use afterwards. */
static bool look(struct refinement *of, int wanted, struct seen_pixels *seen,
                 struct accuracy_estimate *out, struct error *err)
{
    struct surface *surfaces = surfaces_place(of->plan, err);
    accuracy_estimate_free(out);
    seen_free(seen);
    bool done = surfaces && seen_find(of->plan, surfaces, wanted, seen, err);
    if (done) {
        light_seen(of, seen, surfaces);
        measure_scale(&of->measure, surfaces);
        done = accuracy_judge(&of->measure, surfaces, seen, out, err);
    }
    surfaces_close(surfaces, of->plan->n_instances);
    return done;
}

/* ---- all of it ---- */

/* Gives the plan the refined meshes, and judges its picture again. */
static bool take_meshes(struct refinement *of, struct error *err)
{
    const int n = of->plan->scene->n_objects;
    struct mesh **meshes = calloc((size_t)n + 1, sizeof *meshes);
    struct seen_pixels seen = {.pixels = NULL};
    if (!meshes)
        return error_memory(err);
    for (int i = 0; i < n; i++)
        if (of->of_object[i] >= 0)
            meshes[i] = &of->list[of->of_object[i]].mesh;
    of->measure.good = 0;
    const bool done =
        plan_refine(of->plan, meshes, err) && look(of, MANY_PIXELS, &seen, &of->result->after, err);
    seen_free(&seen);
    free(meshes);
    return done;
}

static bool is_good(const struct judgement *judged, double error)
{
    return judged->shading < HUGE_VALF && (double)judged->shading <= error;
}

/* Refines the meshes until no point that is looked at has more than this error, or until there are
 * too many triangles. */
static bool refine_to(struct refinement *of, double error, struct error *err)
{
    enum { MOST_LEVELS = 32 };
    bool done = true;
    of->judge.error = of->measure.good = error;
    of->changed = true;
    for (int i = 0; i < of->n; i++)
        for (int k = 0; k < of->list[i].mesh.n_triangles; k++)
            of->list[i].settled[k] = is_good(&of->list[i].judged[k], error);
    for (int level = 0; done && of->changed && !of->result->stopped && level < MOST_LEVELS; level++)
        done = refine_level(of, err);
    return done;
}

/* Lists the refined objects, in the order of their first instances. */
static bool list_result(struct refinement *of, struct error *err)
{
    struct refine_result *out = of->result;
    bool *listed = calloc((size_t)of->n + 1, sizeof *listed), done = listed || error_memory(err);
    for (int surface = 0; done && surface < of->plan->n_instances; surface++) {
        const int i = of->of_object[object_of(of->plan, surface)];
        if (i < 0 || listed[i])
            continue;
        const struct refined_object object = {surface, of->list[i].before,
                                              of->list[i].mesh.n_triangles};
        listed[i] = true;
        if (object.after > object.before)
            done = array_add(&out->objects, &out->n_objects, &object, sizeof object, err);
    }
    free(listed);
    out->triangles_after = of->plan->n_triangles;
    return done;
}

/* An outline may be off by a quarter of the wanted CIEDE2000, in pixels, within these limits. No
 * edge becomes shorter than the finer one. */
static const double finest_px = 0.05, coarsest_px = 0.25;

/* The view has so many positions in the width of a pixel. */
static double pixel_width(const struct refinement *of)
{
    return of->plan->scene->positions;
}

static void prepare_judge(struct refinement *of, const struct seen_pixels *seen)
{
    const struct refine_request *wanted = &of->result->wanted;
    const double outline_px = wanted->unit == MEASURE_COUNTS
                                  ? coarsest_px
                                  : fmax(finest_px, fmin(wanted->error / 4, coarsest_px));
    of->judge = (struct judge){.plan = of->plan,
                               .measure = &of->measure,
                               .lattice = &seen->lattice,
                               .pixels = seen->pixels,
                               .shortest_px = pixel_width(of),
                               .outline_px = outline_px * pixel_width(of)};
}

/* Begins again with meshes that are not refined, since the last try made too many triangles. */
static bool begin_again(struct refinement *of, struct error *err)
{
    objects_free(of);
    of->result->stopped = false;
    of->result->levels = 0;
    return objects_list(of, false, err);
}

/* The estimate is right within some percent; where fine textures meet outlines it was 16 % too low.
 * So much less is asked for. */
static const double safe_part = 0.85;

/* Returns whether the rest of the error comes from wavelengths, not from triangles. */
static bool is_shaded_well(const struct refinement *of, const struct accuracy_estimate *estimate)
{
    return estimate->shading_95 <= of->result->wanted.error / 4;
}

/* Returns what wavelengths leave of the wanted error to shading, as if the two were at a right
 * angle. */
static double shading_part(const struct accuracy_estimate *reached, double wanted)
{
    const double wavelengths = reached->wavelengths_95;
    return sqrt(fmax(0, wanted * wanted - wavelengths * wavelengths));
}

/* Returns the factor of the error that is asked for next. */
static double tightening(const struct accuracy_estimate *reached, double wanted)
{
    return fmax(0.4, fmin(0.95 * shading_part(reached, wanted) / reached->shading_95, 0.85));
}

/* Allows edges half as long as before: those may be too long that were not looked at. */
static void shorten_edges(struct refinement *of)
{
    of->judge.shortest_px /= 2;
    for (int i = 0; i < of->n; i++)
        judgements_forget(&of->list[i]);
}

/* Divides triangles until the picture is good enough. Points may have more than the wanted error,
 * as long as 95 % of them do not: so the first try asks for less than is wanted. If that makes too
 * many triangles, the next one asks for less still: all triangles share the error that is left. */
static bool refine_shading(struct refinement *of, struct error *err)
{
    enum { MOST_TRIES = 64 };
    const double wanted = safe_part * of->result->wanted.error;
    const struct accuracy_estimate *after = &of->result->after;
    double error = 1.4 * fmax(shading_part(&of->result->before, wanted), wanted / 4);
    const bool full = of->result->wanted.most_triangles <= of->plan->n_triangles;
    bool good = false, too_many = full;
    for (int try = 0; !good && !full && try < MOST_TRIES; try++) {
        if (!refine_to(of, error, err))
            return false;
        if (of->result->stopped) {
            if (!begin_again(of, err))
                return false;
            too_many = true;
            error *= 1.4;
            of->judge.outline_px *= 1.4;
            continue;
        }
        if (!take_meshes(of, err))
            return false;
        good = too_many || after->quantile_95 <= wanted || is_shaded_well(of, after) ||
               of->judge.shortest_px < finest_px * pixel_width(of);
        /* 95 % of the points usually have two thirds of the error that was asked for; if it is
           more, it is in triangles smaller than a pixel */
        if (after->shading_95 > 0.8 * error)
            shorten_edges(of);
        else
            error *= tightening(after, wanted);
    }
    of->result->stopped = too_many;
    /* where no try was small enough, meshes are not refined, and an earlier try may have been taken
     */
    return good || full || take_meshes(of, err);
}

/* Makes the outlines of a picture finer whose shading is good enough. */
static bool refine_outlines(struct refinement *of, struct error *err)
{
    return refine_to(of, HUGE_VAL, err) && (of->result->levels == 0 || take_meshes(of, err));
}

static bool run(struct refinement *of, struct seen_pixels *seen, struct error *err)
{
    struct refine_result *result = of->result;
    const double wanted = safe_part * result->wanted.error;
    bool done = look(of, SOME_PIXELS, seen, &result->before, err);
    if (done && result->before.quantile_95 > wanted / 2)
        done = look(of, MANY_PIXELS, seen, &result->before, err);
    const bool good =
        done && (result->before.quantile_95 <= wanted || is_shaded_well(of, &result->before));
    if (!done || !objects_list(of, good, err))
        return false;
    prepare_judge(of, seen);
    return (good ? refine_outlines(of, err) : refine_shading(of, err)) && list_result(of, err);
}

static bool refuse_camera(const struct plan *plan, const char *observer, struct error *err)
{
    return error_usage(
        err,
        "--accuracy in CIEDE2000 needs an observer, and %s is none; expected counts, "
        "as --accuracy 8counts",
        plan->sampling ? plan->sampling->detector : observer);
}

static bool refine(struct plan *plan, const struct refine_request *request,
                   struct refine_result *out, struct error *err)
{
    struct refinement of = {.plan = plan, .result = out};
    struct seen_pixels seen = {.pixels = NULL};
    bool known;
    *out = (struct refine_result){.wanted = *request,
                                  .triangles_before = plan->n_triangles,
                                  .triangles_after = plan->n_triangles};
    bool done = measure_make(plan, request->unit, request->observer, &of.measure, &known, err) &&
                (known || refuse_camera(plan, request->observer, err));
    done = done && measure_wavelengths(&of.measure, request->observer, err) &&
           (plan->view.shading == FLAT || run(&of, &seen, err));
    objects_free(&of);
    edges_free(&of.marked);
    measure_free(&of.measure);
    seen_free(&seen);
    return done;
}

bool refine_options(const struct options *options, struct plan *plan, struct refine_result *out,
                    struct error *err)
{
    enum { USUAL_TRIANGLES = 4000000 };
    struct refine_request request = {
        .most_triangles = options->max_triangles > 0 ? options->max_triangles : USUAL_TRIANGLES,
        .observer = options_detector(options)};
    struct wanted_accuracy wanted;
    if (!options->accuracy)
        return true;
    if (!accuracy_read("--accuracy", options->accuracy, &wanted, err))
        return false;
    request.unit = wanted.counts ? MEASURE_COUNTS : MEASURE_CIEDE2000;
    request.error = wanted.error;
    return refine(plan, &request, out, err);
}

void refine_result_free(struct refine_result *result)
{
    accuracy_estimate_free(&result->before);
    accuracy_estimate_free(&result->after);
    free(result->objects);
    *result = (struct refine_result){.objects = NULL};
}
