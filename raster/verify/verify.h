/* SPDX-License-Identifier: MIT */
/* The room "verify": many scenes on many drivers, each judged as a render judges its picture. */
#ifndef VERIFY_H
#define VERIFY_H

#include "data/base/base.h"
#include "data/options/options.h"
#include "data/text/text.h"
#include "raster/render/render.h"
#include "spectral.h"

/* ---- command.c: spectral verify ---- */

/* Judges scenes on drivers, and prints a table. Fails with EXIT_DIFFERENT where a picture differs,
 * or is not verified. */
bool command_verify(struct options *options, struct error *err);

/* ---- inside this room ---- */

/* ---- run.c ---- */

/* A driver, as the options --gl and --renderer name it. */
struct verify_driver {
    char library[16], renderer[24]; /* renderer: empty: the one that comes without --renderer */
    struct renderer_names names;    /* known when a scene was drawn */
    char profile[16];               /* whose bounds the check uses; likewise */
};
enum { /* those of a check; or no picture was drawn */
       VERIFY_AGREED = OUTCOME_AGREED,
       VERIFY_DIFFERS = OUTCOME_DIFFERS,
       VERIFY_NOT_VERIFIED = OUTCOME_NOT_VERIFIED,
       VERIFY_FAILED,
       VERIFY_OUTCOMES
};
extern const char *const verify_words[]; /* of these outcomes */
/* The result of a scene on a driver; it owns nothing. */
struct verify_result {
    int outcome;
    struct check_verdict check;
    struct renderer_names names;
    char profile[16];
    double seconds;
    char text[1024]; /* a line: the first pixel that differs, or why there is no verdict; empty: it
                        agrees */
};
/* A scene, as render takes it. */
struct verify_scene {
    char name[BUILTIN_NAME]; /* "hard/..." of a hard case; of a file the end of its path */
    char *path;              /* as SCENE of render; owned */
    bool is_hard, is_large;  /* is_large: drawn with usual_size and usual_wavelengths unless the
                                options say otherwise */
};
/* Large enough for every effect of the built-in scenes, at a tenth of their time. */
extern const char usual_size[], usual_wavelengths[];
/* Draws and judges a scene in a process of its own, which a driver may end. Fails where it is
 * interrupted, or the scene is wrong: every other failure is a result. The options are those of the
 * command. */
bool verify_run(const struct options *options, const struct verify_driver *driver,
                const struct verify_scene *scene, struct verify_result *out, struct error *err);

/* ---- lists.c ---- */

struct verification {
    struct verify_driver *drivers;
    struct verify_scene *scenes;
    struct verify_result *results; /* [driver][scene] */
    int n_drivers, n_scenes;
    double seconds;
};
/* Finds the drivers and scenes that the options name; without any, all. verification_free accepts
 * what a failure left. */
bool verification_open(const struct options *options, struct verification *out, struct error *err);
void verification_free(struct verification *of);
const struct verify_result *result_of(const struct verification *of, int driver, int scene);
/* Counts the results of each outcome, and sums up their seconds. */
struct totals {
    int n[VERIFY_OUTCOMES];
    double seconds;
};
struct totals totals_of(const struct verify_result *results, int n);
/* Writes the driver's options: " --gl egl --renderer softpipe". */
void driver_options(const struct verify_driver *driver, char out[64]);

/* ---- tables.c ---- */

void verify_print(const struct verification *of, struct printed *to);
/* Prints a command for each failure, which repeats it. */
void verify_print_failures(const struct verification *of, const struct options *options,
                           struct printed *to);
void verify_json(const struct verification *of, struct json *json);
/* The format that continuous integration reads: a suite is a driver, a case a scene. */
void verify_junit(const struct verification *of, struct printed *to);

#endif
