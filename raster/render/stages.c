/* SPDX-License-Identifier: MIT */
/* The passes of all tiles, by two stages that work side by side. One draws by OpenGL, three bands a
 * pass. One draws the reference of each tile, judges what OpenGL has drawn, counts and writes. The
 * stages do the same work in the same order, however far one is ahead of the other. */
#include "raster/render/inside.h"

/* Counts on their way to the stack, of pages of a tile that follow one another. */
struct counted {
    struct rectangle at; /* in pixels of the picture */
    int first_page, n_pages;
    unsigned char *samples[BANDS_PER_PASS]; /* each has room for one page of a tile; owned */
};

struct state {
    struct rendering *of;
    const struct plan *plan;
    /* of the numbers that OpenGL draws, by tiles; of frames, by frame_number, in its buffers */
    struct places numbers, frames;
    struct counted counted, written; /* by this pass; by the one before, to be written beside it */
    struct check *checks;            /* one for each chunk of the current tile; NULL: none */
    int *first_bands;                /* of a tile's frames, in the order of drawing; owned */
    int drawing, drawn;              /* the tile that is drawn next; of its frames; -1: not yet its
                                        numbers */
    int tile;                        /* how many are judged */
    int frame, place;                /* the current frame, and where it is; DARK: none */
    float *black;                    /* a row of a frame that is not drawn; owned */
    double since;                    /* clock_seconds when the reference began to draw */
};

void clock_in(double *since, double *part)
{
    const double time = clock_seconds();
    *part += time - *since;
    *since = time;
}

/* ---- frames ---- */

/* Returns whether a frame shows pilots. Such frames are drawn first, and kept until their turn. */
static bool has_pilots(const struct state *state, int frame)
{
    const struct fit *fit = &state->of->check_scene.fit; /* without a check it has none */
    for (int i = 0; i < fit->n_passes; i++)
        if (state->plan->passes.frame[fit->passes[i]] == frame)
            return true;
    return false;
}

enum { TAKEN = -1 }; /* a place whose frame is being drawn */
static long frame_number(const struct state *state, int tile, int frame)
{
    return 1 + (long)tile * state->plan->passes.n_frames + frame;
}

/* ---- drawing by OpenGL ---- */

/* Waits for free places, and draws the frames of a batch there. */
static bool draw_batch(struct state *state, int tile, struct frame_batch *batch, struct error *err)
{
    struct renderer *renderer = state->of->renderer;
    for (int i = 0; i < batch->n; i++) {
        batch->buffers[i] = places_wait(&state->frames, 0);
        if (batch->buffers[i] < 0)
            return false;
        places_set(&state->frames, batch->buffers[i], TAKEN);
    }
    double since = clock_seconds();
    if (renderer->kind->draw && !renderer->kind->draw(renderer, batch, err))
        return false;
    clock_in(&since, &state->of->result->seconds.gl);
    for (int i = 0; i < batch->n; i++) {
        const int frame = state->plan->passes.frame[batch->first_bands[i] / BANDS_PER_PASS];
        places_set(&state->frames, batch->buffers[i], frame_number(state, tile, frame));
    }
    return true;
}

/* Aims at the next tile, and draws its numbers for a check. */
static bool draw_numbers(struct state *state, struct error *err)
{
    struct renderer *renderer = state->of->renderer;
    const struct rectangle at = plan_tile(state->plan, &state->of->region, state->drawing);
    if (renderer->kind->aim)
        renderer->kind->aim(renderer, &at);
    if (!state->plan->options.check)
        return true;
    if (places_wait(&state->numbers, 0) < 0)
        return false;
    double since = clock_seconds();
    if (renderer->kind->identify && !renderer->kind->identify(renderer, err))
        return false;
    clock_in(&since, &state->of->result->seconds.gl);
    places_set(&state->numbers, 0, state->drawing + 1);
    return true;
}

