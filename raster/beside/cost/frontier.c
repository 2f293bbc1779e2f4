/* SPDX-License-Identifier: MIT */
/* The chart of error over cost: steps join the points of the frontier, which no cheaper point
 * beats, and a legend names them. */
#include <math.h>

#include "raster/beside/cost/inside.h"

/* Configurations that the chart marks alike. */
struct marks {
    const char *names[MOST_CONFIGURATIONS];
    double seconds[MOST_CONFIGURATIONS], fastest[MOST_CONFIGURATIONS], slowest[MOST_CONFIGURATIONS],
        errors[MOST_CONFIGURATIONS];
    int n;
};

static void mark(struct marks *marks, const struct cost_entry *entry, double error)
{
    const int i = marks->n++;
    marks->names[i] = entry->name;
    marks->seconds[i] = entry->seconds;
    marks->fastest[i] = entry->fastest;
    marks->slowest[i] = entry->slowest;
    marks->errors[i] = error;
}

static struct chart_series series_of(const char *name, enum chart_kind kind,
                                     const struct marks *marks)
{
    return (struct chart_series){.name = name,
                                 .kind = kind,
                                 .n = marks->n,
                                 .x = marks->seconds,
                                 .y = marks->errors,
                                 .low = marks->fastest,
                                 .high = marks->slowest,
                                 .across = true};
}

void cost_svg(const struct cost *cost, struct printed *to)
{
    struct marks best = {.n = 0}, others = {.n = 0}, uncertain = {.n = 0};
    double largest = 0;
    char title[512], label[96];
    for (int i = 0; i < cost->n; i++)
        largest = fmax(largest, cost->entries[i].accuracy.quantile_95);
    const double least = largest > 0 ? largest / 1000 : 1;
    for (int i = 0; i < cost->n; i++) {
        const struct cost_entry *entry = &cost->entries[i];
        const double error = fmax(entry->accuracy.quantile_95, least);
        mark(entry->best ? &best : &others, entry, error);
        if (entry->uncertain)
            mark(&uncertain, entry, error);
    }
    struct chart_series series[] = {series_of("on the frontier", CHART_STEPS, &best),
                                    series_of("not on it", CHART_CIRCLES, &others),
                                    series_of("either, within noise", CHART_RINGS, &uncertain)};
    series[0].labels = best.names;
    series[2].low = NULL; /* the points below the rings have bars */
    snprintf(title, sizeof title, "%s, %d x %d pixels, %s", cost->scene, cost->width, cost->height,
             cost->observer);
    snprintf(label, sizeof label, "CIEDE2000, 95 %% of the pixels (%.2g: this or less)", least);
    const struct chart chart = {.title = title,
                                .x_label = "seconds",
                                .y_label = label,
                                .logarithmic = true,
                                .series = series,
                                .n = 3};
    chart_svg(&chart, to);
}
