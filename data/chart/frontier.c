/* SPDX-License-Identifier: MIT */
/* Charts of error over cost: each configuration is a point between two logarithmic axes. Steps join
 * the points of the frontier, which no cheaper point beats. Labels cover neither points nor each
 * other. */
#include <math.h>
#include <stdlib.h>

#include "data/chart/chart.h"

enum {
    WIDTH = CHART_WIDTH - CHART_LEFT - CHART_MARGIN, /* of the area */
    HEIGHT = 440,
    NUMBER_SIZE = 10, /* font size of numbers that stand for names */
    NAME_LENGTH = 40, /* characters of a name in the plot */
    KEY_LENGTH = 60,  /* characters of a name in the key */
    SAMPLE = 26,      /* width of a number in the key */
    PAST_DECADES = 3  /* errors smaller by more decades than this lie on the edge */
};
static const char strong[] = "#0072b2", pale[] = "#8a8a8a";

struct plot {
    const struct frontier *frontier;
    struct chart_area area;
    struct axis cost, error;
    struct chart_labels labels; /* a label for each point; lines: the steps, then the cost bars */
    int n_steps;
    int *order; /* points of the frontier, by cost */
    int n_best;
    int *number; /* of each point in the key; 0: the plot shows its name */
    int n_numbers;
};

/* ---- axes ---- */

static struct axis cost_axis(const struct frontier *frontier)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < frontier->n; i++) {
        const struct frontier_point *point = &frontier->points[i];
        low = fmin(low, decimal_logarithm(fmin(point->cost, point->cost_low)));
        high = fmax(high, decimal_logarithm(fmax(point->cost, point->cost_high)));
    }
    return axis_logarithmic(low, high);
}

