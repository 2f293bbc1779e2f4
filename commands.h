/* SPDX-License-Identifier: MIT */
/* The commands and what they share, a section a room. Each section belongs in the header of its
 * room as soon as the room has one.
 *
 * A command reads its own meaning out of the options, does its work and prints. It returns false
 * with the error filled in; main prints the error and exits with its status. A command may change
 * *options, which the caller frees. */
#ifndef COMMANDS_H
#define COMMANDS_H

#include <stdbool.h>
#include <stdint.h>

#include "data/options/options.h"
#include "spectral.h"

/* ======== data/base ======== */

/* ---- data/base/outputs.c: the names of files that a command writes ---- */

/* Returns the file's name without its folder and its ending, with another ending: where the output
 * of a command goes by default. Allocated; NULL: no memory. */
char *output_name(const char *path, const char *ending);
/* Returns whether there is a regular file of that name, or a link to one. */
bool file_is_regular(const char *path);
/* Refuses an output that would replace the input. Either may be NULL. */
bool output_spares(const char *output, const char *input, struct error *err);
/* Refuses an output that cannot be opened, so that the mistake is found before the work and not
 * after it. Leaves no file. "-" is standard output; NULL: no output is wanted. */
bool output_can_open(const char *path, struct error *err);

/* ---- data/base/progress.c: the program watches itself ---- */

/* Seconds of a clock that only goes forward. */
double clock_seconds(void);

/* A line of progress with the time left, on standard error. */
struct progress_line {
    double start, printed; /* in clock_seconds: the beginning, and the last time of printing */
};
/* Begins a line. Returns whether it is to be shown: standard error is a terminal, and not quiet. */
bool progress_start(struct progress_line *out, bool quiet);
/* Shows that `done` of `all` steps are done; removes the line after the last one. The context is a
 * struct progress_line. */
void progress_show(void *context, long done, long all);
/* The largest memory that the process has used so far; 0: unknown. */
uint64_t peak_bytes(void);

/* ======== data/scene ======== */

/* ---- data/scene/command_line.c: a scene as the command line names and changes it ---- */

/* Reads SCENE and makes the changes that the options ask for, in their order. */
bool scene_read_options(const struct options *options, struct scene *out, struct error *err);
/* Refuses an output that would replace a file of the scene. NULL: no output. */
bool scene_spared(const char *output, const struct scene *scene, struct error *err);
/* Refuses the name of a built-in scene where a stack is expected, since nobody has rendered it yet.
 * A missing file passes: whoever opens it reports that. */
bool scene_refuse(const char *stack, struct error *err);

/* ======== data/stack ======== */

/* ---- data/stack/command.c: spectral info ---- */

/* Prints how a stack was made. */
bool command_info(struct options *options, struct error *err);
/* Opens a stack and reads its record. The caller closes the image and frees the record, also after
 * a failure; the record needs the image no longer. */
bool record_open(const char *path, struct image *image, struct record *out, struct error *err);

/* ======== data/develop ======== */

/* ---- data/develop/command.c: spectral develop ---- */

/* Writes the picture of a stack that a detector sees. */
bool command_develop(struct options *options, struct error *err);
/* Refuse a value that --adaptation, --display or --exposure cannot use; `option` is blamed. */
bool develop_accepts_adaptation(const char *option, const char *value, struct error *err);
bool develop_accepts_display(const char *option, const char *value, struct error *err);
bool develop_accepts_exposure(const char *option, const char *value, struct error *err);

/* ======== data/compare ======== */

/* ---- data/compare/command.c: spectral compare ---- */

/* Prints the differences of two stacks. Fails with EXIT_DIFFERENT where they exceed the tolerance.
 */
bool command_compare(struct options *options, struct error *err);
/* Refuses a value that --tolerance cannot use; `option` is blamed. */
bool compare_accepts_tolerance(const char *option, const char *value, struct error *err);

/* ======== data/catalogue ======== */

/* ---- data/catalogue/command.c: spectral list ---- */

/* Prints the names of one kind, or of all kinds. */
bool command_list(struct options *options, struct error *err);

/* ======== raster/plan ======== */

/* ---- raster/plan/command.c: spectral plan ---- */

/* Prints the plan of a scene. */
bool command_plan(struct options *options, struct error *err);
/* Reads SCENE with its changes, and samples it if --sampling is given. Refuses --detector without
 * --sampling. */
bool scene_read_sampled(const struct options *options, struct scene *out, struct error *err);

/* ======== raster/render ======== */

struct render_output;

/* ---- raster/render/command.c: spectral render ---- */

/* Renders a scene, or makes a stack again. Fails with EXIT_DIFFERENT where the pictures differ. */
bool command_render(struct options *options, struct error *err);
/* Renders a scene to its stack and reports. */
bool render_scene(struct options *options, struct error *err);
/* Reads, plans and renders the scene of the options, and reports. made: the record that the stack
 * is made again from; NULL: it is a new one. */
bool render_with_options(const struct options *options, const struct render_output *output,
                         const struct record *made, struct error *err);
/* Takes --no-check and --strict out of the options that the stack records: the reference's stack is
 * the same, however it was checked. */
void options_forget_check(struct options *options);

/* ---- raster/render/again.c: spectral render --again ---- */

/* Makes a stack again from the scene and the options that it records. Fails with EXIT_DIFFERENT
 * where the new stack is not the same to the last byte. */
bool render_again(struct options *options, struct error *err);

/* ======== raster/inspect ======== */

/* ---- raster/inspect/command.c: spectral probe ---- */

/* Prints the spectrum of a region, of a stack or of a scene. */
bool command_probe(struct options *options, struct error *err);

/* ======== raster/cost ======== */

/* ---- raster/cost/command.c: spectral cost ---- */

/* Measures configurations of render and names the best. Fails with EXIT_DIFFERENT where none is
 * within the tolerance or the budget. */
bool command_cost(struct options *options, struct error *err);

/* ======== raster/view ======== */

/* ---- raster/view/command.c: spectral view ---- */

/* Writes the page of a scene's viewer. */
bool command_view(struct options *options, struct error *err);

#endif
