/* SPDX-License-Identifier: MIT */
/* Differences of shading as an observer sees them: a term has tristimulus values, and a point those
 * of its terms times their weights. */
#include "raster/beside/accuracy/inside.h"
#include "raster/beside/colour/colour.h"

/* Finds the observer's weights of the pages: [channel * n + page]. *known: false if the detector of
 * the sampling is no observer. */
static bool find_weights(const struct plan *plan, const char *observer, double *out, bool *known,
                         struct error *err)
{
    const struct sampling *sampling = plan->sampling;
    struct detector detector = {.name = NULL};
    const bool done = channels_read(sampling ? sampling->detector : observer, &detector, err);
    *known = done && detector.observer;
    if (*known && sampling)
        memcpy(out, sampling->weights, 3 * (size_t)plan->n_bands * sizeof *out);
    else if (*known)
        detector_weights(&detector, plan->scene->wavelengths_nm, plan->n_bands, out);
    detector_free(&detector);
    return done;
}

/* Finds the white of the lights, or of a radiance of 1 where the observer sees none. */
static bool find_white(const struct plan *plan, const double *weights, double white[3],
                       struct error *err)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    double *radiance;
    if (!MAKE_ARRAY(radiance, (size_t)pages->n, err, "the white of %s", plan->scene->path))
        return false;
    const bool lit = scene_white(plan->scene, pages, radiance) > 0;
    detector_response(weights, lit ? radiance : NULL, pages->n, white);
    if (!(white[0] > 0 || white[1] > 0 || white[2] > 0))
        detector_response(weights, NULL, pages->n, white);
    free(radiance);
    return true;
}

static bool find_terms(const struct plan *plan, const double *weights, struct measure *out,
                       struct error *err)
{
    const size_t n_bands = (size_t)plan->n_bands;
    if (!MAKE_ARRAY(out->xyz, plan->n_materials * plan->max_rows + 1, err, "the colours of %s",
                    plan->scene->path))
        return false;
    for (int m = 0; m < plan->n_materials; m++)
        for (int t = 0; t < plan->materials[m].n_terms; t++)
            detector_response(weights, plan->materials[m].made.spectra + (size_t)t * n_bands,
                              plan->n_bands, out->xyz[m * plan->max_rows + t]);
    return true;
}

bool measure_make(const struct lit_scene *lit, enum measure_unit unit, const char *observer,
                  struct measure *out, struct error *err)
{
    const struct plan *plan = lit->plan;
    double *weights;
    *out = (struct measure){.lit = lit, .unit = unit, .known = true};
    if (unit == MEASURE_COUNTS)
        return true;
    bool done = MAKE_ARRAY(weights, 3 * (size_t)plan->n_bands, err, "the weights of an observer") &&
                find_weights(plan, observer, weights, &out->known, err);
    if (done && out->known)
        done = find_white(plan, weights, out->white, err) && find_terms(plan, weights, out, err);
    free(weights);
    return done;
}

/* ---- counts ---- */

static double counts_between(const struct measure *measure, int shaded,
                             const struct shaded_point *a, const struct shaded_point *b)
{
    const struct plan *plan = measure->lit->plan;
    const struct shaded_material *material = &plan->materials[shaded];
    double most = 0;
    for (int band = 0; band < plan->n_bands; band++)
        most = fmax(most, fabs(a->texel * shaded_radiance(plan, material, a->weights, band) -
                               b->texel * shaded_radiance(plan, material, b->weights, band)));
    return most / measure->lit->full_scale * UINT16_MAX;
}

/* ---- either unit ---- */

static void xyz_of(const struct measure *measure, int shaded, const struct shaded_point *point,
                   double xyz[3])
{
    const struct plan *plan = measure->lit->plan;
    double(*const term)[3] = measure->xyz + shaded * plan->max_rows;
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (int t = 0; t < plan->materials[shaded].n_terms; t++)
        for (int c = 0; c < 3; c++)
            xyz[c] += point->texel * point->weights[t] * term[t][c];
}

/* Returns whether two colours differ by roundings only; CIEDE2000 would be below 1e-7. */
static bool are_same(const double a[3], const double b[3])
{
    bool same = true;
    for (int c = 0; c < 3; c++)
        same = same && fabs(a[c] - b[c]) <= 1e-10 * fabs(a[c]);
    return same;
}

double measure_difference(const struct measure *measure, int shaded, const struct shaded_point *a,
                          const struct shaded_point *b)
{
    double xyz[2][3], lab[2][3];
    if (measure->unit == MEASURE_COUNTS)
        return counts_between(measure, shaded, a, b);
    xyz_of(measure, shaded, a, xyz[0]);
    xyz_of(measure, shaded, b, xyz[1]);
    if (are_same(xyz[0], xyz[1]))
        return 0;
    cielab(xyz[0], measure->white, lab[0]);
    cielab(xyz[1], measure->white, lab[1]);
    return ciede2000_difference(lab[0], lab[1]);
}
