/* SPDX-License-Identifier: MIT */
/* The loop over the tiles of a region. Threads share the chunks of a tile. */
#include <stdlib.h>

#include "raster/candidates/candidates.h"
#include "raster/plan/plan.h"

static bool draw_chunks(const struct tile *tile)
{
    bool done = true;
#pragma omp parallel for schedule(dynamic) num_threads(tile->lit->plan->options.threads) \
    reduction(&& : done)
    for (int i = 0; i < tile->n_chunks; i++)
        done = chunk_draw(tile->lit, &tile->at, i, &tile->chunks[i]) && done;
    return done;
}

static bool draw_tile(struct tile *tile, struct error *err)
{
    tile->n_chunks = (tile->at.height + CHUNK_ROWS - 1) / CHUNK_ROWS;
    tile->chunks = calloc((size_t)tile->n_chunks, sizeof *tile->chunks);
    return (tile->chunks && draw_chunks(tile)) || error_memory(err);
}

static void free_tile(struct tile *tile)
{
    for (int i = 0; tile->chunks && i < tile->n_chunks; i++)
        chunk_free(&tile->chunks[i]);
    free(tile->chunks);
}

bool tiles_each(const struct lit_scene *lit, const struct rectangle *region,
                bool (*work)(void *context, const struct tile *tile, struct error *err),
                void *context, struct error *err)
{
    const int n = plan_tiles(lit->plan, region);
    bool done = true;
    for (int i = 0; done && i < n; i++) {
        struct tile tile = {.lit = lit, .at = plan_tile(lit->plan, region, i)};
        done = draw_tile(&tile, err) && work(context, &tile, err);
        free_tile(&tile);
    }
    return done;
}
