/* SPDX-License-Identifier: MIT */
/* The passes of all tiles, by three stages that work side by side. One draws by OpenGL, three bands
 * a pass. One draws the reference of each tile, judges what OpenGL has drawn, and counts. One
 * writes. The stages do the same work in the same order, however far one is ahead of another. */
#include <errno.h>
#include <stdlib.h>

#include "data/process/process.h"
#include "raster/render/render.h"

/* Adds the seconds since the last call to `part`, one of the result's seconds. */
void clock_in(double *since, double *part)
{
    const double time = clock_seconds();
    *part += time - *since;
    *since = time;
}

/* Finds the pass that comes as number i: those with pilots come first, each group ascending. */
static int nth_pass(const struct render_state *state, int i)
{
    const struct fit *fit = &state->fit;
    int pass = i - fit->n_passes;
    if (i < fit->n_passes)
        return fit->passes[i];
    for (int p = 0; p < fit->n_passes && fit->passes[p] <= pass; p++)
        pass++;
    return pass;
}

static int bands_of_pass(const struct plan *plan, int pass)
{
    const int left = plan->n_bands - pass * BANDS_PER_PASS;
    return left < BANDS_PER_PASS ? left : BANDS_PER_PASS;
}

/* ---- drawing by OpenGL ---- */

/* Draws into the next place of a queue. */
static bool draw_next(struct render_state *state, struct queue *queue, int pass, struct error *err)
{
    const int place = queue_room(queue);
    double since = clock_seconds();
    if (place < 0)
        return false;
    if (!(queue == &state->numbers
              ? gl_identify(state->gl, err)
              : gl_draw(state->gl, place, pass * BANDS_PER_PASS, state->result->full_scale, err)))
        return false;
    clock_in(&since, &state->result->seconds.gl);
    queue_fill(queue);
    return true;
}

static bool draw_tiles(void *context, struct error *err)
{
    struct render_state *state = context;
    const struct plan *plan = state->plan;
    const struct rectangle picture = plan_picture(plan);
    for (int tile = 0; tile < plan_tiles(plan, &picture); tile++) {
        const struct rectangle at = plan_tile(plan, &picture, tile);
        gl_aim(state->gl, &at);
        if (plan->options.check && !draw_next(state, &state->numbers, 0, err))
            return false;
        for (int i = 0; i < plan->n_passes; i++)
            if (!draw_next(state, &state->drawn, nth_pass(state, i), err))
                return false;
    }
    return true;
}

/* ---- a tile's chunks ---- */

/* A pass over a tile whose chunks threads share. */
struct tile_pass {
    struct render_state *state;
    const struct tile *tile;
    int pass;
    const float *pixels;       /* OpenGL's; NULL: none are drawn */
    const struct written *out; /* where counts go; NULL: nowhere */
    pthread_mutex_t lock;      /* of these sums: */
    double judging, counting;  /* seconds of all threads */
    struct odd_samples odd;
};

/* A thread is worth starting for so many pixels of a pass. */
enum { FEW_PIXELS = 1 << 14 };

/* Calls work(of, i) for each chunk. */
static void each_chunk(struct tile_pass *of, void (*work)(void *of, int i))
{
    const size_t n_pixels = (size_t)of->tile->at.width * (size_t)of->tile->at.height;
    threads_each(threads_for(of->state->plan->options.threads, n_pixels, FEW_PIXELS),
                 of->tile->n_chunks, work, of);
}

/* OpenGL's pixels of a chunk. */
static const float *pixels_of(const struct tile_pass *of, int chunk)
{
    const size_t stride = (size_t)of->state->plan->tile_width;
    return of->pixels + (size_t)chunk * CHUNK_ROWS * stride * 4;
}

static void identify_chunk(void *context, int i)
{
    const struct tile_pass *of = context;
    check_identity(&of->state->checks[i], of->state->gl, &of->tile->at);
}

static void learn_chunk(void *context, int i)
{
    const struct tile_pass *of = context;
    check_pilots(&of->state->checks[i], of->pass * BANDS_PER_PASS, pixels_of(of, i),
                 (size_t)of->state->plan->tile_width);
}

/* Stores the samples of a chunk in one band. */
static struct odd_samples count_band(const struct tile_pass *of, int chunk, int band)
{
    const struct plan *plan = of->state->plan;
    const struct picture *picture = &of->tile->chunks[chunk].picture;
    const size_t first = (size_t)chunk * CHUNK_ROWS * (size_t)of->tile->at.width;
    const int channel = band % BANDS_PER_PASS;
    const struct stored_band stored = {plan, band, of->state->result->full_scale,
                                       of->out->samples[channel] +
                                           first * (size_t)plan->options.bits / 8};
    return plan->options.store_raster
               ? store_reference(&stored, &of->state->lit, picture)
               : store_gl(&stored, &picture->at, of->state->result->clips,
                          pixels_of(of, chunk) + channel, (size_t)plan->tile_width);
}

