/* SPDX-License-Identifier: MIT */
/* The passes of each tile: pixels, verdict, stack. The reference rasterizes a tile once. Each pass
 * then draws three bands, checks them and writes them, before the next pass begins. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "data/process/process.h"
#include "data/sampling/sampling.h"
#include "data/threads/threads.h"
#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/fit/fit.h"
#include "raster/render/render.h"

struct render_state {
    const struct plan *plan;
    struct lit_scene lit;
    struct gl *gl;
    struct stack_writer writer;
    bool writing;
    unsigned char *samples[BANDS_PER_PASS]; /* each has room for one band of a tile */
    struct fit fit;
    struct check_scene check_scene;
    struct check_totals totals;
    struct check_map map;            /* if check_scene.mapped */
    struct check *checks;            /* one for each chunk of the current tile; NULL: none */
    float *pilots[MAX_PILOT_PASSES]; /* OpenGL's pixels of the passes that hold pilots */
    long steps, all_steps;
    double since;                   /* clock_seconds at the last clock_in */
    struct progress_line *progress; /* NULL: none */
    struct render_result *result;
};

/* Adds the seconds since the last call to `part`, one of the result's seconds. */
static void clock_in(struct render_state *state, double *part)
{
    double time = clock_seconds();
    *part += time - state->since;
    state->since = time;
}

/* ---- the checks of a tile ---- */

/* A pass over a tile whose chunks threads share. */
struct tile_pass {
    struct render_state *state;
    const struct tile *tile;
    int pass;
    const float *pixels; /* OpenGL's; NULL: none are drawn */
    void (*look)(struct check *check, int first_band, const float *pixels, size_t stride);
    struct counter clipped, undefined;
};

/* A thread is worth starting for so many pixels of a pass. */
enum { FEW_PIXELS = 1 << 14 };

static int pass_threads(const struct render_state *state, const struct tile *tile)
{
    return threads_for(state->plan->options.threads,
                       (size_t)tile->at.width * (size_t)tile->at.height, FEW_PIXELS);
}

static void identify_chunk(void *context, int i)
{
    const struct tile_pass *of = context;
    check_identity(&of->state->checks[i], of->state->gl, &of->tile->at);
}

/* Opens the checks of all chunks, and checks that OpenGL shows the right triangle at each pixel. */
static bool open_checks(struct render_state *state, const struct tile *tile, struct error *err)
{
    state->checks = calloc((size_t)tile->n_chunks, sizeof *state->checks);
    if (!state->checks)
        return error_memory(err);
    for (int i = 0; i < tile->n_chunks; i++)
        if (!check_open(&state->check_scene, &tile->chunks[i], &state->checks[i], err))
            return false;
    if (!gl_identify(state->gl, err))
        return false;
    struct tile_pass of = {.state = state, .tile = tile};
    threads_each(pass_threads(state, tile), tile->n_chunks, identify_chunk, &of);
    return true;
}

/* Adds a tile's checks to the verdict and to the map. */
static bool settle_checks(struct render_state *state, const struct tile *tile, struct error *err)
{
    for (int i = 0; state->checks && i < tile->n_chunks; i++) {
        check_settle(&state->checks[i], tile, &state->totals);
        if (state->check_scene.mapped && !check_map_write(&state->map, &state->checks[i], err))
            return false;
    }
    return true;
}

static void close_checks(struct render_state *state, const struct tile *tile)
{
    for (int i = 0; state->checks && i < tile->n_chunks; i++)
        check_free(&state->checks[i]);
    free(state->checks);
    state->checks = NULL;
}

/* ---- a pass ---- */

static size_t sample_size(const struct plan *plan)
{
    return (size_t)plan->options.bits / 8;
}

static int bands_of_pass(const struct plan *plan, int pass)
{
    int left = plan->n_bands - pass * BANDS_PER_PASS;
    return left < BANDS_PER_PASS ? left : BANDS_PER_PASS;
}

static void look_at_chunk(void *context, int i)
{
    const struct tile_pass *of = context;
    const size_t stride = (size_t)of->state->plan->tile_width, row = (size_t)i * CHUNK_ROWS;
    of->look(&of->state->checks[i], of->pass * BANDS_PER_PASS, of->pixels + row * stride * 4,
             stride);
}

