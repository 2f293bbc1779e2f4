/* SPDX-License-Identifier: MIT */
/* Charts of error over cost: each configuration is a point with a number between two logarithmic
 * axes, and a legend names the numbers. Steps join the points of the frontier, which no cheaper
 * point beats. */
#include <math.h>

#include "raster/beside/cost/inside.h"

enum {
    WIDTH = CHART_WIDTH - CHART_LEFT - CHART_MARGIN, /* of the area */
    HEIGHT = 440,
    NAME_LENGTH = 60, /* characters of a name */
    SAMPLE = 26,      /* width of a number in the legend */
    PAST_DECADES = 3  /* errors smaller by more decades than this lie on the edge */
};
static const char strong[] = "#0072b2", pale[] = "#8a8a8a";

/* ---- axes ---- */

static struct axis seconds_axis(const struct cost *cost)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < cost->n; i++) {
        const struct cost_entry *entry = &cost->entries[i];
        low = fmin(low, decimal_logarithm(entry->fastest));
        high = fmax(high, decimal_logarithm(entry->slowest));
    }
    return axis_logarithmic(low, high);
}

static struct axis error_axis(const struct cost *cost)
{
    double largest = 0, least = HUGE_VAL;
    for (int i = 0; i < cost->n; i++)
        largest = fmax(largest, cost->entries[i].accuracy.quantile_95);
    const double high = largest > 0 ? decimal_logarithm(largest) : -HUGE_VAL;
    bool clipped = false;
    for (int i = 0; i < cost->n; i++) {
        const double error = cost->entries[i].accuracy.quantile_95;
        const bool below = !(error > 0) || decimal_logarithm(error) < high - PAST_DECADES;
        clipped = clipped || below;
        least = below ? least : fmin(least, decimal_logarithm(error));
    }
    struct axis axis = axis_logarithmic(least, high);
    axis.clipped = clipped;
    axis.least = largest / 1000;
    if (clipped && largest > 0)
        axis.low = high - PAST_DECADES;
    return axis;
}

/* ---- the frontier ---- */

static double y_of(const struct chart_area *area, const struct cost_entry *point)
{
    return chart_y(area, &area->y, point->accuracy.quantile_95);
}

/* Draws the steps: from each point along the cost, then down to the error of the next one. Points
 * are sorted by cost: of equal ones on the frontier the errors are equal, too. */
static void draw_steps(const struct chart_area *area, const struct cost *cost)
{
    const char *before = "";
    for (int i = 0; i < cost->n; i++) {
        const struct cost_entry *point = &cost->entries[i];
        const double x = chart_x(area, point->seconds), y = y_of(area, point);
        if (!point->best)
            continue;
        if (!before[0])
            print(area->to, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2\" d=\"M%.2f,%.2f",
                  strong, x, y);
        else
            print(area->to, "H%.2fV%.2f", x, y);
        before = "\"/>\n";
    }
    print_text(area->to, before);
}

/* ---- points drawn ---- */

static void draw_marker(struct printed *to, double x, double y, bool best, bool uncertain)
{
    if (uncertain)
        print(to,
              "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"6.5\" fill=\"none\" stroke=\"%s\" "
              "stroke-dasharray=\"2 1.5\"/>",
              x, y, strong);
    print(to, "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%s\" fill=\"%s\" stroke=\"%s\"/>", x, y,
          best ? "4.5" : "2.8", best ? strong : "#fff", best ? strong : pale);
}

/* Writes the number of a point of the frontier. No other point lies below and left of it: there is
 * room. */
static void draw_number(const struct chart_area *area, int number, double x, double y)
{
    const double lowest = CHART_TOP + HEIGHT - 4;
    print(area->to, "<text text-anchor=\"end\" x=\"%.2f\" y=\"%.2f\" fill=\"%s\">%d</text>", x - 6,
          fmin(y + CHART_TEXT_SIZE, lowest), strong, number);
}