/* Draws the numbers of a tile, or its next batch of frames: see struct pipeline. */
static bool draw_next(void *context, struct error *err)
{
    struct state *state = context;
    const int n_frames = state->plan->passes.n_frames;
    struct frame_batch batch = {.n = 0};
    if (state->drawing == plan_tiles(state->plan, &state->of->region))
        return false;
    bool done;
    if (state->drawn < 0) {
        done = draw_numbers(state, err);
        state->drawn = 0;
    } else {
        while (batch.n < state->of->renderer->n_at_once && state->drawn < n_frames)
            batch.first_bands[batch.n++] = state->first_bands[state->drawn++];
        done = draw_batch(state, state->drawing, &batch, err);
    }
    if (state->drawn == n_frames) {
        state->drawing++;
        state->drawn = -1;
    }
    return done;
}

/* Frames with pilots come first. */
static bool order_frames(struct state *state, struct error *err)
{
    const struct plan *plan = state->plan;
    int n = 0;
    if (!MAKE_ARRAY(state->first_bands, plan->passes.n_frames, err, "the order of passes"))
        return false;
    for (int with = 1; with >= 0; with--)
        for (int pass = 0, frame = 0; pass < plan->n_passes; pass++)
            if (plan->passes.frame[pass] == frame && has_pilots(state, frame++) == with)
                state->first_bands[n++] = pass * BANDS_PER_PASS;
    return true;
}

/* ---- a tile's chunks ---- */

/* A pass over a tile whose chunks threads share. */
struct tile_pass {
    struct state *state;
    const struct tile *tile;
    int pass;
    int place;               /* of its frame, unless it is dark */
    const float *pixels;     /* OpenGL's; NULL: it does not draw */
    size_t stride;           /* of its rows, in pixels */
    pthread_mutex_t lock;    /* of these sums, and of the result's odd samples: */
    double judging, storing; /* seconds of all threads */
    bool failed;             /* to write */
    struct error *err;
};

/* A thread is worth starting for so many pixels of a pass. */
enum { FEW_PIXELS = 1 << 14 };

/* Calls work(of, i) for each i below n, a number for each chunk at least. */
static void share_work(struct tile_pass *of, int n, void (*work)(void *of, int i))
{
    const int n_threads = of->state->plan->options.threads,
              worth = of->tile->at.width * of->tile->at.height / FEW_PIXELS;
    threads_each(worth < n_threads ? worth : n_threads, n, work, of);
}

/* OpenGL's pixels of a chunk. */
static const float *pixels_of(const struct tile_pass *of, int chunk)
{
    return of->pixels
               ? of->pixels + (size_t)chunk * (size_t)of->state->plan->chunk_rows * of->stride * 4
               : NULL;
}

static void identify_chunk(void *context, int i)
{
    const struct tile_pass *of = context;
    check_identity(&of->state->checks[i], of->state->of->renderer, &of->tile->at);
}

static void learn_chunk(void *context, int i)
{
    const struct tile_pass *of = context;
    check_pass(&of->state->checks[i], of->pass * BANDS_PER_PASS, pixels_of(of, i), of->stride,
               true);
}

/* Writes counted pages. One thread writes at a time: threads that write to one file wait for each
 * other, and spin meanwhile. */
static bool write_counted(const struct state *state, const struct counted *counted,
                          struct error *err)
{
    const struct rendering *of = state->of;
    const struct rectangle *at = &counted->at;
    bool done = true;
    for (int i = 0; i < counted->n_pages && done; i++) {
        const struct page_rectangle to = {counted->first_page + i, at->x,
                                          at->y - of->result->rows.first, at->width, at->height};
        done = pages_write(&of->stack.pages, &to, counted->samples[i], err);
    }
    return done;
}

/* Counts the samples of a chunk in all bands of a pass. */
static struct odd_samples count_bands(const struct tile_pass *of, int chunk)
{
    const struct plan *plan = of->state->plan;
    const struct counted *counted = &of->state->counted;
    const struct chunk *drawn = &of->tile->chunks[chunk];
    const struct picture *picture = &drawn->picture;
    const struct rectangle at = plan_pixels(plan, &picture->at);
    const size_t first = (size_t)at.width * (size_t)(at.y - counted->at.y);
    struct stored_band stored[BANDS_PER_PASS];
    for (int i = 0; i < counted->n_pages; i++)
        stored[i] =
            (struct stored_band){of->tile->lit, counted->first_page + i,
                                 counted->samples[i] + first * (size_t)plan->options.bits / 8};
    return plan->options.store_raster
               ? store_reference(stored, counted->n_pages, picture)
               : store_gl(stored, counted->n_pages, &picture->at, pixels_of(of, chunk), of->stride);
}