/* Has all chunks of a tile look at the pixels of a pass. */
static void
look_at_pass(struct render_state *state, const struct tile *tile, int pass, const float *pixels,
             void (*look)(struct check *check, int first_band, const float *pixels, size_t stride))
{
    struct tile_pass of = {
        .state = state, .tile = tile, .pass = pass, .pixels = pixels, .look = look};
    threads_each(pass_threads(state, tile), tile->n_chunks, look_at_chunk, &of);
}

/* Draws the passes that hold pilots, and learns from them. Their pixels are kept until their turn.
 */
static bool draw_pilots(struct render_state *state, const struct tile *tile, struct error *err)
{
    const size_t n = (size_t)state->plan->tile_width * (size_t)state->plan->tile_height * 4;
    struct render_seconds *seconds = &state->result->seconds;
    for (int p = 0; p < state->fit.n_passes; p++) {
        const int pass = state->fit.passes[p];
        const float *pixels;
        if (!plan_load_textures(state->plan, pass * BANDS_PER_PASS, err))
            return false;
        clock_in(state, &seconds->read);
        if (!gl_draw(state->gl, pass * BANDS_PER_PASS, state->result->full_scale, &pixels, err))
            return false;
        memcpy(state->pilots[p], pixels, n * sizeof *pixels);
        clock_in(state, &seconds->gl);
        look_at_pass(state, tile, pass, pixels, check_pilots);
        clock_in(state, &seconds->check);
    }
    return true;
}

/* Finds OpenGL's pixels of a pass: a pilot's are there, others are drawn. */
static bool draw_pass(struct render_state *state, int pass, const float **pixels, struct error *err)
{
    for (int p = 0; p < state->fit.n_passes; p++)
        if (state->fit.passes[p] == pass) {
            *pixels = state->pilots[p];
            return true;
        }
    return gl_draw(state->gl, pass * BANDS_PER_PASS, state->result->full_scale, pixels, err);
}

/* Stores the samples of a chunk in one band. The chunk begins at `row` of the tile; `pixels` are
 * the tile's. */
static struct odd_samples count_chunk(struct render_state *state, const struct picture *picture,
                                      size_t row, int band, const float *pixels)
{
    const struct plan *plan = state->plan;
    const int channel = band % BANDS_PER_PASS;
    const size_t stride = (size_t)plan->tile_width;
    unsigned char *out =
        state->samples[channel] + row * (size_t)picture->at.width * sample_size(plan);
    const struct stored_band stored = {plan, band, state->result->full_scale, out};
    return plan->options.store_raster ? store_reference(&stored, &state->lit, picture)
                                      : store_gl(&stored, &picture->at, state->result->clips,
                                                 pixels + row * stride * 4 + channel, stride);
}

static void count_bands(void *context, int i)
{
    struct tile_pass *of = context;
    const int first = of->pass * BANDS_PER_PASS, n = bands_of_pass(of->state->plan, of->pass);
    for (int band = first; band < first + n; band++) {
        const struct odd_samples odd = count_chunk(of->state, &of->tile->chunks[i].picture,
                                                   (size_t)i * CHUNK_ROWS, band, of->pixels);
        counter_add(&of->clipped, odd.clipped);
        counter_add(&of->undefined, odd.undefined);
    }
}

static void count_tile(struct render_state *state, const struct tile *tile, int pass,
                       const float *pixels)
{
    struct tile_pass of = {.state = state,
                           .tile = tile,
                           .pass = pass,
                           .pixels = pixels,
                           .clipped = COUNTER,
                           .undefined = COUNTER};
    threads_each(pass_threads(state, tile), tile->n_chunks, count_bands, &of);
    state->result->odd.clipped += of.clipped.n;
    state->result->odd.undefined += of.undefined.n;
}

static bool write_tile(struct render_state *state, const struct rectangle *at, int pass,
                       struct error *err)
{
    struct stack_rectangle to = {pass * BANDS_PER_PASS, at->x, at->y, at->width, at->height};
    for (int c = 0; c < bands_of_pass(state->plan, pass); c++, to.page++)
        if (!stack_write(&state->writer, &to, state->samples[c], err))
            return false;
    return true;
}

