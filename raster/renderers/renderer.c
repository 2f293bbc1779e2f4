/* SPDX-License-Identifier: MIT */
/* Renderers share these: buffers of pixels, and a pixel's triangle, from the colours that it was
 * drawn in. */
#include "data/base/base.h"
#include "raster/renderers/renderers.h"

bool renderer_make_buffers(struct renderer *of, int n_buffers, size_t n, const char *what,
                           struct error *err)
{
    for (int i = 0; i < n_buffers; i++)
        if (!MAKE_ARRAY(of->buffers[i], 4 * n, err, "%s", what))
            return false;
    return true;
}

void renderer_free(struct renderer *of)
{
    for (int i = 0; i < MOST_BUFFERS; i++)
        free(of->buffers[i]);
    free(of);
}

/* Returns the number that a channel holds; -1: it holds no whole number below 2^24. */
static int32_t whole(float value)
{
    return value >= 0 && (double)value < 1 / SINGLE_ROUNDOFF && value == (float)(int32_t)value
               ? (int32_t)value
               : -1;
}

struct shown shown_of(int n_instances, const float number[3], uint32_t depth)
{
    struct shown shown = {-1, -1, depth >> 8, (uint8_t)(depth & 0xff)};
    int32_t low = whole(number[0]), high = whole(number[1]), placed = whole(number[2]);
    if (low < 0 || low > 0xffff || high < 0 || high > INT16_MAX || placed < 0) {
        shown.surface = n_instances; /* a number that no instance has */
    } else if (placed > 0) {
        shown.surface = placed - 1;
        shown.triangle = high * 65536 + low;
    }
    return shown;
}

bool gl_is_built(void)
{
    return drawing_ways.library != NULL;
}
