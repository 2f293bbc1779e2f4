/* SPDX-License-Identifier: MIT */
/* The legal interval: the lowest and the highest count that an OpenGL which keeps the rules may
 * show at each pixel, in each band. The reference and its bounds say so, over all candidates of a
 * pixel; nothing is drawn by OpenGL. */
#include "raster/beside/see/see.h"
#include "raster/beside/verify/inside.h"

struct interval { /* in counts */
    double low, high;
};
struct intervals {
    const struct lit_scene *lit;
    struct stack_writer writer;
    const struct tile *tile; /* the current one, and the band */
    int band;
    struct interval *positions; /* of the tile; owned */
    uint16_t *low, *high;       /* of its pixels; owned */
    bool *open;                 /* pixels that nothing bounds in some band; owned */
    uint64_t n_open;
};

/* ---- positions ---- */

/* The intervals of a chunk, in its tile. */
static struct interval *intervals_of(const struct intervals *of, const struct chunk *chunk)
{
    return of->positions +
           (size_t)(chunk->picture.at.y - of->tile->at.y) * (size_t)of->tile->at.width;
}

/* Widens intervals by the samples of a run and their bounds. Only numbers bound a sample. */
static void widen(const struct intervals *of, const struct run *run, struct interval *to)
{
    double expected[BLOCK];
    float bound[BLOCK];
    expect_counts(of->lit, run, of->band, expected, bound);
    for (size_t i = 0; i < run->n; i++) {
        const double by = bound[i] < HUGE_VALF ? (double)bound[i] : HUGE_VAL;
        to[i].low = fmin(to[i].low, expected[i] - by);
        to[i].high = fmax(to[i].high, expected[i] + by);
    }
}

/* Does so for a pixel with several candidates. One without a bound, and a triangle that the depth
 * buffer may lose, leave it open. */
static void widen_ambiguous(const struct intervals *of, const struct chunk *chunk,
                            const struct ambiguous_pixel *pixel, struct interval *to)
{
    struct textured_sample textured;
    bool open = pixel->may_vanish;
    const struct run background = candidate_run(of->lit, chunk, NULL, &textured);
    if (pixel->background)
        widen(of, &background, to);
    for (int c = pixel->first; c < pixel->first + pixel->count; c++) {
        const struct run run = candidate_run(of->lit, chunk, &chunk->candidates[c], &textured);
        open = open || chunk->candidates[c].loose;
        widen(of, &run, to);
    }
    if (open)
        *to = (struct interval){-HUGE_VAL, HUGE_VAL};
}

static void find_intervals(const struct intervals *of, const struct chunk *chunk)
{
    const size_t n = chunk_pixels(chunk);
    struct interval *to = intervals_of(of, chunk);
    struct textured_sample textured[BLOCK];
    for (size_t i = 0; i < n; i++)
        to[i] = (struct interval){HUGE_VAL, -HUGE_VAL};
    for (size_t first = 0, step; first < n; first += step) {
        const struct run run = settled_run(of->lit, chunk, first, n, textured);
        widen(of, &run, to + first);
        step = run.n ? run.n : 1;
    }
    for (size_t i = 0; i < chunk->n_ambiguous; i++)
        widen_ambiguous(of, chunk, &chunk->ambiguous[i], to + chunk->ambiguous[i].pixel);
}

/* ---- pixels ---- */

/* Finds the intervals of the pixels of chunk i in the band, rounded outwards: of several positions
 * the means. */
static void treat_chunk(void *context, int i)
{
    const struct intervals *of = context;
    const struct chunk *chunk = &of->tile->chunks[i];
    const size_t side = (size_t)of->lit->plan->scene->positions, n = side * side,
                 stride = (size_t)of->tile->at.width, width = stride / side,
                 above = (size_t)(intervals_of(of, chunk) - of->positions) / n;
    find_intervals(of, chunk);
    for (size_t at = above; at < above + chunk_pixels(chunk) / n; at++) {
        const struct interval *first =
            of->positions + at / width * side * stride + at % width * side;
        struct interval sum = {0, 0};
        for (size_t k = 0; k < n; k++) {
            sum.low += first[k / side * stride + k % side].low;
            sum.high += first[k / side * stride + k % side].high;
        }
        of->low[at] = (uint16_t)counts_clamp(floor(sum.low / (double)n));
        of->high[at] = (uint16_t)counts_clamp(ceil(sum.high / (double)n));
        of->open[at] |= of->low[at] == 0 && of->high[at] == FULL_COUNT;
    }
}

/* ---- pages ---- */

static bool treat_tile(void *context, const struct tile *tile, struct error *err)
{
    struct intervals *of = context;
    const struct plan *plan = of->lit->plan;
    const struct rectangle at = plan_pixels(plan, &tile->at);
    const size_t n = (size_t)at.width * (size_t)at.height;
    bool done = true;
    of->tile = tile;
    memset(of->open, 0, n * sizeof *of->open);
    for (of->band = 0; of->band < plan->n_bands && done; of->band++) {
        const struct page_rectangle low = {2 * of->band, at.x, at.y, at.width, at.height},
                                    high = {low.page + 1, at.x, at.y, at.width, at.height};
        done = of->band % BANDS_PER_PASS != 0 || plan_load_textures(plan, of->band, err);
        if (done)
            threads_each(plan->options.threads, tile->n_chunks, treat_chunk, of);
        done = done && pages_write(&of->writer.pages, &low, of->low, err) &&
               pages_write(&of->writer.pages, &high, of->high, err);
    }
    for (size_t i = 0; i < n; i++)
        of->n_open += of->open[i];
    return done;
}

