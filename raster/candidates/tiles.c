/* SPDX-License-Identifier: MIT */
/* The loop over the tiles of a region, and over the chunks of a tile. */
#include <stdlib.h>

#include "raster/bounds/bounds.h"
#include "raster/candidates/candidates.h"
#include "raster/plan/plan.h"
#include "raster/reference/reference.h"
#include "spectral.h"

int chunk_count(const struct rectangle *tile)
{
    return (tile->height + CHUNK_ROWS - 1) / CHUNK_ROWS;
}

struct rectangle chunk_rows(const struct rectangle *tile, int index)
{
    struct rectangle rows = *tile;
    rows.y += index * CHUNK_ROWS;
    rows.height = tile->height - index * CHUNK_ROWS;
    if (rows.height > CHUNK_ROWS)
        rows.height = CHUNK_ROWS;
    return rows;
}

bool chunks_each(const struct rectangle *tile, int threads,
                 bool (*work)(void *context, const struct rectangle *tile, int index,
                              struct error *err),
                 void *context, struct error *err)
{
    const int n = chunk_count(tile);
    bool failed = false;
    (void)threads; /* without OpenMP */
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int i = 0; i < n; i++) {
        struct error own = {.status = EXIT_AGREED};
        if (work(context, tile, i, &own))
            continue;
#pragma omp critical
        {
            if (!failed)
                *err = own;
            failed = true;
        }
    }
    return !failed;
}

/* ---- tiles ---- */

static bool draw_chunk(void *context, const struct rectangle *at, int index, struct error *err)
{
    struct tile *tile = context;
    const struct plan_options *options = &tile->lit->plan->options;
    if (options->check || options->store_raster)
        return chunk_draw(tile->lit, at, index, &tile->chunks[index], err);
    tile->chunks[index].picture.at = chunk_rows(at, index);
    return true;
}

static bool draw_tile(struct tile *tile, struct error *err)
{
    tile->n_chunks = chunk_count(&tile->at);
    tile->chunks = calloc((size_t)tile->n_chunks, sizeof *tile->chunks);
    return tile->chunks
               ? chunks_each(&tile->at, tile->lit->plan->options.threads, draw_chunk, tile, err)
               : error_memory(err);
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
