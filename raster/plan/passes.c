/* SPDX-License-Identifier: MIT */
/* Passes: those that OpenGL need not draw, and what the others draw: the colours of materials, the
 * texels of spectral textures, and the projection of a tile. */
#include "raster/plan/inside.h"

/* ---- passes that need not be drawn ---- */

/* All radiance is a sum of weights x spectra x texture, and weights are the same in all bands. Only
 * the materials of instances in view count, and lights that reach these. */

/* Returns whether the products of a term are the same in two passes; they are 0 in bands that do
 * not exist, and in the pass DARK. */
static bool term_is_same(const struct plan *plan, const double *row, int a, int b)
{
    for (int c = 0; c < BANDS_PER_PASS; c++) {
        const int band = a * BANDS_PER_PASS + c, other = b * BANDS_PER_PASS + c;
        if ((band < plan->n_bands ? row[band] : 0) !=
            (other >= 0 && other < plan->n_bands ? row[other] : 0))
            return false;
    }
    return true;
}

/* Returns whether two passes show the same; b may be DARK. A spectral texture may differ between
 * passes. Only terms count that may show, of materials in view; reaches: a light of this spectrum,
 * by the number of its first one, reaches something. */
static bool is_same(const struct plan *plan, const bool *reaches, int a, int b)
{
    for (int m = 0; m < plan->n_materials; m++) {
        const struct shaded_material *shaded = &plan->materials[m];
        if (!shaded->shown)
            continue;
        if (b != DARK && shaded->texture && shaded->texture->spectral)
            return false;
        for (int t = 0; t < shaded->n_terms; t++) {
            const int light = shaded->terms[t].light;
            if ((light < 0 || reaches[light]) &&
                !term_is_same(plan, shaded->made.spectra + (size_t)t * (size_t)plan->n_bands, a, b))
                return false;
        }
    }
    return true;
}

bool passes_make(struct plan *plan, struct error *err)
{
    const size_t n = (size_t)plan->n_passes;
    const bool complete = plan->options.complete;
    struct passes *out = &plan->passes;
    bool *reaches;
    *out = (struct passes){.frame = NULL};
    const int n_lights = plan->illumination.n_lights;
    int first = DARK; /* pass of the last frame */
    const bool done = MAKE_ARRAY(reaches, n_lights, err, "%d lights", n_lights) &&
                      MAKE_ARRAY(out->frame, n, err, "%zu passes", n);
    for (int i = 0; i < plan->n_lights && done; i++)
        if (!plan->is_idle[i])
            reaches[plan->lights[i].first] = true;
    for (int pass = 0; pass < plan->n_passes && done; pass++) {
        out->frame[pass] = DARK;
        if (!complete && is_same(plan, reaches, pass, DARK)) {
            out->n_dark++;
            continue;
        }
        if (complete || !is_same(plan, reaches, pass, first)) {
            first = pass;
            out->n_frames++;
        }
        out->frame[pass] = out->n_frames - 1;
    }
    out->n_repeated = plan->n_passes - out->n_dark - out->n_frames;
    free(reaches);
    return done;
}

/* ---- colours ---- */

/* Products of light and material spectra are made in double and become the colours of OpenGL's
 * lights, with white materials: a fluorescent material, too, is then one pass under eight lights.
 */

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
    const struct light_group lights = light_group(plan, group);
    const int first = lights.first;
    *out = (struct pass_colours){.n_lights = lights.n};
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

/* ---- texels: the planes of three bands, side by side; vertices ---- */

bool pass_texels(const struct plan *plan, struct texture *texture, int first_band, float *out,
                 struct error *err)
{
    const size_t n = texture->plane_size;
    float *planes;
    if (!MAKE_ARRAY(planes, BANDS_PER_PASS * n, err, "the texels of %s", texture->image.path))
        return false;
    float *const rooms[BANDS_PER_PASS] = {planes, planes + n, planes + 2 * n};
    const bool done = texture_fill(texture, plan->scene->wavelengths_nm + first_band,
                                   pass_bands(plan, first_band), rooms, err);
    for (size_t i = 0; i < n && done; i++)
        for (size_t c = 0; c < BANDS_PER_PASS; c++)
            out[BANDS_PER_PASS * i + c] = rooms[c][i];
    free(planes);
    return done;
}

void vertex_numbers(const struct vertex *vertex, float out[VERTEX_NUMBERS])
{
    const struct vector p = vertex->position, n = vertex->normal;
    const double numbers[VERTEX_NUMBERS] = {p.x, p.y, p.z, n.x, n.y, n.z, vertex->s, vertex->t};
    for (int i = 0; i < VERTEX_NUMBERS; i++)
        out[i] = (float)numbers[i];
}

/* ---- a tile ---- */

/* Makes a row of a projection map [low, high] of the picture's clip space to [-1, 1]. */
static void aim_row(struct matrix *m, int row, double low, double high)
{
    for (int j = 0; j < 4; j++)
        m->row[row][j] = (2 * m->row[row][j] - (low + high) * m->row[3][j]) / (high - low);
}

struct matrix pass_projection(const struct plan *plan, const struct rectangle *tile, bool mirrored)
{
    const double width = plan->view.width, height = plan->view.height;
    struct matrix out = plan->view.projection;
    aim_row(&out, 0, 2 * tile->x / width - 1, 2 * (tile->x + tile->width) / width - 1);
    aim_row(&out, 1, 1 - 2 * (tile->y + tile->height) / height, 1 - 2 * tile->y / height);
    for (int i = 0; i < 4 && mirrored; i++)
        out.row[1][i] = -out.row[1][i];
    return out;
}
