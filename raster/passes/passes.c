/* SPDX-License-Identifier: MIT */
/* Finds the passes that OpenGL need not draw: all radiance is a sum of weights x spectra x texture,
 * and weights are the same in all bands. Only the materials of instances in view count. */
#include <stdlib.h>

#include "raster/passes/passes.h"

/* Returns the product of a term in channel c of a pass; 0 where there is no such band. */
static double product(const struct plan *plan, const double *row, int pass, int c)
{
    const int band = pass * BANDS_PER_PASS + c;
    return band < plan->n_bands ? row[band] : 0;
}

static bool term_is_dark(const struct plan *plan, const double *row, int pass)
{
    for (int c = 0; c < BANDS_PER_PASS; c++)
        if (product(plan, row, pass, c) != 0)
            return false;
    return true;
}

static bool term_is_same(const struct plan *plan, const double *row, int a, int b)
{
    for (int c = 0; c < BANDS_PER_PASS; c++)
        if (product(plan, row, a, c) != product(plan, row, b, c))
            return false;
    return true;
}

/* The products of a term: one in each band. */
static const double *row_of(const struct plan *plan, const struct shaded_material *shaded, int term)
{
    return shaded->made.spectra + (size_t)term * (size_t)plan->n_bands;
}

static bool is_dark(const struct plan *plan, int pass)
{
    for (int m = 0; m < plan->n_materials; m++)
        for (int t = 0; t < plan->materials[m].n_terms && plan->materials[m].shown; t++)
            if (!term_is_dark(plan, row_of(plan, &plan->materials[m], t), pass))
                return false;
    return true;
}

/* Returns whether two passes show the same. A spectral texture may differ between them. */
static bool is_same(const struct plan *plan, int a, int b)
{
    for (int m = 0; m < plan->n_materials; m++) {
        const struct shaded_material *shaded = &plan->materials[m];
        if (texture_is_drawn(plan, shaded->texture) && shaded->texture->spectral && shaded->shown)
            return false;
        for (int t = 0; t < shaded->n_terms && shaded->shown; t++)
            if (!term_is_same(plan, row_of(plan, shaded, t), a, b))
                return false;
    }
    return true;
}

bool passes_make(const struct plan *plan, struct passes *out, struct error *err)
{
    const size_t n = (size_t)plan->n_passes;
    *out = (struct passes){.frame = calloc(n, sizeof *out->frame),
                           .first_pass = calloc(n, sizeof *out->first_pass)};
    if (!out->frame || !out->first_pass)
        return error_memory(err);
    for (int pass = 0; pass < plan->n_passes; pass++) {
        out->frame[pass] = DARK;
        if (is_dark(plan, pass)) {
            out->n_dark++;
            continue;
        }
        if (out->n_frames == 0 || !is_same(plan, out->first_pass[out->n_frames - 1], pass))
            out->first_pass[out->n_frames++] = pass;
        out->frame[pass] = out->n_frames - 1;
    }
    return true;
}

void passes_free(struct passes *passes)
{
    free(passes->frame);
    free(passes->first_pass);
    *passes = (struct passes){.frame = NULL};
}
