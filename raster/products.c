/* SPDX-License-Identifier: MIT */
/* The spectra that a scene's pixels are made of, from a plan of nothing but its lights and
 * materials at every nm; and scenes that are sampled with their help. What a texture adds is none
 * of these: a spectral one is taken at the wavelength of each page. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan.h"

/* As wide as a stack of every nm may be. */
enum { WIDEST_RANGE = 65535 };
/* Sums over the range times a detector's sensitivities, and 100 of an observer, are finite. */
static const double largest_radiance = 1e290;

/* ---- materials that objects show ---- */

typedef bool material_visitor(void *context, const struct material *material, struct error *err);

/* A material, and the partner that half of an object is made of. */
static bool visit_halves(const struct scene *scene, int index, material_visitor *visit,
                         void *context, struct error *err)
{
    const struct material *material = &scene->materials[index], *partner = material->partner;
    if (material->partner_name)
        partner = &scene->materials[material->partner_index];
    return visit(context, material, err) && (!partner || visit(context, partner, err));
}

/* Of a material map all lines are taken: which of them a mesh has is not known. */
static bool visit_materials(const struct scene *scene, material_visitor *visit, void *context,
                            struct error *err)
{
    for (int i = 0; i < scene->n_objects; i++) {
        const struct object *object = &scene->objects[i];
        if (!object->material_map && !visit_halves(scene, object->material, visit, context, err))
            return false;
        for (int j = 0; j < object->n_assignments; j++)
            if (!visit_halves(scene, object->assignments[j].material, visit, context, err))
                return false;
    }
    return true;
}

/* ---- a plan at every nm ---- */

static bool read_range(const struct scene *scene, double *first_nm, int *n_nm, struct error *err)
{
    const double last = scene->wavelengths_nm[scene->n_wavelengths - 1];
    *first_nm = scene->wavelengths_nm[0];
    const double n = floor(last - *first_nm + 1e-9) + 1;
    *n_nm = (int)fmin(n, WIDEST_RANGE);
    return n <= WIDEST_RANGE ||
           error_at(err, scene->wavelengths_place,
                    "wavelengths from %.10g to %.10g nm; a sampling takes up to %d nm", *first_nm,
                    last, WIDEST_RANGE);
}

static bool visit_finish(void *plan, const struct material *material, struct error *err)
{
    int finish;
    return finish_terms(plan, material, &finish, err);
}

/* `fine` shares all but its wavelengths with the scene, and must outlive the plan. */
static bool plan_finely(const struct scene *scene, struct scene *fine, struct plan *plan,
                        struct error *err)
{
    double first_nm;
    *fine = *scene;
    *plan = (struct plan){.scene = fine};
    fine->sampling = NULL;
    fine->wavelengths_nm = NULL;
    if (!read_range(scene, &first_nm, &fine->n_wavelengths, err))
        return false;
    fine->wavelengths_nm = calloc((size_t)fine->n_wavelengths, sizeof *fine->wavelengths_nm);
    if (!fine->wavelengths_nm)
        return error_memory(err);
    for (int i = 0; i < fine->n_wavelengths; i++)
        fine->wavelengths_nm[i] = first_nm + i;
    plan->n_bands = fine->n_wavelengths;
    return plan_allocate(plan, err) && lights_list(plan, err) &&
           visit_materials(fine, visit_finish, plan, err);
}

/* ---- rows of spectra ---- */

/* Rows of n_nm values each. */
struct rows {
    double **values;
    int *n, n_nm;
};

/* A zeroed row more; NULL after an error. */
static double *add_row(const struct rows *rows, struct error *err)
{
    const size_t n_nm = (size_t)rows->n_nm;
    double *more = array_more(*rows->values, *rows->n, n_nm * sizeof *more, err);
    if (!more)
        return NULL;
    *rows->values = more;
    return more + (size_t)(*rows->n)++ * n_nm;
}

static bool check_row(const struct rows *rows, const double *row, struct place place,
                      struct error *err)
{
    for (int i = 0; i < rows->n_nm; i++)
        if (!(row[i] <= largest_radiance))
            return error_at(err, place, "radiance %g cannot be sampled; it is at most %g", row[i],
                            largest_radiance);
    return true;
}

static bool add_light(const struct rows *rows, const struct plan *plan,
                      const struct spectrum *spectrum, double intensity, struct error *err)
{
    double *row = add_row(rows, err);
    for (int i = 0; row && i < rows->n_nm; i++)
        row[i] = intensity * spectrum_at(spectrum, plan->scene->wavelengths_nm[i], SPECTRUM_ZERO);
    return row && check_row(rows, row, spectrum->place, err);
}

/* What a material fluoresces under a light. */
static bool add_luminescence(const struct rows *rows, const struct plan *plan,
                             const struct finish *finish, const struct spectrum *light,
                             struct error *err)
{
    double *row = add_row(rows, err);
    return row && finish_luminescence(plan, finish, light, row, err) &&
           check_row(rows, row, finish->material->place, err);
}