/* ---- the file ---- */

/* Prints the names of the pages in lines, "450 nm low", "450 nm high". */
static void name_pages(const struct plan *plan, struct printed *to)
{
    char band[BAND_NAME];
    for (int i = 0; i < plan->n_bands; i++) {
        band_name(plan, i, band);
        print(to, "%s low\n%s high\n", band, band);
    }
}

static bool allocate(struct intervals *of, struct error *err)
{
    const struct plan *plan = of->lit->plan;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height;
    return MAKE_ARRAY(of->positions, n, err, "the bounds of a tile") &&
           MAKE_ARRAY(of->low, n, err, "the bounds of a tile") &&
           MAKE_ARRAY(of->high, n, err, "the bounds of a tile") &&
           MAKE_ARRAY(of->open, n, err, "the bounds of a tile");
}

static const char *name_of(const struct driver *driver)
{
    return strcmp(driver->name, driver_of(NULL)->name) == 0 ? "any driver" : driver->name;
}

static bool write_file(struct intervals *of, const struct interval_file *to, struct error *err)
{
    const struct plan *plan = of->lit->plan;
    const struct rectangle picture = plan_picture(plan);
    struct printed lines = {.text = NULL}, names = {.text = NULL};
    record_put_beside(&lines, "bounds of", plan->scene, to->options);
    print(&lines, "bounds for: %s\n", name_of(of->lit->driver));
    name_pages(plan, &names);
    const struct stack_options layout = {.width = plan->scene->width,
                                         .height = plan->scene->height,
                                         .n_wavelengths = 2 * plan->n_bands,
                                         .full_scale = of->lit->full_scale,
                                         .unit = has_components(plan)             ? NULL
                                                 : scene_is_absolute(plan->scene) ? ABSOLUTE_UNIT
                                                                                  : RELATIVE_UNIT,
                                         .scene = plan->scene->path};
    const bool done = named_pages_open(&of->writer, to->path, layout, &lines, &names, err) &&
                      tiles_each(of->lit, &picture, treat_tile, of, err);
    return named_pages_end(&of->writer, done, "bounds by the reference", to->outputs, err);
}

bool interval_write(const struct lit_scene *lit, const struct interval_file *to, uint64_t *n_open,
                    struct error *err)
{
    struct intervals of = {.lit = lit};
    const bool done = allocate(&of, err) && write_file(&of, to, err);
    *n_open = of.n_open;
    FREE_ALL(of.positions, of.low, of.high, of.open);
    return done;
}

/* ---- the lit scene ---- */

bool light_plan(const struct plan *plan, const struct driver *driver, struct lit_scene *lit,
                struct volumes *volumes, struct error *err)
{
    if (!lit_make(plan, driver, lit, err))
        return false;
    if (plan->view.n_shadowed > 0) {
        if (!volumes_make(lit, volumes, err))
            return false;
        lit->volumes = volumes;
    }
    return find_full_scale(lit, err);
}

/* ---- spectral render --bounds ---- */

/* The picture is planned anew: a render without a check has no bounds. */
static bool bounds_write(const struct options *options, const struct render_job *job,
                         struct render_result *result, struct outputs *outputs, struct error *err)
{
    const struct render_options *own = options->own;
    const struct interval_file to = {options, own->bounds, outputs};
    struct render_job bounded = {
        .scene = job->scene, .sampling = job->sampling, .options = job->options};
    struct lit_scene lit = {.plan = NULL};
    struct volumes volumes = {.n = 0};
    if (!own->bounds)
        return true;
    const struct driver *driver = own->bounds_for ? driver_of(own->bounds_for) : &result->driver;
    bounded.options.check = bounded.options.use_gl = true;
    result->bounds_for = name_of(driver);
    const bool done = job_plan(options, &bounded, err) &&
                      light_plan(&bounded.plan, driver, &lit, &volumes, err) &&
                      interval_write(&lit, &to, &result->open_pixels, err);
    volumes_free(&volumes);
    lit_free(&lit);
    notes_free(&bounded.notes);
    plan_free(&bounded.plan);
    return done;
}

static bool bounds_check(const struct options *options, const struct scene *scene,
                         struct error *err)
{
    const struct render_options *own = options->own;
    return !own->bounds || scene->shading != SHADING_PHONG ||
           error_usage(err, "--bounds are those of OpenGL, which phong shading has not");
}

static const char *const bounded_drivers[] = {"any", "llvmpipe", "softpipe", NULL};
static const struct option rows[] = {
    {"--bounds FILE.tif",
     "writes the lowest and the highest legal count of each pixel, two pages a wavelength",
     OWN(TEXT, render_options, bounds), .writes = true},
    {"--bounds-for any|llvmpipe|softpipe",
     "bounds of these drivers (default: of the one that draws; any: of all that are known)",
     OWN(TEXT, render_options, bounds_for), .choices = bounded_drivers, .needs = "--bounds"},
};
const struct option_list bounds_options = OPTION_LIST(rows);
const struct map_maker interval_maker = {bounds_check, bounds_write};
