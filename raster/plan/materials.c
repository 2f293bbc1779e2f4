/* SPDX-License-Identifier: MIT */
/* Which lights shine and what each material makes of them: spectra of light, reflectance and
 * fluorescence multiplied once, for all vertices. A term that is 0 in every band is not a term, a
 * light without terms does not shine, and a texture without terms is not opened; but where lights
 * may be exchanged all of them are kept. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "raster/plan/plan.h"

/* ---- lights ---- */

static bool is_zero(const struct spectrum *spectrum)
{
    bool zero = spectrum->kind == SPECTRUM_CONSTANT && spectrum->parameter[0] == 0;
    if (spectrum->kind == SPECTRUM_SAMPLED) {
        zero = true;
        for (int i = 0; i < spectrum->count; i++)
            zero = zero && spectrum->value[i] == 0;
    }
    return zero || spectrum->factor == 0;
}

/* Whether one spectrum is the other times a factor, as far as that can be seen without rounding. */
static bool same_spectrum(const struct spectrum *a, const struct spectrum *b)
{
    if (a->kind != b->kind || a->count != b->count)
        return false;
    size_t size = (size_t)a->count * sizeof *a->value;
    return a->kind == SPECTRUM_CONSTANT ||
           (memcmp(a->parameter, b->parameter, sizeof a->parameter) == 0 &&
            (size == 0 || (memcmp(a->wavelength_nm, b->wavelength_nm, size) == 0 &&
                           memcmp(a->value, b->value, size) == 0)));
}

static double strength(const struct light *light)
{
    const struct spectrum *spectrum = &light->spectrum;
    double level = spectrum->kind == SPECTRUM_CONSTANT ? spectrum->parameter[0] : 1;
    return light->intensity * spectrum->factor * level;
}

/* Finds the first light of this one's spectrum. Shares that are hardly a number are not shared. */
static void find_first(const struct plan *plan, int index)
{
    struct plan_light *light = &plan->lights[index];
    light->first = index;
    light->share = 1;
    for (int i = 0; i < index && !plan->options.exchangeable; i++) {
        const struct light *other = plan->lights[i].light;
        double share = strength(light->light) / strength(other);
        if (plan->lights[i].first != i || !(share > 1e-30 && share < 1e30) ||
            !same_spectrum(&light->light->spectrum, &other->spectrum))
            continue;
        light->first = i;
        light->share = share;
        return;
    }
}

static struct plan_light plan_light(const struct plan *plan, const struct light *light)
{
    struct plan_light out = {.light = light};
    const double *k = light->attenuation;
    if (light->directional) {
        struct vector towards = vector_normalise(light->position);
        out.eye_position = vector_normalise(matrix_direction(&plan->view, towards));
        return out;
    }
    out.eye_position = matrix_point(&plan->view, light->position);
    for (int i = 0; i < 3; i++)
        out.attenuation[i] = k[i] * (i > 0 ? plan->unit : 1) * (i > 1 ? plan->unit : 1);
    out.attenuated = k[0] != 1 || k[1] != 0 || k[2] != 0;
    out.spot = light->spot && light->spot_cutoff_deg <= 90;
    if (out.spot) {
        double sine;
        struct vector axis = vector_normalise(light->spot_direction);
        out.eye_spot = vector_normalise(matrix_direction(&plan->view, axis));
        sine_cosine(light->spot_cutoff_deg, &sine, &out.spot_cosine);
    }
    return out;
}

/* Whether OpenGL can take a light's distances and their squares in single precision. */
static bool check_light(const struct plan_light *light, struct error *err)
{
    const double *k = light->attenuation;
    if (light->light->directional)
        return true;
    if (!(vector_length(light->eye_position) < FARTHEST))
        return error_at(err, light->light->place,
                        "this light is too far away for single precision; give it a direction");
    for (int i = 0; i < 3; i++)
        if (!(k[i] < 1e18))
            return error_at(err, light->light->attenuation_place,
                            "attenuation %g is too strong for single precision, beside the "
                            "picture's size",
                            light->light->attenuation[i]);
    return true;
}

bool lights_list(struct plan *plan, struct error *err)
{
    const struct scene *scene = plan->scene;
    plan->lights = calloc((size_t)scene->n_lights + 1, sizeof *plan->lights);
    if (!plan->lights)
        return error_memory(err);
    for (int i = 0; i < scene->n_lights; i++)
        if (plan->options.exchangeable ||
            (scene->lights[i].intensity != 0 && !is_zero(&scene->lights[i].spectrum))) {
            plan->lights[plan->n_lights] = plan_light(plan, &scene->lights[i]);
            if (!check_light(&plan->lights[plan->n_lights], err))
                return false;
            find_first(plan, plan->n_lights++);
        }
    return true;
}