/* Judges and counts a chunk while its pixels are in the cache. */
static void treat_chunk(void *context, int i)
{
    struct tile_pass *of = context;
    const struct plan *plan = of->state->plan;
    const int first = of->pass * BANDS_PER_PASS, end = first + bands_of_pass(plan, of->pass);
    double since = clock_seconds(), judging = 0, counting = 0;
    struct odd_samples odd = {0, 0};
    if (plan->options.check)
        check_pass(&of->state->checks[i], first, pixels_of(of, i), (size_t)plan->tile_width);
    clock_in(&since, &judging);
    for (int band = first; band < end && of->out; band++) {
        const struct odd_samples more = count_band(of, i, band);
        odd.clipped += more.clipped;
        odd.undefined += more.undefined;
    }
    clock_in(&since, &counting);
    pthread_mutex_lock(&of->lock);
    of->judging += judging;
    of->counting += counting;
    of->odd.clipped += odd.clipped;
    of->odd.undefined += odd.undefined;
    pthread_mutex_unlock(&of->lock);
}

/* ---- a tile ---- */

/* Opens the checks of all chunks, and checks that OpenGL shows the right triangle at each pixel. */
static bool open_checks(struct render_state *state, const struct tile *tile, struct error *err)
{
    struct tile_pass of = {.state = state, .tile = tile};
    double since = clock_seconds();
    state->checks = calloc((size_t)tile->n_chunks, sizeof *state->checks);
    if (!state->checks)
        return error_memory(err);
    for (int i = 0; i < tile->n_chunks; i++)
        if (!check_open(&state->check_scene, &tile->chunks[i], &state->checks[i], err))
            return false;
    clock_in(&since, &state->result->seconds.check);
    if (queue_next(&state->numbers, 0) < 0)
        return false;
    since = clock_seconds();
    each_chunk(&of, identify_chunk);
    clock_in(&since, &state->result->seconds.check);
    return true;
}

/* Adds a tile's checks to the verdict and to the map. */
static bool settle_checks(struct render_state *state, const struct tile *tile, struct error *err)
{
    double since = clock_seconds();
    for (int i = 0; state->checks && i < tile->n_chunks; i++) {
        check_settle(&state->checks[i], tile, &state->totals);
        if (state->check_scene.mapped && !check_map_write(&state->map, &state->checks[i], err))
            return false;
    }
    clock_in(&since, &state->result->seconds.check);
    return true;
}

static void close_checks(struct render_state *state, const struct tile *tile)
{
    for (int i = 0; state->checks && i < tile->n_chunks; i++)
        check_free(&state->checks[i]);
    free(state->checks);
    state->checks = NULL;
}

/* Learns from the passes that hold pilots, which come first. They stay in the queue. */
static bool learn_pilots(struct render_state *state, const struct tile *tile, struct error *err)
{
    for (int i = 0; i < state->fit.n_passes; i++) {
        struct tile_pass of = {.state = state, .tile = tile, .pass = nth_pass(state, i)};
        const int place = queue_next(&state->drawn, i);
        double since = clock_seconds();
        if (place < 0 || !plan_load_textures(state->plan, of.pass * BANDS_PER_PASS, err))
            return false;
        of.pixels = gl_pixels(state->gl, place);
        clock_in(&since, &state->result->seconds.read);
        each_chunk(&of, learn_chunk);
        clock_in(&since, &state->result->seconds.check);
    }
    return true;
}

/* Finds room for counts; *out is NULL where none are written. */
static bool find_room(struct render_state *state, const struct tile *tile, struct written **out)
{
    *out = NULL;
    if (!state->writing)
        return true;
    const int place = queue_room(&state->counted);
    if (place < 0)
        return false;
    *out = &state->written[place];
    (*out)->at = tile->at;
    return true;
}

/* Shares the seconds of a pass in proportion to those of its threads. */
static void share_seconds(const struct tile_pass *of, double seconds)
{
    struct render_seconds *to = &of->state->result->seconds;
    const double all = of->judging + of->counting;
    to->check += all > 0 ? seconds * of->judging / all : 0;
    to->write += all > 0 ? seconds * of->counting / all : 0;
}

