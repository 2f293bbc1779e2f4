/* SPDX-License-Identifier: MIT */
/* A list of notes, and the order in which they are made. */
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

/* Adds a note on tables that end before the picture's wavelengths do. */
static void note_tables(const struct plan *plan, struct notes *notes)
{
    char first[BEYOND_TEXT];
    const int tables = tables_beyond(plan, NULL, first);
    if (tables == 1)
        note_add(notes, "extrapolated", "extrapolated: %s", first);
    else if (tables > 1)
        note_add(notes, "extrapolated", "extrapolated: %d spectra, first %s", tables, first);
}

bool notes_make(const struct lit_scene *lit, int judged_pixels, struct notes *out,
                struct error *err)
{
    note_dark(lit, out);
    note_tables(lit->plan, out);
    return !shading_judge || shading_judge->judge(lit, judged_pixels, out, err);
}

bool notes_of_plan(const struct plan *plan, int judged_pixels, struct notes *out, struct error *err)
{
    struct lit_scene lit;
    const bool done =
        lit_make(plan, driver_of(NULL), &lit, err) && notes_make(&lit, judged_pixels, out, err);
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

void notes_print_shading(const struct notes *notes, struct printed *to)
{
    if (notes->shading)
        shading_judge->print(notes->shading, to);
}

void notes_put_shading(const struct plan *plan, const struct notes *notes, struct json *json)
{
    if (notes->shading)
        shading_judge->put(plan, notes->shading, json);
}

bool notes_refine(const struct options *options, struct plan *plan, struct notes *notes,
                  struct error *err)
{
    return !shading_judge || shading_judge->refine(options, plan, &notes->shading, err);
}

void notes_free(struct notes *notes)
{
    if (notes->shading)
        shading_judge->free(notes->shading);
    notes->shading = NULL;
}