/* Work 0 writes what the pass before has counted, while other threads judge and count the chunks:
 * each while its pixels are in the cache. */
static void write_or_treat(void *context, int i)
{
    struct tile_pass *of = context;
    struct state *state = of->state;
    struct odd_samples *sums = &state->of->result->odd, odd = {0, 0};
    double since = clock_seconds(), judging = 0, storing = 0;
    if (i == 0)
        of->failed = !write_counted(state, &state->written, of->err);
    if (i > 0 && state->checks) {
        check_pass(&state->checks[i - 1], of->pass * BANDS_PER_PASS, pixels_of(of, i - 1),
                   of->stride, false);
        clock_in(&since, &judging);
    }
    if (i > 0 && state->counted.n_pages > 0)
        odd = count_bands(of, i - 1);
    clock_in(&since, &storing);
    pthread_mutex_lock(&of->lock);
    of->judging += judging;
    of->storing += storing;
    sums->clipped += odd.clipped;
    sums->undefined += odd.undefined;
    pthread_mutex_unlock(&of->lock);
}

/* ---- a tile ---- */

/* Opens the checks of all chunks, and checks that OpenGL shows the right triangle at each pixel. */
static bool open_checks(struct state *state, const struct tile *tile, struct error *err)
{
    struct tile_pass of = {.state = state, .tile = tile};
    double since = clock_seconds();
    if (!MAKE_ARRAY(state->checks, tile->n_chunks, err, "the check of a tile"))
        return false;
    for (int i = 0; i < tile->n_chunks; i++)
        if (!check_open(&state->of->check_scene, &tile->chunks[i], &state->checks[i], err))
            return false;
    clock_in(&since, &state->of->result->seconds.check);
    if (places_wait(&state->numbers, state->tile + 1) < 0)
        return false;
    since = clock_seconds();
    share_work(&of, tile->n_chunks, identify_chunk);
    clock_in(&since, &state->of->result->seconds.check);
    return true;
}

/* Adds a tile's checks to the verdict and to the map, unless the tile has failed; and frees them.
 */
static bool end_checks(struct state *state, const struct tile *tile, bool done, struct error *err)
{
    double since = clock_seconds();
    for (int i = 0; state->checks && i < tile->n_chunks; i++) {
        if (done)
            check_settle(&state->checks[i], tile, &state->of->totals);
        if (done && state->of->check_scene.mapped)
            done = check_map_write(&state->of->map, &state->checks[i], err);
        check_free(&state->checks[i]);
    }
    free(state->checks);
    state->checks = NULL;
    clock_in(&since, &state->of->result->seconds.check);
    return done;
}

/* ---- the frame of a pass ---- */

/* Finds the pixels of a pass, black ones where it is dark, and the texels that it shows. Waits
 * until OpenGL has drawn its frame; false: the other stage has failed, or this one. */
static bool find_pixels(struct tile_pass *of, struct error *err)
{
    struct state *state = of->state;
    const struct renderer *renderer = state->of->renderer;
    const int frame = state->plan->passes.frame[of->pass];
    of->pixels = renderer ? state->black : NULL;
    if (renderer && frame != DARK) {
        of->place = places_wait(&state->frames, frame_number(state, state->tile, frame));
        if (of->place < 0)
            return false;
        of->pixels = renderer->buffers[of->place];
        of->stride = (size_t)state->plan->tile_width;
    }
    double since = clock_seconds();
    const bool done = plan_load_textures(state->plan, of->pass * BANDS_PER_PASS, err);
    clock_in(&since, &state->of->result->seconds.read);
    return done;
}

