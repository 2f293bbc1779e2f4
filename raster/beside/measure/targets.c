/* SPDX-License-Identifier: MIT */
/* Measures a driver by the targets, a built-in scene of small triangles. Its pixels are drawn, or
 * read, once, and judged by one profile after the other: the narrowest one that explains them is
 * the driver's. */
#include "raster/beside/measure/inside.h"

/* ---- the scene ---- */

bool targets_plan(const struct plan_options *by, bool textured, struct render_job *job,
                  struct error *err)
{
    struct options options = {.operand = NULL};
    bool done = options_read(&render_command, true, NULL, 0, &options, err);
    options.operand = textured ? BUILTIN_PREFIX "targets/targets.scene"
                               : BUILTIN_PREFIX "targets/untextured.scene";
    done = done && job_read(&options, true, job, err);
    if (by) {
        job->options.gl_library = by->gl_library;
        job->options.gl_driver = by->gl_driver;
        job->options.gl_way = by->gl_way;
        job->options.threads = by->threads;
    }
    done = done && job_plan(&options, job, err);
    options_free(&options);
    return done;
}

/* ---- its pixels ---- */

struct targets {
    struct renderer kept; /* the first member: the pixels of `source`, judged by kept.driver */
    struct renderer *source;
    struct render_job job;
    struct lit_scene lit; /* which the source has */
    struct render_result result;
};

/* Lets the source draw all bands, which are those of one pass. Refuses a driver that does not draw
 * the same twice, as no verdict on it would last. */
static bool draw(struct targets *of, struct error *err)
{
    const struct renderer_kind *kind = of->source->kind;
    const struct rectangle all = plan_picture(&of->job.plan);
    if (!lit_make(&of->job.plan, driver_of(NULL), &of->lit, err) ||
        !find_full_scale(&of->lit, err) || !kind->take_scene(of->source, &of->lit, err))
        return false;
    for (int i = 0; i < 2; i++) {
        const struct frame_batch batch = {.n = 1, .buffers = {i}};
        if (kind->aim)
            kind->aim(of->source, &all);
        if ((kind->identify && !kind->identify(of->source, err)) ||
            !kind->draw(of->source, &batch, err))
            return false;
    }
    return memcmp(of->source->buffers[0], of->source->buffers[1],
                  4 * sizeof(float) * (size_t)all.width * (size_t)all.height) == 0 ||
           error_failed(err, "the driver cannot be checked: it draws its targets twice, and the "
                             "pictures differ");
}

static struct shown kept_shown(const struct renderer *of, int x, int y)
{
    const struct renderer *source = ((const struct targets *)of)->source;
    return source->kind->shown(source, x, y);
}

/* Keeps the pixels as a renderer: all is drawn already, and targets_close frees them. */
static void keep(struct targets *of)
{
    static const struct renderer_kind kind = {.shown = kept_shown};
    of->kept = (struct renderer){
        .kind = &kind, .n_at_once = 1, .names = of->source->names, .lacks = of->source->lacks};
    for (int i = 0; i < MOST_BUFFERS; i++)
        of->kept.buffers[i] = of->source->buffers[0];
}

static void targets_close(struct targets *of)
{
    if (of->source)
        of->source->kind->close(of->source);
    lit_free(&of->lit);
    job_free(&of->job);
    *of = (struct targets){.source = NULL};
}

/* Opens the source. One that filters no textures gets none. */
static bool targets_open(const struct render_foreign *source, const struct plan_options *by,
                         struct targets *out, struct error *err)
{
    bool textured = true, done;
    *out = (struct targets){.source = NULL};
    do {
        done = targets_plan(by, textured, &out->job, err) &&
               source->open(source->of, &out->job.plan, 2, &out->source, err);
        textured = done && !(textured && out->source->unfiltered);
        if (!textured)
            targets_close(out);
    } while (done && !textured);
    done = done && draw(out, err);
    if (done)
        keep(out);
    return done;
}

static bool kept_open(void *targets, const struct plan *plan, int n_buffers, struct renderer **out,
                      struct error *err)
{
    (void)plan, (void)n_buffers, (void)err;
    *out = &((struct targets *)targets)->kept;
    return true;
}

/* Finds whether the targets are what kept.driver may draw. */
static bool judge(struct targets *of, bool *agrees, struct error *err)
{
    const struct render_foreign kept = {.open = kept_open, .of = of};
    const struct render_output output = {.foreign = &kept, .limits = &of->job.limits};
    const bool done = render(&of->job.plan, &output, NULL, &of->result, err);
    *agrees = done && check_outcome(&of->result.check) != OUTCOME_DIFFERS;
    return done;
}

