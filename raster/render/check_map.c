/* SPDX-License-Identifier: MIT */
/* The map of a check: what could pass at each pixel, how near OpenGL came to it, and the verdict.
 * A TIFF has these as numbers. A PNG shows both floors in colours, side by side. */
#include "raster/render/inside.h"

enum { MAP_FLOOR, MAP_BAND_FLOOR, MAP_RATIO, MAP_CLASS, MAP_PAGES };

/* The least floor that has a colour of its own, in counts: so the last colour begins where a pixel
 * is not checked. */
static const double least_floor = 1.0 / 16;
/* A colour that the scale has not. */
static const uint8_t colour_differs[3] = {255, 0, 255};

/* ---- in words ---- */

void check_map_print_colours(struct printed *to)
{
    print_text(to, "floors in counts, in all bands alike (left) and in one band (right): ");
    scale_print(least_floor, to);
    print_text(to, "; background black; pixels that differ magenta");
}

static const char planes_in_words[] =
    "Cross-check of OpenGL. Floors: the largest error that can pass, in counts of 65535, in all "
    "bands alike and in one band; -1: background. Class: 0 checked, 1 ambiguous, 2 not checked, "
    "3 differs.";
static const char *const plane_names[MAP_PAGES] = {[MAP_FLOOR] = "floor",
                                                   [MAP_BAND_FLOOR] = "floor in one band",
                                                   [MAP_RATIO] = "error / bound",
                                                   [MAP_CLASS] = "class"};

/* ---- the file ---- */

bool check_map_open(const char *path, const struct plan *plan, struct check_map *out,
                    struct error *err)
{
    const bool coloured = picture_is_png(path);
    const int width = plan->scene->width;
    struct printed colours = {.text = NULL};
    *out = (struct check_map){.samples = NULL};
    print_text(&colours, "Cross-check of OpenGL. ");
    check_map_print_colours(&colours);
    char *in_words = printed_take(&colours, err);
    struct picture_options options = {.width = coloured ? 2 * width : width,
                                      .height = plan->scene->height,
                                      .bits = coloured ? 8 : 32,
                                      .srgb = coloured,
                                      .description = coloured ? in_words : planes_in_words};
    if (!coloured)
        memcpy(options.channels, plane_names, sizeof plane_names);
    const bool done =
        in_words && picture_open(&out->picture, path, &options, err) &&
        MAKE_ARRAY(out->samples, plan->tile_width * plan->chunk_rows, err, "rows of %s", path);
    free(in_words);
    return done;
}

/* ---- pixels ---- */

static float position_sample(const struct check *check, int page, size_t position)
{
    const float *const samples[MAP_CLASS] = {check->floor, check->band_floor, check->ratio};
    return page < MAP_CLASS ? samples[page][position] : (float)check_class(check, position);
}

/* Returns the largest sample of a pixel's positions. */
static float sample_of(const struct check *check, int page, size_t pixel)
{
    const size_t side = (size_t)check->scene->lit->plan->scene->positions,
                 stride = (size_t)check->chunk->picture.at.width, width = stride / side,
                 first = pixel / width * side * stride + pixel % width * side;
    float largest = position_sample(check, page, first);
    for (size_t i = 1; i < side * side; i++)
        largest =
            fmaxf(largest, position_sample(check, page, first + i / side * stride + i % side));
    return largest;
}

/* Colours a floor. Negative floors mean the background. */
static void colour_pixel(const struct check *check, int page, size_t pixel, uint8_t out[3])
{
    const double floor = (double)sample_of(check, page, pixel);
    scale_colour(floor < 0 ? 0 : floor > least_floor ? floor : least_floor, least_floor, out);
    if (sample_of(check, MAP_CLASS, pixel) >= (float)CLASS_DIFFERS)
        memcpy(out, colour_differs, sizeof colour_differs);
}

bool check_map_write(struct check_map *map, const struct check *check, struct error *err)
{
    const struct plan *plan = check->scene->lit->plan;
    const struct rectangle at = plan_pixels(plan, &check->chunk->picture.at);
    const bool coloured = map->picture.png != NULL;
    uint8_t *colours = (uint8_t *)map->samples; /* 3 of its 4 bytes a pixel */
    bool done = true;
    for (int page = 0; done && page < (coloured ? MAP_RATIO : MAP_PAGES); page++) {
        const struct page_rectangle to = {coloured ? 0 : page,
                                          at.x + (coloured ? page * plan->scene->width : 0), at.y,
                                          at.width, at.height};
        for (size_t i = 0; i < (size_t)at.width * (size_t)at.height; i++)
            if (coloured)
                colour_pixel(check, page, i, colours + 3 * i);
            else
                map->samples[i] = sample_of(check, page, i);
        done = coloured ? picture_put(&map->picture, &to, colours, err)
                        : pages_write(&map->picture.pages, &to, map->samples, err);
    }
    return done;
}