static bool render_pass(struct render_state *state, const struct tile *tile, int pass,
                        struct error *err)
{
    struct render_seconds *seconds = &state->result->seconds;
    const float *pixels = NULL;
    if (!plan_load_textures(state->plan, pass * BANDS_PER_PASS, err))
        return false;
    clock_in(state, &seconds->read);
    if (state->gl && !draw_pass(state, pass, &pixels, err))
        return false;
    clock_in(state, &seconds->gl);
    if (state->plan->options.check)
        look_at_pass(state, tile, pass, pixels, check_pass);
    clock_in(state, &seconds->check);
    if (state->writing) {
        count_tile(state, tile, pass, pixels);
        if (!write_tile(state, &tile->at, pass, err))
            return false;
    }
    clock_in(state, &seconds->write);
    state->steps++;
    if (state->progress)
        progress_show(state->progress, state->steps, state->all_steps);
    errno = 0;
    return !is_interrupted() || error_system(err, "interrupted; nothing was written");
}

/* ---- the object map ---- */

/* Returns the number, from 1, of the object at a pixel of the tile. The renderer of the stored
 * pixels decides: the reference's picture, or OpenGL's last identification. An unknown surface
 * number counts as background. */
static int object_at(const struct render_state *state, const struct tile *tile, int x, int y)
{
    const struct picture *picture = &tile->chunks[y / CHUNK_ROWS].picture;
    const size_t pixel = (size_t)(y % CHUNK_ROWS) * (size_t)tile->at.width + (size_t)x;
    const int surface = state->plan->options.store_raster ? picture->surface[pixel]
                                                          : gl_shown(state->gl, x, y).surface;
    return surface < state->plan->n_instances ? surface + 1 : 0;
}

/* Writes the object map of a tile. It is built in the memory of the first band's samples. */
static bool write_map(struct render_state *state, const struct tile *tile, struct error *err)
{
    const struct rectangle *at = &tile->at;
    const struct stack_rectangle to = {state->plan->n_bands, at->x, at->y, at->width, at->height};
    unsigned char *out = state->samples[0];
    if (!state->writing || state->plan->map_bytes == 0)
        return true;
    for (int y = 0; y < at->height; y++)
        for (int x = 0; x < at->width; x++) {
            const int object = object_at(state, tile, x, y);
            *out++ = (unsigned char)(object % 256);
            if (state->plan->map_bytes > 1)
                *out++ = (unsigned char)(object / 256);
        }
    return stack_write(&state->writer, &to, state->samples[0], err);
}

/* ---- the whole picture ---- */

static void add_work(struct light_work *to, const struct tile *tile)
{
    for (int i = 0; i < tile->n_chunks; i++) {
        const struct light_work *work = &tile->chunks[i].picture.work;
        to->points_lit += work->points_lit;
        to->specular_vertices += work->specular_vertices;
        to->power_functions += work->power_functions;
    }
}

static bool render_tile(void *context, const struct tile *tile, struct error *err)
{
    struct render_state *state = context;
    struct render_seconds *seconds = &state->result->seconds;
    clock_in(state, &seconds->raster);
    add_work(&state->result->light, tile);
    if (state->gl)
        gl_aim(state->gl, &state->lit, &tile->at);
    bool done = !state->plan->options.check || open_checks(state, tile, err);
    clock_in(state, &seconds->check);
    done = done && write_map(state, tile, err);
    clock_in(state, &seconds->write);
    done = done && draw_pilots(state, tile, err);
    for (int pass = 0; done && pass < state->plan->n_passes; pass++)
        done = render_pass(state, tile, pass, err);
    done = done && settle_checks(state, tile, err);
    close_checks(state, tile);
    clock_in(state, &seconds->check);
    return done;
}

static bool render_tiles(struct render_state *state, struct error *err)
{
    const struct rectangle picture = plan_picture(state->plan);
    state->all_steps = (long)plan_tiles(state->plan, &picture) * state->plan->n_passes;
    return tiles_each(&state->lit, &picture, render_tile, state, err);
}

static bool open_gl(struct render_state *state, struct error *err)
{
    struct render_result *result = state->result;
    if (!gl_open(state->plan, &state->gl, err))
        return false;
    snprintf(result->gl_renderer, sizeof result->gl_renderer, "%s", gl_renderer(state->gl));
    snprintf(result->gl_version, sizeof result->gl_version, "%s", gl_version(state->gl));
    return true;
}

