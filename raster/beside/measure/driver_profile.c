/* SPDX-License-Identifier: MIT */
/* Compares measurements with the specification of OpenGL 2.1, and makes the profile of a driver. */
#include <math.h>
#include <stdarg.h>

#include "raster/beside/measure/inside.h"

/* GL_SUBPIXEL_BITS is at least 4 (table 6.31): a grid of 1/16 pixel. */
static const double most_px = 1.0 / 16;
/* The specification gives weights of linear filtering no accuracy. Coarser ones than this show as
 * steps to the eye. */
static const double most_filter_texels = 1.0 / 16;
/* A depth has 24 bits: it is cut off or rounded to a step, and may round once before. */
static const double most_depth_steps = 1.5;
/* Single operations are accurate to about 1 part in 10^5 (section 2.1.1), which is 168 roundings;
 * bounds of lighting count at least 6 roundings. */
static const double most_lighting = 16;

/* ---- the profile ---- */

/* The least power of two that is not smaller; 0 where single precision explains the error. */
static double grid_of(double measured, double by_roundings)
{
    double grid = most_px;
    if (measured <= by_roundings)
        return 0;
    while (grid / 2 >= measured)
        grid /= 2;
    return grid;
}

/* A measured maximum is not the largest there is: twice as much, as a power of two. */
static double lighting_of(const struct traits *traits)
{
    /* normals, their product with the light, and its length: see eye_normal and cosine_between */
    static const double roundings_of_normals = 26;
    const double ratio = fmax(traits->power_ratio, traits->normal_roundings / roundings_of_normals);
    double factor = 1;
    while (factor < 2 * ratio && ratio > 0.9 && factor <= most_lighting)
        factor *= 2;
    return factor;
}

static double largest_depth_error(const struct traits *traits)
{
    return fmax(-traits->depth_low, traits->depth_high);
}

/* Refuses what breaks the specification in a way that no bound covers. */
static bool check_traits(const struct traits *of, struct error *err)
{
    const double depth = largest_depth_error(of);
    return (of->edge_px <= most_px ||
            error_failed(err, "it draws edges off by %.3g pixel; at most 1/16 is allowed",
                         of->edge_px)) &&
           (depth <= most_depth_steps ||
            error_failed(err,
                         "it stores depths off by %.4g steps of 24 bits; at most %g are allowed",
                         depth, most_depth_steps)) &&
           (of->provoking == 2 ||
            error_failed(err,
                         "it takes the colour of a flat triangle from corner %d; "
                         "the last one is required",
                         of->provoking + 1)) &&
           (!of->clamps ||
            error_failed(err, "it clamps colours although clamps are switched off")) &&
           (of->varying_pixels == 0 ||
            error_failed(
                err,
                "its passes do not show the same triangles: %ld of %ld pixels differ between "
                "flat and lit ones",
                of->varying_pixels, of->seen_pixels)) &&
           (of->value_px <= most_px ||
            error_failed(
                err,
                "it interpolates values as if corners were off by %.3g pixel; at most 1/16 is "
                "allowed",
                of->value_px)) &&
           (of->filter_texels <= most_filter_texels ||
            error_failed(err,
                         "its weights of linear filtering are off by %.3g; at most 1/16 is bounded",
                         of->filter_texels)) &&
           (lighting_of(of) <= most_lighting ||
            error_failed(
                err,
                "its lighting is off by %.3g of a highlight and %.3g roundings of a cosine; 1 "
                "part in 100000 is allowed",
                of->power_error, of->normal_roundings));
}

bool traits_profile(const struct traits *traits, struct driver *out, struct error *err)
{
    const struct driver *most = driver_of(NULL);
    *out = *most;
    if (!check_traits(traits, err))
        return false;
    out->name = "measured";
    out->is_measured = true;
    out->grid_px = grid_of(traits->edge_px, roundings(most->edge_roundings) * TARGET);
    /* The depths that were measured are exact in single precision; others round before. A step of
     * 24 bits is as large as a rounding of 1. */
    out->depth_roundings = ceil(2 * largest_depth_error(traits)) / 2 + 0.5;
    /* The values that were measured change by at least 1 across the target, and lie below 1. Their
     * planes round at the origin, a target away, and in two sums: 8 roundings each, a few more of
     * the set-up. */
    out->corner_px = grid_of(traits->value_px, roundings(16) * 3 * TARGET);
    out->filter_texels = grid_of(traits->filter_texels, roundings(32));
    out->lighting = lighting_of(traits);
    out->watertight = traits->holes == 0 && traits->doubles == 0;
    const bool *draws = traits->draws, left_bottom = draws[SIDE_LEFT] && draws[SIDE_BOTTOM] &&
                                                     !draws[SIDE_RIGHT] && !draws[SIDE_TOP] &&
                                                     traits->odd_centres == 0;
    out->fill_rule = left_bottom && out->grid_px <= 1.0 / 512 ? FILL_LEFT_BOTTOM : FILL_ANY;
    return true;
}