/* What a material gives out that no light is. */
static bool add_own_lights(const struct rows *rows, const struct plan *plan,
                           const struct finish *finish, struct error *err)
{
    const struct scene *scene = plan->scene;
    if (finish->emits && !add_light(rows, plan, &finish->material->glow, 1, err))
        return false;
    for (int i = 0; finish->fluoresces && i < plan->n_lights; i++)
        if (plan->lights[i].first == i &&
            !add_luminescence(rows, plan, finish, &plan->lights[i].light->spectrum, err))
            return false;
    for (int i = 0; finish->fluoresces && i < scene->n_ambients; i++)
        if (!add_luminescence(rows, plan, finish, &scene->ambients[i].spectrum, err))
            return false;
    return true;
}

/* Lights of one spectrum are one. */
static bool add_lights(const struct rows *rows, const struct plan *plan, struct error *err)
{
    const struct scene *scene = plan->scene;
    for (int i = 0; i < plan->n_lights; i++) {
        const struct light *light = plan->lights[i].light;
        if (plan->lights[i].first == i &&
            !add_light(rows, plan, &light->spectrum, light->intensity, err))
            return false;
    }
    for (int i = 0; i < scene->n_ambients; i++)
        if (!add_light(rows, plan, &scene->ambients[i].spectrum, scene->ambients[i].intensity, err))
            return false;
    for (int i = 0; i < plan->n_finishes; i++)
        if (!add_own_lights(rows, plan, &plan->finishes[i], err))
            return false;
    return true;
}

static bool add_products(const struct rows *rows, const struct plan *plan, struct error *err)
{
    const size_t n_nm = (size_t)rows->n_nm;
    for (int i = 0; i < plan->n_finishes; i++)
        for (int t = 0; t < plan->finishes[i].n_terms; t++) {
            const double *spectrum = plan->finishes[i].spectra + (size_t)t * n_nm;
            double *row = add_row(rows, err);
            if (!row || !check_row(rows, spectrum, plan->finishes[i].material->place, err))
                return false;
            memcpy(row, spectrum, n_nm * sizeof *row);
        }
    return true;
}

bool scene_spectra(const struct scene *scene, struct fine_spectra *out, struct error *err)
{
    struct scene fine;
    struct plan plan;
    *out = (struct fine_spectra){.n_nm = 0};
    bool done = plan_finely(scene, &fine, &plan, err);
    if (done) {
        out->first_nm = fine.wavelengths_nm[0];
        out->n_nm = fine.n_wavelengths;
        const struct rows lights = {&out->lights, &out->n_lights, out->n_nm};
        const struct rows products = {&out->products, &out->n_products, out->n_nm};
        done = add_lights(&lights, &plan, err) && add_products(&products, &plan, err);
    }
    plan_free(&plan);
    free(fine.wavelengths_nm);
    if (!done)
        fine_spectra_free(out);
    return done;
}

/* ---- scenes that are sampled ---- */

static bool refuse_texture(void *sampling, const struct material *material, struct error *err)
{
    char name[SAMPLING_NAME];
    if (!material->spectral_texture)
        return true;
    sampling_name(&((const struct sampling *)sampling)->method, name);
    return error_at(err, material->spectral_texture_place,
                    "%s has no wavelengths to take a spectral texture at; box, riemann, gauss and "
                    "adaptive have",
                    name);
}

/* The pages' wavelengths, or numbers of components, become the scene's. */
static bool take_sampling(struct scene *scene, struct sampling *sampling, struct error *err)
{
    if (!sampling->spectral && !visit_materials(scene, refuse_texture, sampling, err))
        return false;
    const size_t n = (size_t)sampling->n;
    double *wavelengths_nm = malloc(n * sizeof *wavelengths_nm);
    if (!wavelengths_nm)
        return error_memory(err);
    memcpy(wavelengths_nm, sampling->wavelength_nm, n * sizeof *wavelengths_nm);
    free(scene->wavelengths_nm);
    scene->wavelengths_nm = wavelengths_nm;
    scene->n_wavelengths = sampling->n;
    scene->sampling = sampling;
    return true;
}

bool scene_sample(struct scene *scene, const struct sampling_method *method, const char *detector,
                  struct error *err)
{
    struct fine_spectra spectra = {.n_nm = 0};
    struct sampling *sampling = calloc(1, sizeof *sampling);
    if (!sampling)
        return error_memory(err);
    bool done = scene_spectra(scene, &spectra, err) &&
                sampling_make(method, detector, &spectra, sampling, err) &&
                take_sampling(scene, sampling, err);
    fine_spectra_free(&spectra);
    if (!done) {
        sampling_free(sampling);
        free(sampling);
    }
    return done;
}