const char *render_stored(const struct plan *plan, const struct render_result *result)
{
    return plan->options.store_raster ? "raster" : result->gl_renderer;
}

/* Lists the names of the objects in the order of their numbers; none if there is no object map. */
static bool list_objects(const struct plan *plan, struct record *record, struct error *err)
{
    const char **names = calloc((size_t)plan->n_instances + 1, sizeof *names);
    if (!names)
        return error_memory(err);
    record->objects = (struct texts){names, plan->map_bytes > 0 ? plan->n_instances : 0};
    for (int i = 0; i < record->objects.n; i++)
        names[i] = object_name(plan, i);
    return true;
}

/* Returns the record of the stack as text, allocated; NULL on failure. */
static char *provenance_text(const struct plan *plan, const struct render_result *result,
                             struct error *err)
{
    struct record record;
    char *text = NULL;
    if (!record_scene(plan->scene, plan->sampling, &record, err))
        return NULL;
    record.program = PROGRAM;
    record.renderer = render_stored(plan, result);
    record.n_options = plan->options.n_recorded;
    for (int i = 0; i < record.n_options; i++)
        record.options[i] = plan->options.recorded[i];
    if (list_objects(plan, &record, err)) {
        text = record_text(&record);
        if (!text)
            error_memory(err);
    }
    record_free(&record);
    return text;
}

static bool allocate_samples(struct render_state *state, struct error *err)
{
    const struct plan *plan = state->plan;
    size_t n_samples = (size_t)plan->tile_width * (size_t)plan->tile_height;
    size_t size = sample_size(plan), map = (size_t)plan->map_bytes;
    for (int c = 0; c < BANDS_PER_PASS; c++) {
        state->samples[c] = malloc(n_samples * (size > map ? size : map));
        if (!state->samples[c])
            return error_memory(err);
    }
    return true;
}

/* Returns the labels of the pages of components. One allocation holds the pointers and the text.
 * NULL: no memory. */
static const char **make_labels(const struct sampling *sampling, struct error *err)
{
    typedef char label_text[24];
    size_t n = (size_t)sampling->pages.n;
    const char **labels = calloc(n, sizeof *labels + sizeof(label_text));
    label_text *text = (label_text *)(labels + n);
    if (!labels)
        error_memory(err);
    for (int i = 0; labels && i < sampling->pages.n; i++) {
        sampling_label(sampling, i, text[i]);
        labels[i] = text[i];
    }
    return labels;
}

static bool open_stack(struct render_state *state, const char *path, struct error *err)
{
    const struct plan *plan = state->plan;
    const struct sampling *sampling = plan->sampling;
    const bool labelled = sampling && !sampling->spectral;
    if (!allocate_samples(state, err))
        return false;
    char *provenance = provenance_text(plan, state->result, err);
    const char **labels = labelled && provenance ? make_labels(sampling, err) : NULL;
    struct stack_options options = {.width = plan->scene->width,
                                    .height = plan->scene->height,
                                    .n_wavelengths = plan->n_bands,
                                    .wavelengths_nm = plan->scene->wavelengths_nm,
                                    .full_scale = state->result->full_scale,
                                    .bits = plan->options.bits,
                                    .scene = plan->scene->path,
                                    .provenance = provenance,
                                    .map_bytes = plan->map_bytes,
                                    .labels = labels};
    state->writing =
        provenance && (labels || !labelled) && stack_open(&state->writer, path, &options, err);
    free(labels);
    free(provenance);
    clock_in(state, &state->result->seconds.write);
    return state->writing;
}

/* Prepares the check of all bands together. */
static bool prepare_fit(struct render_state *state, struct error *err)
{
    const struct plan *plan = state->plan;
    const size_t n = (size_t)plan->tile_width * (size_t)plan->tile_height * 4;
    if (!fit_make(plan, state->result->full_scale, &state->fit, err))
        return false;
    for (int p = 0; p < state->fit.n_passes; p++) {
        state->pilots[p] = malloc(n * sizeof *state->pilots[p]);
        if (!state->pilots[p])
            return error_memory(err);
    }
    state->check_scene.lit = &state->lit;
    state->check_scene.fit = &state->fit;
    state->check_scene.full_scale = state->result->full_scale;
    state->check_scene.clips = state->result->clips;
    bool done = totals_open(&state->check_scene, &state->totals, err);
    clock_in(state, &state->result->seconds.check);
    return done;
}

