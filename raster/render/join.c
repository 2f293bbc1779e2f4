/* SPDX-License-Identifier: MIT */
/* spectral join: puts the parts of a picture together. The stack is that of one process, byte for
 * byte, and its verdict the sum of the parts'. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "raster/render/render.h"

/* ---- tiles ---- */

bool join_sums(const struct part_file *file, const struct part_tile *tile, struct tile_sums *own,
               struct tile_sums *picture, struct error *err)
{
    if (!sums_unpack(tile->sums, tile->sums_length, own))
        return error_at(err, (struct place){file->path, 0, 0},
                        "records impossible sums; remove it, and repeat its render");
    sums_add(picture, own);
    return true;
}

/* The samples of a tile on their way into the stack. */
struct copy {
    const struct part_file *file;
    struct stack_writer *writer;
    struct rectangle at; /* in pixels of the stack */
    uint64_t from;       /* where the next samples lie */
    uint32_t checksum;
    unsigned char *samples; /* room for one page of the tile */
};

static bool copy_page(struct copy *copy, int page, size_t sample_bytes, struct error *err)
{
    const struct stack_rectangle to = {page, copy->at.x, copy->at.y, copy->at.width,
                                       copy->at.height};
    const size_t length = (size_t)to.width * (size_t)to.height * sample_bytes;
    if (!part_samples(copy->file, copy->from, copy->samples, length, &copy->checksum, err))
        return false;
    copy->from += length;
    return stack_write(copy->writer, &to, copy->samples, err);
}

/* Copies the samples of a tile: those of the object map come first. */
static bool copy_tile(struct copy *copy, const struct part_tile *tile, struct error *err)
{
    const struct plan *plan = copy->file->plan;
    copy->from = tile->samples;
    copy->checksum = 0;
    if (plan->map_bytes > 0 && !copy_page(copy, plan->n_bands, (size_t)plan->map_bytes, err))
        return false;
    for (int band = 0; band < plan->n_bands; band++)
        if (!copy_page(copy, band, (size_t)plan->options.bits / 8, err))
            return false;
    return copy->checksum == tile->checksum ||
           error_at(
               err, (struct place){copy->file->path, 0, 0},
               "has samples that differ from their checksum; remove it, and repeat its render");
}

/* Finds the part whose next tile this is. Each tile is in one part. */
static struct part_file *find_part(struct parts *parts, int tile)
{
    for (int i = 0; i < parts->n; i++)
        if (parts->list[i].n_complete < parts->list[i].n_tiles &&
            parts->list[i].tiles[parts->list[i].n_complete] == tile)
            return &parts->list[i];
    return NULL;
}

static bool join_tile(struct parts *parts, int number, struct copy *copy, struct tile_sums *own,
                      struct tile_sums *picture, struct error *err)
{
    struct part_file *file = find_part(parts, number);
    struct part_tile tile = {.sums = NULL};
    bool found = false, done = file && part_next(file, &found, &tile, err);
    if (file && done && !found)
        done = error_at(err, (struct place){file->path, 0, 0},
                        "part %d of %d is not complete: it has %d of %d tiles; repeat its render, "
                        "which goes on there",
                        file->part.number, file->part.count, file->n_complete, file->n_tiles);
    copy->file = file;
    done = done && copy_tile(copy, &tile, err) && join_sums(file, &tile, own, picture, err);
    free(tile.sums);
    return done;
}

bool join_tiles(struct parts *parts, const struct plan *plan, struct stack_writer *writer,
                struct tile_sums *picture, struct error *err)
{
    const struct rectangle region = plan_picture(plan);
    const int n_tiles = plan_tiles(plan, &region);
    struct tile_sums own = {.odd = {0, 0}};
    struct copy copy = {
        .writer = writer,
        .samples = malloc((size_t)plan->tile_width * (size_t)plan->tile_height * sizeof(float))};
    bool done = copy.samples || error_memory(err);
    for (int i = 0; done && i < parts->n; i++)
        done = part_plan(&parts->list[i], plan, err);
    done = done && (!picture->totals.scene || totals_open(picture->totals.scene, &own.totals, err));
    for (int i = 0; done && i < n_tiles; i++) {
        const struct rectangle positions = plan_tile(plan, &region, i);
        copy.at = plan_pixels(plan, &positions);
        done = join_tile(parts, i, &copy, &own, picture, err);
    }
    totals_free(&own.totals);
    free(copy.samples);
    return done;
}

/* ---- the command ---- */

/* The check is part of the facts: a stack of the reference's pixels does not record it. */
static bool join_options(const struct options *options, const struct parts *parts,
                         const struct record *record, char unchecked[32], struct options *out,
                         struct error *err)
{
    struct part_facts facts;
    if (!recorded_options(options, options->operand, record, out, err))
        return false;
    if (!facts_read(parts->list[0].text, &facts))
        return error_usage(err, "%s: records no facts", parts->list[0].path);
    snprintf(unchecked, 32, "%.17g", facts.unchecked);
    out->no_check = !facts.check;
    out->strict = facts.check && facts.strict;
    out->unchecked = facts.check ? unchecked : NULL;
    return true;
}

static bool join_parts(struct options *options, struct parts *parts, struct error *err)
{
    struct record record = {.text = NULL};
    struct options made = {.operand = NULL};
    char unchecked[32];
    const struct render_output output = {.path = options->operand,
                                         .keep = options->keep,
                                         .envi = options->envi,
                                         .outputs = &options->outputs,
                                         .join = parts};
    bool done = record_parse(parts->list[0].text, &record, err) ||
                error_usage(err, "%s: records no scene", parts->list[0].path);
    done = done && join_options(options, parts, &record, unchecked, &made, err) &&
           (options->trust || record_is_trusted(parts->list[0].path, &record, err)) &&
           render_with_options(&made, &output, NULL, err);
    options_free(&made);
    record_free(&record);
    return done;
}

bool command_join(struct options *options, struct error *err)
{
    struct parts parts;
    if (!options->operand)
        return error_usage(err, "join needs STACK, the name that the parts were drawn for");
    const bool done = parts_find(options->operand, &parts, err) && join_parts(options, &parts, err);
    parts_free(&parts);
    return done;
}
