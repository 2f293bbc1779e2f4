/* SPDX-License-Identifier: MIT */
/* Bounds OpenGL's errors in a texture. OpenGL turns a coordinate s into texels by scale, offset and
 * wrapping (4 roundings relative to s x width or to the width), finds weights exactly, and mixes
 * four texels. */
#include <float.h>
#include <math.h>

#include "raster/bounds/bounds.h"

/* Three mixes of two values, each a difference, a product and a sum. */
enum { MIX_ROUNDINGS = 9 };
/* Bounds wider than this many texels take in the whole texture. Within them lie twice as many
 * texels, one for either end, and a neighbour; one more if an end is rounded. */
enum { WIDEST_BOUND = 3, MOST_TEXELS = 2 * WIDEST_BOUND + 4 };

float texel_weights_error(const struct texels *texels, const struct driver *driver)
{
    return texels->linear ? (float)(4 * driver->filter_texels) : 0;
}

/* Extrapolated far outside a thin triangle, a place may be anywhere. A place whose texel the
 * reference does not know has no bound. */
struct texel_point texel_point(const struct texels *texels, const struct driver *driver,
                               const double s_t[2], const float e_s_t[2])
{
    const double size[2] = {texels->width, texels->height},
                 filter = texels->linear ? driver->filter_texels : 0;
    struct texel_point at = {.e_weights = texel_weights_error(texels, driver)};
    texel_place(texels, s_t, at.place);
    for (int i = 0; i < 2; i++)
        at.e_place[i] = fabs(s_t[0] * size[0]) < 0x1p40 && fabs(s_t[1] * size[1]) < 0x1p40
                            ? (float)fmin((double)FLT_MAX,
                                          filter + size[i] * ((double)e_s_t[i] +
                                                              roundings(4) * (1 + fabs(s_t[i]))))
                            : FLT_MAX;
    return at;
}

/* Texels along one direction. */
struct span {
    double first; /* whole */
    int n;
};

static struct span span_of(double low, double high)
{
    return (struct span){floor(low), (int)(floor(high) - floor(low)) + 1};
}

int texel_choices(const struct texels *texels, const struct texel_point *at,
                  struct texel_point out[TEXEL_CHOICES])
{
    double e_u = (double)at->e_place[0], e_v = (double)at->e_place[1];
    out[0] = *at;
    if (texels->linear || e_u >= 0.5 || e_v >= 0.5)
        return 1;
    struct span across = span_of(at->place[0] - e_u, at->place[0] + e_u),
                up = span_of(at->place[1] - e_v, at->place[1] + e_v);
    for (int j = 0; j < up.n; j++)
        for (int i = 0; i < across.n; i++)
            out[j * across.n + i] =
                (struct texel_point){.place = {across.first + i + 0.5, up.first + j + 0.5}};
    return up.n * across.n;
}

/* The largest differences of neighbouring texels in a patch, and its largest texel. */
struct spread {
    double across, up, largest;
};

/* For numbers only: fmax also handles NaN, at the price of a call. */
static double larger(double a, double b)
{
    return a > b ? a : b;
}

static struct spread spread_of(const struct texels *texels, const struct span *across,
                               const struct span *up)
{
    struct spread out = {0, 0, 0};
    size_t column[MOST_TEXELS];
    const float *below = NULL;
    for (int i = 0; i < across->n; i++)
        column[i] = texel_wrapped(across->first + i, texels->width);
    for (int j = 0; j < up->n; j++) {
        const float *row =
            texels->values + (size_t)texels->width * texel_wrapped(up->first + j, texels->height);
        for (int i = 0; i < across->n; i++) {
            double here = (double)row[column[i]];
            out.largest = larger(out.largest, here);
            if (i > 0)
                out.across = larger(out.across, fabs(here - (double)row[column[i - 1]]));
            if (j > 0)
                out.up = larger(out.up, fabs(here - (double)below[column[i]]));
        }
        below = row;
    }
    return out;
}

/* Between texel centres the value changes by at most the largest difference of neighbours per
 * texel; from one nearest texel to another by as many differences as lie between them. */
static double error_in_patch(const struct texels *texels, const struct texel_point *at,
                             double largest)
{
    double offset = texels->linear ? 0.5 : 0, x = at->place[0] - offset, y = at->place[1] - offset;
    double e_u = (double)at->e_place[0], e_v = (double)at->e_place[1];
    if (e_u > WIDEST_BOUND || e_v > WIDEST_BOUND)
        return largest;
    struct span across = span_of(x - e_u, x + e_u), up = span_of(y - e_v, y + e_v);
    if (!texels->linear && across.n == 1 && up.n == 1)
        return 0;
    across.n += texels->linear;
    up.n += texels->linear;
    struct spread spread = spread_of(texels, &across, &up);
    return texels->linear
               ? e_u * spread.across + e_v * spread.up + roundings(MIX_ROUNDINGS) * spread.largest +
                     (double)at->e_weights * (spread.across + spread.up) / 2
               : (across.n - 1) * spread.across + (up.n - 1) * spread.up;
}

/* Fills in the slope at parts u and v of the way between four texel centres. The texels make
 * a + b u + c v + d u v. */
static void find_slope(const struct texels *texels, const struct texel_point *at,
                       const double u_v[2], struct texel_value *out)
{
    const double x = floor(at->place[0] - 0.5), y = floor(at->place[1] - 0.5),
                 e_u = (double)at->e_place[0], e_v = (double)at->e_place[1];
    const size_t width = (size_t)texels->width, left = texel_wrapped(x, texels->width),
                 right = texel_wrapped(x + 1, texels->width);
    const float *low = texels->values + width * texel_wrapped(y, texels->height),
                *high = texels->values + width * texel_wrapped(y + 1, texels->height);
    const double a = (double)low[left], b = (double)low[right] - a, c = (double)high[left] - a,
                 d = (double)high[right] - (double)high[left] - b,
                 largest = larger(larger(a, a + b), larger(a + c, (double)high[right])),
                 least = -larger(larger(-a, -a - b), larger(-a - c, -(double)high[right]));
    out->across = b + d * u_v[1];
    out->up = c + d * u_v[0];
    out->rest = fabs(d) * e_u * e_v + roundings(MIX_ROUNDINGS) * largest +
                (double)at->e_weights * (largest - least) / 2;
    out->error = fabs(out->across) * e_u + fabs(out->up) * e_v + out->rest;
}

void texel_value(const struct texels *texels, const struct texel_point *at, double largest,
                 struct texel_value *out)
{
    const double x = at->place[0] - 0.5, y = at->place[1] - 0.5,
                 u_v[2] = {x - floor(x), y - floor(y)}, e_u = (double)at->e_place[0],
                 e_v = (double)at->e_place[1];
    out->value = texel_at(texels, at->place);
    out->is_straight =
        texels->linear && u_v[0] >= e_u && u_v[0] + e_u <= 1 && u_v[1] >= e_v && u_v[1] + e_v <= 1;
    if (out->is_straight)
        find_slope(texels, at, u_v, out);
    else
        out->error = error_in_patch(texels, at, largest);
}
