/* SPDX-License-Identifier: MIT */
/* Makes the terms of a material: spectra of light, reflectance and fluorescence, multiplied. A term
 * that is 0 on every page is left out, unless lights may be exchanged. */
#include "data/sampling/inside.h"

struct luminescence {
    const struct spectral_pages *pages;
    const struct material *material;
    bool glows;                     /* the pages show the emission that belongs to an excitation */
    const struct donaldson *matrix; /* the pages show its emission; NULL: there is none */
    long integrals;                 /* over an excitation that were computed */
    bool seen;                      /* a value was not 0 */
};
struct terms_maker {
    const struct illumination *illumination;
    struct material_terms *out;
    struct luminescence luminescence;
    double *row; /* the next term: 0 until something is added to it; owned */
};

/* ---- products ---- */

/* Returns how many values a product has: one a page, or for components one a nm. */
static int product_length(const struct spectral_pages *pages)
{
    return pages->of_products ? pages->n_nm : pages->n;
}

static double factor_at(const struct spectral_pages *pages, const struct spectrum *spectrum, int i,
                        enum spectrum_ends ends)
{
    return pages->of_products ? spectrum_at(spectrum, pages_looked_at_nm(pages, i), ends)
                              : page_value(pages, spectrum, i, ends);
}

/* Adds factor x spectrum x reflectance (NULL: 1) to a row; returns whether any value is not 0. */
static bool add_product(const struct spectral_pages *pages, double factor,
                        const struct spectrum *spectrum, const struct spectrum *reflectance,
                        double *row)
{
    const int n = product_length(pages);
    bool any = false;
    for (int i = 0; i < n; i++) {
        double radiance = factor * factor_at(pages, spectrum, i, SPECTRUM_ZERO) *
                          (reflectance ? factor_at(pages, reflectance, i, SPECTRUM_HOLD) : 1);
        row[i] += radiance;
        any = any || radiance != 0;
    }
    return any;
}

/* ---- fluorescence ---- */

/* Returns the fluorescence of a material, as far as a page shows its emission. */
static struct luminescence luminescence_of(const struct spectral_pages *pages,
                                           const struct material *material)
{
    struct luminescence out = {.pages = pages, .material = material};
    const struct spectrum *emission = &material->matrix.emission;
    if (pages->reflectance_analysis)
        return out;
    out.glows =
        material->excitation.kind != SPECTRUM_NONE && pages_show(pages, &material->emission);
    if (emission->count > 0 &&
        emission->wavelength_nm[0] <= pages_looked_at_nm(pages, pages_looked_at(pages) - 1) &&
        emission->wavelength_nm[emission->count - 1] >= pages_looked_at_nm(pages, 0))
        out.matrix = &material->matrix;
    return out;
}

/* Adds the luminescence under a light to the row, and sets *lit if any of its values is not 0. */
static bool luminesce(struct luminescence *of, const struct spectrum *light, double intensity,
                      double *row, bool *lit, struct error *err)
{
    bool any = false;
    if (of->glows) {
        double mean = excitation_mean(light, &of->material->excitation);
        any = add_product(of->pages, intensity * mean, &of->material->emission, NULL, row);
    }
    if (of->matrix) {
        struct spectrum emission = {.kind = SPECTRUM_NONE};
        if (!donaldson_emission(of->matrix, light, &emission, err))
            return false;
        any = add_product(of->pages, intensity, &emission, NULL, row);
        spectrum_free(&emission);
    }
    of->integrals += of->glows + (of->matrix ? of->matrix->emission.count : 0);
    of->seen = of->seen || any;
    *lit = *lit || any;
    return true;
}

bool material_luminescence(const struct spectral_pages *pages, const struct material *material,
                           const struct spectrum *light, double *out, struct error *err)
{
    struct luminescence luminescence = luminescence_of(pages, material);
    bool lit = false;
    for (int i = 0; i < pages->n; i++)
        out[i] = 0;
    return luminesce(&luminescence, light, 1, out, &lit, err);
}

/* ---- terms ---- */

/* Makes a term of the row, or of its components, and the row becomes 0 again. The components of a
 * term are not negative. A sum of n products is off by at most n 2^-53 of the sum of their
 * magnitudes; a sum below 0 is such an error. */
static void keep_term(struct terms_maker *maker, enum term_kind kind, int light)
{
    const struct spectral_pages *pages = &maker->illumination->pages;
    const size_t length = (size_t)product_length(pages);
    double *spectrum = maker->out->spectra + (size_t)maker->out->n * (size_t)pages->n;
    struct spectral_term term = {.kind = kind, .light = light};
    for (int i = 0; i < pages->n; i++) {
        spectrum[i] = maker->row[i];
        if (pages->of_products) {
            const double *analysis = pages->analysis + (size_t)i * length;
            const double sum = sampling_dot(analysis, maker->row, pages->n_nm);
            spectrum[i] = sum < 0 ? 0 : sum;
        }
        term.peak = fmax(term.peak, spectrum[i]);
        term.mean += spectrum[i] / pages->n;
    }
    memset(maker->row, 0, length * sizeof *maker->row);
    maker->out->terms[maker->out->n++] = term;
}