/* The current frame is not needed any more. */
static void leave_frame(struct state *state)
{
    if (state->frame != DARK)
        places_set(&state->frames, state->place, 0);
    state->frame = DARK;
}

/* Learns from all passes that hold pilots; a pass is dark where only materials out of view have
 * light. */
static bool learn_pilots(struct state *state, const struct tile *tile, struct error *err)
{
    const struct fit *fit = &state->of->check_scene.fit;
    for (int i = 0; i < fit->n_passes; i++) {
        struct tile_pass of = {.state = state, .tile = tile, .pass = fit->passes[i]};
        if (!find_pixels(&of, err))
            return false;
        double since = clock_seconds();
        share_work(&of, tile->n_chunks, learn_chunk);
        clock_in(&since, &state->of->result->seconds.check);
    }
    return true;
}

/* ---- a pass ---- */

/* Shares the seconds of a pass in proportion to those of its threads. */
static void share_seconds(const struct tile_pass *of, double seconds)
{
    struct part_seconds *to = &of->state->of->result->seconds;
    const double all = of->judging + of->storing;
    to->check += all > 0 ? seconds * of->judging / all : 0;
    to->write += all > 0 ? seconds * of->storing / all : 0;
}

/* The pass that was counted is written next, and this one is counted. */
static void count_next(struct state *state, const struct tile *tile, int pass)
{
    const struct counted last = state->counted;
    state->counted = state->written;
    state->counted.at = plan_pixels(state->plan, &tile->at);
    state->counted.first_page = pass * BANDS_PER_PASS;
    state->counted.n_pages =
        state->of->output->path ? pass_bands(state->plan, state->counted.first_page) : 0;
    state->written = last;
}

/* Passes come in their order, so that a frame is left where another one begins. */
static bool treat_pass(struct state *state, const struct tile *tile, int pass, struct error *err)
{
    const int frame = state->of->renderer ? state->plan->passes.frame[pass] : DARK;
    struct tile_pass of = {
        .state = state, .tile = tile, .pass = pass, .lock = PTHREAD_MUTEX_INITIALIZER, .err = err};
    if (frame != DARK && frame != state->frame)
        leave_frame(state);
    if (!find_pixels(&of, err))
        return false;
    if (frame != DARK) {
        state->frame = frame;
        state->place = of.place;
    }
    double since = clock_seconds(), seconds = 0;
    count_next(state, tile, pass);
    share_work(&of, 1 + tile->n_chunks, write_or_treat);
    clock_in(&since, &seconds);
    share_seconds(&of, seconds);
    return !of.failed;
}

/* ---- the object map ---- */

/* Returns the number, from 1, of the object at a position of the tile; 0: the background. The
 * renderer of the stored pixels decides: the reference's picture, or OpenGL's last identification.
 * An unknown surface number counts as background. */
static int object_at(const struct rendering *of, const struct tile *tile, int x, int y)
{
    const int rows = of->plan->chunk_rows;
    const struct picture *picture = &tile->chunks[y / rows].picture;
    const size_t pixel = (size_t)(y % rows) * (size_t)tile->at.width + (size_t)x;
    const int surface = of->plan->options.store_raster
                            ? picture->surface[pixel]
                            : of->renderer->kind->shown(of->renderer, x, y).surface;
    return surface < of->plan->n_instances ? surface + 1 : 0;
}

/* Returns the object that most positions of a pixel show, as object_at does; of equally many the
 * one that comes first. */
static int pixel_object(const struct rendering *of, const struct tile *tile, int x, int y)
{
    const int side = of->plan->scene->positions, n = side * side;
    int objects[MOST_POSITIONS * MOST_POSITIONS], best = 0, most = 0;
    for (int i = 0; i < n; i++)
        objects[i] = object_at(of, tile, x * side + i % side, y * side + i / side);
    for (int i = 0; i < n && most <= n / 2; i++) {
        int count = 0;
        for (int k = 0; k < n; k++)
            count += objects[k] == objects[i];
        best = count > most ? objects[i] : best;
        most = count > most ? count : most;
    }
    return best;
}

/* Writes the object map of a tile, the page after the last one: the number of each pixel's object.
 */
