/* SPDX-License-Identifier: MIT */
/* The loop over the tiles of a region. Threads share the chunks of a tile. */
#include <stdlib.h>

#include "data/base/base.h"
#include "raster/candidates/inside.h"
#include "raster/plan/plan.h"

/* A tile whose chunks are drawn. */
struct drawn_tile {
    struct tile *tile;
    struct counter failures;
};

static void draw_chunk(void *context, int i)
{
    struct drawn_tile *drawn = context;
    if (!chunk_draw(drawn->tile, i))
        counter_add(&drawn->failures, 1);
}

static bool draw_chunks(struct tile *tile, struct error *err)
{
    tile->n_chunks = (tile->at.height + CHUNK_ROWS - 1) / CHUNK_ROWS;
    if (!MAKE_ARRAY(tile->chunks, tile->n_chunks, err, "a tile"))
        return false;
    struct drawn_tile drawn = {tile, COUNTER};
    threads_each(tile->lit->plan->options.threads, tile->n_chunks, draw_chunk, &drawn);
    return drawn.failures.n == 0 ||
           memory_lacks(err, (double)tile->lit->plan->tile_bytes, "a tile of %d x %d pixels",
                        tile->at.width, tile->at.height);
}

static void free_tile(struct tile *tile)
{
    for (int i = 0; tile->chunks && i < tile->n_chunks; i++)
        chunk_free(&tile->chunks[i]);
    free(tile->chunks);
}

bool tile_draw(const struct lit_scene *lit, const struct rectangle *at,
               bool (*work)(void *context, const struct tile *tile, struct error *err),
               void *context, struct error *err)
{
    struct tile tile = {.lit = lit, .at = *at};
    const bool done = draw_chunks(&tile, err) && work(context, &tile, err);
    free_tile(&tile);
    return done;
}

bool tiles_each(const struct lit_scene *lit, const struct rectangle *region,
                bool (*work)(void *context, const struct tile *tile, struct error *err),
                void *context, struct error *err)
{
    const int n = plan_tiles(lit->plan, region);
    bool done = true;
    for (int i = 0; done && i < n; i++) {
        const struct rectangle at = plan_tile(lit->plan, region, i);
        done = tile_draw(lit, &at, work, context, err);
    }
    return done;
}
