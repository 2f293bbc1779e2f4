/* SPDX-License-Identifier: MIT */
/* spectral render: plans and renders a scene, and reports the result. again.c takes the scene and
 * the options from a stack's record instead. */
#include "raster/render/inside.h"

/* ---- checks before anything is drawn ---- */

/* Refuses the name of a stack that ends like that of another format. */
static bool check_stack_name(const char *path, struct error *err)
{
    static const char *const others[] = {".png", ".exr", ".jpg",  ".jpeg", ".hdr", ".bmp",  ".gif",
                                         ".pfm", ".ppm", ".html", ".svg",  ".hdf", ".hdf5", ".h5",
                                         ".nc",  ".npy", ".mat",  ".csv",  NULL};
    struct error unknown = {0};
    int other;
    return !path || !path_ending(path, others, &other, &unknown) || other < 0 ||
           error_at(err, (struct place){path, 0, 0},
                    "render writes a stack, which is a TIFF; expected .tif (spectral view writes "
                    "pictures)");
}

/* Refuses to make OpenGL's pixels again in a program without OpenGL. */
static bool check_again(const struct render_options *own, const struct render_output *output,
                        struct error *err)
{
    return gl_is_built() || !output->again || stores_raster(own) ||
           error_usage(err, "%s stores OpenGL's pixels, but this program was built without OpenGL",
                       output->again);
}

/* Refuses a scene that differs from the scene that the stack was made from: in its text, or in a
 * file that it names. Stacks of older programs record no files. */
static bool check_same_scene(const struct options *options, const struct scene *scene,
                             const char *stack, const struct record *made, struct error *err)
{
    if (made && strcmp(scene->sha256, made->scene_sha256) != 0)
        return error_usage(err,
                           "%s: the scene has changed since %s was made: expected SHA-256 %.64s, "
                           "found %s",
                           scene->path, stack, made->scene_sha256, scene->sha256);
    return !made || made->files.n == 0 || record_has_files(made, scene, options->detector, err);
}

/* ---- report ---- */

/* A render that is done. */
struct rendered {
    const struct plan *plan;
    const struct render_output *output;
    const struct record *made; /* of the stack that is made again; NULL: the stack is new */
    struct render_result result;
    const char *stored; /* the name of the stack; NULL: no stack was stored */
};

/* A stack that went into a pipe gets no digest, since it cannot be read back. */
static bool write_json(const struct rendered *of, struct error *err)
{
    struct outputs *outputs = of->output->outputs;
    char sha256[65];
    const char *stack = NULL;
    if ((of->stored && !outputs_readable(outputs, outputs->n, of->stored, &stack, err)) ||
        (stack && !digest_file(stack, sha256, err)))
        return false;
    struct json json;
    json_begin(&json);
    report_put(of->plan, &of->result, &json);
    json_count(&json, "peak_bytes", peak_bytes());
    json_string(&json, "output", of->stored);
    if (of->result.bounds_for)
        json_count(&json, "unbounded_pixels", of->result.open_pixels);
    json_string(&json, "sha256", stack ? sha256 : NULL);
    return json_write(&json, of->output->options->json, outputs, err);
}

/* Prints the name of a header of an older stack, which stays where it is: it may give wrong places
 * of samples. */
static bool print_header(const char *stack, struct printed *to, struct error *err)
{
    char *header = sidecar_name(stack, err);
    bool older = false;
    const bool done = header && file_is_regular(header, &older, err);
    if (older) {
        print(to, "header            %s is of an older stack; spectral envi", header);
        print_shell(to, stack);
        print_text(to, " renews it\n");
    }
    free(header);
    return done;
}

static bool print_report(const struct rendered *of, struct printed *to, struct error *err)
{
    const struct render_output *output = of->output;
    const struct render_options *own = output->options->own;
    const struct stack_difference *difference = &of->result.difference;
    report_print(of->plan, &of->result, to);
    if (output->check_map && picture_is_png(output->check_map)) {
        print_text(to, "map colours       ");
        check_map_print_colours(to);
        print_text(to, "\n");
    }
    if (difference->compared)
        print(to, "again             %s bytes as %s\n",
              difference->found ? "not the same" : "the same", output->again);
    if (of->stored)
        print(to, "stack             %s\n", of->stored);
    if (own->maps)
        print(to, "maps              %s\n", own->maps);
    if (own->bounds)
        print(to, "legal counts      %s, for %s: nothing bounds %llu pixels\n", own->bounds,
              of->result.bounds_for, (unsigned long long)of->result.open_pixels);
    return !of->stored || print_header(of->stored, to, err);
}

/* Shows the table; with -v behind the plan and all figures. JSON, the stack itself (-o -) or the
 * map may use standard output. */
