/* SPDX-License-Identifier: MIT */
/* A list of notes, and those that are made here: on darkness, where nothing is in view, or an
 * object in view is black in all bands, and on tables that end early. */
#include <stdarg.h>

#include "raster/render/inside.h"

void note_add(struct notes *notes, const char *code, const char *format, ...)
{
    struct note *note = &notes->list[notes->n++];
    va_list arguments;
    note->code = code;
    va_start(arguments, format);
    vsnprintf(note->text, sizeof note->text, format, arguments);
    va_end(arguments);
}

/* ---- darkness ---- */

void notes_of_nothing(const struct plan *plan, struct notes *notes)
{
    const struct camera *camera = &plan->scene->camera;
    char where[128] = "";
    if (plan->n_instances > 0 && !plan->instances[0].in_view)
        snprintf(where, sizeof where, "; the first lies %s (near %g, far %g)",
                 view_plane_words[plan->instances[0].outside], camera->near, camera->far);
    notes->n = 0;
    note_add(notes, "nothing-in-view", "the picture is black: no object is in view%s", where);
}

/* Returns the sum of what all lights may give all vertices of a surface. Phong shading lights
 * points between vertices: there each light that the material shows counts. */
static double light_of(const struct lit_scene *lit, int index)
{
    const struct surface *surface = &lit->surfaces[index];
    const struct shaded_material *shaded = lit->bounds[index].shaded;
    const bool phong = lit->plan->scene->shading == SHADING_PHONG;
    double light = 0;
    for (int i = 0; i < surface->instance->n_vertices; i++)
        for (int side = 0; side < surface->n_sides; side++) {
            const double *weights = surface->weights + surface_attributes(surface, i, side);
            for (int t = 0; t < shaded->n_terms; t++)
                light += (phong ? 1 : weights[t]) * shaded->made.terms[t].peak;
        }
    return shaded->texture && !phong ? light * shaded->texture->largest : light;
}

/* A material of diffuse 0 alone is meant to be black. */
static bool is_black(const struct lit_scene *lit, int index)
{
    const struct material *material = lit->bounds[index].shaded->material;
    const bool meant = spectrum_is_zero(&material->diffuse) && material->gloss == 0 &&
                       material->excitation.kind == SPECTRUM_NONE && !material->donaldson &&
                       material->glow.kind == SPECTRUM_NONE;
    return lit->plan->instances[index].in_view && !meant && light_of(lit, index) == 0;
}

/* Adds one note for all objects that are black. Halves and parts of an object count once. */
static void note_dark(const struct lit_scene *lit, struct notes *notes)
{
    const struct placed_instance *instances = lit->plan->instances;
    const struct object *last = NULL;
    int n = 0, first = 0;
    char object[256];
    bool shows = false;
    for (int s = 0; s < lit->plan->n_instances; s++) {
        shows = shows || instances[s].in_view;
        if (instances[s].object == last || !is_black(lit, s))
            continue;
        first = n++ == 0 ? s : first;
        last = instances[s].object;
    }
    if (!shows)
        notes_of_nothing(lit->plan, notes);
    if (n == 0)
        return;
    object_text(lit->plan, first, object, sizeof object);
    note_add(notes, "black",
             "%d object%s black, first %s: no light that it shows reaches its vertices", n,
             n == 1 ? " is" : "s are", object);
}

/* ---- depth ---- */

/* Adds a note on the first object whose depth, of 24 bits, lies within a few steps of that of the
 * far plane. In perspective its steps are then about as long as its distance. */
static void note_depth(const struct lit_scene *lit, struct notes *notes)
{
    char object[256];
    for (int s = 0; s < lit->plan->n_instances && lit->plan->options.check; s++) {
        double nearest = 1;
        for (int v = 0; v < lit->surfaces[s].instance->n_vertices; v++)
            nearest = fmin(nearest, lit->surfaces[s].vertices[v].z);
        if (!lit->plan->instances[s].in_view || nearest < 1 - 4 * 0x1p-24)
            continue;
        object_text(lit->plan, s, object, sizeof object);
        note_add(notes, "depth",
                 "the depth of %s rounds to that of the far plane, so that OpenGL may lose it; "
                 "move the near plane away, or the far plane near",
                 object);
        return;
    }
}

/* ---- emission ---- */

/* Adds a note on each material that emits light as no substance does, while there is room. A
 * quarter of shorter wavelengths is more than overlapping curves have; these may be exchanged. */
