/* SPDX-License-Identifier: MIT */
/* Finds the passes that OpenGL need not draw: all radiance is a sum of weights x spectra x texture,
 * and weights are the same in all bands. Only the materials of instances in view count, and lights
 * that reach these. */
#include <stdlib.h>

#include "raster/plan/plan.h"

/* Returns the product of a term in channel c of a pass; 0 where there is no such band, and in the
 * pass DARK. */
static double product(const struct plan *plan, const double *row, int pass, int c)
{
    const int band = pass * BANDS_PER_PASS + c;
    return band >= 0 && band < plan->n_bands ? row[band] : 0;
}

static bool term_is_same(const struct plan *plan, const double *row, int a, int b)
{
    for (int c = 0; c < BANDS_PER_PASS; c++)
        if (product(plan, row, a, c) != product(plan, row, b, c))
            return false;
    return true;
}

/* The terms that may show: of materials in view, and of light that reaches them. */
struct reaching_terms {
    const struct plan *plan;
    bool *reaches; /* of each light: it, or one that it is the first of, reaches something */
};

/* Returns the products of a term, one in each band; NULL: the term does not show. */
static const double *row_of(const struct reaching_terms *of, const struct shaded_material *shaded,
                            int term)
{
    const int light = shaded->terms[term].light;
    if (!shaded->shown || (light >= 0 && !of->reaches[light]))
        return NULL;
    return shaded->made.spectra + (size_t)term * (size_t)of->plan->n_bands;
}

/* Returns whether two passes show the same; b may be DARK. A spectral texture may differ between
 * passes. */
static bool is_same(const struct reaching_terms *of, int a, int b)
{
    for (int m = 0; m < of->plan->n_materials; m++) {
        const struct shaded_material *shaded = &of->plan->materials[m];
        if (b != DARK && shaded->shown && texture_is_drawn(of->plan, shaded->texture) &&
            shaded->texture->spectral)
            return false;
        for (int t = 0; t < shaded->n_terms; t++) {
            const double *row = row_of(of, shaded, t);
            if (row && !term_is_same(of->plan, row, a, b))
                return false;
        }
    }
    return true;
}

static void find_frames(const struct reaching_terms *of, struct passes *out)
{
    const bool complete = of->plan->options.complete;
    for (int i = 0; i < of->plan->n_lights; i++)
        if (!of->plan->is_idle[i])
            of->reaches[of->plan->lights[i].first] = true;
    for (int pass = 0; pass < of->plan->n_passes; pass++) {
        out->frame[pass] = DARK;
        if (!complete && is_same(of, pass, DARK)) {
            out->n_dark++;
            continue;
        }
        if (complete || out->n_frames == 0 ||
            !is_same(of, out->first_pass[out->n_frames - 1], pass))
            out->first_pass[out->n_frames++] = pass;
        out->frame[pass] = out->n_frames - 1;
    }
}

bool passes_make(const struct plan *plan, struct passes *out, struct error *err)
{
    const size_t n = (size_t)plan->n_passes;
    struct reaching_terms of = {.plan = plan};
    *out = (struct passes){.frame = NULL};
    const bool done = MAKE_ARRAY(of.reaches, plan->n_lights, err, "%d lights", plan->n_lights) &&
                      MAKE_ARRAY(out->frame, n, err, "%zu passes", n) &&
                      MAKE_ARRAY(out->first_pass, n, err, "%zu passes", n);
    if (done)
        find_frames(&of, out);
    free(of.reaches);
    return done;
}

void passes_free(struct passes *passes)
{
    FREE_ALL(passes->frame, passes->first_pass);
    *passes = (struct passes){.frame = NULL};
}
