/* SPDX-License-Identifier: MIT */
/* A texture at a point (OpenGL 2.1 specification, section 3.8.8). Places are in texels, from the
 * lower left corner of the texture; texel centres lie at half-integers. A pyramid of levels, each
 * half as wide and high as the one before (Williams 1983), serves a texture that is seen from afar.
 */
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

struct texels texel_level(const struct texels *texels, int level)
{
    struct texels out = *texels;
    for (int k = 0; k < level; k++) {
        out.values += (size_t)out.width * (size_t)out.height;
        out.width = out.width > 1 ? out.width / 2 : 1;
        out.height = out.height > 1 ? out.height / 2 : 1;
    }
    return out;
}

/* The value of a level at a place in level 0: the nearest texel, or a mix of four. */
static double level_at(const struct texels *texels, int k, const double place[2])
{
    const struct texels level = texel_level(texels, k);
    double offset = texels->linear ? 0.5 : 0,
           x = place[PLACE_ACROSS] * ((double)level.width / texels->width) - offset,
           y = place[PLACE_UP] * ((double)level.height / texels->height) - offset;
    const size_t width = (size_t)level.width, left = texel_wrapped(floor(x), level.width),
                 right = texel_wrapped(floor(x) + 1, level.width);
    const float *low = level.values + width * texel_wrapped(floor(y), level.height),
                *high = level.values + width * texel_wrapped(floor(y) + 1, level.height);
    if (!texels->linear)
        return (double)low[left];
    return mix(mix((double)low[left], (double)low[right], x - floor(x)),
               mix((double)high[left], (double)high[right], x - floor(x)), y - floor(y));
}

/* The value of the texture; with mipmaps, a mix of two levels. */
double texel_at(const struct texels *texels, const double place[TEXEL_PLACE])
{
    const int k = texels->n_levels > 1 ? (int)place[PLACE_DETAIL] : 0;
    const double share = texels->n_levels > 1 ? place[PLACE_DETAIL] - k : 0;
    const double value = level_at(texels, k, place);
    return share > 0 ? mix(value, level_at(texels, k + 1, place), share) : value;
}

int place_rows(const struct texels *texels)
{
    return texels->n_levels > 1 ? TEXEL_PLACE : 2;
}