static bool treat_pass(struct render_state *state, const struct tile *tile, int pass,
                       struct error *err)
{
    struct tile_pass of = {
        .state = state, .tile = tile, .pass = pass, .lock = PTHREAD_MUTEX_INITIALIZER};
    struct written *room;
    const int drawn = state->gl ? queue_next(&state->drawn, 0) : 0;
    if (drawn < 0 || !find_room(state, tile, &room))
        return false;
    double since = clock_seconds(), seconds = 0;
    if (!plan_load_textures(state->plan, pass * BANDS_PER_PASS, err))
        return false;
    clock_in(&since, &state->result->seconds.read);
    of.pixels = state->gl ? gl_pixels(state->gl, drawn) : NULL;
    of.out = room;
    each_chunk(&of, treat_chunk);
    clock_in(&since, &seconds);
    share_seconds(&of, seconds);
    state->result->odd.clipped += of.odd.clipped;
    state->result->odd.undefined += of.odd.undefined;
    if (state->gl)
        queue_free(&state->drawn);
    if (room) {
        room->first_page = pass * BANDS_PER_PASS;
        room->n_pages = bands_of_pass(state->plan, pass);
        queue_fill(&state->counted);
    }
    return true;
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

/* Makes the object map of a tile. */
static bool map_objects(struct render_state *state, const struct tile *tile)
{
    struct written *room;
    if (state->plan->map_bytes == 0 || !state->writing)
        return true;
    if (!find_room(state, tile, &room))
        return false;
    unsigned char *out = room->samples[0];
    for (int y = 0; y < tile->at.height; y++)
        for (int x = 0; x < tile->at.width; x++) {
            const int object = object_at(state, tile, x, y);
            *out++ = (unsigned char)(object % 256);
            if (state->plan->map_bytes > 1)
                *out++ = (unsigned char)(object / 256);
        }
    room->first_page = state->plan->n_bands;
    room->n_pages = 1;
    queue_fill(&state->counted);
    return true;
}

/* ---- judging ---- */

static void add_work(struct light_work *to, const struct tile *tile)
{
    for (int i = 0; i < tile->n_chunks; i++) {
        const struct light_work *work = &tile->chunks[i].picture.work;
        to->points_lit += work->points_lit;
        to->specular_vertices += work->specular_vertices;
        to->power_functions += work->power_functions;
    }
}

static bool take_step(struct render_state *state, struct error *err)
{
    state->steps++;
    if (state->progress)
        progress_show(state->progress, state->steps, state->all_steps);
    errno = 0;
    return !is_interrupted() || error_system(err, "interrupted; nothing was written");
}

static bool treat_tile(void *context, const struct tile *tile, struct error *err)
{
    struct render_state *state = context;
    const bool checking = state->plan->options.check;
    clock_in(&state->since, &state->result->seconds.raster);
    add_work(&state->result->light, tile);
    bool done = (!checking || open_checks(state, tile, err)) && map_objects(state, tile);
    if (done && checking)
        queue_free(&state->numbers);
    done = done && learn_pilots(state, tile, err);
    for (int i = 0; done && i < state->plan->n_passes; i++)
        done = treat_pass(state, tile, nth_pass(state, i), err) && take_step(state, err);
    done = done && settle_checks(state, tile, err);
    close_checks(state, tile);
    state->since = clock_seconds();
    return done;
}

static bool treat_tiles(void *context, struct error *err)
{
    struct render_state *state = context;
    const struct rectangle picture = plan_picture(state->plan);
    state->all_steps = (long)plan_tiles(state->plan, &picture) * state->plan->n_passes;
    state->since = clock_seconds();
    const bool done = tiles_each(&state->lit, &picture, treat_tile, state, err);
    queue_end(&state->counted);
    return done;
}

/* ---- writing ---- */

static bool write_tiles(void *context, struct error *err)
{
    struct render_state *state = context;
    for (int place; (place = queue_next(&state->counted, 0)) >= 0;) {
        const struct written *from = &state->written[place];
        const struct rectangle *at = &from->at;
        double since = clock_seconds();
        for (int i = 0; i < from->n_pages; i++) {
            const struct stack_rectangle to = {from->first_page + i, at->x, at->y, at->width,
                                               at->height};
            if (!stack_write(&state->writer, &to, from->samples[i], err))
                return false;
        }
        clock_in(&since, &state->written_seconds);
        queue_free(&state->counted);
    }
    return true;
}

/* ---- all of it ---- */

bool stages_run(struct render_state *state, struct error *err)
{
    stage *stages[MOST_STAGES];
    struct pipeline pipeline;
    int n = 0;
    state->numbers = (struct queue){.pipeline = &pipeline, .n_places = 1};
    state->drawn =
        (struct queue){.pipeline = &pipeline, .n_places = state->fit.n_passes + AHEAD_PASSES};
    state->counted = (struct queue){.pipeline = &pipeline, .n_places = WRITTEN_PLACES};
    if (state->gl)
        stages[n++] = draw_tiles; /* OpenGL's context is this thread's */
    stages[n++] = treat_tiles;
    if (state->writing)
        stages[n++] = write_tiles;
    const bool done =
        pipeline_run(&pipeline, state->plan->options.threads == 1, stages, n, state, err);
    state->result->seconds.write += state->written_seconds;
    return done;
}
