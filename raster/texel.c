/* SPDX-License-Identifier: MIT */
/* A texture at a point, as OpenGL 2.1, section 3.8.8, defines it, in double; and how far OpenGL's
 * single precision may be off.
 *
 * OpenGL turns a coordinate s into texels by scale, offset and wrapping (4 roundings relative to
 * s x width or to the width), finds weights exactly, and mixes four texels. u = 2^-24. */
#include <float.h>
#include <math.h>

#include "raster/raster.h"

static const double u = 1.0 / 16777216;

/* Three mixes of two values, each a difference, a product and a sum. */
enum { MIX_ROUNDINGS = 9 };
/* Bounds wider than this many texels take in the whole texture. Within them lie twice as many
 * texels, one for either end, and a neighbour; one more if an end is rounded. */
enum { WIDEST_BOUND = 3, MOST_TEXELS = 2 * WIDEST_BOUND + 4 };

/* Extrapolated far outside a thin triangle, a place may be anywhere: beyond 2^40 texels no texel is
 * known any more. */
struct texel_point texel_point(const struct texture *texture, double s, double t, float e_s,
                               float e_t)
{
    double width = texture->image.width, height = texture->image.height;
    struct texel_point at = {
        .u = s * width,
        .v = t * height,
        .e_u = (float)fmin((double)FLT_MAX, width * ((double)e_s + 4 * u * (1 + fabs(s)))),
        .e_v = (float)fmin((double)FLT_MAX, height * ((double)e_t + 4 * u * (1 + fabs(t))))};
    if (fabs(at.u) < 0x1p40 && fabs(at.v) < 0x1p40)
        return at;
    return (struct texel_point){0, 0, FLT_MAX, FLT_MAX};
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

int texel_choices(const struct texture *texture, struct texel_point at,
                  struct texel_point out[TEXEL_CHOICES])
{
    double e_u = (double)at.e_u, e_v = (double)at.e_v;
    out[0] = at;
    if (texture->linear || e_u >= 0.5 || e_v >= 0.5)
        return 1;
    struct span across = span_of(at.u - e_u, at.u + e_u), up = span_of(at.v - e_v, at.v + e_v);
    for (int j = 0; j < up.n; j++)
        for (int i = 0; i < across.n; i++)
            out[j * across.n + i] =
                (struct texel_point){across.first + i + 0.5, up.first + j + 0.5, 0, 0};
    return up.n * across.n;
}

/* In [0, n). */
static size_t wrapped(double whole, int n)
{
    if (whole >= 0 && whole < n)
        return (size_t)whole;
    return (size_t)(whole - n * floor(whole / n));
}

/* The texels that a point may touch: all within its bounds, and between texels their neighbours. */
struct patch {
    struct span across, up;
    double value[MOST_TEXELS][MOST_TEXELS]; /* [up][across] */
};

static void fetch(const struct texture *texture, int plane, struct patch *patch)
{
    size_t width = (size_t)texture->image.width;
    for (int j = 0; j < patch->up.n; j++) {
        const float *row =
            texture->plane[plane] + width * wrapped(patch->up.first + j, texture->image.height);
        for (int i = 0; i < patch->across.n; i++)
            patch->value[j][i] =
                (double)row[wrapped(patch->across.first + i, texture->image.width)];
    }
}

static double mix(double a, double b, double share)
{
    return a + (b - a) * share;
}

/* At a point in texels from the patch's first texel, or its centre where texels are mixed. */
static double value_at(const struct patch *patch, bool linear, double x, double y)
{
    int i = (int)x, j = (int)y;
    const double *low = patch->value[j] + i, *high = patch->value[j + linear] + i;
    return linear ? mix(mix(low[0], low[1], x - i), mix(high[0], high[1], x - i), y - j) : low[0];
}

/* How much neighbouring texels of a patch differ, and the largest of them. */
struct spread {
    double across, up, largest;
};

static struct spread spread_of(const struct patch *patch)
{
    struct spread out = {0, 0, 0};
    for (int j = 0; j < patch->up.n; j++)
        for (int i = 0; i < patch->across.n; i++) {
            double here = patch->value[j][i];
            out.largest = fmax(out.largest, here);
            if (i > 0)
                out.across = fmax(out.across, fabs(here - patch->value[j][i - 1]));
            if (j > 0)
                out.up = fmax(out.up, fabs(here - patch->value[j - 1][i]));
        }
    return out;
}

/* Between texel centres the value changes by at most the largest difference of neighbours per
 * texel; from one nearest texel to another by as many differences as lie between them. */
double texel_value(const struct texture *texture, int plane, struct texel_point at, double *error)
{
    double offset = texture->linear ? 0.5 : 0, x = at.u - offset, y = at.v - offset;
    double e_u = (double)at.e_u, e_v = (double)at.e_v;
    bool wide = e_u > WIDEST_BOUND || e_v > WIDEST_BOUND;
    double reach_u = wide ? 0 : e_u, reach_v = wide ? 0 : e_v;
    struct patch patch;
    patch.across = span_of(x - reach_u, x + reach_u);
    patch.up = span_of(y - reach_v, y + reach_v);
    patch.across.n += texture->linear;
    patch.up.n += texture->linear;
    fetch(texture, plane, &patch);
    if (error) {
        struct spread spread = spread_of(&patch);
        *error = wide ? texture->largest
                 : texture->linear
                     ? e_u * spread.across + e_v * spread.up + MIX_ROUNDINGS * u * spread.largest
                     : (patch.across.n - 1) * spread.across + (patch.up.n - 1) * spread.up;
    }
    return value_at(&patch, texture->linear, x - patch.across.first, y - patch.up.first);
}
