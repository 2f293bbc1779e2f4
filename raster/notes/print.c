/* SPDX-License-Identifier: MIT */
/* Prints the plan in words: each effect with the reason why it is simulated or not, each light, and
 * each value that is guessed, not measured. */
#include <stdlib.h>

#include "raster/notes/notes.h"

/* The sources keep the order of the scene's lights. */
static int compare_sources(const void *a, const void *b)
{
    const struct light *p = *(const struct light *const *)a, *q = *(const struct light *const *)b;
    return (p > q) - (p < q);
}

const char *why_off(const struct plan *plan, const struct light *light)
{
    const struct spectral_pages *pages = &plan->illumination.pages;
    const struct light **found = bsearch(&light, plan->sources, (size_t)plan->n_lights,
                                         sizeof *plan->sources, compare_sources);
    if (found)
        return plan->is_idle[found - plan->sources] ? "it reaches no object in view" : NULL;
    return light->intensity == 0                  ? "intensity 0"
           : !pages_show(pages, &light->spectrum) ? "spectrum 0 at every wavelength shown"
                                                  : "no material reflects it";
}

static void print_lights(const struct plan *plan, struct printed *to)
{
    for (int i = 0; i < plan->scene->n_lights; i++) {
        const struct light *light = &plan->scene->lights[i];
        const char *off = why_off(plan, light);
        print(to, "light %-11d %s%s (%s, intensity %.6g)\n", i + 1, off ? "off: " : "on",
              off ? off : "", light->spectrum.name, light->intensity);
    }
}

static void print_texture(const struct plan *plan, const struct texture *texture,
                          struct printed *to)
{
    const struct image *image = &texture->image;
    print(to, "texture           %s: %d x %d texels, %d pages, %s%s\n", image->path, image->width,
          image->height, image->n_pages, texture->linear ? "linear" : "nearest",
          texture->spectral && plan->sampling ? ", at the wavelength of each page" : "");
}

static void print_extrapolation(const struct plan *plan, const struct table_use *use,
                                struct printed *to)
{
    const struct spectrum *table = &use->table;
    const int outside = table_outside(plan, use);
    if (outside > 0)
        print(to, "extrapolated      %s %s: %d of %d wavelengths outside %g..%g nm, %s there\n",
              use->what, use->owner, outside, pages_looked_at(&plan->illumination.pages),
              table->wavelength_nm[0], table->wavelength_nm[table->count - 1], use->ends);
}

static bool print_guesses(const struct plan *plan, struct printed *to, struct error *err)
{
    int n;
    struct table_use *tables = tables_list(plan, &n, err);
    if (!tables)
        return false;
    for (int i = 0; i < n; i++)
        print_extrapolation(plan, &tables[i], to);
    free(tables);
    for (int i = 0; i < plan->n_materials; i++) {
        const struct material *material = plan->materials[i].material;
        if (material->from_rgb)
            print(to, "not measured      %s: RGB of %s, spread over three bands\n", material->name,
                  material->path);
    }
    return true;
}

static void print_work(const struct plan *plan, const struct left_out_list *left_out,
                       struct printed *to)
{
    const struct scene *scene = plan->scene;
    const struct rectangle picture = plan_picture(plan);
    const int passes = left_out->drawn_passes;
    int most = 0;
    for (int i = 0; i < plan->n_materials; i++)
        most = plan->materials[i].n_terms > most ? plan->materials[i].n_terms : most;
    print(to, "objects           %d (%d instances, %ld vertices, %ld triangles)\n",
          scene->n_objects, plan->n_instances, plan->n_vertices, plan->n_triangles);
    print(to, "materials         %d (%ld terms, at most %d in one)\n", plan->n_materials,
          plan->work.terms, most);
    print(to, "excitation        %ld integrals\n", plan->work.excitation_integrals);
    print(to, "tiles             %d of %d x %d pixels\n", plan_tiles(plan, &picture),
          plan->tile_width, plan->tile_height);
    print(to, "passes            %ld (%d a tile, %d bands and %d lights each)\n",
          (long)passes * plan_tiles(plan, &picture), passes, BANDS_PER_PASS, LIGHTS_PER_PASS);
    for (int i = 0; i < left_out->n; i++)
        print(to, "left out          %ld of %ld %s (%s)\n", left_out->list[i].n,
              left_out->list[i].of, left_out->list[i].what, left_out->list[i].reason);
    print(to, "memory            %.1f MiB for a tile\n", (double)plan->tile_bytes / 1048576);
    print(to, "file              %llu bytes of pixels\n", (unsigned long long)plan->file_bytes);
}

static void print_bands(const struct plan *plan, struct printed *to)
{
    const struct scene *scene = plan->scene;
    if (plan->sampling && !plan->sampling->spectral)
        print(to, "bands             %d (components)\n", plan->n_bands);
    else
        print(to, "bands             %d (%.10g to %.10g nm)\n", plan->n_bands,
              scene->wavelengths_nm[0], scene->wavelengths_nm[plan->n_bands - 1]);
    if (plan->sampling) {
        print(to, "sampling          ");
        sampling_print(plan->sampling, to);
    }
}

bool plan_print(const struct plan *plan, struct printed *to, struct error *err)
{
    const struct scene *scene = plan->scene;
    struct left_out_list left_out;
    if (!left_out_make(plan, &left_out, err))
        return false;
    print(to, "scene             %s\n", scene->path);
    print(to, "picture           %d x %d pixels", scene->width, scene->height);
    if (scene->positions > 1)
        print(to, " of %d x %d positions", scene->positions, scene->positions);
    print_text(to, "\n");
    print_bands(plan, to);
    print_work(plan, &left_out, to);
    for (int i = 0; i < plan->n_effects; i++)
        print(to, "%-17s %s (%s)\n", plan->effects[i].name, plan->effects[i].used ? "yes" : "no",
              plan->effects[i].reason);
    print_lights(plan, to);
    for (int i = 0; i < plan->n_textures; i++)
        print_texture(plan, &plan->textures[i], to);
    return print_guesses(plan, to, err);
}
