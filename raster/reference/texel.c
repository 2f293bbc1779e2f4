/* SPDX-License-Identifier: MIT */
/* A texture at a point (OpenGL 2.1 specification, section 3.8.8). Places are in texels, from the
 * lower left corner of the texture; texel centres lie at half-integers. */
#include <math.h>

#include "raster/reference/reference.h"

/* Beyond 2^40 texels a double no longer knows which texel it is. */
void texel_place(const struct texels *texels, const double s_t[2], double place[2])
{
    place[0] = s_t[0] * texels->width;
    place[1] = s_t[1] * texels->height;
    if (!(fabs(place[0]) < 0x1p40 && fabs(place[1]) < 0x1p40))
        place[0] = place[1] = 0;
}

/* A whole number of texels, in [0, n). */
static size_t wrapped(double whole, int n)
{
    if (whole >= 0 && whole < n)
        return (size_t)whole;
    return (size_t)(whole - n * floor(whole / n));
}

const float *texel_row(const struct texels *texels, double row)
{
    return texels->values + (size_t)texels->width * wrapped(row, texels->height);
}

size_t texel_column(const struct texels *texels, double column)
{
    return wrapped(column, texels->width);
}

static double mix(double a, double b, double share)
{
    return a + (b - a) * share;
}

double texel_at(const struct texels *texels, const double place[2])
{
    double offset = texels->linear ? 0.5 : 0, x = place[0] - offset, y = place[1] - offset;
    double i = floor(x), j = floor(y);
    const float *low = texel_row(texels, j);
    size_t left = texel_column(texels, i);
    if (!texels->linear)
        return (double)low[left];
    const float *high = texel_row(texels, j + 1);
    size_t right = texel_column(texels, i + 1);
    return mix(mix((double)low[left], (double)low[right], x - i),
               mix((double)high[left], (double)high[right], x - i), y - j);
}