/* Does everything that comes before the first pixel. notes: see struct render_output. */
static bool prepare(struct render_state *state, struct notes *notes, struct error *err)
{
    struct render_result *result = state->result;
    const struct plan *plan = state->plan;
    if (plan->options.use_gl && !open_gl(state, err))
        return false;
    result->driver = driver_of(state->gl ? result->gl_renderer : NULL);
    clock_in(state, &result->seconds.gl);
    if (!lit_make(plan, result->driver, &state->lit, &result->light, err))
        return false;
    if (!find_full_scale(&state->lit, &result->full_scale, &result->clips, err) ||
        (notes && !notes_make(&state->lit, notes, err)))
        return false;
    clock_in(state, &result->seconds.raster);
    return !plan->options.check || prepare_fit(state, err);
}

bool render_agreed(const struct plan *plan, const struct render_result *result)
{
    return !result->difference.found &&
           (!plan->options.check || check_outcome(plan, &result->check) == OUTCOME_AGREED);
}

static bool commit(struct render_state *state, const struct render_output *output,
                   struct error *err)
{
    struct render_result *result = state->result;
    char verdict[STACK_VERDICT];
    bool compared = output->again && result->odd.undefined == 0;
    if (!state->writing || !(output->keep || compared || render_agreed(state->plan, result)))
        return true;
    if (result->odd.undefined > 0) {
        errno = 0;
        return error_system(err,
                            "%llu samples are not finite (or too large for a float page); "
                            "nothing was written",
                            (unsigned long long)result->odd.undefined);
    }
    report_verdict(state->plan, &result->check, verdict, sizeof verdict);
    bool done =
        stack_finish(&state->writer, verdict, err) &&
        (!output->again || stack_compare(&state->writer, output->again, &result->difference, err));
    if (done && !output->discard && (output->keep || render_agreed(state->plan, result)))
        done = output->envi ? stack_commit_envi(&state->writer, output->path, output->outputs, err)
                            : stack_commit(&state->writer, output->outputs, err);
    clock_in(state, &result->seconds.write);
    return done;
}

static bool render_all(struct render_state *state, const struct render_output *output,
                       struct error *err)
{
    bool done = prepare(state, output->notes, err);
    if (done && output->check_map && state->plan->options.check)
        done = state->check_scene.mapped =
            check_map_open(output->check_map, state->plan, &state->map, err);
    if (!done || (output->path && !open_stack(state, output->path, err)) ||
        !render_tiles(state, err))
        return false;
    if (state->gl)
        state->result->gl = gl_work(state->gl);
    if (state->plan->options.check) {
        totals_finish(&state->totals);
        state->result->check = state->totals.verdict;
    }
    /* both files are complete before the first of them appears */
    const bool mapped = state->check_scene.mapped;
    return (!mapped || check_map_finish(&state->map, err)) && commit(state, output, err) &&
           (!mapped || check_map_commit(&state->map, output->outputs, err));
}

bool render(const struct plan *plan, const struct render_output *output,
            struct progress_line *progress, struct render_result *out, struct error *err)
{
    const double start = clock_seconds();
    struct render_state state = {.plan = plan, .progress = progress, .result = out, .since = start};
    *out = (struct render_result){.notes = output->notes};
    bool done = render_all(&state, output, err);
    if (state.writing)
        stack_discard(&state.writer); /* keeps a committed stack */
    for (int c = 0; c < BANDS_PER_PASS; c++)
        free(state.samples[c]);
    for (int p = 0; p < MAX_PILOT_PASSES; p++)
        free(state.pilots[p]);
    if (state.fit.plan)
        fit_free(&state.fit);
    if (state.check_scene.mapped)
        check_map_discard(&state.map);
    totals_free(&state.totals);
    gl_close(state.gl);
    lit_free(&state.lit);
    out->seconds.total = clock_seconds() - start;
    return done;
}