static bool show_report(const struct rendered *of, struct error *err)
{
    const struct options *options = of->output->options;
    const char *map = of->output->check_map;
    const int to = options_table(options, map && output_is_stream(map) ? map : of->stored);
    struct json words;
    words_begin(&words);
    if (options->verbose && !options->quiet) {
        plan_facts(of->plan, &words);
        plan_put_files(of->plan, options->detector, &words, err);
        report_put(of->plan, &of->result, &words);
    }
    return (options->quiet || print_report(of, &words.printed, err)) &&
           printed_show(&words.printed, to, err);
}

/* Fails if the pictures differ, or the stack from the one that is made again. */
static bool conclude(const struct rendered *of, struct error *err)
{
    const struct render_output *output = of->output;
    const struct check_verdict *verdict = &of->result.check;
    const char *wanted = output->discard ? NULL : output->path;
    const char *then = output->foreign ? ""
                       : !wanted       ? "; no stack was wanted"
                       : output->keep  ? "; the stack was kept"
                                       : "; no stack was written (--keep stores it anyway)";
    if (render_agreed(of->plan, &of->result))
        return true;
    return of->plan->options.check && check_outcome(verdict) != OUTCOME_AGREED
               ? report_disagreement(of->plan, verdict, then, err)
               : report_not_again(of->plan, &of->result, output->again, of->made, then, err);
}

/* ---- plan, render, report ---- */

static bool check_maps(const struct options *options, const struct scene *scene, struct error *err)
{
    for (int i = 0; map_makers[i]; i++)
        if (!map_makers[i]->check(options, scene, err))
            return false;
    return true;
}

static bool render_job(const struct render_job *job, struct rendered *of, struct error *err)
{
    const struct render_output *output = of->output;
    const struct options *options = output->options;
    struct progress_line line;
    const bool shown = progress_start(&line, options->quiet);
    if (!render(of->plan, output, shown ? &line : NULL, &of->result, err))
        return false;
    for (int i = 0; map_makers[i]; i++)
        if (!map_makers[i]->write(options, job, &of->result, output->outputs, err))
            return false;
    of->result.seconds.read += job->seconds.read;
    of->result.seconds.plan = job->seconds.plan;
    of->result.seconds.total += job->seconds.read + job->seconds.plan;
    if (!output->discard && (output->keep || render_agreed(of->plan, &of->result)))
        of->stored = output->path;
    return (!options->json || write_json(of, err)) && show_report(of, err) && conclude(of, err);
}

bool render_with_options(const struct options *options, const struct render_output *output,
                         const struct record *made, struct error *err)
{
    const struct render_options *own = options->own;
    struct render_job job = {.limits = {false, 0}};
    struct render_output complete = *output;
    complete.options = options;
    complete.limits = &job.limits;
    complete.notes = !options->quiet || options->json ? &job.notes : NULL;
    struct rendered rendered = {.plan = &job.plan, .output = &complete, .made = made};
    const bool done = check_stack_name(output->path, err) && check_stack_name(own->maps, err) &&
                      check_stack_name(own->bounds, err) &&
                      (!output->check_map || picture_accepts(output->check_map, err)) &&
                      check_again(own, output, err) &&
                      job_read(options, output->foreign, &job, err) &&
                      check_same_scene(options, &job.scene, output->again, made, err) &&
                      job_plan(options, &job, err) && options_check_outputs(options, err) &&
                      check_maps(options, &job.scene, err) && render_job(&job, &rendered, err);
    job_free(&job);
    return done;
}

/* ---- the command ---- */

/* Reads "3/7", the number of a part and how many there are. */
static bool part_read(const char *value, struct picture_part *out, struct error *err)
{
    int end = 0;
    if (value[strspn(value, "0123456789/")] == '\0' &&
        sscanf(value, "%6d/%6d%n", &out->number, &out->count, &end) == 2 && value[end] == '\0' &&
        out->number >= 1 && out->number <= out->count)
        return true;
    return error_at(err, VALUE_OF("--part"), "expected a part and their number, as 3/7, not '%s'",
                    value);
}

/* A program without OpenGL draws by the reference where no renderer is given. */
static bool choose_renderer(struct options *options, struct error *err)
{
    struct render_options *own = options->own;
    if (gl_is_built() || own->renderer)
        return true;
    own->renderer = "raster";
    return options_record(options, "--renderer", own->renderer, err);
}

