/* SPDX-License-Identifier: MIT */
/* The chart of error over seconds: steps join the configurations that no cheaper one beats. */
#include "raster/beside/cost/inside.h"

/* Configurations that the chart marks alike. */
struct marks {
    const char *names[MOST_SAMPLINGS];
    double seconds[MOST_SAMPLINGS], errors[MOST_SAMPLINGS];
    int n;
};

static void mark(struct marks *marks, const struct configuration *of, const struct timing *timing,
                 double least)
{
    marks->names[marks->n] = of->words + strlen("--sampling=");
    marks->seconds[marks->n] = median_of(timing);
    marks->errors[marks->n++] = fmax(of->error.quantile_95, least);
}

static struct chart_series series_of(const char *name, enum chart_kind kind,
                                     const struct marks *marks)
{
    return (struct chart_series){.name = name,
                                 .kind = kind,
                                 .n = marks->n,
                                 .x = marks->seconds,
                                 .y = marks->errors,
                                 .labels = marks->names};
}

void cost_svg(const struct cost *cost, struct printed *to)
{
    struct marks best = {.n = 0}, checked = {.n = 0}, components = {.n = 0};
    double largest = 0;
    char title[512], label[96];
    for (int i = 0; i < cost->n; i++)
        largest = fmax(largest, cost->samplings[i].error.quantile_95);
    const double least = largest > 0 ? largest / 1000 : 1;
    for (int i = 0; i < cost->n; i++) {
        const struct configuration *one = &cost->samplings[i];
        if (one->best)
            mark(one->components ? &components : &best, one, &one->unchecked, least);
        if (one->checked.n > 0)
            mark(&checked, one, &one->checked, least);
    }
    const struct chart_series series[] = {
        series_of(cost->checked ? "unchecked" : "by the reference", CHART_STEPS, &best),
        series_of("unchecked, without spectra", CHART_RINGS, &components),
        series_of("checked", CHART_CIRCLES, &checked)};
    snprintf(title, sizeof title, "%s, %d x %d pixels, %s", cost->scene, cost->width, cost->height,
             cost->observer);
    snprintf(label, sizeof label, "CIEDE2000, 95 %% of the pixels (%.2g: this or less)", least);
    const struct chart chart = {.title = title,
                                .x_label = "seconds of processors",
                                .y_label = label,
                                .logarithmic = true,
                                .series = series,
                                .n = cost->checked ? 3 : 2};
    chart_svg(&chart, to);
}
