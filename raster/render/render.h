/* SPDX-License-Identifier: MIT */
/* The room "render": a scene becomes a plan, and a plan becomes a stack, tile by tile and pass by
 * pass; the result is reported, with notes on what makes a picture black or guessed. OpenGL
 * draws while the check and the file take what it has drawn before. This room connects them, and
 * does not depend on how any of them works. */
#ifndef RASTER_RENDER_RENDER_H
#define RASTER_RENDER_RENDER_H

#include "data/stack/stack.h"
#include "raster/check/check.h"

struct shading;

/* ---- notes.c: a list of notes ---- */

enum { NOTE_TEXT = 768, MOST_NOTES = 10 };
struct note {
    const char *code;     /* a name for scripts, which stays from version to version: "black" */
    char text[NOTE_TEXT]; /* one line */
};
struct notes {
    struct note list[MOST_NOTES];
    int n;
    struct shading *shading; /* what the judge of shading found; NULL: nothing; owned */
};
/* Pixels at which shading is judged: enough for a note, and for a table of objects. */
enum { SOME_PIXELS = 2048, MANY_PIXELS = 16384 };
/* Makes the notes on a lit scene, in time linear in vertices x terms and in triangles. *out comes
 * in zeroed, but for what refining left. Judges the shading of about so many pixels, unless the
 * plan was refined. */
bool notes_make(const struct lit_scene *lit, int judged_pixels, struct notes *out,
                struct error *err);

/* Prints a line for each note. */
void notes_print(const struct notes *notes, struct printed *to);
/* Prints the lines; as JSON: the array "notes" of objects with the members "code" and "text". */
void notes_put(const struct notes *notes, struct json *json);
void notes_free(struct notes *notes);

/* Judges by how much a shaded picture is off light at every point of the true surfaces, before it
 * is drawn: see raster/beside/accuracy. */
struct shading_judge {
    /* Divides the triangles of a plan if the options ask for it. After an error the plan can
     * only be freed. *out is allocated; NULL: the options do not ask for it. */
    bool (*refine)(const struct options *options, struct plan *plan, struct shading **out,
                   struct error *err);
    /* Judges about so many pixels, unless the plan was refined, and adds notes. */
    bool (*judge)(const struct lit_scene *lit, int pixels, struct notes *notes, struct error *err);
    void (*print)(const struct shading *shading, struct printed *to); /* in a line */
    /* as the object "accuracy" */
    void (*put)(const struct plan *plan, const struct shading *shading, struct json *json);
    void (*free)(struct shading *shading);
};
extern const struct shading_judge *const shading_judge; /* NULL: this program has none */

/* ---- plan_command.c: spectral plan ---- */

/* Prints the plan of a scene, and the notes on it. */
extern const struct command plan_command;

void note_add(struct notes *notes, const char *code, const char *format, ...) PRINTF_LIKE(3, 4);

/* ---- stages.c ---- */

/* Seconds of each part. Parts work side by side, so that their sum may exceed the total. The
 * processor's are those of all threads. */
struct part_seconds {
    double read, plan, gl, raster, check, write, total, processor;
};

/* ---- render.c: everything before the first pixel, and after the last one ---- */

struct render_result {
    double full_scale;
    struct renderer_names names; /* empty: OpenGL did not draw */
    struct driver driver;        /* whose bounds the check uses */
    struct renderer_work gl;
    struct light_work light;
    struct check_verdict check;
    struct odd_samples odd;
    struct stack_difference difference; /* from the stack that is made again */
    const struct notes *notes;          /* those of struct render_output */
    struct part_rows rows;              /* that the stack has; count 0: all */
    const char *bounds_for;             /* the driver whose bounds were written; NULL: none were */
    uint64_t open_pixels;               /* that nothing bounds there, in some band */
    struct part_seconds seconds;
};
/* Pixels that another program has drawn. */
struct render_foreign {
    /* opens them as a renderer: see struct drawing_ways */
    bool (*open)(void *of, const struct plan *plan, int n_buffers, struct renderer **out,
                 struct error *err);
    void *of;
};
struct render_output {
    const struct verdict_limits *limits; /* of the check, if there is one */
    const char *path;                    /* of the stack; NULL: no stack is written */
    const char *check_map;               /* the map of the check; NULL: none is wanted */
    const char *again; /* the stack to compare the new one with, byte by byte; NULL: none */
    bool keep;         /* store the stack even if it fails its check or differs from `again` */
    bool discard;      /* compare the stack with `again`, and store none */
    struct outputs *outputs;              /* get all files */
    struct notes *notes;                  /* as notes_make takes them; NULL: none are wanted */
    const struct options *options;        /* for the record of the stack, if there is one */
    const struct render_foreign *foreign; /* NULL: OpenGL draws here */
    struct picture_part {                 /* draws these rows of tiles; count 0: all */
        int number, count;                /* from 1 */
    } part;
};