static struct axis error_axis(const struct frontier *frontier)
{
    double largest = 0, least = HUGE_VAL;
    for (int i = 0; i < frontier->n; i++)
        largest = fmax(largest, frontier->points[i].error);
    const double high = largest > 0 ? decimal_logarithm(largest) : -HUGE_VAL;
    bool clipped = false;
    for (int i = 0; i < frontier->n; i++) {
        const double error = frontier->points[i].error;
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

static int compare_cost(const struct frontier_point *a, const struct frontier_point *b)
{
    return a->cost != b->cost ? (a->cost > b->cost) - (a->cost < b->cost)
                              : (a->error < b->error) - (a->error > b->error);
}

/* Sorts the points of the frontier by cost, and numbers the others. */
static void sort_points(struct plot *plot)
{
    const struct frontier_point *points = plot->frontier->points;
    for (int i = 0; i < plot->frontier->n; i++) {
        if (!points[i].best) {
            plot->number[i] = ++plot->n_numbers;
            continue;
        }
        int at = plot->n_best++;
        for (; at > 0 && compare_cost(&points[plot->order[at - 1]], &points[i]) > 0; at--)
            plot->order[at] = plot->order[at - 1];
        plot->order[at] = i;
    }
}

/* Finds the steps: from each point along the cost, then down to the error of the next one. */
static void find_steps(struct plot *plot)
{
    for (int i = 0; i + 1 < plot->n_best; i++) {
        const struct chart_label *here = &plot->labels.label[plot->order[i]];
        const struct chart_label *next = &plot->labels.label[plot->order[i + 1]];
        plot->labels.lines[plot->n_steps++] =
            (struct chart_segment){{here->x, next->x}, {here->y, here->y}};
        plot->labels.lines[plot->n_steps++] =
            (struct chart_segment){{next->x, next->x}, {here->y, next->y}};
    }
}

/* Finds the bar of each point, from its lowest to its highest cost. */
static void find_bars(struct plot *plot)
{
    plot->labels.n_lines = plot->n_steps + plot->frontier->n;
    for (int i = 0; i < plot->frontier->n; i++) {
        const struct frontier_point *point = &plot->frontier->points[i];
        const double y = plot->labels.label[i].y;
        plot->labels.lines[plot->n_steps + i] =
            (struct chart_segment){{chart_x(&plot->area, &plot->cost, point->cost_low),
                                    chart_x(&plot->area, &plot->cost, point->cost_high)},
                                   {y, y}};
    }
}

static void draw_steps(const struct plot *plot)
{
    if (plot->n_steps == 0)
        return;
    print(plot->area.to, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"2\" d=\"M%.2f,%.2f",
          strong, plot->labels.lines[0].x[0], plot->labels.lines[0].y[0]);
    for (int i = 0; i < plot->n_steps; i++)
        print(plot->area.to, "L%.2f,%.2f", plot->labels.lines[i].x[1], plot->labels.lines[i].y[1]);
    print_text(plot->area.to, "\"/>\n");
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

static void draw_point(const struct plot *plot, int index)
{
    const struct frontier_point *point = &plot->frontier->points[index];
    const struct chart_label *label = &plot->labels.label[index];
    const struct chart_segment *bar = &plot->labels.lines[plot->n_steps + index];
    print_text(plot->area.to, "<g><title>");
    chart_text(plot->area.to, point->name, 200);
    print(plot->area.to, "</title><path stroke=\"%s\" stroke-width=\"0.8\" d=\"M%.2f,%.2fH%.2f\"/>",
          point->best ? strong : pale, bar->x[0], label->y, bar->x[1]);
    draw_marker(plot->area.to, label->x, label->y, point->best, point->uncertain);
    print_text(plot->area.to, "</g>\n");
}

/* ---- labels ---- */

static int shown_length(const char *name, int most)
{
    const int length = chart_text_length(name);
    return length < most ? length : most;
}

/* Places the names of the frontier first, because they are the largest labels. A name without a
 * free place becomes a number. */
static void place_labels(struct plot *plot)
{
    for (int i = 0; i < plot->n_best; i++) {
        const int index = plot->order[i];
        const int length = shown_length(plot->frontier->points[index].name, NAME_LENGTH);
        if (!chart_place_label(&plot->labels, index, chart_text_width(length, CHART_TEXT_SIZE),
                               CHART_TEXT_SIZE + 2))
            plot->number[index] = ++plot->n_numbers;
    }
    for (int i = 0; i < plot->frontier->n; i++) {
        const int digits = snprintf(NULL, 0, "%d", plot->number[i]);
        if (plot->number[i] > 0)
            chart_place_label(&plot->labels, i, chart_text_width(digits, NUMBER_SIZE) + 2,
                              NUMBER_SIZE);
    }
}

static void draw_label(const struct plot *plot, int index)
{
    const struct chart_label *label = &plot->labels.label[index];
    const struct chart_segment line = chart_leader(label);
    const int size = plot->number[index] > 0 ? NUMBER_SIZE : CHART_TEXT_SIZE;
    if (!label->placed)
        return;
    if (label->led)
        print(plot->area.to,
              "<path stroke=\"%s\" stroke-width=\"0.6\" d=\"M%.2f,%.2fL%.2f,%.2f\"/>", pale,
              line.x[0], line.y[0], line.x[1], line.y[1]);
    print(plot->area.to, "<text text-anchor=\"middle\" x=\"%.2f\" y=\"%.2f\" font-size=\"%d\"%s>",
          (label->box.left + label->box.right) / 2,
          (label->box.top + label->box.bottom) / 2 + 0.35 * size, size,
          plot->number[index] > 0 ? " fill=\"#555\"" : "");
    if (plot->number[index] > 0)
        print(plot->area.to, "%d", plot->number[index]);
    else
        chart_text(plot->area.to, plot->frontier->points[index].name, NAME_LENGTH);
    print_text(plot->area.to, "</text>\n");
}

/* ---- the key ---- */

static struct chart_grid key_grid(const struct plot *plot)
{
    int longest = 1;
    for (int i = 0; i < plot->frontier->n; i++) {
        const int length = shown_length(plot->frontier->points[i].name, KEY_LENGTH);
        longest = plot->number[i] > 0 && length > longest ? length : longest;
    }
    return chart_grid(plot->n_numbers, longest, SAMPLE);
}

/* Draws the legend of the markers, in one row. */
static void draw_markers(const struct plot *plot, int y)
{
    static const char *const meaning[] = {"on the frontier", "not on it: see the number",
                                          "either, within noise"};
    for (int i = 0; i < 3; i++) {
        const double x = CHART_LEFT + 10 + (CHART_WIDTH - CHART_LEFT) / 3.0 * i;
        draw_marker(plot->area.to, x, y, i == 0, i == 2);
        print(plot->area.to, "<text x=\"%.2f\" y=\"%.2f\">%s</text>\n", x + 14,
              y + 0.35 * CHART_TEXT_SIZE, meaning[i]);
    }
}

static void draw_key(const struct plot *plot, int top)
{
    const struct chart_grid grid = key_grid(plot);
    const int fitting = chart_fitting(grid.column - SAMPLE - 8, CHART_TEXT_SIZE);
    for (int i = 0; i < plot->frontier->n; i++) {
        const int place = plot->number[i] - 1;
        if (place < 0)
            continue;
        const double x = CHART_LEFT + grid.column * (place / grid.rows);
        const double y = top + CHART_LEGEND_ROW * (place % grid.rows) + 0.35 * CHART_TEXT_SIZE;
        print(plot->area.to,
              "<text text-anchor=\"end\" x=\"%.2f\" y=\"%.2f\" fill=\"#555\">%d</text>"
              "<text x=\"%.2f\" y=\"%.2f\">",
              x + SAMPLE - 8, y, plot->number[i], x + SAMPLE, y);
        chart_text(plot->area.to, plot->frontier->points[i].name,
                   fitting < KEY_LENGTH ? fitting : KEY_LENGTH);
        print_text(plot->area.to, "</text>\n");
    }
}

/* ---- the file ---- */

static void draw(void *of, struct printed *to)
{
    struct plot *plot = of;
    const int markers = CHART_TOP + HEIGHT + CHART_TICK + CHART_TEXT_SIZE + CHART_LABEL_SIZE + 36;
    const int key = markers + CHART_LEGEND_ROW + 6;
    plot->area.to = to;
    chart_head(to, plot->frontier->title, key + CHART_LEGEND_ROW * key_grid(plot).rows);
    axis_draw_x(&plot->area, &plot->cost, plot->frontier->cost_label, 0);
    axis_draw_y(&plot->area, &plot->error, plot->frontier->error_label, false);
    chart_frame(&plot->area);
    for (int i = 0; i < plot->frontier->n; i++)
        if (!plot->frontier->points[i].best)
            draw_point(plot, i);
    draw_steps(plot);
    for (int i = 0; i < plot->n_best; i++)
        draw_point(plot, plot->order[i]);
    for (int i = 0; i < plot->frontier->n; i++)
        draw_label(plot, i);
    draw_markers(plot, markers);
    draw_key(plot, key);
}

/* Finds the places of all points, steps, bars and labels. */
static void find_places(struct plot *plot)
{
    plot->cost = cost_axis(plot->frontier);
    plot->error = error_axis(plot->frontier);
    for (int i = 0; i < plot->frontier->n; i++) {
        const struct frontier_point *point = &plot->frontier->points[i];
        plot->labels.label[i] =
            (struct chart_label){.x = chart_x(&plot->area, &plot->cost, point->cost),
                                 .y = chart_y(&plot->area, &plot->error, point->error),
                                 .radius = point->uncertain ? 7
                                           : point->best    ? 5
                                                            : 3.3};
    }
    sort_points(plot);
    find_steps(plot);
    find_bars(plot);
    place_labels(plot);
}

char *frontier_svg(const struct frontier *frontier)
{
    const size_t n = (size_t)frontier->n + 1;
    struct plot plot = {
        .frontier = frontier,
        .area = {.width = WIDTH, .height = HEIGHT},
        .labels = {.n = frontier->n,
                   .frame = {CHART_LEFT, CHART_TOP, CHART_LEFT + WIDTH, CHART_TOP + HEIGHT}}};
    char *text = NULL;
    plot.labels.label = calloc(n, sizeof *plot.labels.label);
    plot.order = calloc(n, sizeof *plot.order);
    plot.number = calloc(n, sizeof *plot.number);
    plot.labels.lines = calloc(3 * n, sizeof *plot.labels.lines);
    if (plot.labels.label && plot.order && plot.number && plot.labels.lines) {
        find_places(&plot);
        text = chart_file(draw, &plot);
    }
    free(plot.labels.label);
    free(plot.order);
    free(plot.number);
    free(plot.labels.lines);
    return text;
}
