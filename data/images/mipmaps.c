/* SPDX-License-Identifier: MIT */
/* Levels of a texture for views from afar (Williams 1983: Pyramidal Parametrics). Sides are halved,
 * rounded down; a texel of a level averages the part of level 0 that it covers, at odd sizes with
 * parts of texels at its ends. Both the reference and OpenGL get these numbers. */
#include "data/images/inside.h"

static int halved(int side)
{
    return side > 1 ? side / 2 : 1;
}

void mipmaps_count(struct texture *texture)
{
    int width = texture->image.width, height = texture->image.height;
    texture->n_levels = 1;
    texture->plane_size = (size_t)width * (size_t)height;
    for (; texture->mipmapped && (width > 1 || height > 1); texture->n_levels++) {
        width = halved(width);
        height = halved(height);
        texture->plane_size += (size_t)width * (size_t)height;
    }
}

/* The part of texel i of level 0 that lies between two places. */
static double part_of(int i, double from, double to)
{
    return fmin(i + 1, to) - fmax(i, from);
}

/* Averages rows low to high of level 0 into a row of a level. */
static void make_row(const float *base, int base_width, double low, double high, int width,
                     float *out)
{
    for (int i = 0; i < width; i++) {
        const double left = (double)i * base_width / width,
                     right = (double)(i + 1) * base_width / width;
        double sum = 0;
        for (int y = (int)low; y < high; y++) {
            const float *row = base + (size_t)y * (size_t)base_width;
            double of_row = 0;
            for (int x = (int)left; x < right; x++)
                of_row += part_of(x, left, right) * (double)row[x];
            sum += part_of(y, low, high) * of_row;
        }
        out[i] = (float)(sum / ((right - left) * (high - low)));
    }
}

void mipmaps_make(const struct texture *texture, float *plane)
{
    const int width = texture->image.width, height = texture->image.height;
    float *level = plane + (size_t)width * (size_t)height;
    int level_width = width, level_height = height;
    for (int k = 1; k < texture->n_levels; k++) {
        level_width = halved(level_width);
        level_height = halved(level_height);
        for (int j = 0; j < level_height; j++, level += level_width)
            make_row(plane, width, (double)j * height / level_height,
                     (double)(j + 1) * height / level_height, level_width, level);
    }
}