static void draw_point(const struct chart_area *area, const struct cost_entry *point, int number)
{
    const double x = chart_x(area, point->seconds), y = y_of(area, point);
    print_text(area->to, "<g><title>");
    chart_text(area->to, point->name, 200);
    print(area->to, "</title><path stroke=\"%s\" stroke-width=\"0.8\" d=\"M%.2f,%.2fH%.2f\"/>",
          point->best ? strong : pale, chart_x(area, point->fastest), y,
          chart_x(area, point->slowest));
    draw_marker(area->to, x, y, point->best, point->uncertain);
    if (point->best)
        draw_number(area, number, x, y);
    print_text(area->to, "</g>\n");
}

/* ---- the legend ---- */

/* The legend names the points of the frontier; the table has all. */
static struct chart_legend legend_of(const struct cost *cost)
{
    int longest = 1, n = 0;
    for (int i = 0; i < cost->n; i++) {
        const int length = cost->entries[i].best ? chart_text_length(cost->entries[i].name) : 0;
        longest = length > longest ? length : longest;
        n += cost->entries[i].best;
    }
    return chart_legend(n, longest < NAME_LENGTH ? longest : NAME_LENGTH, SAMPLE);
}

/* Draws the legend of the markers, in one row. */
static void draw_markers(struct printed *to, int y)
{
    static const char *const meaning[] = {"on the frontier", "not on it", "either, within noise"};
    for (int i = 0; i < 3; i++) {
        const double x = CHART_LEFT + 10 + (CHART_WIDTH - CHART_LEFT) / 3.0 * i;
        draw_marker(to, x, y, i == 0, i == 2);
        print(to, "<text x=\"%.2f\" y=\"%.2f\">%s</text>\n", x + 14, y + 0.35 * CHART_TEXT_SIZE,
              meaning[i]);
    }
}

static void draw_legend(const struct cost *cost, struct printed *to, int top)
{
    const struct chart_legend legend = legend_of(cost);
    const int fitting = chart_fitting(legend.column - SAMPLE - 8, CHART_TEXT_SIZE);
    for (int i = 0, cell = 0; i < cost->n; i++) {
        if (!cost->entries[i].best)
            continue;
        const double x = legend_x(&legend, cell);
        const double y = legend_y(&legend, top, cell++) + 0.35 * CHART_TEXT_SIZE;
        print(to,
              "<text text-anchor=\"end\" x=\"%.2f\" y=\"%.2f\" fill=\"%s\">%d</text>"
              "<text x=\"%.2f\" y=\"%.2f\">",
              x + SAMPLE - 8, y, strong, i + 1, x + SAMPLE, y);
        chart_text(to, cost->entries[i].name, fitting < NAME_LENGTH ? fitting : NAME_LENGTH);
        print_text(to, "</text>\n");
    }
}

/* ---- the file ---- */

void cost_svg(const struct cost *cost, struct printed *to)
{
    static const char *const labels[3] = {"seconds", "CIEDE2000, 95 % of the pixels", NULL};
    const struct chart_area area = {
        .to = to, .width = WIDTH, .height = HEIGHT, .x = seconds_axis(cost), .y = error_axis(cost)};
    const int markers = CHART_TOP + HEIGHT + CHART_TICK + CHART_TEXT_SIZE + CHART_LABEL_SIZE + 36;
    const int legend = markers + CHART_LEGEND_ROW + 6;
    char title[512];
    snprintf(title, sizeof title, "%s, %d x %d pixels, %s", cost->scene, cost->width, cost->height,
             cost->observer);
    chart_head(to, title, legend + CHART_LEGEND_ROW * legend_of(cost).rows);
    chart_axes(&area, labels, 0);
    draw_steps(&area, cost);
    for (int best = 0; best < 2; best++) /* the frontier on top */
        for (int i = cost->n - 1; i >= 0; i--)
            if (cost->entries[i].best == best)
                draw_point(&area, &cost->entries[i], i + 1);
    draw_markers(to, markers);
    draw_legend(cost, to, legend);
    print_text(to, "</svg>\n");
}
