/* SPDX-License-Identifier: MIT */
/* The room "notes": the plan in words, and notes on a scene: what makes its picture black, dark or
 * guessed, and what to change. A note changes no pixel and no exit status. */
#ifndef NOTES_H
#define NOTES_H

#include "data/options/options.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "raster/bounds/bounds.h"
#include "raster/forecast/forecast.h"
#include "raster/plan/plan.h"
#include "raster/accuracy/accuracy.h"
#include "spectral.h"

/* ---- notes.c: a list of notes ---- */

enum { NOTE_TEXT = 768 };
struct note {
    const char *code;     /* a name for scripts, which stays from version to version: "black" */
    char text[NOTE_TEXT]; /* one line */
};
struct notes {
    struct note *list; /* owned */
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
/* Prints a line for each note. */
void notes_print(const struct notes *notes, struct printed *to);
/* Writes the array "notes" of objects with the members "code" and "text". */
void notes_json(const struct notes *notes, struct json *json);
void notes_free(struct notes *notes);

/* ---- print.c: the plan in words ---- */

/* Fail only where memory runs out. */
bool plan_print(const struct plan *plan, struct printed *to, struct error *err);
/* json.c: begins a text with one JSON object. */
bool plan_json(const struct plan *plan, const struct notes *notes, const struct forecast *forecast,
               struct json *json, struct error *err);

/* ---- command.c: spectral plan ---- */

/* Prints the plan of a scene, and the notes on it. */
bool command_plan(struct options *options, struct error *err);

/* ---- Inside this room ---- */

bool note_add(struct notes *notes, const char *code, struct error *err, const char *format, ...)
    PRINTF_LIKE(4, 5);

/* print.c: returns why a light does not shine; NULL: it shines. */
const char *why_off(const struct plan *plan, const struct light *light);

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

/* survey.c: what the vertices of a scene show. */

struct surface_survey {
    double area;      /* of its triangles in the picture, in pixels, as if nothing else hid them */
    double dark_area; /* of triangles without light */
    double brightest; /* an upper bound on the radiance of its vertices in all bands, and of those
                         that are corners of triangles in view */
    double brightest_in_view;
    unsigned outside; /* the planes that all of its vertices lie outside of */
    bool reaches;     /* some vertex lies inside the view, not on its border */
};
struct scene_survey {
    const struct lit_scene *lit;
    struct surface_survey *surfaces;   /* of each surface; owned */
    double brightest, area, dark_area; /* the largest of them, and sums */
    double *areas;                     /* of triangles of each class of brightness; owned */
};
bool survey_make(const struct lit_scene *lit, struct scene_survey *out, struct error *err);
void survey_free(struct scene_survey *survey);
/* Returns an upper bound on the radiance of a vertex, on a side, in all bands. */
double survey_vertex(const struct lit_scene *lit, int surface, int vertex, int side);
/* Returns a radiance, exact to 1/8, such that at most this share of the area in view shows
 * triangles with a brighter vertex. The area is not 0. */
double survey_exceeded(const struct scene_survey *survey, double share);
/* Returns a radiance that certainly becomes count 0; 0: there is none. */
double survey_black(const struct scene_survey *survey);
/* Returns true if the surface begins another object than the surface before it. */
bool begins_object(const struct plan *plan, int surface);

/* tables.c: spectra that are tables, and what may be wrong with them. */

struct table_use {
    const char *what, *owner; /* "diffuse", and the material's name; "light", and the table's */
    const char *ends;         /* the value outside the table, in words */
    struct spectrum table;    /* its arrays belong to the scene */
    double intensity;         /* of a light; 0: the table is no light */
};
/* Lists the tables that the picture depends on. The array is allocated; NULL after an error. */
struct table_use *tables_list(const struct plan *plan, int *n, struct error *err);
/* Returns how many of the wavelengths that the pages depend on lie outside the table. */
int table_outside(const struct plan *plan, const struct table_use *use);
/* Add notes on wavelengths that are no nanometres, on tables that end too early, and on lights that
 * count in percent. */
bool note_wavelengths(const struct plan *plan, struct notes *notes, struct error *err);
bool note_tables(const struct plan *plan, struct notes *notes, struct error *err);

/* shading.c. Adds a note on the object whose shading is worst, if it is seen to be wrong. */
bool note_shading(const struct plan *plan, struct notes *notes, struct error *err);
/* Print the refinement in a line, and the shading's error of the picture and of the worst objects.
 */
void refined_print(const struct notes *notes, struct printed *to);
void shading_print(const struct plan *plan, const struct notes *notes, struct printed *to);
/* Writes both for all objects, as the object "accuracy". */
void accuracy_json(const struct plan *plan, const struct notes *notes, struct json *json);

/* view.c, dark.c, weak.c, bright.c: add notes on objects that are not in view, on objects without
 * light, on lights that add next to nothing, and on a full scale that leaves the picture dark. */
bool note_view(const struct scene_survey *survey, struct notes *notes, struct error *err);
bool note_dark(const struct scene_survey *survey, struct notes *notes, struct error *err);
bool note_weak(const struct scene_survey *survey, struct notes *notes, struct error *err);
bool note_full_scale(const struct scene_survey *survey, struct notes *notes, struct error *err);

#endif
