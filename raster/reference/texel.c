/* SPDX-License-Identifier: MIT */
/* A texture at a point (OpenGL 2.1 specification, section 3.8.8). Places are in texels, from the
 * lower left corner of the texture; texel centres lie at half-integers. */
#include <math.h>

#include "raster/reference/reference.h"

/* Texture coordinates to texels. Beyond 2^40 texels a double no longer knows which texel it is. */
void texel_place(const struct texels *texels, const double s_t[2], double place[2])
{
    place[0] = s_t[0] * texels->width;
    place[1] = s_t[1] * texels->height;
    if (!(fabs(place[0]) < 0x1p40 && fabs(place[1]) < 0x1p40))
        place[0] = place[1] = 0;
}

/* A whole number of texels, in [0, n). */
size_t texel_wrapped(double whole, int n)
{
    return (size_t)(whole >= 0 && whole < n ? whole : whole - n * floor(whole / n));
}

static double mix(double a, double b, double share)
{
    return a + (b - a) * share;
}

/* The value of the texture at a place: the nearest texel, or a mix of four. */
double texel_at(const struct texels *texels, const double place[2])
{
    double offset = texels->linear ? 0.5 : 0, x = place[0] - offset, y = place[1] - offset;
    const size_t width = (size_t)texels->width, left = texel_wrapped(floor(x), texels->width),
                 right = texel_wrapped(floor(x) + 1, texels->width);
    const float *low = texels->values + width * texel_wrapped(floor(y), texels->height),
                *high = texels->values + width * texel_wrapped(floor(y) + 1, texels->height);
    if (!texels->linear)
        return (double)low[left];
    return mix(mix((double)low[left], (double)low[right], x - floor(x)),
               mix((double)high[left], (double)high[right], x - floor(x)), y - floor(y));
}