/* ---- its profile ---- */

/* Traits of a driver: what bounds make of Mesa's drivers at first, and what OpenGL 2.1 allows at
 * last. GL_SUBPIXEL_BITS is at least 4. Weights of filters have no rule; coarser ones than 1/16
 * show as steps to the eye. A single operation may be off by 1 in 10^5, which is 168 roundings,
 * where values of planes count 5 and lighting at least 6: of both the targets may show half, see
 * `narrow`. A depth is cut off or rounded to a step, and rounds once before: in perspective the
 * roundings of corners hide whether it does less. */
enum { TRAITS = 6 };
static const struct trait {
    const char *name, *key, *unit, *allowed;
    size_t place;
    double least, next, most; /* next, and twice as much again and again, up to the most */
} traits[TRAITS] = {
    {"edges", "edge_px", "pixel", "1/16", offsetof(struct driver, grid_px), 0x1p-9, 0x1p-8, 0x1p-4},
    {"corners of values", "value_px", "pixel", "1/16", offsetof(struct driver, corner_px), 0,
     0x1p-8, 0x1p-4},
    {"values in triangles", "value_roundings", "roundings", "1e-05 an operation",
     offsetof(struct driver, value_roundings), 5, 10, 80},
    {"depth", "depth_steps", "steps of 24 bits", "1.5 and a rounding",
     offsetof(struct driver, depth_roundings), 2, 2, 2},
    {"linear filtering", "filter_texels", "texel", "no rule; bounded to 1/16",
     offsetof(struct driver, filter_texels), 0, 0x1p-8, 0x1p-4},
    {"lighting", "lighting", "times Mesa's", "1e-05 an operation",
     offsetof(struct driver, lighting), 1, 2, 8},
};

static double *trait_of(struct driver *driver, int trait)
{
    return (void *)((char *)driver + traits[trait].place);
}

/* Gives all traits their least value, or the most. */
static bool judge_all(struct targets *of, bool least, bool *agrees, struct error *err)
{
    for (int t = 0; t < TRAITS; t++)
        *trait_of(&of->kept.driver, t) = least ? traits[t].least : traits[t].most;
    of->kept.driver.watertight = least;
    return judge(of, agrees, err);
}

static bool refuse(const struct targets *of, struct error *err)
{
    struct error words = {.status = EXIT_AGREED};
    report_disagreement(&of->job.plan, &of->result.check, "", &words);
    return error_failed(err,
                        "the driver cannot be checked: its targets differ by more than OpenGL "
                        "leaves free: %.600s",
                        error_words(&words));
}

/* Narrows each trait, all others as they are, as far as the targets agree. */
static bool narrow(struct targets *of, struct error *err)
{
    struct driver *driver = &of->kept.driver;
    bool agrees;
    if (!judge_all(of, true, &agrees, err) || agrees)
        return agrees;
    if (!judge_all(of, false, &agrees, err))
        return false;
    if (!agrees)
        return refuse(of, err);
    for (int t = 0; t < TRAITS; t++) { /* by the most of each they agree already */
        double *value = trait_of(driver, t), next = traits[t].next;
        for (*value = traits[t].least; judge(of, &agrees, err) && !agrees; next *= 2)
            *value = next;
        if (!agrees)
            return false;
    }
    /* Places on a grid, and weights of filters, are off by anything up to their trait alike. The
     * targets show hundreds of edges and thousands of texels, so that one is off by more than half
     * of it: the next smaller power of two does not explain it. Errors of values and light are sums
     * of roundings instead. A sum of n, each as likely to be any, exceeds a part 1 - d of its bound
     * in (n d / 2)^n / n! of all pixels and at either end: of 10^5 pixels the largest comes to 0.59
     * of it for n = 16, and to more for fewer. Twice the seen error is enough. */
    driver->value_roundings *= driver->value_roundings > 5 ? 2 : 1;
    driver->lighting *= driver->lighting > 1 ? 2 : 1;
    driver->watertight = true;
    return judge(of, &driver->watertight, err);
}

enum { DETAIL_RULES = 4 };
static const struct driver *detail_driver(int rule)
{
    return driver_of(rule < 2 ? "llvmpipe" : "softpipe");
}

