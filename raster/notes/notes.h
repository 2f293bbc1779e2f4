/* SPDX-License-Identifier: MIT */
/* The room "notes": the plan in words, and notes on a scene: what makes its picture black or
 * guessed. A note changes no pixel and no exit status. */
#ifndef NOTES_H
#define NOTES_H

#include "data/options/options.h"
#include "data/text/text.h"
#include "raster/bounds/bounds.h"
#include "raster/passes/passes.h"
#include "raster/plan/plan.h"
#include "raster/accuracy/accuracy.h"
#include "spectral.h"

/* ---- notes.c: a list of notes ---- */

enum { NOTE_TEXT = 768, MOST_NOTES = 8 };
struct note {
    const char *code;     /* a name for scripts, which stays from version to version: "black" */
    char text[NOTE_TEXT]; /* one line */
};
struct notes {
    struct note list[MOST_NOTES];
    int n;
    struct accuracy_estimate shading;    /* its error, unless the plan was refined */
    const struct refine_result *refined; /* how the plan was refined; NULL: it was not */
};
/* Pixels at which shading is judged: enough for a note, and for a table of objects. */
enum { SOME_PIXELS = 2048, MANY_PIXELS = 16384 };
/* Makes the notes on a lit scene, in time linear in vertices x terms and in triangles. *out comes
 * in zeroed, but for `refined`, which must outlive it. Judges the shading of about so many pixels,
 * unless the plan was refined. */
bool notes_make(const struct lit_scene *lit, int judged_pixels, struct notes *out,
                struct error *err);
/* Makes them on a plan. Refuses what lit_make refuses, as a render does. */
bool notes_of_plan(const struct plan *plan, int judged_pixels, struct notes *out,
                   struct error *err);
/* Leaves one note, on a picture that shows no object. */
void notes_of_nothing(struct notes *notes);
/* Prints a line for each note. */
void notes_print(const struct notes *notes, struct printed *to);
/* Prints the lines; as JSON: the array "notes" of objects with the members "code" and "text". */
void notes_put(const struct notes *notes, struct json *json);
void notes_free(struct notes *notes);

/* ---- facts.c: the plan as JSON or in words ---- */

/* Puts one object. notes NULL: leaves them out. Fails only where memory or a file of the scene
 * does.
 */
bool plan_facts(const struct plan *plan, const struct notes *notes, struct json *json,
                struct error *err);
/* Puts the members on the scene, and on the size and the wavelengths of its picture. */
void scene_put(const struct plan *plan, struct json *json);
/* shading.c: puts the shading's error of the picture and of its objects, and how triangles were
 * divided, as the object "accuracy". */
void accuracy_put(const struct plan *plan, const struct notes *notes, struct json *json);

/* ---- command.c: spectral plan ---- */

/* Prints the plan of a scene, and the notes on it. */
bool command_plan(struct options *options, struct error *err);

/* ---- Inside this room ---- */

void note_add(struct notes *notes, const char *code, const char *format, ...) PRINTF_LIKE(3, 4);

/* left_out.c: puts the work that the scene does not call for, as the list "left_out". */
void left_out_put(const struct plan *plan, const struct passes *passes, struct json *json);

/* dark.c, tables.c: add notes on a black picture, on black objects in view, and on tables that end
 * before the picture's wavelengths do. */
void note_dark(const struct lit_scene *lit, struct notes *notes);
void note_tables(const struct plan *plan, struct notes *notes);
/* Prints a line for each table that the picture reaches beyond. */
void tables_print(const struct plan *plan, struct printed *to);

/* shading.c. Adds a note on the object whose shading is worst, if it is seen to be wrong. */
void note_shading(const struct plan *plan, struct notes *notes);
/* Prints the refinement in a line. */
void refined_print(const struct notes *notes, struct printed *to);

#endif
