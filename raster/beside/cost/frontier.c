/* SPDX-License-Identifier: MIT */
/* The chart of error over cost: steps join the points of the frontier, which no cheaper point
 * beats, and a legend names them. */
#include <math.h>

#include "raster/beside/cost/inside.h"

/* Points that the chart marks alike; bars have three for each configuration. */
struct marks {
    const char *names[MOST_CONFIGURATIONS];
    double seconds[3 * MOST_CONFIGURATIONS], errors[3 * MOST_CONFIGURATIONS];
    int n;
};

static void mark(struct marks *marks, double seconds, double error)
{
    marks->seconds[marks->n] = seconds;
    marks->errors[marks->n++] = error;
}

static struct chart_series series_of(const char *name, enum chart_kind kind,
                                     const struct marks *marks)
{
    return (struct chart_series){
        .name = name, .kind = kind, .n = marks->n, .x = marks->seconds, .y = marks->errors};
}

void cost_svg(const struct cost *cost, struct printed *to)
{
    struct marks best = {.n = 0}, others = {.n = 0}, uncertain = {.n = 0}, bars = {.n = 0};
    double largest = 0;
    char title[512], label[96];
    for (int i = 0; i < cost->n; i++)
        largest = fmax(largest, cost->entries[i].accuracy.quantile_95);
    const double least = largest > 0 ? largest / 1000 : 1;
    for (int i = 0; i < cost->n; i++) {
        const struct cost_entry *entry = &cost->entries[i];
        const double error = fmax(entry->accuracy.quantile_95, least);
        best.names[best.n] = entry->name;
        mark(entry->best ? &best : &others, entry->seconds, error);
        if (entry->uncertain)
            mark(&uncertain, entry->seconds, error);
        mark(&bars, entry->fastest, error);
        mark(&bars, entry->slowest, error);
        mark(&bars, (double)NAN, error);
    }
    struct chart_series series[] = {
        series_of("on the frontier", CHART_STEPS, &best),
        series_of("not on it", CHART_CIRCLES, &others),
        series_of("either, within noise", CHART_RINGS, &uncertain),
        series_of("from the fastest run to the slowest", CHART_BARS, &bars)};
    series[0].labels = best.names;
    snprintf(title, sizeof title, "%s, %d x %d pixels, %s", cost->scene, cost->width, cost->height,
             cost->observer);
    snprintf(label, sizeof label, "CIEDE2000, 95 %% of the pixels (%.2g: this or less)", least);
    const struct chart chart = {.title = title,
                                .x_label = "seconds",
                                .y_label = label,
                                .logarithmic = true,
                                .series = series,
                                .n = 4};
    chart_svg(&chart, to);
}