/* Renders a scene, or a part of it, and reports the result; or makes a stack again. */
static bool run_render(struct options *options, struct error *err)
{
    const struct render_options *own = options->own;
    struct picture_part part = {.count = 0};
    char ending[48] = ".tif";
    if (own->again)
        return render_again(options, err);
    if (own->part && (own->check_map || own->maps || own->bounds))
        return error_usage(err, "--part takes no %s, which shows the whole picture",
                           own->maps     ? "--maps"
                           : own->bounds ? "--bounds"
                                         : "--check-map");
    if (own->part && !part_read(own->part, &part, err))
        return false;
    if (own->part) /* each has a name of its own where the command line gives none */
        snprintf(ending, sizeof ending, ".%d-of-%d.tif", part.number, part.count);
    if (!choose_renderer(options, err) ||
        !options_name_output(options, options_scene(options), ending, err))
        return false;
    if (stores_raster(own))
        options_forget_check(options);
    const bool discard = strcmp(options->output, "/dev/null") == 0;
    const struct render_output wanted = {.path = discard ? NULL : options->output,
                                         .check_map = own->check_map,
                                         .keep = own->keep,
                                         .outputs = &options->outputs,
                                         .part = part};
    return render_with_options(options, &wanted, NULL, err);
}

/* ---- options ---- */

static const char *const buffers[] = {"8", "10", "16", "float", NULL};
static const char *const depths[] = {"8", "16", "32f", NULL};
static const struct option renderer_rows[] = {
    {"--renderer gl|llvmpipe|softpipe|gl-shader[:DRIVER]|es-shader[:DRIVER]|raster",
     "stores pixels of gl (default), of its driver llvmpipe or softpipe, of shaders by OpenGL 3.3 "
     "core or OpenGL ES 3, or of the reference",
     OWN(TEXT, render_options, renderer), .choices = renderer_words, .recorded = true},
    {"--buffer 8|10|16|float", "bits of OpenGL's colours (default: float); 10 needs --gl egl",
     OWN(TEXT, render_options, buffer), .choices = buffers, .recorded = true},
};
static const struct option library_rows[] = {
    {"--gl LIBRARY", "osmesa, egl, egl:N for EGL's device N, or auto (default), whichever is here",
     OWN(TEXT, render_options, gl), .accepts = driver_accepts_library, .recorded = true},
};
static const struct option judged_rows[] = {
    {"--strict", "like --unchecked 0; also no fragment may be lost or doubled where triangles meet",
     OWN(FLAG, render_options, strict), .recorded = true},
    {"--unchecked SHARE",
     "the part of object pixels that may stay unchecked, from 0 to 1 (default: 0.01)",
     OWN(TEXT, render_options, unchecked), .recorded = true},
};
static const struct option map_rows[] = {
    {"--check-map FILE",
     "writes what the check can see at each pixel, and its verdict there (.tif or .png)",
     OWN(TEXT, render_options, check_map), .writes = true},
};
static const struct option scale_rows[] = {
    {"--full-scale R", "radiance of count 65535 (default: the largest)",
     OWN(NUMBER, render_options, full_scale), .lowest = 1e-300, .highest = 1e300, .recorded = true},
};
static const struct option verbose_rows[] = {
    {"-v, --verbose", "prints the plan, and all figures of the check, too", SHARED(FLAG, verbose)},
};
static const struct option render_rows[] = {
    {"-o, --output STACK.tif",
     "writes there; - is standard output; /dev/null: checks only, writes nothing",
     SHARED(TEXT, output), .writes = true},
    {"--again STACK",
     "makes that stack again, from its record (default output: STACK's name + -again.tif)",
     OWN(TEXT, render_options, again), .made_again = true},
    {"--trust", "--again reads files outside of this folder, too", OWN(FLAG, render_options, trust),
     .needs = "--again"},
    {"--no-check", "does not cross-check", OWN(FLAG, render_options, no_check), .recorded = true},
    {"--keep", "stores the stack even if the check fails", OWN(FLAG, render_options, keep)},
    {"--part I/N", "draws part I of N as a stack of some rows of the picture; see join",
     OWN(TEXT, render_options, part)},
    {"--depth 8|16|32f", "bits of counts, or 32-bit float radiances (default: 16)",
     OWN(TEXT, render_options, depth), .choices = depths, .recorded = true},
};
const struct option_list renderer_options = OPTION_LIST(renderer_rows),
                         library_option = OPTION_LIST(library_rows),
                         judged_options = OPTION_LIST(judged_rows),
                         map_option = OPTION_LIST(map_rows), scale_option = OPTION_LIST(scale_rows),
                         verbose_option = OPTION_LIST(verbose_rows);
const struct command render_command = {
    .name = "render",
    .operands = "[SCENE] [-o STACK.tif]",
    .summary = "render, cross-check, write a stack",
    .example = "render colorchecker",
    .first = "writes the stack colorchecker.tif",
    .run = run_render,
    .rows = OPTION_LIST(render_rows),
    .shared = {&scene_options, &shading_options, &accuracy_options, &sampling_options,
               &renderer_options, &library_option, &judged_options, &map_option, &maps_options,
               &bounds_options, &scale_option, &threads_option, &json_option, &verbose_option,
               &quiet_option},
    .own_size = sizeof(struct render_options),
    .n_operands = 1,
};
