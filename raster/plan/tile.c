/* SPDX-License-Identifier: MIT */
/* A tile: its projection, which is the picture's, scaled and shifted, and its pixels. */
#include "raster/plan/plan.h"

/* Makes a row of a projection map [low, high] of the picture's clip space to [-1, 1]. */
static void aim_row(struct matrix *m, int row, double low, double high)
{
    for (int j = 0; j < 4; j++)
        m->row[row][j] = (2 * m->row[row][j] - (low + high) * m->row[3][j]) / (high - low);
}

struct matrix pass_projection(const struct plan *plan, const struct rectangle *tile, bool mirrored)
{
    const double width = plan->view.width, height = plan->view.height;
    struct matrix out = plan->view.projection;
    aim_row(&out, 0, 2 * tile->x / width - 1, 2 * (tile->x + tile->width) / width - 1);
    aim_row(&out, 1, 1 - 2 * (tile->y + tile->height) / height, 1 - 2 * tile->y / height);
    for (int i = 0; i < 4 && mirrored; i++)
        out.row[1][i] = -out.row[1][i];
    return out;
}

static size_t count_numbers(const struct plan *plan)
{
    return 4 * (size_t)plan->tile_width * (size_t)plan->tile_height;
}

void pass_convert(const struct plan *plan, const void *steps, float *pixels)
{
    const size_t n = count_numbers(plan);
    const uint16_t *words = steps;
    const uint8_t *bytes = steps;
    const float whole = (float)buffer_steps(plan);
    const bool wide = plan->options.buffer_bits == 16;
    for (size_t i = 0; i < n; i++)
        pixels[i] = (float)(wide ? words[i] : bytes[i]) / whole;
}

void pass_add(const struct plan *plan, const float *part, float *sum)
{
    const size_t n = count_numbers(plan);
    for (size_t i = 0; i < n; i++)
        sum[i] += part[i];
}