/* Gives the terms of a light another number; whether there are any. */
static bool renumber_terms(struct plan *plan, int from, int to)
{
    bool any = false;
    for (int f = 0; f < plan->n_finishes; f++)
        for (int t = 0; t < plan->finishes[f].n_terms; t++) {
            struct term *term = &plan->finishes[f].terms[t];
            if (term->light != from)
                continue;
            term->light = to;
            any = true;
        }
    return any;
}

/* Lights that share a spectrum are kept or dropped together. */
bool lights_drop_idle(struct plan *plan, struct error *err)
{
    if (plan->options.exchangeable)
        return true;
    int *number = calloc((size_t)plan->n_lights + 1, sizeof *number); /* new one; -1: dropped */
    if (!number)
        return error_memory(err);
    int n = 0;
    for (int i = 0; i < plan->n_lights; i++) {
        struct plan_light light = plan->lights[i];
        bool kept = light.first == i ? renumber_terms(plan, i, n) : number[light.first] >= 0;
        number[i] = kept ? n : -1;
        light.first = number[light.first];
        if (kept)
            plan->lights[n++] = light;
    }
    free(number);
    plan->n_lights = n;
    return true;
}

/* ---- what spectra are looked at ---- */

/* The grid of the scene's sampling, where pages are made of all of it. */
static const struct sampling *grid_of(const struct scene *scene)
{
    const struct sampling *sampling = scene->sampling;
    return sampling && (sampling->light_mean || sampling->analysis) ? sampling : NULL;
}

int looked_at(const struct scene *scene)
{
    const struct sampling *grid = grid_of(scene);
    return grid ? grid->n_nm : scene->n_wavelengths;
}

double looked_at_nm(const struct scene *scene, int i)
{
    const struct sampling *grid = grid_of(scene);
    return grid ? grid->first_nm + i : scene->wavelengths_nm[i];
}

bool is_seen(const struct scene *scene, const struct spectrum *light)
{
    for (int i = 0; i < looked_at(scene); i++)
        if (spectrum_at(light, looked_at_nm(scene, i), SPECTRUM_ZERO) != 0)
            return true;
    return false;
}

/* Pages that are components are made of whole products. */
static bool is_analysed(const struct scene *scene)
{
    return scene->sampling && scene->sampling->analysis;
}

/* Values that a product has: one a page, or one a nm for components. */
static int product_length(const struct plan *plan)
{
    return is_analysed(plan->scene) ? plan->scene->sampling->n_nm : plan->n_bands;
}

static double factor_at(const struct scene *scene, const struct spectrum *spectrum, int i,
                        enum spectrum_ends ends)
{
    return is_analysed(scene) ? spectrum_at(spectrum, looked_at_nm(scene, i), ends)
                              : scene_page(scene, spectrum, i, ends);
}

bool shows_luminescence(const struct scene *scene)
{
    return !scene->sampling || scene->sampling->spectral || scene->sampling->analysis;
}

/* ---- spectra of terms ---- */

struct luminescence {
    const struct material *material;
    bool glows;              /* excitation and emission, of which the picture shows something */
    struct donaldson matrix; /* likewise; n_emission 0: none */
};
struct finish_maker {
    struct plan *plan;
    struct finish *finish;
    struct luminescence luminescence;
    double *fine; /* the next term at every nm, if pages are components; owned, otherwise NULL */
};

/* Adds factor x spectrum x reflectance (NULL: 1) to a row; whether that is anything. */
static bool add_product(const struct plan *plan, double factor, const struct spectrum *spectrum,
                        const struct spectrum *reflectance, double *row)
{
    const struct scene *scene = plan->scene;
    const int n = product_length(plan);
    bool any = false;
    for (int i = 0; i < n; i++) {
        double radiance = factor * factor_at(scene, spectrum, i, SPECTRUM_ZERO) *
                          (reflectance ? factor_at(scene, reflectance, i, SPECTRUM_HOLD) : 1);
        row[i] += radiance;
        any = any || radiance != 0;
    }
    return any;
}

/* Adds what fluoresces under a light to the row; *any tells whether that is anything. */
static bool luminesce(const struct plan *plan, const struct luminescence *of,
                      const struct spectrum *light, double intensity, double *row, bool *any,
                      struct error *err)
{
    *any = false;
    if (of->glows) {
        double mean = excitation_mean(light, &of->material->excitation);
        *any = add_product(plan, intensity * mean, &of->material->emission, NULL, row);
    }
    if (of->matrix.n_emission > 0) {
        struct spectrum emission = {.kind = SPECTRUM_NONE};
        if (!donaldson_emission(&of->matrix, light, &emission, err))
            return false;
        *any = add_product(plan, intensity, &emission, NULL, row);
        spectrum_free(&emission);
    }
    return true;
}