static void set_detail(struct driver *driver, int rule)
{
    driver->detail = detail_driver(rule)->detail;
    driver->detail_error = 0;
    driver->detail.lower = driver->detail.lower != rule % 2;
    driver->detail.first_row = rule % 2;
}

/* Finds the rule for the level of detail: that of a driver of Mesa's, or the same in a picture that
 * is drawn the other way up. Rows then pair from the other end, which the targets show by their odd
 * number of rows. Another driver may have any rule that OpenGL allows. */
static bool find_detail(struct targets *of, struct error *err)
{
    struct driver *driver = &of->kept.driver;
    const struct driver given = *driver;
    for (int i = 0; i < DETAIL_RULES; i++) {
        bool agrees;
        if (driver_is_known(&given) && strcmp(given.name, detail_driver(i)->name) != 0)
            continue;
        set_detail(driver, i);
        if (!judge(of, &agrees, err) || agrees)
            return agrees;
    }
    *driver = given;
    return true;
}

bool targets_measure(const struct render_foreign *source, const struct plan_options *by,
                     struct driver *out, struct error *err)
{
    struct targets of;
    bool done = targets_open(source, by, &of, err);
    if (done) {
        of.kept.driver = *out;
        if (!driver_is_known(out)) {
            of.kept.driver.name = "measured";
            of.kept.driver.is_measured = true;
            done = narrow(&of, err);
        }
        done = done && find_detail(&of, err);
        *out = of.kept.driver;
    }
    targets_close(&of);
    return done;
}

static bool open_here(void *of, const struct plan *plan, int n_buffers, struct renderer **out,
                      struct error *err)
{
    (void)of;
    return drawing_ways.open[plan->options.gl_way](plan, n_buffers, out, err);
}

bool driver_measure(const struct plan_options *by, struct driver *out, struct error *err)
{
    const struct render_foreign here = {.open = open_here};
    *out = *driver_of(NULL);
    return targets_measure(&here, by, out, err);
}

/* ---- in numbers ---- */

void traits_numbers(const struct driver *of, struct printed *to)
{
    struct driver driver = *of;
    for (int t = 0; t < TRAITS; t++)
        print(to, "%.17g ", *trait_of(&driver, t));
    print(to, "%d %d\n", of->watertight,
          of->detail_error < 0 ? -1 : 2 * of->detail.largest + of->detail.first_row);
}

bool traits_read(struct text *text, struct driver *out, struct error *err)
{
    long watertight, rule;
    *out = *driver_of(NULL);
    out->name = "measured before";
    out->is_measured = true;
    for (int t = 0; t < TRAITS; t++)
        if (!text_number(text, traits[t].name, traits[t].least, 2 * traits[t].most,
                         trait_of(out, t), err))
            return false;
    if (!text_integer(text, "mark of no holes", 0, 1, &watertight, err) ||
        !text_integer(text, "rule for levels of detail", -1, DETAIL_RULES - 1, &rule, err))
        return false;
    out->watertight = watertight != 0;
    if (rule >= 0)
        set_detail(out, (int)rule);
    return text_end(text, "driver", err);
}

/* ---- in words ---- */

static void print_row(const char *name, const char *value, const char *allowed, struct printed *to)
{
    print(to, "    %-22s %-34s %s\n", name, value, allowed);
}

void traits_print(const struct driver *of, struct printed *to)
{
    struct driver driver = *of;
    char value[48];
    print_row("measured", "", "allowed", to);
    for (int t = 0; t < TRAITS; t++) {
        snprintf(value, sizeof value, "off by %.3g %s", *trait_of(&driver, t), traits[t].unit);
        print_row(traits[t].name, value, traits[t].allowed, to);
    }
    print_row("where triangles meet",
              of->watertight ? "each pixel of the targets once" : "holes or doubles",
              "each pixel once", to);
    print_row("level of detail",
              of->detail_error < 0 ? "neither as llvmpipe nor softpipe"
              : of->detail.largest ? "as softpipe"
                                   : "as llvmpipe",
              "any corner, norm and logarithm", to);
}

void traits_json(const struct driver *of, struct json *json)
{
    struct driver driver = *of;
    json_open(json, "measured_bounds", '{');
    for (int t = 0; t < TRAITS; t++)
        json_number(json, traits[t].key, *trait_of(&driver, t));
    json_number(json, "detail", of->detail_error >= 0 ? of->detail_error : HUGE_VAL);
    json_truth(json, "watertight", of->watertight);
    json_close(json, '}');
}
