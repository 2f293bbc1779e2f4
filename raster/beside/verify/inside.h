/* SPDX-License-Identifier: MIT */
/* Only the files of the room "verify" include this. */
#ifndef RASTER_BESIDE_VERIFY_INSIDE_H
#define RASTER_BESIDE_VERIFY_INSIDE_H

#include "raster/beside/measure/measure.h"
#include "raster/beside/verify/verify.h"
#include "raster/beside/view/view.h"
#include "raster/volumes/volumes.h"

/* ---- export_scene.c: a scene as files ---- */

enum { DIGEST_TEXT = 65, FILE_NAME = 64 };
/* Describes all that is to be drawn of a plan, whose full scale is found: the files of meshes,
 * triangles, textures and passes, and at last scene.txt, which has the digests of all others. id:
 * the SHA-256 of scene.txt without its line "id". folder: gets the files, whose names begin with
 * the prefix; NULL: only the id is wanted. */
bool scene_describe(const struct lit_scene *lit, const struct folder *folder, const char *prefix,
                    char id[DIGEST_TEXT], struct error *err);
/* Writes the files of a plan, its legal counts, the files of the targets and exported.txt, which
 * has these words, into a new folder, options->output, which appears whole or not at all. */
bool export_plans(const struct plan *plan, const struct plan *targets, const char *words,
                  const struct options *options, struct error *err);

/* ---- interval.c: the legal counts of pixels ---- */

/* Lights a plan for a driver, makes the volumes of its shadows, and finds its full scale. The
 * caller frees both, also after a failure. */
bool light_plan(const struct plan *plan, const struct driver *driver, struct lit_scene *lit,
                struct volumes *volumes, struct error *err);
struct interval_file {
    const struct options *options; /* for its record */
    const char *path;
    struct outputs *outputs; /* gets the file; NULL: it appears at once */
};
/* Writes a stack with two pages a band: the lowest and the highest count of 16 bits that the
 * driver of a lit scene may show at each pixel; the scene has bounds. *n_open: pixels that nothing
 * bounds in some band. */
bool interval_write(const struct lit_scene *lit, const struct interval_file *to, uint64_t *n_open,
                    struct error *err);

/* ---- exchange.c: pixels of another program ---- */

extern const char targets_prefix[]; /* of the files of the targets */
struct foreign_pixels {
    const char *path;     /* the folder */
    const char *prefix;   /* of the names of the files there: "", or targets_prefix */
    struct driver driver; /* a finding, once they are opened: the one that was measured */
};
/* Opens struct foreign_pixels as a renderer: see struct render_foreign. */
bool drawn_open(void *pixels, const struct plan *plan, int n_buffers, struct renderer **out,
                struct error *err);

/* ---- command.c ---- */

/* The outcomes of a check, and: no picture was drawn. */
enum { VERIFY_FAILED = OUTCOME_NOT_VERIFIED + 1, VERIFY_OUTCOMES };
extern const char *const verify_words[]; /* of these outcomes */
/* The result of a scene on a driver; it owns nothing. */
struct verify_result {
    int outcome, expected; /* expected: by an earlier report; a picture that it has not agrees */
    struct check_verdict check;
    double seconds;
    char text[1024]; /* a line: the first pixel that differs, or why there is no verdict; empty: it
                        agrees */
};
int change_of(const struct verify_result *result); /* below 0: worse than expected; above: better */
/* Built-in scenes that are not hard are drawn so, unless the options say otherwise. Large enough
 * for every effect of the built-in scenes, at a tenth of their time. */
extern const char usual_size[], usual_wavelengths[];

struct verification {
    struct listed_driver *drivers; /* see raster/beside/measure */
    struct verified_scene *scenes;
    struct verify_result *results; /* [driver][scene] */
    int n_drivers, n_scenes;
    double seconds;
    char processor[80]; /* its model; "": it is not known */
    char differs[512];  /* how the report that is expected was made otherwise, in lines */
};
struct verify_result *result_of(const struct verification *of, int driver, int scene);
/* Counts the results of each outcome, and those that are worse than expected; sums up seconds. */
struct totals {
    int n[VERIFY_OUTCOMES], worse;
    double seconds;
};
struct totals totals_of(const struct verify_result *results, int n);

/* ---- tables.c ---- */

/* The table: a driver and the names of columns; a line for each result; a line for each driver's
 * sum; commands that repeat each failure. */
void verify_head(const struct verification *of, int driver, struct printed *to);
void verify_line(const struct verification *of, int driver, int scene, struct printed *to);
void verify_sum(const struct verification *of, int driver, struct printed *to);
void verify_end(const struct verification *of, const struct options *options, struct printed *to);
void verify_json(const struct verification *of, struct json *json);
/* The format that continuous integration reads: a suite is a driver, a case a scene. */
void verify_junit(const struct verification *of, struct printed *to);
/* A report says this of a driver, beside its options: keys of JSON, and values; NULL ends them. */
enum { REPORTED = 6 };
struct reported {
    const char *key, *value;
};
void reported_of(const struct verification *of, int driver, struct reported out[REPORTED + 1]);

/* ---- expect.c ---- */

/* Reads the outcomes that verify_json has written, for pictures that are verified again. Refuses a
 * file that has none. */
bool expect_read(const char *path, struct verification *of, struct error *err);

#endif