static bool add_constant(struct terms_maker *maker, struct error *err)
{
    const struct illumination *illumination = maker->illumination;
    const struct scene *scene = illumination->scene;
    struct material_terms *out = maker->out;
    double *row = maker->row;
    for (int i = 0; i < scene->n_ambients; i++) {
        const struct light *ambient = &scene->ambients[i];
        if (ambient->intensity == 0 || spectrum_is_zero(&ambient->spectrum))
            continue;
        if (add_product(&illumination->pages, ambient->intensity, &ambient->spectrum,
                        &out->material->diffuse, row))
            out->ambient = true;
        if (!luminesce(&maker->luminescence, &ambient->spectrum, ambient->intensity, row,
                       &out->ambient, err))
            return false;
    }
    out->emits = out->material->glow.kind != SPECTRUM_NONE &&
                 add_product(&illumination->pages, 1, &out->material->glow, NULL, row);
    if (out->ambient || out->emits || illumination->exchangeable)
        keep_term(maker, TERM_CONSTANT, -1);
    return true;
}

static bool add_light(struct terms_maker *maker, int index, struct error *err)
{
    const struct spectral_pages *pages = &maker->illumination->pages;
    const struct light *light = maker->illumination->lights[index].light;
    const struct material *material = maker->out->material;
    bool kept = maker->illumination->exchangeable;
    double *row = maker->row;
    bool lit = add_product(pages, light->intensity, &light->spectrum, &material->diffuse, row);
    if (!luminesce(&maker->luminescence, &light->spectrum, light->intensity, row, &lit, err))
        return false;
    if (lit || kept)
        keep_term(maker, TERM_DIFFUSE, index);
    if (material->gloss > 0 &&
        (add_product(pages, light->intensity, &light->spectrum,
                     material->specular.kind != SPECTRUM_NONE ? &material->specular : NULL, row) ||
         kept))
        keep_term(maker, TERM_SPECULAR, index);
    return true;
}

/* Refuses a reflectance whose table has no value in the range that the pages stand for: its end
 * value would be the whole picture. The first and last wavelength stand for half a step more. */
static bool check_range(const struct spectral_pages *pages, const struct spectrum *table,
                        struct error *err)
{
    const int last = pages_looked_at(pages) - 1;
    const double first_nm = pages_looked_at_nm(pages, 0), last_nm = pages_looked_at_nm(pages, last);
    const double half = last > 0 ? (pages_looked_at_nm(pages, 1) - first_nm) / 2 : 0.5;
    if (table->kind != SPECTRUM_SAMPLED ||
        (table->wavelength_nm[0] <= last_nm + half &&
         table->wavelength_nm[table->count - 1] >= first_nm - half))
        return true;
    return error_at(
        err, table->place,
        "'%.100s' has values from %g to %g nm, and none in the picture's range, %g to %g "
        "nm; if they are not in nm, name the unit above them",
        table->name, table->wavelength_nm[0], table->wavelength_nm[table->count - 1], first_nm,
        last_nm);
}

bool material_terms_make(const struct illumination *illumination, const struct material *material,
                         struct material_terms *out, struct error *err)
{
    struct terms_maker maker = {.illumination = illumination,
                                .out = out,
                                .luminescence = luminescence_of(&illumination->pages, material)};
    const struct spectral_pages *pages = &illumination->pages;
    const size_t most = 1 + 2 * (size_t)illumination->n_first;
    *out = (struct material_terms){.material = material};
    bool done = check_range(pages, &material->diffuse, err) &&
                check_range(pages, &material->specular, err) &&
                MAKE_ARRAY(out->terms, most, err, "the terms of a material") &&
                MAKE_ARRAY(out->spectra, most * (size_t)pages->n, err, "the terms of a material") &&
                MAKE_ARRAY(maker.row, product_length(pages), err, "the terms of a material") &&
                add_constant(&maker, err);
    for (int i = 0; done && i < illumination->n_lights; i++)
        done = illumination->lights[i].first < i || add_light(&maker, i, err);
    out->fluoresces = maker.luminescence.seen;
    out->excitation_integrals = maker.luminescence.integrals;
    free(maker.row);
    return done;
}

void material_terms_free(struct material_terms *terms)
{
    FREE_ALL(terms->terms, terms->spectra);
    *terms = (struct material_terms){.n = 0};
}

/* ---- materials that objects show ---- */

/* Adds a material, and its partner if it has one, unless it is in the list already. */
static void add_shown(const struct scene *scene, int index, bool *shown,
                      const struct material **list, int *n)
{
    const struct material *material = &scene->materials[index];
    if (shown[index])
        return;
    shown[index] = true;
    list[(*n)++] = material;
    if (material->partner_name)
        add_shown(scene, material->partner_index, shown, list, n);
    else if (material->partner)
        list[(*n)++] = material->partner;
}

bool materials_shown(const struct scene *scene, const struct material ***out, int *n,
                     struct error *err)
{
    bool *shown;
    *out = NULL;
    *n = 0;
    if (!MAKE_ARRAY(shown, scene->n_materials, err, "a list of materials"))
        return false;
    const bool done = MAKE_ARRAY(*out, 2 * (size_t)scene->n_materials, err, "a list of materials");
    for (int i = 0; done && i < scene->n_objects; i++) {
        const struct object *object = &scene->objects[i];
        if (object->material >= 0)
            add_shown(scene, object->material, shown, *out, n);
        for (int line = 0; line < object->n_assignments; line++)
            add_shown(scene, object->assignments[line].material, shown, *out, n);
    }
    free(shown);
    return done;
}
