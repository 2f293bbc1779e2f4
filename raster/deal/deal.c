/* SPDX-License-Identifier: MIT */
/* Deals the tiles of a picture to parts. */
#include <stdio.h>
#include <stdlib.h>

#include "data/text/text.h"
#include "raster/deal/deal.h"

bool part_read(const char *option, const char *value, struct picture_part *out, struct error *err)
{
    int end = 0;
    *out = (struct picture_part){0, 0};
    if (sscanf(value, "%6d/%6d%n", &out->number, &out->count, &end) == 2 && value[end] == '\0' &&
        out->number >= 1 && out->number <= out->count && out->count <= MOST_PARTS)
        return true;
    return error_usage(err, "%s: expected a part and their number, from 1/1 to %d/%d, found '%s'",
                       option, MOST_PARTS, MOST_PARTS, value);
}

bool part_accepts(const char *option, const char *value, struct error *err)
{
    struct picture_part part;
    return part_read(option, value, &part, err);
}

static long greatest_divisor(long a, long b)
{
    return b == 0 ? a : greatest_divisor(b, a % b);
}

bool part_deal(const struct plan *plan, const struct picture_part *part, int **tiles, int *n,
               struct error *err)
{
    const struct rectangle picture = plan_picture(plan);
    const int all = plan_tiles(plan, &picture);
    const long columns = (picture.width + plan->tile_width - 1) / plan->tile_width,
               parts = part->count > 0 ? part->count : 1, me = part->count > 0 ? part->number : 1,
               rounds = columns / greatest_divisor(columns, parts) * parts;
    *n = 0;
    *tiles = calloc((size_t)all, sizeof **tiles);
    if (!*tiles)
        return error_memory(err);
    for (int tile = 0; tile < all; tile++)
        if ((tile + tile / rounds) % parts == me - 1)
            (*tiles)[(*n)++] = tile;
    return true;
}
