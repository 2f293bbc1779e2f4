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
/* A rule that leaves more is not the driver's: then its levels of detail may be any that the
 * specification allows. One that leaves less than roundings do may still be off by as much. */
static const double most_detail = 0.02, least_detail = 1e-4;
/* A depth has 24 bits: it is cut off or rounded to a step, and may round once before. */
static const double most_depth_steps = 1.5;
/* Single operations are accurate to about 1 part in 10^5 (section 2.1.1), which is 168 roundings;
 * bounds of lighting count at least 6 roundings. */
static const double most_lighting = 16;

/* ---- what was measured, in words ---- */

static const char *const side_names[SIDES] = {"left", "right", "top", "bottom"};

enum { ROWS = 13 };
/* A row of the table of traits. */
struct trait {
    const char *name, *allowed; /* by the specification, or by what bounds can cover */
    bool is_allowed;
    char measured[96];
};

static void add_row(struct trait **next, const char *name, const char *allowed, bool is_allowed,
                    const char *format, ...) PRINTF_LIKE(5, 6);
static void add_row(struct trait **next, const char *name, const char *allowed, bool is_allowed,
                    const char *format, ...)
{
    struct trait *row = (*next)++;
    va_list values;
    va_start(values, format);
    vsnprintf(row->measured, sizeof row->measured, format, values);
    va_end(values);
    row->name = name;
    row->allowed = allowed;
    row->is_allowed = is_allowed;
}

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

/* Normals, their product with the light, and its length: see eye_normal and cosine_between. */
static const double roundings_of_normals = 26;

/* Returns how many times Mesa's the bounds of lighting are, where errors are so many times them. A
 * measured maximum is not the largest there is: twice as much, as a power of two. */
static double lighting_of(double ratio)
{
    double factor = 1;
    while (factor < 2 * ratio && ratio > 0.9 && factor <= most_lighting)
        factor *= 2;
    return factor;
}

static double largest_depth_error(const struct traits *traits)
{
    return fmax(-traits->depth_low, traits->depth_high);
}

static void describe_traits(const struct traits *of, struct trait row[ROWS])
{
    static const char *const corners[3] = {"first", "second", "last"};
    static const char *const logarithms[3] = {"exact", "linear", "256 steps"};
    const struct detail_rule *rule = &of->detail;
    const char *corner = rule->lower   ? rule->right ? "lower right" : "lower left"
                         : rule->right ? "upper right"
                                       : "upper left";
    char sides[64] = "";
    for (size_t i = 0, length = 0; i < SIDES; i++)
        if (of->draws[i])
            length += (size_t)snprintf(sides + length, sizeof sides - length, "%s%s",
                                       length ? ", " : "", side_names[i]);
    add_row(&row, "edges", "1/16", of->edge_px <= most_px,
            "off by %.3g pixel (GL_SUBPIXEL_BITS %d)", of->edge_px, of->subpixel_bits);
    add_row(&row, "centres on edges", "any rule", true, "%s; %ld of %ld not so", sides,
            of->odd_centres, of->centres);
    add_row(&row, "shared edges", "0, 0", true, "%ld holes, %ld doubles in %ld pixels", of->holes,
            of->doubles, of->shared_pixels);
    add_row(&row, "without area", "no rule", true, "%ld pixels, %ld not finite, %ld shown",
            of->sliver_pixels, of->undefined_pixels, of->shown_pixels);
    add_row(&row, "depth", "-1.5 to 1.5 of 24 bits", largest_depth_error(of) <= most_depth_steps,
            "%+.2f to %+.2f steps (GL_DEPTH_BITS %d)", of->depth_low, of->depth_high,
            of->depth_bits);
    add_row(&row, "flat colour", "last", of->provoking == 2, "of the %s corner",
            corners[of->provoking]);
    add_row(&row, "colours above 1", "kept", !of->clamps, "%s", of->clamps ? "clamped" : "kept");
    add_row(&row, "values in triangles", "1/16", of->value_px <= most_px,
            "as of corners off by %.2g pixel", of->value_px);
    add_row(&row, "linear filtering", "no rule; bounded to 1/16",
            of->filter_texels <= most_filter_texels, "weights off by %.3g", of->filter_texels);
    add_row(&row, "level of detail", "any rule, twice the same", of->detail_changes == 0,
            "%s, %s, %s: off by %.1g", corner, of->detail.largest ? "component" : "length",
            logarithms[of->detail.logarithm], of->detail_residual);
    add_row(&row, "highlights", "1e-05 an operation", lighting_of(of->power_ratio) <= most_lighting,
            "off by %.2g, %.2g of the bound of Mesa's", of->power_error, of->power_ratio);
    add_row(&row, "normals", "1e-05 an operation",
            lighting_of(of->normal_roundings / roundings_of_normals) <= most_lighting,
            "off by %.2g roundings", of->normal_roundings);
    add_row(&row, "flat and lit passes", "0", of->varying_pixels == 0, "%ld of %ld pixels differ",
            of->varying_pixels, of->seen_pixels);
}

void traits_print(const struct traits *of, struct printed *to)
{
    struct trait rows[ROWS];
    describe_traits(of, rows);
    print(to, "  %-24s %-44s %s\n", "measured", "", "allowed");
    for (int i = 0; i < ROWS; i++)
        print(to, "    %-22s %-44s %s\n", rows[i].name, rows[i].measured, rows[i].allowed);
}

/* ---- the profile ---- */

bool traits_profile(const struct traits *traits, struct driver *out, struct error *err)
{
    const struct driver *most = driver_of(NULL);
    struct trait rows[ROWS];
    *out = *most;
    describe_traits(traits, rows);
    for (int i = 0; i < ROWS; i++)
        if (!rows[i].is_allowed)
            return error_failed(err, "%s: %s; allowed: %s", rows[i].name, rows[i].measured,
                                rows[i].allowed);
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
    if (traits->detail_residual <= most_detail) {
        out->detail = traits->detail;
        out->detail_error = fmax(2 * traits->detail_residual, least_detail);
    }
    out->lighting =
        lighting_of(fmax(traits->power_ratio, traits->normal_roundings / roundings_of_normals));
    out->watertight = traits->holes == 0 && traits->doubles == 0;
    const bool *draws = traits->draws, left_bottom = draws[SIDE_LEFT] && draws[SIDE_BOTTOM] &&
                                                     !draws[SIDE_RIGHT] && !draws[SIDE_TOP] &&
                                                     traits->odd_centres == 0;
    out->fill_rule = left_bottom && out->grid_px <= 1.0 / 512 ? FILL_LEFT_BOTTOM : FILL_ANY;
    return true;
}

/* ---- as JSON ---- */

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
    json_number(json, "detail_error", traits->detail_residual);
    json_count(json, "pixels_that_vary_in_detail", (uint64_t)traits->detail_changes);
    json_number(json, "highlight_error", traits->power_error);
    json_number(json, "normal_roundings", traits->normal_roundings);
    json_count(json, "pixels_that_vary_between_passes", (uint64_t)traits->varying_pixels);
    json_count(json, "subpixel_bits", (uint64_t)traits->subpixel_bits);
    json_close(json, '}');
}
