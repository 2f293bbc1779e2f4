/* SPDX-License-Identifier: MIT */
/* The colours of a pass. Products of light and material spectra are made in double and become the
 * colours of OpenGL's lights, with white materials: a fluorescent material, too, is then one pass
 * under eight lights. */
#include "raster/plan/inside.h"

/* row NULL stands for no term. */
static void band_colour(const struct plan *plan, const double *row, int first_band,
                        double full_scale, float out[4])
{
    for (int c = 0; c < BANDS_PER_PASS; c++)
        out[c] = row && first_band + c < plan->n_bands ? (float)(row[first_band + c] / full_scale)
                                                       : 0.0F;
    out[3] = 1;
}

static const double *term_row(const struct plan *plan, const struct shaded_material *shaded,
                              enum reflection reflection, int light)
{
    for (int t = 0; t < shaded->n_terms; t++)
        if (shaded->terms[t].reflection == reflection && shaded->terms[t].light == light)
            return shaded->made.spectra + (size_t)t * (size_t)plan->n_bands;
    return NULL;
}

void pass_colours(const struct plan *plan, const struct shaded_material *shaded, int group,
                  int first_band, double full_scale, struct pass_colours *out)
{
    const double *constant = group == 0 ? term_row(plan, shaded, CONSTANT, -1) : NULL;
    const int first = group * LIGHTS_PER_PASS, left = plan->n_lights - first;
    const double factor = shaded->texture ? texture_factor(plan, shaded->texture) : 1;
    if (factor >= 0)
        full_scale /= factor; /* infinite, and colours 0, where all texels are 0 */
    *out = (struct pass_colours){.n_lights = left < LIGHTS_PER_PASS ? left : LIGHTS_PER_PASS};
    band_colour(plan, constant, first_band, full_scale, out->constant);
    for (int i = 0; i < out->n_lights; i++) {
        if (plan->is_idle[first + i])
            continue;
        const struct eye_light *light = &plan->lights[first + i];
        const double *specular = term_row(plan, shaded, SPECULAR, light->first);
        band_colour(plan, term_row(plan, shaded, DIFFUSE, light->first), first_band,
                    full_scale / light->share, out->diffuse[i]);
        band_colour(plan, specular, first_band, full_scale / light->share, out->specular[i]);
        out->shines = out->shines || specular;
    }
}