/* Renders into a stack. Returns true even if the picture fails its check or differs from `again`:
 * ask render_agreed. progress: shown after each pass; NULL: none. After a failure, an interruption
 * or a difference (without `keep`) no file has been created or changed. */
bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err);

/* ---- job.c: a scene on its way to a render ---- */

/* The plan points to scene and sampling: a job does not move. Zero it before use. */
struct render_job {
    struct scene scene;
    struct sampling sampling;
    struct plan plan;
    struct verdict_limits limits;
    struct notes notes;
    struct part_seconds seconds; /* of reading and planning */
    struct plan_options options;
};
/* Reads and samples the scene of the options, whose own options begin with struct render_options.
 * foreign: another program draws. Refuses what cannot be drawn so. The caller frees the job, also
 * after a failure. */
bool job_read(const struct options *options, bool foreign, struct render_job *job,
              struct error *err);
/* Plans the scene, and divides its triangles where --accuracy asks for it. */
bool job_plan(const struct options *options, struct render_job *job, struct error *err);
/* Plans a scene by the reference, and so reads its files: where renders read them in processes of
 * their own, no output of this one may replace one. Refuses what cannot be drawn. */
bool job_read_files(const struct scene *scene, struct error *err);
void job_free(struct render_job *job);

/* Makes a file beside a stack, by the reference: raster/beside/see/maps.c, and
 * raster/beside/verify/interval.c. */
struct map_maker {
    /* Refuses options that do not go together, or not with the scene. */
    bool (*check)(const struct options *options, const struct scene *scene, struct error *err);
    /* Draws the scene of a job, and writes the file that the options ask for, if they do. Reads
     * the driver of a render, and adds to its result. */
    bool (*write)(const struct options *options, const struct render_job *job,
                  struct render_result *result, struct outputs *outputs, struct error *err);
};
extern const struct map_maker *const map_makers[]; /* of this program; NULL comes last */

/* ---- verdict_words.c: the verdict in words ---- */

/* Returns false with EXIT_DIFFERENT. The message names the first pixel where the pictures differ,
 * or what could not be checked, and ends with `then`, the consequence, as "; no stack was wanted".
 */
bool report_disagreement(const struct plan *plan, const struct check_verdict *verdict,
                         const char *then, struct error *err);

/* ---- command.c: spectral render ---- */

/* Renders a scene, or makes a stack again. Fails with EXIT_DIFFERENT if the pictures differ. */
extern const struct command render_command;
/* The own options of render; of commands that render, too, they are the first member of theirs. */
struct render_options {
    const char *again, *check_map, *renderer, *gl, *buffer, *depth, *unchecked, *part, *maps,
        *bounds, *bounds_for;
    double full_scale;
    bool trust, no_check, strict, keep;
};
/* Options of these, which other commands take, too. `judged`: what may stay unchecked. */
extern const struct option_list renderer_options, library_option, judged_options, map_option,
    scale_option, verbose_option;
/* Options of the judge of shading, and of the makers of maps; empty without them. */
extern const struct option_list accuracy_options, maps_options, bounds_options;
/* Reads, plans and renders the scene of the options, and reports the result. The own options begin
 * with struct render_options. made: the record of the stack that is made again; NULL: the stack is
 * new. */
bool render_with_options(const struct options *options, const struct render_output *output,
                         const struct record *made, struct error *err);

#endif
