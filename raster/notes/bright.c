/* SPDX-License-Identifier: MIT */
/* A note on a full scale that leaves the picture dark: one vertex is far brighter than almost all
 * of the area in view. */
#include "raster/notes/notes.h"

/* The picture is dark if all but a hundredth of it lies below an eighth of full scale: 32 of 255.
 */
static const double dark = 8, bright_share = 0.01;

struct brightest {
    double radiance;
    int surface, vertex, side, band;
};

/* Raises *largest to the radiance of a side of a vertex in its brightest band. */
static void raise(const struct lit_scene *lit, const struct brightest *at,
                  struct brightest *largest)
{
    const struct surface *of = &lit->surfaces[at->surface];
    const struct shaded_material *shaded = lit->bounds[at->surface].shaded;
    const double *weights = of->weights + surface_attributes(of, at->vertex, at->side);
    const int n_bands = lit->plan->n_bands;
    for (int band = 0; band < n_bands; band++) {
        double radiance = 0;
        for (int t = 0; t < shaded->n_terms; t++)
            radiance +=
                weights[t] * shaded->made.spectra[(size_t)t * (size_t)n_bands + (size_t)band];
        radiance *= shaded->texture ? shaded->texture->largest : 1;
        if (radiance > largest->radiance)
            *largest = (struct brightest){radiance, at->surface, at->vertex, at->side, band};
    }
}

/* Returns the brightest of the vertices that may be brighter than this. */
static struct brightest find_brightest(const struct scene_survey *survey, double than)
{
    const struct lit_scene *lit = survey->lit;
    struct brightest largest = {.surface = -1}, at = {.surface = 0};
    for (; at.surface < lit->plan->n_instances; at.surface++) {
        const struct surface *of = &lit->surfaces[at.surface];
        if (!(survey->surfaces[at.surface].brightest > than))
            continue;
        for (at.vertex = 0; at.vertex < of->instance->n_vertices; at.vertex++)
            for (at.side = 0; at.side < of->n_sides; at.side++)
                if (survey_vertex(lit, at.surface, at.vertex, at.side) > than)
                    raise(lit, &at, &largest);
    }
    return largest;
}

/* Full scales that the user or a viewer sets are meant. Where most is dark, light is missing. With
 * phong shading a full scale is an upper bound, and no vertex has it. */
bool note_full_scale(const struct scene_survey *survey, struct notes *notes, struct error *err)
{
    const struct plan *plan = survey->lit->plan;
    const struct plan_options *options = &plan->options;
    char object[256], page[BAND_NAME];
    if (options->full_scale > 0 || options->exchangeable || options->bits == 32 ||
        plan->scene->shading == SHADING_PHONG || survey->area < 1 ||
        survey->dark_area > 0.5 * survey->area)
        return true;
    const double most = survey_exceeded(survey, bright_share);
    const struct brightest largest = find_brightest(survey, dark * most);
    if (!(largest.radiance > dark * most))
        return true;
    object_text(plan, largest.surface, object, sizeof object);
    band_name(plan, largest.band, page);
    return note_add(notes, "full-scale", err,
                    "the picture is dark: its full scale, %.3g, is the radiance at %s of vertex %d "
                    "of %s; 99 %% of the area in view is below %.3g; try --full-scale %.2g",
                    largest.radiance, page, largest.vertex + 1, object, most, most);
}
