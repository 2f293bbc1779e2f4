/* SPDX-License-Identifier: MIT */
/* One scene on one driver. */
#include <stdio.h>
#include <string.h>

#include "data/scene/scene.h"
#include "raster/beside/verify/inside.h"

const char usual_size[] = "300x200", usual_wavelengths[] = "400:700:10";
const char *const verify_words[] = {"agreed", "differs", "not verified", "failed"};

struct task {
    const struct options *options;
    const struct verify_driver *driver;
    const struct verify_scene *scene;
};

/* Takes the verdict out of a render. */
static void take(const struct plan *plan, const struct render_result *result,
                 struct verify_result *out)
{
    struct error words = {.status = EXIT_AGREED};
    out->check = result->check;
    out->names = result->names;
    snprintf(out->profile, sizeof out->profile, "%s", result->driver.name);
    out->outcome = (int)check_outcome(&result->check);
    if (out->outcome == VERIFY_AGREED)
        return;
    report_disagreement(plan, &result->check, NULL, &words);
    snprintf(out->text, sizeof out->text, "%.1000s", error_words(&words));
}

/* The change comes before those of the command line, so that the user's win. */
static void put_first(struct options *options, struct option_change change)
{
    if (options->n_changes == MAX_RECORDED)
        return;
    memmove(options->changes + 1, options->changes,
            (size_t)options->n_changes * sizeof *options->changes);
    options->changes[0] = change;
    options->n_changes++;
}

/* Puts a scene in the place of the operands, with the changes that come before the user's. */
static void place_scene(struct options *options, const struct verify_scene *scene)
{
    options->operand = options->operands[0] = scene->path;
    options->n_operands = 1;
    if (scene->is_large) {
        put_first(options, (struct option_change){scene_set_size, usual_size});
        put_first(options, (struct option_change){scene_set_wavelengths, usual_wavelengths});
    }
}

static bool judge(void *context, void *out, struct error *err)
{
    const struct task *task = context;
    struct options options = *task->options;
    struct render_job job = {.limits = {false, 0}};
    const struct render_output nothing = {.limits = &job.limits};
    struct render_result result;
    const double start = clock_seconds();
    memset(out, 0, sizeof(struct verify_result));
    struct verify_options own = *(const struct verify_options *)task->options->own;
    own.render.gl = task->driver->library;
    own.render.renderer = task->driver->renderer[0] ? task->driver->renderer : NULL;
    options.own = &own;
    place_scene(&options, task->scene);
    const bool done = job_read(&options, false, &job, err) && job_plan(&options, &job, err) &&
                      render(&job.plan, &nothing, NULL, &result, err);
    if (done)
        take(&job.plan, &result, out);
    job_free(&job);
    ((struct verify_result *)out)->seconds = clock_seconds() - start;
    return done;
}

bool verify_run(const struct options *options, const struct verify_driver *driver,
                const struct verify_scene *scene, struct verify_result *out, struct error *err)
{
    struct task task = {options, driver, scene};
    struct error own = {.status = EXIT_AGREED};
    if (process_run(judge, &task, out, sizeof *out, &own))
        return true;
    if (own.status == EXIT_INPUT) {
        *err = own;
        return false;
    }
    memset(out, 0, sizeof *out);
    out->outcome = VERIFY_FAILED;
    snprintf(out->text, sizeof out->text, "%.1000s", error_words(&own));
    return true;
}
