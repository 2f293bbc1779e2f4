/* SPDX-License-Identifier: MIT */
/* The room "notes": the plan in words, and notes on a scene: what makes its picture black or
 * guessed. A note changes no pixel and no exit status. */
#ifndef NOTES_H
#define NOTES_H

#include "data/options/options.h"
#include "data/text/text.h"
#include "raster/bounds/bounds.h"
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
/* Writes the array "notes" of objects with the members "code" and "text". */
void notes_json(const struct notes *notes, struct json *json);
void notes_free(struct notes *notes);

/* ---- print.c: the plan in words ---- */

/* Fail only where memory runs out. */
bool plan_print(const struct plan *plan, struct printed *to, struct error *err);
/* json.c: begins a text with one JSON object. */
bool plan_json(const struct plan *plan, const struct notes *notes, struct json *json,
               struct error *err);

/* ---- command.c: spectral plan ---- */

/* Prints the plan of a scene, and the notes on it. */
bool command_plan(struct options *options, struct error *err);

/* ---- Inside this room ---- */

void note_add(struct notes *notes, const char *code, const char *format, ...) PRINTF_LIKE(3, 4);

/* print.c: returns why a light does not shine; NULL: it shines. Ask for all lights in the order of
 * the scene; *shining counts those of the plan, from 0. */
const char *why_off(const struct plan *plan, const struct light *light, int *shining);

/* print.c: finds "SHA-256 PATH" of each of the n files of the scene, each with a NUL behind it. The
 * caller frees *text, also after a failure. */
bool plan_files(const struct plan *plan, char **text, int *n, struct error *err);

/* print.c: the work of a plan in numbers, with their names. */
enum { PLAN_COUNTS = 11 };
struct plan_count {
    const char *name;
    uint64_t n;
};
/* passes: those of a tile. */
void count_work(const struct plan *plan, int passes, struct plan_count out[PLAN_COUNTS]);

/* left_out.c: work that the scene does not call for. */

enum { LEFT_OUT_REASON = 128 };
struct left_out {
    const char *what; /* "instances", in the plural */
    long n, of;       /* so many of all */
    char reason[LEFT_OUT_REASON];
};
struct left_out_list {
    struct left_out list[16];
    int n, drawn_passes; /* drawn_passes: of a tile, by OpenGL */
};
/* Fails only where memory runs out. */
bool left_out_make(const struct plan *plan, struct left_out_list *out, struct error *err);

/* dark.c, tables.c: add notes on a black picture, on black objects in view, and on tables that end
 * before the picture's wavelengths do. */
void note_dark(const struct lit_scene *lit, struct notes *notes);
void note_tables(const struct plan *plan, struct notes *notes);
/* Prints a line for each table that the picture reaches beyond. */
void tables_print(const struct plan *plan, struct printed *to);

/* shading.c. Adds a note on the object whose shading is worst, if it is seen to be wrong. */
void note_shading(const struct plan *plan, struct notes *notes);
/* Print the refinement in a line, and the shading's error of the picture and of the worst objects.
 */
void refined_print(const struct notes *notes, struct printed *to);
void shading_print(const struct plan *plan, const struct notes *notes, struct printed *to);
/* Writes both for all objects, as the object "accuracy". */
void accuracy_json(const struct plan *plan, const struct notes *notes, struct json *json);

#endif