/* Adds what fluoresces under a light to *lit and the row. */
static bool add_luminescence(struct finish_maker *maker, const struct spectrum *light,
                             double intensity, double *row, bool *lit, struct error *err)
{
    bool any;
    if (!luminesce(maker->plan, &maker->luminescence, light, intensity, row, &any, err))
        return false;
    maker->plan->work.excitation_integrals +=
        maker->luminescence.glows + maker->luminescence.matrix.n_emission;
    maker->finish->fluoresces = maker->finish->fluoresces || any;
    *lit = *lit || any;
    return true;
}

/* The bands of the next term; zeroed. */
static double *next_bands(const struct finish_maker *maker)
{
    size_t n_bands = (size_t)maker->plan->n_bands;
    return maker->finish->spectra + (size_t)maker->finish->n_terms * n_bands;
}

/* The row that the next term fills; zeroed. */
static double *next_row(const struct finish_maker *maker)
{
    return maker->fine ? maker->fine : next_bands(maker);
}

/* What is left of the row becomes components, and it is cleared. Components of the scene's terms
 * are not negative, and a sum of n products is off by n 2^-53 of the sum of their magnitudes at
 * most: what lies below 0 is such an error. */
static void analyse(const struct sampling *sampling, double *fine, double *bands)
{
    const int n_nm = sampling->n_nm;
    for (int page = 0; page < sampling->n; page++) {
        double sum = 0;
        for (int j = 0; j < n_nm; j++)
            sum += sampling->analysis[(size_t)page * (size_t)n_nm + (size_t)j] * fine[j];
        bands[page] = sum < 0 ? 0 : sum;
    }
    memset(fine, 0, (size_t)n_nm * sizeof *fine);
}

static void keep_term(struct finish_maker *maker, enum term_kind kind, int light)
{
    maker->finish->n_colours += kind == TERM_CONSTANT;
    for (int i = 0; i < maker->plan->n_lights; i++)
        maker->finish->n_colours += maker->plan->lights[i].first == light;
    struct term term = {kind, light, 0};
    if (maker->fine)
        analyse(maker->plan->scene->sampling, maker->fine, next_bands(maker));
    for (int i = 0; i < maker->plan->n_bands; i++)
        term.peak = fmax(term.peak, next_bands(maker)[i]);
    maker->finish->terms[maker->finish->n_terms++] = term;
    maker->plan->work.terms++;
}

static bool add_constant(struct finish_maker *maker, struct error *err)
{
    const struct scene *scene = maker->plan->scene;
    struct finish *finish = maker->finish;
    double *row = next_row(maker);
    for (int i = 0; i < scene->n_ambients; i++) {
        const struct ambient *ambient = &scene->ambients[i];
        if (ambient->intensity == 0 || is_zero(&ambient->spectrum))
            continue;
        if (add_product(maker->plan, ambient->intensity, &ambient->spectrum,
                        &finish->material->diffuse, row))
            finish->ambient = true;
        if (!add_luminescence(maker, &ambient->spectrum, ambient->intensity, row, &finish->ambient,
                              err))
            return false;
    }
    finish->emits = finish->material->glow.kind != SPECTRUM_NONE &&
                    add_product(maker->plan, 1, &finish->material->glow, NULL, row);
    if (finish->ambient || finish->emits || maker->plan->options.exchangeable)
        keep_term(maker, TERM_CONSTANT, -1);
    return true;
}

static bool add_light(struct finish_maker *maker, int index, struct error *err)
{
    const struct light *light = maker->plan->lights[index].light;
    const struct material *material = maker->finish->material;
    bool kept = maker->plan->options.exchangeable;
    double *row = next_row(maker);
    bool lit =
        add_product(maker->plan, light->intensity, &light->spectrum, &material->diffuse, row);
    if (!add_luminescence(maker, &light->spectrum, light->intensity, row, &lit, err))
        return false;
    if (lit || kept)
        keep_term(maker, TERM_DIFFUSE, index);
    if (material->gloss > 0 &&
        (add_product(maker->plan, light->intensity, &light->spectrum,
                     material->specular.kind != SPECTRUM_NONE ? &material->specular : NULL,
                     next_row(maker)) ||
         kept))
        keep_term(maker, TERM_SPECULAR, index);
    return true;
}

/* ---- textures ---- */

static bool same_texture(const struct texture *a, const char *path, bool spectral, bool linear)
{
    return a->spectral == spectral && a->linear == linear && strcmp(a->image.path, path) == 0;
}

