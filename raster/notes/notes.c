/* SPDX-License-Identifier: MIT */
/* A list of notes, and the order in which they are made. */
#include <stdarg.h>
#include <stdlib.h>

#include "raster/notes/notes.h"

bool note_add(struct notes *notes, const char *code, struct error *err, const char *format, ...)
{
    struct note note = {.code = code};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(note.text, sizeof note.text, format, arguments);
    va_end(arguments);
    return array_add(&notes->list, &notes->n, &note, sizeof note, err);
}

static bool note_objects(const struct lit_scene *lit, struct notes *notes, struct error *err)
{
    struct scene_survey survey;
    bool done = survey_make(lit, &survey, err) && note_view(&survey, notes, err) &&
                note_dark(&survey, notes, err) && note_weak(&survey, notes, err) &&
                note_full_scale(&survey, notes, err);
    survey_free(&survey);
    return done;
}

bool notes_make(const struct lit_scene *lit, int judged_pixels, struct notes *out,
                struct error *err)
{
    const struct plan *plan = lit->plan;
    if (!note_wavelengths(plan, out, err))
        return false;
    if (plan->n_instances == 0)
        return note_add(out, "no-object", err,
                        "the scene shows no object: the picture is black; add lines such as "
                        "material white { diffuse 0.9 } and object sphere 1 30 30 material white");
    return note_objects(lit, out, err) && note_tables(plan, out, err) &&
           (out->refined ||
            accuracy_estimate(plan, lit->surfaces, judged_pixels, &out->shading, err)) &&
           note_shading(plan, out, err);
}

void notes_print(const struct notes *notes, struct printed *to)
{
    refined_print(notes, to);
    for (int i = 0; i < notes->n; i++)
        print(to, "note              %s\n", notes->list[i].text);
}

void notes_json(const struct notes *notes, struct json *json)
{
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
    free(notes->list);
    accuracy_estimate_free(&notes->shading);
    *notes = (struct notes){.list = NULL};
}
