/* SPDX-License-Identifier: MIT */
/* Notes on spectra: wavelengths that count in another unit, tables that end before the picture's
 * wavelengths do, and lights that count in percent. */
#include <stdlib.h>
#include <string.h>

#include "raster/notes/notes.h"

/* ---- the tables of a scene ---- */

struct table_list {
    struct table_use *list;
    int n;
};

/* Adds the spectrum if it is a table. */
static void add_table(struct table_list *to, const struct table_use *use)
{
    if (use->table.kind == SPECTRUM_SAMPLED)
        to->list[to->n++] = *use;
}

static void add_lights(const struct scene *scene, struct table_list *to)
{
    for (int i = 0; i < scene->n_lights; i++) {
        const struct light *light = &scene->lights[i];
        if (light->intensity != 0)
            add_table(to, &(struct table_use){"light", light->spectrum.name, "0", light->spectrum,
                                              light->intensity});
    }
    for (int i = 0; i < scene->n_ambients; i++) {
        const struct ambient *ambient = &scene->ambients[i];
        if (ambient->intensity != 0)
            add_table(to, &(struct table_use){"ambient", ambient->spectrum.name, "0",
                                              ambient->spectrum, ambient->intensity});
    }
}

static void add_material(const struct shaded_material *shaded, struct table_list *to)
{
    static const char held[] = "the end value holds";
    const struct material *material = shaded->material;
    const char *name = material->name;
    add_table(to, &(struct table_use){"diffuse", name, held, material->diffuse, 0});
    if (has_term(shaded, TERM_SPECULAR))
        add_table(to, &(struct table_use){"specular", name, held, material->specular, 0});
    if (shaded->made.fluoresces && material->excitation.kind != SPECTRUM_NONE)
        add_table(to, &(struct table_use){"emission", name, "0", material->emission, 0});
    if (shaded->made.emits)
        add_table(to, &(struct table_use){"emission", name, "0", material->glow, 1});
}

static void add_texture(const struct texture *texture, struct table_list *to)
{
    const struct image *image = &texture->image;
    if (texture->spectral)
        add_table(to, &(struct table_use){"texture",
                                          image->path,
                                          "the end page holds",
                                          {.kind = SPECTRUM_SAMPLED,
                                           .count = image->n_pages,
                                           .wavelength_nm = image->wavelengths_nm},
                                          0});
}

struct table_use *tables_list(const struct plan *plan, int *n, struct error *err)
{
    const struct scene *scene = plan->scene;
    const int most =
        scene->n_lights + scene->n_ambients + 4 * plan->n_materials + plan->n_textures + 1;
    struct table_list made = {.list = calloc((size_t)most, sizeof *made.list)};
    if (!made.list) {
        error_memory(err);
        return NULL;
    }
    add_lights(scene, &made);
    for (int i = 0; i < plan->n_materials; i++)
        add_material(&plan->materials[i], &made);
    for (int i = 0; i < plan->n_textures; i++)
        add_texture(&plan->textures[i], &made);
    *n = made.n;
    return made.list;
}

int table_outside(const struct plan *plan, const struct table_use *use)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    int outside = 0;
    for (int i = 0; i < pages_looked_at(pages); i++)
        outside += spectrum_extrapolates(&use->table, pages_looked_at_nm(pages, i));
    return outside;
}

/* ---- wavelengths in another unit ---- */

/* As for tables: see spectrum_is_in_nm. */
static const double shortest_nm = 20;
static const double longest_metre = 1e-3; /* the longest wavelength, a millimetre, in metres */

static double last_nm(const struct plan *plan)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    return pages_looked_at_nm(pages, pages_looked_at(pages) - 1);
}

static double table_end(const struct table_use *use)
{
    return use->table.wavelength_nm[use->table.count - 1];
}

bool note_wavelengths(const struct plan *plan, struct notes *notes, struct error *err)
{
    const double last = last_nm(plan), first = pages_looked_at_nm(&plan->illumination.pages, 0);
    const int steps = plan->n_bands > 1 ? plan->n_bands - 1 : 1;
    const bool metres = last < longest_metre;
    const double nm = metres ? 1e9 : 1e3;
    return last >= shortest_nm ||
           note_add(notes, "wavelengths", err,
                    "the wavelengths of the picture, %.6g to %.6g nm, look like %s; in "
                    "nanometres they are: wavelengths %.6g %.6g %.3g",
                    first, last, metres ? "metres" : "micrometres", first * nm, last * nm,
                    last > first ? (last - first) / steps * nm : nm / 1e3);
}

/* ---- tables that end too early ---- */

/* Returns true if the picture reaches beyond an end of the table by more than the table's step
 * there. A light's table that ends near 0 misses nothing. */
