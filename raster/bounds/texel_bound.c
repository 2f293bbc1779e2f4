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
    if (texels->n_levels > 1) {
        out[1] = *at;
        out[1].place[PLACE_DETAIL] = at->other;
        return at->other == at->place[PLACE_DETAIL] ? 1 : 2;
    }
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
    out->slope[PLACE_ACROSS] = b + d * u_v[1];
    out->slope[PLACE_UP] = c + d * u_v[0];
    out->slope[PLACE_DETAIL] = 0;
    out->rest = fabs(d) * e_u * e_v + roundings(MIX_ROUNDINGS) * largest +
                (double)at->e_weights * (largest - least) / 2;
    out->error =
        fabs(out->slope[PLACE_ACROSS]) * e_u + fabs(out->slope[PLACE_UP]) * e_v + out->rest;
}

/* A texture of one level. */
static void level_value(const struct texels *texels, const struct texel_point *at, double largest,
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

/* ---- mipmaps ---- */

/* The rule is followed in single precision: so many roundings of the steps, and of a logarithm of
 * at most 16. */
enum { STEP_ROUNDINGS = 4, DETAIL_ROUNDINGS = 16 };
/* The specification allows lengths from the largest component to the sum of the largest ones. A
 * logarithm may be linear between powers of two, or come from a table. */
static const double detail_below = 0.045, detail_above = 0.003;
/* The largest step of a table of 256 steps between powers of two, 0.00563, and a little more. */
static const double table_step = 0.0057;

/* The interval of the level of detail for steps from `low` to `high`. */
static void find_range(const struct texels *texels, const struct driver *driver, double low[2][2],
                       double high[2][2], double out[2])
{
    static const struct detail_rule largest = {.largest = true};
    double sum[2][2] = {{fmax(high[0][0], high[1][0]) + fmax(high[0][1], high[1][1])}};
    const bool is_known = driver->detail_error >= 0;
    out[0] = detail_of(is_known ? &driver->detail : &largest, texels->n_levels, low);
    out[1] = is_known ? detail_of(&driver->detail, texels->n_levels, high)
                      : detail_of(&largest, texels->n_levels, sum) + detail_above;
    if (!is_known)
        out[0] -= detail_below;
}

void texel_detail(const struct texels *texels, const struct driver *driver, double steps[2][2],
                  double e_steps[2][2], struct texel_point *at)
{
    double low[2][2], high[2][2], range[2];
    for (int i = 0; i < 2; i++)
        for (int c = 0; c < 2; c++) {
            const double size = fabs(steps[i][c]);
            low[i][c] = fmax(0, size - e_steps[i][c]) * (1 - roundings(STEP_ROUNDINGS));
            high[i][c] = e_steps[i][c] < HUGE_VAL
                             ? (size + e_steps[i][c]) * (1 + roundings(STEP_ROUNDINGS))
                             : HUGE_VAL; /* where the step is no number, too */
        }
    find_range(texels, driver, low, high, range);
    const double detail = detail_of(&driver->detail, texels->n_levels, steps),
                 rounding = fmax(0, driver->detail_error) + roundings(DETAIL_ROUNDINGS),
                 error = fmax(detail - range[0], range[1] - detail);
    const bool is_step = driver->detail.logarithm == LOGARITHM_TABLE && error > 0 &&
                         range[1] - range[0] < table_step,
               is_end = error == 0 && (detail == 0 || detail == texels->n_levels - 1);
    at->place[PLACE_DETAIL] = at->other = detail;
    at->e_place[PLACE_DETAIL] = (float)(is_end ? 0 : (is_step ? 0 : error) + rounding);
    if (is_step)
        at->other = detail > range[0] ? range[0] : range[1];
}

enum { MOST_LEVELS = 16 };

/* The levels that a place may show, each with its value. */
struct levels {
    int first, last;
    struct texel_value values[MOST_LEVELS];
};

/* A level at a place: its errors shrink with its size, but for that of the filter's weights. */
static void value_in(const struct texels *texels, const struct texel_point *at, int k,
                     double largest, struct texel_value *out)
{
    struct texels level = texel_level(texels, k);
    const double share[2] = {(double)level.width / texels->width,
                             (double)level.height / texels->height},
                 filter = (double)at->e_weights / 4;
    struct texel_point there = *at;
    level.n_levels = 1;
    for (int i = 0; i < 2; i++) {
        there.place[i] *= share[i];
        there.e_place[i] = (float)(filter + ((double)at->e_place[i] - filter) * share[i]);
    }
    level_value(&level, &there, largest, out);
    out->slope[PLACE_ACROSS] *= share[PLACE_ACROSS];
    out->slope[PLACE_UP] *= share[PLACE_UP];
}

/* Returns the largest error if OpenGL takes level of detail x. */
static double error_for(const struct levels *of, double x, double value)
{
    const int k = (int)x < of->last ? (int)x : of->last - 1;
    const struct texel_value *fine = &of->values[k - of->first], *coarse = fine + 1;
    const double share = x - k;
    return fabs(fine->value + share * (coarse->value - fine->value) - value) +
           (1 - share) * fine->error + share * coarse->error;
}

/* Between two levels the value is linear in the level of detail, and off by products of errors. */
static void join_slopes(const struct levels *of, const struct texel_point *at,
                        struct texel_value *out)
{
    const struct texel_value *fine = of->values, *coarse = fine + 1;
    const double share = at->place[PLACE_DETAIL] - of->first,
                 e_detail = (double)at->e_place[PLACE_DETAIL];
    out->is_straight = of->last - of->first == 1 && fine->is_straight && coarse->is_straight;
    if (!out->is_straight)
        return;
    out->rest =
        (1 - share) * fine->rest + share * coarse->rest + e_detail * (fine->rest + coarse->rest);
    for (int i = 0; i < 2; i++) {
        out->slope[i] = (1 - share) * fine->slope[i] + share * coarse->slope[i];
        out->rest += e_detail * fabs(coarse->slope[i] - fine->slope[i]) * (double)at->e_place[i];
    }
    out->slope[PLACE_DETAIL] = coarse->value - fine->value;
}

/* The value is continuous and piecewise linear in the level of detail: its error is largest at an
 * end, or at a whole level. */
static void mipmap_value(const struct texels *texels, const struct texel_point *at, double largest,
                         struct texel_value *out)
{
    if (at->e_place[PLACE_DETAIL] == 0) { /* an end of the pyramid */
        value_in(texels, at, (int)at->place[PLACE_DETAIL], largest, out);
        return;
    }
    const double e_detail = (double)at->e_place[PLACE_DETAIL], last = texels->n_levels - 1,
                 low = fmin(fmax(0, at->place[PLACE_DETAIL] - e_detail), last),
                 high = fmin(at->place[PLACE_DETAIL] + e_detail, last);
    struct levels levels = {.first = (int)fmin(floor(low), last - 1)};
    levels.last = (int)fmax(ceil(high), levels.first + 1);
    double most = 0;
    for (int k = levels.first; k <= levels.last; k++) {
        struct texel_value *value = &levels.values[k - levels.first];
        value_in(texels, at, k, largest, value);
        most = larger(most, value->value + value->error);
    }
    const double rounding = roundings(MIX_ROUNDINGS) * most;
    out->value = texel_at(texels, at->place);
    out->error = larger(error_for(&levels, low, out->value), error_for(&levels, high, out->value));
    for (int k = levels.first + 1; k < levels.last; k++)
        out->error = larger(out->error, error_for(&levels, k, out->value));
    out->error += rounding;
    join_slopes(&levels, at, out);
    out->rest += rounding;
}

void texel_value(const struct texels *texels, const struct texel_point *at, double largest,
                 struct texel_value *out)
{
    *out = (struct texel_value){.rest = 0};
    if (texels->n_levels > 1)
        mipmap_value(texels, at, largest, out);
    else
        level_value(texels, at, largest, out);
}
