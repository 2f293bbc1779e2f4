/* SPDX-License-Identifier: MIT */
/* The differences of two stacks as JSON. */
#include "raster/beside/see/inside.h"

static void json_band(struct json *json, const struct band_difference *band)
{
    json_number(json, "largest", band->largest);
    json_count(json, "x", (uint64_t)band->x);
    json_count(json, "y", (uint64_t)band->y);
    json_number(json, "rms", band->rms);
}

static void json_pixels(struct json *json, const char *name,
                        const struct pixel_difference *difference)
{
    json_open(json, name, '{');
    json_number(json, "mean", difference->mean);
    json_number(json, "quantile_95", difference->quantile_95);
    json_number(json, "largest", difference->largest);
    json_count(json, "x", (uint64_t)difference->x);
    json_count(json, "y", (uint64_t)difference->y);
    json_close(json, '}');
}

void comparison_json(const struct comparison *comparison, bool within, struct json *json)
{
    static const char *const measures[] = {"angle_deg", "dE76", "dE94", "dE00"};
    json_begin(json);
    json_truth(json, "within_tolerance", within);
    json_count(json, "width", (uint64_t)comparison->width);
    json_count(json, "height", (uint64_t)comparison->height);
    json_numbers(json, "wavelengths_nm", comparison->components ? NULL : comparison->wavelengths_nm,
                 comparison->n);
    json_band(json, &comparison->all);
    json_number(json, "largest_of_A", comparison->largest_radiance);
    json_string(json, "observer", comparison->has_white ? comparison->observer : NULL);
    for (int i = 0; i < (comparison->has_white ? PIXEL_MEASURES : 1); i++)
        json_pixels(json, measures[i], &comparison->pixels[i]);
    json_open(json, "bands", '[');
    for (int i = 0; i < comparison->n; i++) {
        json_open(json, NULL, '{');
        json_band(json, &comparison->bands[i]);
        json_close(json, '}');
    }
    json_close(json, ']');
}
