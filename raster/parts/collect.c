/* SPDX-License-Identifier: MIT */
/* Collects complete tiles: their samples and their sums. */
#include <stdlib.h>

#include "raster/parts/parts.h"

bool collector_open(const struct plan *plan, struct stack_writer *writer, struct tile_sums *picture,
                    struct collector *out, struct error *err)
{
    const size_t most = (size_t)plan->tile_width * (size_t)plan->tile_height * sizeof(float);
    *out = (struct collector){.plan = plan, .writer = writer, .picture = picture};
    if (writer && !(out->samples = malloc(most)))
        return error_memory(err);
    return !picture->totals.scene || totals_open(picture->totals.scene, &out->own.totals, err);
}

void collector_close(struct collector *collector)
{
    totals_free(&collector->own.totals);
    free(collector->samples);
    *collector = (struct collector){.plan = NULL};
}

/* The samples of a tile, page by page. */
struct passage {
    const struct part_file *file;
    struct rectangle at; /* in pixels of the stack */
    uint64_t from;       /* where the next samples lie in the part's file */
    uint32_t checksum;
};

/* Copies a page of a tile into the stack, or reads it there again. */
static bool collect_page(struct collector *collector, struct passage *of, int page,
                         size_t sample_bytes, struct error *err)
{
    const struct stack_rectangle to = {page, of->at.x, of->at.y, of->at.width, of->at.height};
    const size_t length = (size_t)to.width * (size_t)to.height * sample_bytes;
    if (of->file->stack) {
        if (!stack_read(collector->writer, &to, collector->samples, err))
            return false;
        of->checksum = checksum_add(of->checksum, collector->samples, length);
        return true;
    }
    if (!part_samples(of->file, of->from, collector->samples, length, &of->checksum, err))
        return false;
    of->from += length;
    return stack_write(collector->writer, &to, collector->samples, err);
}

/* The samples of the object map come first. */
static bool collect_samples(struct collector *collector, const struct part_file *file, int tile,
                            const struct part_tile *has, struct error *err)
{
    const struct plan *plan = collector->plan;
    const struct rectangle picture = plan_picture(plan),
                           positions = plan_tile(plan, &picture, tile);
    struct passage of = {.file = file, .at = plan_pixels(plan, &positions), .from = has->samples};
    if (plan->map_bytes > 0 &&
        !collect_page(collector, &of, plan->n_bands, (size_t)plan->map_bytes, err))
        return false;
    for (int band = 0; band < plan->n_bands; band++)
        if (!collect_page(collector, &of, band, (size_t)plan->options.bits / 8, err))
            return false;
    return of.checksum == has->checksum ||
           error_at(err, (struct place){file->path, 0, 0},
                    "tile %d has samples that differ from their checksum; remove this file, and "
                    "repeat its render",
                    tile + 1);
}

bool collector_take(struct collector *collector, struct part_file *file, bool *found,
                    struct error *err)
{
    struct part_tile tile;
    bool done = part_next(file, found, &tile, err);
    if (done && *found && collector->writer)
        done = collect_samples(collector, file, file->tiles[file->n_complete - 1], &tile, err);
    if (done && *found && !sums_unpack(tile.sums, tile.sums_length, &collector->own))
        done = error_at(err, (struct place){file->path, 0, 0},
                        "records impossible sums; remove it, and repeat its render");
    if (done && *found)
        sums_add(collector->picture, &collector->own);
    free(tile.sums);
    return done;
}

/* Finds the part whose next tile this is. Each tile is in one part. */
static struct part_file *find_part(const struct parts *parts, int tile)
{
    for (int i = 0; i < parts->n; i++) {
        struct part_file *file = &parts->list[i];
        if (file->n_complete < file->n_tiles && file->tiles[file->n_complete] == tile)
            return file;
    }
    return NULL;
}

static bool collect_all(struct collector *collector, struct parts *parts, struct error *err)
{
    const struct rectangle picture = plan_picture(collector->plan);
    const int n = plan_tiles(collector->plan, &picture);
    for (int tile = 0; tile < n; tile++) {
        struct part_file *file = find_part(parts, tile);
        bool found = false;
        if (!file || !collector_take(collector, file, &found, err))
            return false;
        if (!found)
            return error_at(err, (struct place){file->path, 0, 0},
                            "part %d of %d is not complete: it has %d of %d tiles; repeat its "
                            "render, which goes on there",
                            file->part.number, file->part.count, file->n_complete, file->n_tiles);
    }
    return true;
}

bool parts_collect(struct parts *parts, const struct plan *plan, struct stack_writer *writer,
                   struct tile_sums *picture, struct error *err)
{
    struct part_facts facts;
    struct collector collector;
    bool done = collector_open(plan, writer, picture, &collector, err) &&
                facts_read(parts->list[0].text, &facts);
    for (int i = 0; done && i < parts->n; i++) {
        parts->list[i].stack = facts.shared ? writer : NULL;
        done = part_plan(&parts->list[i], plan, err);
    }
    done = done && collect_all(&collector, parts, err);
    collector_close(&collector);
    return done;
}
