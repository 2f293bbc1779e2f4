/* SPDX-License-Identifier: MIT */
/* From a command line to a plan. */
#include "raster/render/inside.h"

/* ---- what the options ask for ---- */

bool stores_raster(const struct render_options *own)
{
    return own->renderer && strcmp(own->renderer, "raster") == 0;
}

/* Refuses options that ask for OpenGL, or for its check, where a picture does without. */
static bool check_used(const struct render_options *own, const struct plan_options *plan,
                       struct error *err)
{
    const char *for_check = own->strict      ? "--strict"
                            : own->unchecked ? "--unchecked"
                            : own->check_map ? "--check-map"
                                             : NULL,
               *for_gl = own->gl       ? "--gl"
                         : own->buffer ? "--buffer"
                                       : NULL,
               *unused = plan->use_gl ? NULL : for_gl;
    unused = plan->check || !for_check ? unused : for_check;
    return !unused || error_usage(err, "%s is for OpenGL and its check, %s", unused,
                                  !gl_is_built()  ? "but this program was built without OpenGL"
                                  : own->no_check ? "which --no-check leaves out"
                                                  : "which phong shading has not");
}

/* Refuses options that need OpenGL in a program without it. Reads no file. */
static bool check_gl(const struct render_options *own, struct error *err)
{
    const char *driver;
    if (gl_is_built())
        return drawing_ways.open[driver_way(own->renderer, &driver)] ||
               error_usage(err,
                           "this program draws without shaders; expected another --renderer "
                           "than %s",
                           own->renderer);
    return stores_raster(own) ||
           error_usage(err, "this program was built without OpenGL; add --renderer raster");
}

/* Phong shading lights each pixel. OpenGL lights vertices only, so it can neither draw nor check
 * this shading. */
static bool check_shading(const struct scene *scene, struct plan_options *plan, struct error *err)
{
    if (scene->shading != SHADING_PHONG)
        return true;
    if (!plan->store_raster)
        return error_usage(err, "OpenGL lights vertices only and cannot draw phong shading; add %s",
                           plan->complete ? "--shading smooth" : "--renderer raster");
    plan->check = plan->use_gl = false;
    return true;
}

/* Returns 8 or 16 for these words, 32 for any other word, and 0 for NULL. */
static int bits_of(const char *choice)
{
    if (!choice)
        return 0;
    const int bits = atoi(choice); /* of float, 0 */
    return bits > 0 ? bits : 32;
}

/* foreign: another program draws. */
static bool plan_options_of(const struct options *options, bool foreign, struct render_job *job,
                            struct error *err)
{
    const struct render_options *own = options->own;
    struct plan_options plan = {.full_scale = own->full_scale,
                                .buffer_bits = bits_of(own->buffer),
                                .gl_library = own->gl,
                                .store_raster = stores_raster(own),
                                .bits = bits_of(own->depth),
                                .threads = options->threads};
    plan.gl_way = driver_way(own->renderer, &plan.gl_driver);
    if (plan.gl_way != GL_WITHOUT_SHADERS && plan.buffer_bits != 0 && plan.buffer_bits != 32)
        return error_usage(err, "shaders draw into floats; leave out --buffer %s", own->buffer);
    plan.complete = foreign;
    plan.check = (gl_is_built() || foreign) && !own->no_check;
    plan.use_gl = plan.check || !plan.store_raster;
    job->options = plan;
    job->limits = (struct verdict_limits){own->strict, own->strict ? 0 : USUAL_UNCHECKED};
    return !own->unchecked ||
           option_number("--unchecked", own->unchecked, 0, 1, &job->limits.unchecked, err);
}

/* ---- the job ---- */

bool job_read(const struct options *options, bool foreign, struct render_job *job,
              struct error *err)
{
    const double start = clock_seconds();
    const bool done = plan_options_of(options, foreign, job, err) &&
                      (foreign || check_gl(options->own, err)) &&
                      scene_read_sampled(options, &job->scene, &job->sampling, err) &&
                      check_shading(&job->scene, &job->options, err) &&
                      check_used(options->own, &job->options, err);
    job->seconds.read = clock_seconds() - start;
    return done;
}

bool job_plan(const struct options *options, struct render_job *job, struct error *err)
{
    const double start = clock_seconds();
    const struct sampling *sampling = job->sampling.pages.n > 0 ? &job->sampling : NULL;
    const bool done =
        plan_make(&job->scene, sampling, &job->options, &job->plan, err) &&
        (!shading_judge || shading_judge->refine(options, &job->plan, &job->notes.shading, err));
    job->seconds.plan = clock_seconds() - start;
    return done;
}

bool job_read_files(const struct scene *scene, struct error *err)
{
    const struct plan_options options = {.store_raster = true, .threads = 1};
    struct plan plan = {.scene = NULL};
    const bool done = plan_make(scene, NULL, &options, &plan, err);
    plan_free(&plan);
    return done;
}

void job_free(struct render_job *job)
{
    notes_free(&job->notes);
    plan_free(&job->plan);
    sampling_free(&job->sampling);
    scene_free(&job->scene);
}