static void note_emission(const struct plan *plan, struct notes *notes)
{
    double shorter, most;
    for (int i = 0; i < plan->n_materials && notes->n < MOST_NOTES - 2; i++) {
        const struct material *material = plan->materials[i].material;
        const struct donaldson *matrix = &material->matrix;
        if (material->donaldson)
            fluorescence_balance(&matrix->excitation, &matrix->emission, matrix->share, &shorter,
                                 &most);
        else if (material->excitation.kind != SPECTRUM_NONE)
            fluorescence_balance(&material->excitation, &material->emission, NULL, &shorter, &most);
        else
            continue;
        if (shorter > 0.25)
            note_add(notes, "emission",
                     "%.0f %% of the light that %s emits has shorter wavelengths than the light "
                     "that it absorbs",
                     100 * shorter, material->name);
        if (most > 1 + 1e-9)
            note_add(notes, "emission", "%s emits %.3g times the light that it absorbs",
                     material->name, most);
    }
}

/* ---- entries of MTL files ---- */

/* Returns what the entries of the MTL file of material i lose; 0 if an earlier one has that file.
 */
static int lost_of_file(const struct scene *scene, int i)
{
    const struct material *all = scene->materials;
    int lost = 0;
    for (int k = 0; all[i].from_rgb && k < scene->n_materials; k++)
        if (all[k].from_rgb && strcmp(all[k].path, all[i].path) == 0) {
            if (k < i)
                return 0;
            lost |= all[k].lost;
        }
    return lost;
}

/* Adds a note for each MTL file on what the entries that objects use lose, while there is room. */
static void note_lost(const struct plan *plan, struct notes *notes)
{
    const struct scene *scene = plan->scene;
    static const char *const words[LOST_KINDS] = {
        "map_Kd without a picture that can be read, or with options",
        "other maps",
        "transparency (d, Tr, Tf)",
        "Ns above 128",
        "Ks above 1",
        "Ks without Ns, or with Ns 0",
        "illum 0, or 1 beside Ks and Ns"};
    for (int i = 0; i < scene->n_materials && notes->n < MOST_NOTES - 2; i++) {
        const int lost = lost_of_file(scene, i);
        char list[NOTE_TEXT / 2] = "";
        for (int k = 0; k < LOST_KINDS; k++)
            if (lost & 1 << k)
                snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s",
                         list[0] ? "; " : "", words[k]);
        if (lost)
            note_add(notes, "mtl", "not drawn of %.300s: %s", scene->materials[i].path, list);
    }
    for (int i = 0; i < plan->n_textures && notes->n < MOST_NOTES - 2; i++)
        if (plan->textures[i].rgb && image_has_alpha(&plan->textures[i].image))
            note_add(notes, "alpha", "not drawn: the alpha of %.300s",
                     plan->textures[i].image.path);
}

/* ---- all notes ---- */

/* Adds notes on tables that end before the picture's wavelengths do, and on noise in tables. */
static void note_tables(const struct plan *plan, struct notes *notes)
{
    const struct tables_found found = tables_look(plan, NULL);
    if (found.n == 1)
        note_add(notes, "extrapolated", "extrapolated: %s", found.first);
    else if (found.n > 1)
        note_add(notes, "extrapolated", "extrapolated: %d spectra, first %s", found.n, found.first);
    if (found.n_limited > 0)
        note_add(notes, "noise", "%d value%s of tables beyond 0 or 1 became that, first of %s",
                 found.n_limited, found.n_limited == 1 ? "" : "s", found.limited);
}

bool notes_make(const struct lit_scene *lit, int judged_pixels, struct notes *out,
                struct error *err)
{
    const struct place turn = lit->plan->scene->doubted_turn;
    note_dark(lit, out);
    note_depth(lit, out);
    if (turn.line > 0)
        note_add(out, "rotate", "%.300s:%d:%d: a turn by 1 degree or less; expected ANGLE X Y Z",
                 turn.path, turn.line, turn.column);
    note_tables(lit->plan, out);
    note_emission(lit->plan, out);
    note_lost(lit->plan, out);
    return !shading_judge || shading_judge->judge(lit, judged_pixels, out, err);
}

void notes_print(const struct notes *notes, struct printed *to)
{
    for (int i = 0; i < notes->n; i++)
        print(to, "note              %s\n", notes->list[i].text);
}

void notes_put(const struct notes *notes, struct json *json)
{
    if (json->words) {
        notes_print(notes, &json->printed);
        return;
    }
    json_open(json, "notes", '[');
    for (int i = 0; i < notes->n; i++) {
        json_open(json, NULL, '{');
        json_string(json, "code", notes->list[i].code);
        json_string(json, "text", notes->list[i].text);
        json_close(json, '}');
    }
    json_close(json, ']');
}

void notes_free(struct notes *notes)
{
    if (notes->shading)
        shading_judge->free(notes->shading);
    notes->shading = NULL;
}
