/* SPDX-License-Identifier: MIT */
/* The map of a check: what could pass at each pixel, how near OpenGL came to it, and the verdict.
 */
#include <stdlib.h>

#include "raster/render/render.h"

enum { MAP_FLOOR, MAP_BAND_FLOOR, MAP_RATIO, MAP_CLASS, MAP_PAGES };
static const char *const page_names[MAP_PAGES] = {[MAP_FLOOR] = "floor",
                                                  [MAP_BAND_FLOOR] = "floor in one band",
                                                  [MAP_RATIO] = "error / bound",
                                                  [MAP_CLASS] = "class"};

bool check_map_open(const char *path, const struct plan *plan, struct check_map *out,
                    struct error *err)
{
    const struct planes_options options = {
        .width = plan->scene->width,
        .height = plan->scene->height,
        .n = MAP_PAGES,
        .names = page_names,
        .description =
            "Cross-check of OpenGL. Floors: the largest error that can pass, in counts of "
            "65535, in all bands alike and in one band; -1: background. Class: 0 checked, "
            "1 ambiguous, 2 not checked, 3 differs."};
    out->samples = malloc((size_t)plan->tile_width * CHUNK_ROWS * sizeof *out->samples);
    if (!out->samples)
        return error_memory(err);
    if (planes_open(&out->pages, path, &options, err))
        return true;
    free(out->samples);
    return false;
}

static float sample_of(const struct check *check, int page, size_t pixel)
{
    switch (page) {
    case MAP_FLOOR:
        return check->floor[pixel];
    case MAP_BAND_FLOOR:
        return check->band_floor[pixel];
    case MAP_RATIO:
        return check->ratio[pixel];
    default:
        return (float)check_class(check, pixel);
    }
}

bool check_map_write(struct check_map *map, const struct check *check, struct error *err)
{
    const struct rectangle *at = &check->chunk->picture.at;
    const size_t n = (size_t)at->width * (size_t)at->height;
    for (int page = 0; page < MAP_PAGES; page++) {
        const struct plane_rectangle to = {page, at->x, at->y, at->width, at->height};
        for (size_t i = 0; i < n; i++)
            map->samples[i] = sample_of(check, page, i);
        if (!planes_write(&map->pages, &to, map->samples, err))
            return false;
    }
    return true;
}

bool check_map_finish(struct check_map *map, struct error *err)
{
    return planes_finish(&map->pages, err);
}

bool check_map_commit(struct check_map *map, struct error *err)
{
    return planes_commit(&map->pages, err);
}

void check_map_discard(struct check_map *map)
{
    planes_discard(&map->pages);
    free(map->samples);
    map->samples = NULL;
}