/* ---- the table ---- */

static const char *const side_names[SIDES] = {"left", "right", "top", "bottom"};

/* One row: a trait, its measurement, and the rule. */
static void print_row(struct printed *to, const char *trait, const char *allowed,
                      const char *format, ...) PRINTF_LIKE(4, 5);
static void print_row(struct printed *to, const char *trait, const char *allowed,
                      const char *format, ...)
{
    char measured[128];
    va_list values;
    va_start(values, format);
    vsnprintf(measured, sizeof measured, format, values);
    va_end(values);
    print(to, "    %-22s %-44s %s\n", trait, measured, allowed);
}

void traits_print(const struct traits *of, struct printed *to)
{
    static const char *const corners[3] = {"first", "second", "last"};
    char sides[64] = "";
    for (size_t i = 0, length = 0; i < SIDES; i++)
        if (of->draws[i])
            length += (size_t)snprintf(sides + length, sizeof sides - length, "%s%s",
                                       length ? ", " : "", side_names[i]);
    print(to, "  %-24s %-44s %s\n", "measured", "", "allowed");
    print_row(to, "edges", "1/16", "off by %.3g pixel (GL_SUBPIXEL_BITS %d)", of->edge_px,
              of->subpixel_bits);
    print_row(to, "centres on edges", "any rule", "%s; %ld of %ld not so", sides, of->odd_centres,
              of->centres);
    print_row(to, "shared edges", "0, 0", "%ld holes, %ld doubles in %ld pixels", of->holes,
              of->doubles, of->shared_pixels);
    print_row(to, "without area", "no rule", "%ld pixels, %ld not finite, %ld shown",
              of->sliver_pixels, of->undefined_pixels, of->shown_pixels);
    print_row(to, "depth", "-1.5 to 1.5 of 24 bits", "%+.2f to %+.2f steps (GL_DEPTH_BITS %d)",
              of->depth_low, of->depth_high, of->depth_bits);
    print_row(to, "flat colour", "last", "of the %s corner", corners[of->provoking]);
    print_row(to, "colours above 1", "kept", "%s", of->clamps ? "clamped" : "kept");
    print_row(to, "values in triangles", "1/16", "as of corners off by %.2g pixel", of->value_px);
    print_row(to, "linear filtering", "no rule", "weights off by %.3g", of->filter_texels);
    print_row(to, "highlights", "1e-05 an operation", "off by %.2g, %.2g of the bound of Mesa's",
              of->power_error, of->power_ratio);
    print_row(to, "normals", "1e-05 an operation", "off by %.2g roundings", of->normal_roundings);
    print_row(to, "flat and lit passes", "0", "%ld of %ld pixels differ", of->varying_pixels,
              of->seen_pixels);
}

void traits_json(const struct traits *traits, struct json *json)
{
    json_open(json, "traits", '{');
    json_number(json, "edge_px", traits->edge_px);
    json_open(json, "fill_rule", '[');
    for (int i = 0; i < SIDES; i++)
        if (traits->draws[i])
            json_string(json, NULL, side_names[i]);
    json_close(json, ']');
    json_count(json, "centres_on_edges", (uint64_t)traits->centres);
    json_count(json, "centres_against_rule", (uint64_t)traits->odd_centres);
    json_count(json, "shared_edge_pixels", (uint64_t)traits->shared_pixels);
    json_count(json, "edge_holes", (uint64_t)traits->holes);
    json_count(json, "edge_doubles", (uint64_t)traits->doubles);
    json_count(json, "sliver_pixels", (uint64_t)traits->sliver_pixels);
    json_count(json, "sliver_pixels_not_finite", (uint64_t)traits->undefined_pixels);
    json_count(json, "sliver_pixels_shown", (uint64_t)traits->shown_pixels);
    json_number(json, "depth_steps_low", traits->depth_low);
    json_number(json, "depth_steps_high", traits->depth_high);
    json_count(json, "provoking_corner", (uint64_t)traits->provoking + 1);
    json_truth(json, "clamps_colours", traits->clamps);
    json_number(json, "value_px", traits->value_px);
    json_number(json, "filter_texels", traits->filter_texels);
    json_number(json, "highlight_error", traits->power_error);
    json_number(json, "normal_roundings", traits->normal_roundings);
    json_count(json, "pixels_that_vary_between_passes", (uint64_t)traits->varying_pixels);
    json_count(json, "subpixel_bits", (uint64_t)traits->subpixel_bits);
    json_close(json, '}');
}