/* A texture is read when it is first asked for; NULL after an error. */
static struct texture *find_texture(struct plan *plan, const struct material *material,
                                    struct error *err)
{
    bool spectral = material->spectral_texture != NULL, linear = material->texture_linear;
    const char *path = spectral ? material->spectral_texture : material->texture;
    struct place place = spectral ? material->spectral_texture_place : material->texture_place;
    struct texture *new = &plan->textures[plan->n_textures];
    for (int i = 0; i < plan->n_textures; i++)
        if (same_texture(&plan->textures[i], path, spectral, linear))
            return &plan->textures[i];
    if (!(spectral ? texture_read_spectral : texture_read)(path, place, linear, new, err))
        return NULL;
    plan->n_textures++;
    plan->work.textures_loaded++;
    return new;
}

bool plan_load_textures(const struct plan *plan, int first_band, struct error *err)
{
    int n = plan->n_bands - first_band;
    for (int i = 0; i < plan->n_textures; i++)
        if (!texture_load(&plan->textures[i], plan->scene->wavelengths_nm + first_band,
                          n < BANDS_PER_PASS ? n : BANDS_PER_PASS, err))
            return false;
    return true;
}

/* ---- finishes ---- */

int finish_rows(const struct finish *finish)
{
    bool places = finish->texture && finish->texture->spectral;
    return finish->n_terms + (places ? 2 : 0);
}

static bool add_terms(struct finish_maker *maker, struct error *err)
{
    struct plan *plan = maker->plan;
    struct finish *finish = maker->finish;
    size_t most = 1 + 2 * (size_t)plan->n_lights;
    bool components = is_analysed(plan->scene);
    finish->terms = calloc(most, sizeof *finish->terms);
    finish->spectra = calloc(most * (size_t)plan->n_bands, sizeof *finish->spectra);
    if (components)
        maker->fine = calloc((size_t)product_length(plan), sizeof *maker->fine);
    if (!finish->terms || !finish->spectra || (components && !maker->fine))
        return error_memory(err);
    if (!add_constant(maker, err))
        return false;
    for (int light = 0; light < plan->n_lights; light++)
        if (plan->lights[light].first == light && !add_light(maker, light, err))
            return false;
    return true;
}

/* Reads what fluoresces; nothing where the picture has no band of its emission. */
static bool open_luminescence(const struct plan *plan, const struct material *material,
                              struct luminescence *out, struct error *err)
{
    struct donaldson *matrix = &out->matrix;
    const struct scene *scene = plan->scene;
    *out = (struct luminescence){.material = material};
    if (!shows_luminescence(scene))
        return true;
    out->glows = material->excitation.kind != SPECTRUM_NONE && is_seen(scene, &material->emission);
    if (!material->donaldson)
        return true;
    if (!donaldson_read(material->donaldson, material->donaldson_place, &material->diffuse, matrix,
                        err))
        return false;
    if (matrix->emission_nm[0] > looked_at_nm(scene, looked_at(scene) - 1) ||
        matrix->emission_nm[matrix->n_emission - 1] < looked_at_nm(scene, 0))
        donaldson_free(matrix);
    return true;
}

bool finish_luminescence(const struct plan *plan, const struct finish *finish,
                         const struct spectrum *light, double *out, struct error *err)
{
    struct luminescence luminescence;
    bool any;
    for (int i = 0; i < plan->n_bands; i++)
        out[i] = 0;
    bool done = open_luminescence(plan, finish->material, &luminescence, err) &&
                luminesce(plan, &luminescence, light, 1, out, &any, err);
    donaldson_free(&luminescence.matrix);
    return done;
}

static bool make_finish(struct plan *plan, const struct material *material, struct finish *finish,
                        struct error *err)
{
    struct finish_maker maker = {.plan = plan, .finish = finish};
    finish->material = material;
    plan->work.materials_loaded++;
    bool done =
        open_luminescence(plan, material, &maker.luminescence, err) && add_terms(&maker, err);
    donaldson_free(&maker.luminescence.matrix);
    free(maker.fine);
    return done;
}

bool finish_terms(struct plan *plan, const struct material *material, int *out, struct error *err)
{
    for (*out = 0; *out < plan->n_finishes; ++*out)
        if (plan->finishes[*out].material == material)
            return true;
    plan->n_finishes++; /* counted first, so that plan_free reaches it after a failure */
    return make_finish(plan, material, &plan->finishes[*out], err);
}

bool finish_find(struct plan *plan, const struct material *material, int *out, struct error *err)
{
    const bool textured = material->texture || material->spectral_texture;
    if (!finish_terms(plan, material, out, err))
        return false;
    struct finish *finish = &plan->finishes[*out];
    if (textured && finish->n_terms > 0 && !finish->texture) {
        finish->texture = find_texture(plan, material, err);
        if (!finish->texture)
            return false;
    }
    if (finish_rows(finish) > plan->max_rows)
        plan->max_rows = finish_rows(finish);
    return true;
}
