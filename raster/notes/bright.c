/* SPDX-License-Identifier: MIT */
/* A note on a full scale that leaves the picture dark: one vertex is far brighter than almost all
 * of the area in view. */
#include "raster/notes/notes.h"

/* The picture is dark if all but a hundredth of it lies below an eighth of full scale: 32 of 255.
 */
static const double dark = 8, bright_share = 0.01;

struct brightest {
    double radiance;
    int surface, vertex, band;
};

/* Raises *largest to the radiance of a vertex in its brightest band. */
static void raise(const struct lit_scene *lit, int surface, int vertex, struct brightest *largest)
{
    const struct surface *of = &lit->surfaces[surface];
    const struct shaded_material *shaded = lit->bounds[surface].shaded;
    const int n_bands = lit->plan->n_bands;
    for (int side = 0; side < of->n_sides; side++) {
        const double *weights = of->weights + surface_attributes(of, vertex, side);
        for (int band = 0; band < n_bands; band++) {
            double radiance = 0;
            for (int t = 0; t < shaded->n_terms; t++)
                radiance +=
                    weights[t] * shaded->made.spectra[(size_t)t * (size_t)n_bands + (size_t)band];
            radiance *= shaded->texture ? shaded->texture->largest : 1;
            if (radiance > largest->radiance)
                *largest = (struct brightest){radiance, surface, vertex, band};
        }
    }
}

/* Returns the brightest of the vertices that may be brighter than this. */
static struct brightest find_brightest(const struct scene_survey *survey, double than)
{
    struct brightest largest = {.surface = -1};
    for (int s = 0; s < survey->lit->plan->n_instances; s++)
        for (int i = 0; survey->surfaces[s].brightest > than &&
                        i < survey->lit->surfaces[s].instance->n_vertices;
             i++)
            if (survey_vertex(survey->lit, s, i) > than)
                raise(survey->lit, s, i, &largest);
    return largest;
}

/* Full scales that the user or a viewer sets are meant. With phong shading a full scale is an upper
 * bound, and no vertex has it. */
bool note_full_scale(const struct scene_survey *survey, struct notes *notes, struct error *err)
{
    const struct plan *plan = survey->lit->plan;
    const struct plan_options *options = &plan->options;
    char object[256], page[BAND_NAME];
    if (options->full_scale > 0 || options->exchangeable || options->bits == 32 ||
        plan->scene->shading == SHADING_PHONG || survey->area < 1)
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
