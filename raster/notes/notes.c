/* SPDX-License-Identifier: MIT */
/* A list of notes, and the order in which they are made. */
#include <stdarg.h>

#include "raster/notes/notes.h"

void note_add(struct notes *notes, const char *code, const char *format, ...)
{
    struct note *note = &notes->list[notes->n++];
    va_list arguments;
    note->code = code;
    va_start(arguments, format);
    vsnprintf(note->text, sizeof note->text, format, arguments);
    va_end(arguments);
}

bool notes_make(const struct lit_scene *lit, int judged_pixels, struct notes *out,
                struct error *err)
{
    note_dark(lit, out);
    note_tables(lit->plan, out);
    if (!out->refined &&
        !accuracy_estimate(lit->plan, lit->surfaces, judged_pixels, &out->shading, err))
        return false;
    note_shading(lit->plan, out);
    return true;
}

bool notes_of_plan(const struct plan *plan, int judged_pixels, struct notes *out, struct error *err)
{
    struct lit_scene lit;
    struct light_work work;
    const bool done = lit_make(plan, driver_of(NULL), &lit, &work, err) &&
                      notes_make(&lit, judged_pixels, out, err);
    lit_free(&lit);
    return done;
}

void notes_of_nothing(struct notes *notes)
{
    notes->n = 0;
    note_add(notes, "nothing-in-view", "the picture is black: no object is in view");
}

void notes_print(const struct notes *notes, struct printed *to)
{
    refined_print(notes, to);
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
    accuracy_estimate_free(&notes->shading);
}
