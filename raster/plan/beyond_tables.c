/* SPDX-License-Identifier: MIT */
/* Spectra that are tables, and end before the picture's wavelengths do. */
#include "raster/plan/inside.h"

/* The tables of a plan, looked at one by one. */
struct looked {
    const struct plan *plan;
    struct printed *to; /* gets a line for each that ends too early; NULL: none */
    struct tables_found found;
};

static int count_outside(const struct spectral_pages *pages, const struct spectrum *table)
{
    int outside = 0;
    for (int i = 0; i < pages_looked_at(pages); i++)
        outside += spectrum_extrapolates(table, pages_looked_at_nm(pages, i));
    return outside;
}

/* Returns true if the picture reaches beyond an end of the table by more than the table's step
 * there. A table that ends near 0, and is 0 beyond, misses nothing. */
static bool ends_early(const struct spectral_pages *pages, const struct spectrum *table, bool holds)
{
    const double *at = table->wavelength_nm;
    const int last = table->count - 1, second = last > 0, before = last - second;
    const double low_nm = at[0] - pages_looked_at_nm(pages, 0),
                 high_nm = pages_looked_at_nm(pages, pages_looked_at(pages) - 1) - at[last];
    double seen = 0;
    for (int i = 0; !holds && i <= last; i++)
        seen = fmax(seen, 0.01 * table->value[i]);
    return (low_nm > at[second] - at[0] && (holds || table->value[0] > seen)) ||
           (high_nm > at[last] - at[before] && (holds || table->value[last] > seen));
}

/* what, owner: "diffuse", and the material's name, or "light", and the table's. Outside of the
 * table its end value holds, or it is 0. */
static void look_at(struct looked *tables, const char *what, const char *owner,
                    const struct spectrum *table, bool holds)
{
    const struct spectral_pages *pages = &tables->plan->illumination.pages;
    const int outside = table->kind == SPECTRUM_SAMPLED ? count_outside(pages, table) : 0;
    char rest[160];
    if (table->n_limited > 0 && tables->found.n_limited == 0)
        snprintf(tables->found.limited, BEYOND_TEXT, "%s %.200s, at %g nm", what, owner,
                 table->limited_nm);
    tables->found.n_limited += table->n_limited;
    if (outside == 0)
        return;
    snprintf(rest, sizeof rest, "%d of %d wavelengths outside %g..%g nm, %s there", outside,
             pages_looked_at(pages), table->wavelength_nm[0],
             table->wavelength_nm[table->count - 1], holds ? "the end value holds" : "0");
    if (tables->to)
        print(tables->to, "extrapolated      %s %s: %s\n", what, owner, rest);
    if (ends_early(pages, table, holds) && tables->found.n++ == 0)
        snprintf(tables->found.first, BEYOND_TEXT, "%s %.200s: %s", what, owner, rest);
}

static void look_at_material(struct looked *tables, const struct shaded_material *shaded)
{
    const struct material *material = shaded->material;
    const char *name = material->name;
    look_at(tables, "diffuse", name, &material->diffuse, true);
    if (has_term(shaded, TERM_SPECULAR))
        look_at(tables, "specular", name, &material->specular, true);
    if (shaded->made.fluoresces && material->excitation.kind != SPECTRUM_NONE)
        look_at(tables, "emission", name, &material->emission, false);
    if (shaded->made.emits)
        look_at(tables, "emission", name, &material->glow, false);
}

struct tables_found tables_look(const struct plan *plan, struct printed *to)
{
    struct looked tables = {.plan = plan, .to = to};
    const int n_lights = plan->scene->n_lights;
    for (int i = 0; i < n_lights + plan->scene->n_ambients; i++) {
        const struct light *light = scene_light(plan->scene, i);
        if (light->intensity != 0)
            look_at(&tables, i < n_lights ? "light" : "ambient", light->spectrum.name,
                    &light->spectrum, false);
    }
    for (int i = 0; i < plan->n_materials; i++)
        look_at_material(&tables, &plan->materials[i]);
    for (int i = 0; i < plan->n_textures; i++) {
        const struct image *image = &plan->textures[i].image;
        const struct spectrum pages = {.kind = SPECTRUM_SAMPLED,
                                       .count = image->n_pages,
                                       .wavelength_nm = image->wavelengths_nm};
        if (plan->textures[i].spectral)
            look_at(&tables, "texture", image->path, &pages, true);
    }
    return tables.found;
}