static bool misses(const struct table_use *use, double beyond_nm, double step_nm, int end)
{
    double largest = 0;
    if (!(beyond_nm > step_nm))
        return false;
    if (strcmp(use->ends, "0") != 0)
        return true;
    for (int i = 0; i < use->table.count; i++)
        largest = use->table.value[i] > largest ? use->table.value[i] : largest;
    return use->table.value[end] > 0.01 * largest;
}

static bool ends_early(const struct plan *plan, const struct table_use *use)
{
    const double first = pages_looked_at_nm(&plan->illumination.pages, 0);
    const double *at = use->table.wavelength_nm;
    const int last = use->table.count - 1;
    return last_nm(plan) >= shortest_nm &&
           (misses(use, at[0] - first, last > 0 ? at[1] - at[0] : 0, 0) ||
            misses(use, last_nm(plan) - at[last], last > 0 ? at[last] - at[last - 1] : 0, last));
}

/* How many tables of one kind and range end too early, and the first of them. */
struct alike {
    int first, n;
};
struct table_ends {
    const struct plan *plan;
    const struct table_list *tables;
    struct alike *alike;
    int n_alike;
    struct index ranges; /* the indices of `alike` */
};

/* Writes a key that tables of one kind and range share. */
static int range_key(const struct table_use *use, char key[128])
{
    return snprintf(key, 128, "%s,%s,%a,%a", use->what, use->ends, use->table.wavelength_nm[0],
                    table_end(use));
}

/* Counts the tables that end too early. */
static bool count_alike(struct table_ends *ends, struct error *err)
{
    for (int i = 0; i < ends->tables->n; i++) {
        const struct table_use *use = &ends->tables->list[i];
        const struct alike fresh = {.first = i, .n = 1};
        char key[128];
        if (!ends_early(ends->plan, use))
            continue;
        const size_t length = (size_t)range_key(use, key);
        const int known = index_find(&ends->ranges, key, length);
        if (known >= 0)
            ends->alike[known].n++;
        else if (!index_add(&ends->ranges, key, length, ends->n_alike, err) ||
                 !array_add(&ends->alike, &ends->n_alike, &fresh, sizeof fresh, err))
            return false;
    }
    return true;
}

/* Adds a note if tables end too early, and this is the first of them. */
static bool note_end(const struct table_ends *ends, int index, struct notes *notes,
                     struct error *err)
{
    const struct plan *plan = ends->plan;
    const struct table_use *use = &ends->tables->list[index];
    char others[32] = "", key[128];
    const int known = index_find(&ends->ranges, key, (size_t)range_key(use, key));
    if (known < 0 || ends->alike[known].first != index)
        return true;
    if (ends->alike[known].n > 1)
        snprintf(others, sizeof others, " and %d more", ends->alike[known].n - 1);
    return note_add(notes, "extrapolated", err,
                    "%s %.300s%s: the table covers %g to %g nm; %d of the %d wavelengths of the "
                    "picture lie outside, where %s",
                    use->what, use->owner, others, use->table.wavelength_nm[0], table_end(use),
                    table_outside(plan, use), pages_looked_at(&plan->illumination.pages),
                    strcmp(use->ends, "0") == 0 ? "it is taken as 0" : use->ends);
}

/* ---- lights in percent ---- */

/* Returns the mean from 400 to 700 nm, over the wavelengths that the table covers; 0: none. */
static double visible_mean(const struct spectrum *table)
{
    double sum = 0;
    int n = 0;
    for (int nm = 400; nm <= 700; nm += 10)
        if (!spectrum_extrapolates(table, nm)) {
            sum += spectrum_at(table, nm, SPECTRUM_ZERO);
            n++;
        }
    return n > 0 ? sum / n : 0;
}

/* Built-in illuminants are 1 at 560 nm, and about 1 on average. Tables of the CIE and of many
 * instruments are 100 there. An intensity that makes up for it shows that the author knows. */
static bool note_percent(const struct table_use *use, struct notes *notes, struct error *err)
{
    const double most = 20, mean = use->intensity > 0 ? visible_mean(&use->table) : 0;
    return !(mean > most && use->intensity * mean > most) ||
           note_add(notes, "percent", err,
                    "%s %.300s is %.3g on average from 400 to 700 nm, where built-in lights are "
                    "about 1; if the table counts in percent, write %.*s*%.3g",
                    use->what, use->table.name, mean, (int)strcspn(use->table.name, "*"),
                    use->table.name, 0.01 * use->table.factor);
}

bool note_tables(const struct plan *plan, struct notes *notes, struct error *err)
{
    struct table_list tables;
    struct table_ends ends = {.plan = plan, .tables = &tables};
    tables.list = tables_list(plan, &tables.n, err);
    bool done = tables.list != NULL && count_alike(&ends, err);
    for (int i = 0; done && i < tables.n; i++)
        done = note_end(&ends, i, notes, err) && note_percent(&tables.list[i], notes, err);
    free(tables.list);
    free(ends.alike);
    index_free(&ends.ranges);
    return done;
}