static bool add_object_map(struct state *state, const struct tile *tile, struct error *err)
{
    struct counted *map = &state->written; /* free: the last pass of the tile before is counted */
    unsigned char *out = map->samples[0];
    if (state->plan->map_bytes == 0 || !state->of->output->path)
        return true;
    map->at = plan_pixels(state->plan, &tile->at);
    map->first_page = state->plan->n_bands;
    map->n_pages = 1;
    for (int y = 0; y < map->at.height; y++)
        for (int x = 0; x < map->at.width; x++) {
            const int object = pixel_object(state->of, tile, x, y);
            *out++ = (unsigned char)(object % 256);
            if (state->plan->map_bytes > 1)
                *out++ = (unsigned char)(object / 256);
        }
    return write_counted(state, map, err);
}

/* ---- judging ---- */

static bool treat_tile(void *context, const struct tile *tile, struct error *err)
{
    struct state *state = context;
    const bool checking = state->plan->options.check;
    const int n_passes = state->plan->n_passes;
    const long all = (long)plan_tiles(state->plan, &state->of->region) * n_passes;
    clock_in(&state->since, &state->of->result->seconds.raster);
    for (int i = 0; i < tile->n_chunks; i++)
        light_work_add(&state->of->result->light, &tile->chunks[i].picture.work);
    bool done = (!checking || open_checks(state, tile, err)) && add_object_map(state, tile, err);
    if (done && checking)
        places_set(&state->numbers, 0, 0);
    done = done && learn_pilots(state, tile, err);
    for (int pass = 0; done && pass < n_passes; pass++) {
        done = treat_pass(state, tile, pass, err);
        if (state->of->progress)
            progress_show(state->of->progress, (long)state->tile * n_passes + pass + 1, all);
    }
    leave_frame(state);
    done = end_checks(state, tile, done, err);
    state->since = clock_seconds();
    state->tile++;
    return done;
}

static bool treat_tiles(void *context, struct error *err)
{
    struct state *state = context;
    const struct rendering *of = state->of;
    state->since = clock_seconds();
    return tiles_each(&of->lit, &of->region, treat_tile, state, err) &&
           write_counted(state, &state->counted, err);
}

/* ---- all of it ---- */

static bool allocate(struct state *state, struct error *err)
{
    const struct plan *plan = state->plan;
    const size_t n_samples = (size_t)plan->tile_width * (size_t)plan->tile_height,
                 size = (size_t)plan->options.bits / 8, map = (size_t)plan->map_bytes,
                 most = size > map ? size : map;
    if (!MAKE_ARRAY(state->black, 4 * plan->tile_width, err, "a row of the picture") ||
        !order_frames(state, err))
        return false;
    for (int i = 0; i < BANDS_PER_PASS && state->of->output->path; i++)
        if (!MAKE_ARRAY(state->counted.samples[i], n_samples * most, err, "a page of a tile") ||
            !MAKE_ARRAY(state->written.samples[i], n_samples * most, err, "a page of a tile"))
            return false;
    return true;
}

bool stages_run(struct rendering *of, struct error *err)
{
    struct state state = {.of = of, .plan = of->plan, .frame = DARK, .drawn = -1};
    struct pipeline pipeline = {.make = draw_next,
                                .take = treat_tiles,
                                .context = &state,
                                .alone = of->plan->options.threads == 1};
    state.numbers = (struct places){.pipeline = &pipeline, .n = 1};
    state.frames = (struct places){.pipeline = &pipeline,
                                   .n = (of->plan->options.check ? GL_BUFFERS : AHEAD_FRAMES) +
                                        (of->renderer ? of->renderer->n_at_once - 1 : 0)};
    bool done = allocate(&state, err);
    if (done && of->renderer) /* OpenGL's context is this thread's */
        done = pipeline_run(&pipeline, err);
    else
        done = done && treat_tiles(&state, err);
    FREE_ALL(state.black, state.first_bands);
    for (int i = 0; i < BANDS_PER_PASS; i++)
        FREE_ALL(state.counted.samples[i], state.written.samples[i]);
    return done;
}
